//! What a session needs in order to go on elsewhere with the same bits, as bytes.
//!
//! ```text
//! magic | version u32 | origins | steps u32, moved | target | begun | state | SHA-256
//! ```
//!
//! Little-endian; numbers by their bits. Before the values of every list stands their
//! count, u64; before an origin its bytes, u8. Origins tie the bytes to what they go on
//! upon: mesh, prepared data, scene, instruction set ([`origins`]). The digest covers
//! all that stands before it. Reading fills a checkpoint that has the shape of the plan,
//! so that no number of the bytes sizes memory. Cost: one pass over the state.

mod bytes;
mod error;
mod scene_digest;

use std::slice::from_mut;

use sha2::{Digest, Sha256};

use crate::assembly::simd::InstructionSet;
use crate::model::drive::Drive;
use crate::model::given::Given;
use crate::model::push::{Push, named};
use crate::model::state::{SlipState, State};
use crate::pairs::Support;
use crate::plan::Plan;

use bytes::{Fields, Reader, Writer};
pub use error::{CheckpointError, Origin};

/// What every checkpoint begins with.
const MAGIC: &[u8; 21] = b"signorini-checkpoint\n";
/// Of the format, where all obstacles are led; another one says nothing about its bytes beyond
/// this number.
const VERSION: u32 = 1;
/// Of the format with what obstacles shall exert in every drive.
const WITH_PUSHES: u32 = 2;
/// Of the format with values of other codes besides.
const WITH_VALUES: u32 = 3;
/// Of the format with the way of points that no slip explains, where a scene has friction.
const WITH_RESIDUES: u32 = 4;
/// Of the format where programs may begin by a factor.
const WITH_FACTOR: u32 = 5;
/// Of the format with what supports shall exert in every drive, where any shall.
const WITH_SUPPORTS: u32 = 6;
/// Of the format with fluids, where a scene has any.
const WITH_FLUIDS: u32 = 7;
/// Of the format with multipliers that lend their functions, where any do.
const WITH_LENDING: u32 = 8;
/// Of the format with fluids between bodies, where a scene has any.
const WITH_FILMS: u32 = 9;
/// Bytes of a SHA-256 digest.
const DIGEST: usize = 32;
/// More steps than any session takes.
const MOST_STEPS: u32 = 1 << 30;

/// What travels: everything that later bits depend on, but for what the solver has
/// learnt.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Checkpoint {
    /// Where the body is.
    pub(crate) state: State,
    /// What the last step led to, reached or not.
    pub(crate) target: Drive,
    /// What drove the body when the last step began; none where it was ended.
    pub(crate) begun: Option<Drive>,
    /// Steps begun so far.
    pub(crate) steps: u32,
    /// Whether any increment has moved the state.
    pub(crate) moved: bool,
}

/// What a checkpoint may have been rounded by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rounding {
    /// The instruction set of this machine: later bits are the same.
    Same,
    /// Any: later results are the same up to rounding.
    Any,
}

impl Checkpoint {
    /// As bytes that only a session of the same plan reads.
    pub(crate) fn encode(mut self, plan: &Plan) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        let version = self.version();
        bytes.extend(version.to_le_bytes());
        for (_, own) in origins(plan) {
            bytes.push(own.len() as u8);
            bytes.extend(own);
        }
        let mut writer = Writer { bytes };
        let Ok(()) = self.visit(version, &mut writer);
        let mut bytes = writer.bytes;
        let digest = Sha256::digest(&bytes);
        bytes.extend(digest);
        bytes
    }

    /// From the bytes of [`Checkpoint::encode`] on the same plan and, unless `rounding`
    /// says that it does not matter, the same instruction set.
    ///
    /// # Errors
    /// [`CheckpointError`], with the first thing that is not as it was written.
    pub(crate) fn decode(
        plan: &Plan,
        bytes: &[u8],
        rounding: Rounding,
    ) -> Result<Self, CheckpointError> {
        let (version, rest) = verified(bytes)?;
        let mut reader = Reader { rest };
        for (origin, here) in origins(plan) {
            let written = reader.short("origin")?;
            let is_excused = origin == Origin::InstructionSet && rounding == Rounding::Any;
            if written != here && !is_excused {
                return Err(origin.differs(written, &here));
            }
        }
        let mut checkpoint = Self::shaped(plan);
        checkpoint.visit(version, &mut reader)?;
        reader.end()?;
        checkpoint.check()?;
        Ok(checkpoint)
    }

    /// Has a place for everything that a checkpoint on this plan can hold.
    fn shaped(plan: &Plan) -> Self {
        let drive = Drive::undeformed(plan);
        Self {
            state: State::undeformed(plan),
            target: drive.clone(),
            begun: Some(drive),
            steps: 0,
            moved: false,
        }
    }

    /// Version of the format that holds all of it.
    fn version(&self) -> u32 {
        let drives = [&self.target, &self.state.drive];
        let drives = drives.into_iter().chain(&self.begun);
        let of_one = |drive: &Drive| match (drive.given == Given::default(), &drive.pushes[..]) {
            _ if !drive.fluids.is_empty() => WITH_FLUIDS,
            _ if !drive.support_pushes.is_empty() => WITH_SUPPORTS,
            (false, _) => WITH_VALUES,
            (true, [_, ..]) => WITH_PUSHES,
            (true, []) => VERSION,
        };
        let of_state = match (self.state.by_factor, self.state.slip.residue.is_empty()) {
            _ if !self.state.film.is_empty() => WITH_FILMS,
            _ if !self.state.supports.is_empty() => WITH_LENDING,
            (true, _) => WITH_FACTOR,
            (false, true) => VERSION,
            (false, false) => WITH_RESIDUES,
        };
        drives.map(of_one).fold(of_state, u32::max)
    }

    /// Leads `fields` through all of it: the order of the bytes.
    fn visit<E>(&mut self, version: u32, fields: &mut impl Fields<Error = E>) -> Result<(), E> {
        fields.count("steps", &mut self.steps)?;
        fields.flags("moved", from_mut(&mut self.moved))?;
        visit_drive(&mut self.target, version, fields)?;
        let mut is_under_way = self.begun.is_some();
        fields.flags("begun", from_mut(&mut is_under_way))?;
        match &mut self.begun {
            Some(begun) if is_under_way => visit_drive(begun, version, fields)?,
            _ => self.begun = None,
        }
        visit_state(&mut self.state, version, fields)
    }

    /// What the fields say together.
    fn check(&self) -> Result<(), CheckpointError> {
        let fault = match (self.steps, &self.begun) {
            (0, Some(_)) => "are none, but one is under way",
            (MOST_STEPS.., _) => "are more than a session takes",
            _ => return Ok(()),
        };
        let field = "steps";
        Err(CheckpointError::Malformed { field, fault })
    }
}

/// The version and what stands between it and the digest, if the bytes are those that were written.
fn verified(bytes: &[u8]) -> Result<(u32, &[u8]), CheckpointError> {
    let rest = bytes.strip_prefix(MAGIC);
    let rest = rest.ok_or(CheckpointError::NotACheckpoint)?;
    let (version, rest) = rest.split_first_chunk().ok_or(CheckpointError::Damaged)?;
    let found = u32::from_le_bytes(*version);
    if !(VERSION..=WITH_FILMS).contains(&found) {
        let known = WITH_FILMS;
        return Err(CheckpointError::UnknownVersion { found, known });
    }
    let (body, written) = rest
        .split_last_chunk::<DIGEST>()
        .ok_or(CheckpointError::Damaged)?;
    let (covered, _) = bytes.split_at(bytes.len() - DIGEST);
    if Sha256::digest(covered)[..] == written[..] {
        Ok((found, body))
    } else {
        Err(CheckpointError::Damaged)
    }
}

/// What the bits of a session rest upon, each by its name or its digest, which are
/// shorter than 256 bytes. The key of the prepared data holds the decisions of the plan.
fn origins(plan: &Plan) -> [(Origin, Vec<u8>); 4] {
    let set = InstructionSet::of_this_machine().name();
    [
        (Origin::Mesh, plan.mesh_id().as_bytes().to_vec()),
        (Origin::Scene, scene_digest::of(plan.scene()).to_vec()),
        (Origin::Prepared, plan.key().0.to_vec()),
        (Origin::InstructionSet, set.as_bytes().to_vec()),
    ]
}

fn visit_state<E>(
    state: &mut State,
    version: u32,
    fields: &mut impl Fields<Error = E>,
) -> Result<(), E> {
    fields.numbers("displacement", &mut state.displacement)?;
    fields.numbers("pressure", &mut state.pressure)?;
    fields.numbers("contact pressure", &mut state.multiplier)?;
    fields.statuses("contact statuses", &mut state.status)?;
    visit_drive(&mut state.drive, version, fields)?;
    let scales = &mut state.scales;
    fields.magnitude("scale of the constraint", &mut scales.constraint)?;
    fields.magnitude("scale of the gap", &mut scales.gap)?;
    fields.magnitude("scale of the force", &mut state.force_scale)?;
    fields.magnitude("penalty", &mut state.penalty)?;
    if version >= WITH_FACTOR {
        fields.flags("factor", from_mut(&mut state.by_factor))?;
    }
    for wet in &mut state.wet {
        fields.flags("wet nodes", wet)?;
    }
    for film in &mut state.film {
        fields.numbers("shares of fluids", film)?;
    }
    if version >= WITH_LENDING {
        visit_supports(state, fields)?;
    }
    if state.slip.total.is_empty() {
        Ok(())
    } else {
        visit_slip(&mut state.slip, version, fields)
    }
}

/// What multipliers have to press on, as three lists of flags.
fn visit_supports<E>(state: &mut State, fields: &mut impl Fields<Error = E>) -> Result<(), E> {
    let supports = &mut state.supports;
    supports.resize(state.multiplier.len(), Support::Enough);
    let of = |kind: Support| {
        supports
            .iter()
            .map(|one| *one == kind)
            .collect::<Vec<bool>>()
    };
    let [mut nothing, mut nearly, mut little] =
        [Support::Nothing, Support::Nearly, Support::Little].map(of);
    fields.flags("multipliers without a partner", &mut nothing)?;
    fields.flags("multipliers that lend beside a pressure", &mut nearly)?;
    fields.flags("multipliers that lend", &mut little)?;
    let flags = nothing.into_iter().zip(nearly).zip(little);
    for (support, flags) in supports.iter_mut().zip(flags) {
        *support = match flags {
            (_, true) => Support::Little,
            ((_, true), false) => Support::Nearly,
            ((true, false), false) => Support::Nothing,
            ((false, false), false) => Support::Enough,
        };
    }
    // As the session has it where none lends.
    if !supports.iter().any(|support| support.lends()) {
        supports.clear();
    }
    Ok(())
}

/// What friction did, in scenes that have it.
fn visit_slip<E>(
    slip: &mut SlipState,
    version: u32,
    fields: &mut impl Fields<Error = E>,
) -> Result<(), E> {
    fields.numbers("slip", &mut slip.travel)?;
    if version >= WITH_RESIDUES {
        fields.numbers("way without slip", &mut slip.residue)?;
    }
    fields.numbers("dissipated energy of the increment", &mut slip.increment)?;
    fields.numbers("dissipated energy", &mut slip.total)
}

fn visit_drive<E>(
    drive: &mut Drive,
    version: u32,
    fields: &mut impl Fields<Error = E>,
) -> Result<(), E> {
    fields.numbers("load factor", from_mut(&mut drive.load))?;
    fields.length("obstacles", drive.poses.len())?;
    for pose in &mut drive.poses {
        fields.name("obstacle", &pose.name)?;
        fields.numbers("translation of an obstacle", &mut pose.translation)?;
        fields.numbers("rotation of an obstacle", &mut pose.rotation)?;
    }
    if version >= WITH_PUSHES {
        visit_pushes(&mut drive.pushes, drive.poses.len(), fields)?;
    }
    if !drive.friction.is_empty() {
        fields.numbers("friction", &mut drive.friction)?;
    }
    fields.numbers("supports", drive.supports.as_flattened_mut())?;
    fields.length("motions", drive.motions.len())?;
    for motion in &mut drive.motions {
        fields.numbers("translation of a support", &mut motion.translation)?;
        fields.numbers("rotation of a support", &mut motion.rotation)?;
        fields.numbers("reference point of a support", &mut motion.about)?;
    }
    if version >= WITH_SUPPORTS {
        visit_pushes(&mut drive.support_pushes, drive.motions.len(), fields)?;
    }
    if version >= WITH_VALUES {
        visit_given(&mut drive.given, fields)?;
    }
    for fluid in &mut drive.fluids {
        fields.magnitude("pressure of a fluid", &mut fluid.pressure)?;
        fields.flags("blow-off", from_mut(&mut fluid.to_blow_off))?;
    }
    Ok(())
}

/// Values of other codes; their numbers are those of the mesh that the checkpoint is tied to.
fn visit_given<E>(given: &mut Given, fields: &mut impl Fields<Error = E>) -> Result<(), E> {
    for list in [
        &mut given.supports,
        &mut given.tractions,
        &mut given.body_force,
    ] {
        fields.spreads("values", list)?;
    }
    Ok(())
}

/// Which components of each pose are pushed, and by what; zero where none is.
fn visit_pushes<E>(
    pushes: &mut Vec<Push>,
    parts: usize,
    fields: &mut impl Fields<Error = E>,
) -> Result<(), E> {
    pushes.resize(parts, Push::default());
    for push in pushes.iter_mut() {
        let mut flags = push.components.map(|component| component.is_some());
        let mut values = push.components.map(Option::unwrap_or_default);
        fields.flags("pushed components", &mut flags)?;
        fields.numbers("push", &mut values)?;
        let components = flags.into_iter().zip(values);
        let slots = push.components.iter_mut().zip(components);
        slots.for_each(|(slot, (is_pushed, value))| *slot = is_pushed.then_some(value));
    }
    *pushes = named(std::mem::take(pushes));
    Ok(())
}

#[cfg(test)]
mod tests;
