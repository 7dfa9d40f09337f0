//! What a session is at between two increments: fields, multipliers, what drives them
//! and the scales of their residuals. It is the checkpoint: a session that starts from
//! it goes on with the same bits. What the solver has learnt on the way stands apart,
//! in `sqp::learned`.

use std::borrow::Cow;
use std::sync::Arc;

use super::drive::Drive;
use super::remainder::Remainder;
use crate::assembly::strain::StrainGrid;
use crate::inequality::QpScales;
use crate::linalg::vector::add_scaled;
use crate::pairs::Support;
use crate::plan::Plan;
use crate::prepare::TaylorHoodData;
use crate::saddle::Status;

/// The state, non-dimensional but for the drive.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct State {
    /// Hierarchical displacement `[nodes * components]`.
    pub(crate) displacement: Vec<f64>,
    /// Pressure `[vertices]`; empty for displacement forms.
    pub(crate) pressure: Vec<f64>,
    /// Contact pressure of all obstacles, one after the other `[multipliers]`.
    pub(crate) multiplier: Vec<f64>,
    /// What each multiplier does `[multipliers]`; those of supports are always closed.
    pub(crate) status: Vec<Status>,
    /// Load factor, poses and prescribed motions that the fields belong to.
    pub(crate) drive: Drive,
    /// Scales of the residual blocks that have no load of their own.
    pub(crate) scales: QpScales,
    /// Scale of the force residual when the present drive was reached.
    pub(crate) force_scale: f64,
    /// Weight of the volume term of rubber, in shear moduli; zero without it.
    pub(crate) penalty: f64,
    /// What friction did in the last increment; empty without it.
    pub(crate) slip: SlipState,
    /// Whether a program has cost as much as a factor of the body, by which later ones begin.
    pub(crate) by_factor: bool,
    /// Whether each node of the surface of each fluid is wet `[fluids][nodes of the surface]`; empty
    /// without fluids.
    pub(crate) wet: Vec<Vec<bool>>,
    /// Share of each fluid's pressure at its nodes `[fluids][nodes of the surface]`, as it is wet but between
    /// bodies; empty without contact between bodies.
    pub(crate) film: Vec<Vec<f64>>,
    /// What multipliers have to press on `[multipliers]`, of contacts between bodies of finite strain
    /// where some lend their functions to others; empty elsewhere.
    pub(crate) supports: Vec<Support>,
    /// What moved the surface where the response of the body has answered; none after others,
    /// and in every checkpoint.
    pub(crate) surface_load: Option<SurfaceLoad>,
    /// Further digits of the displacement while an increment is solved; none in every checkpoint.
    pub(crate) remainder: Option<Remainder>,
}

/// The contact load that has moved a surface.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SurfaceLoad {
    /// On free rows `[displacement]`.
    pub(crate) load: Arc<[f64]>,
    /// Whether the body inside has been found, which an answer on contact alone leaves behind.
    pub(crate) is_whole: bool,
}

/// Where an increment began.
#[derive(Clone, Debug)]
pub(crate) struct Start {
    /// Load factor, poses and prescribed motions.
    pub(crate) drive: Drive,
    /// Hierarchical displacement `[nodes * components]`.
    pub(crate) displacement: Vec<f64>,
}

impl Start {
    /// At that state.
    pub(crate) fn at(state: &State) -> Self {
        Self {
            drive: state.drive.clone(),
            displacement: state.displacement.clone(),
        }
    }
}

/// What friction did.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct SlipState {
    /// Mean slip vector of the last increment at each point `[points * 3]`, in units of the
    /// scaled body.
    pub(crate) travel: Vec<f64>,
    /// What of its way no slip explains, weighted, at each point `[points * 3]`.
    pub(crate) residue: Vec<f64>,
    /// Energy that the friction of each obstacle, and of each contact between bodies, has dissipated in
    /// the last increment `[obstacles and contacts]`, non-dimensional.
    pub(crate) increment: Vec<f64>,
    /// The same from the start.
    pub(crate) total: Vec<f64>,
}

impl SlipState {
    /// At rest.
    fn undeformed(plan: &Plan) -> Self {
        if !plan.has_friction() {
            return Self::default();
        }
        let points = plan.problem.tangential_multipliers / (plan.problem.units.dimension - 1);
        let contacts = plan.problem.obstacles.len() + plan.problem.pairs.len();
        let obstacles = vec![0.0; contacts];
        Self {
            travel: vec![0.0; 3 * points],
            residue: vec![0.0; 3 * points],
            increment: obstacles.clone(),
            total: obstacles,
        }
    }
}

/// Sources alone.
fn film_at_rest(plan: &Plan) -> Vec<Vec<f64>> {
    if plan.problem.pairs.is_empty() {
        return Vec::new();
    }
    let surfaces = plan.problem.fluid_surfaces.iter();
    let of_sources = surfaces.map(|one| one.sources.iter().copied().map(f64::from).collect());
    of_sources.collect()
}

impl State {
    /// At rest, with nothing driving the body.
    pub(crate) fn undeformed(plan: &Plan) -> Self {
        let unknowns = plan.unknowns();
        Self {
            displacement: vec![0.0; unknowns.displacement as usize],
            pressure: vec![0.0; unknowns.pressure as usize],
            multiplier: vec![0.0; unknowns.contact as usize],
            status: statuses_at_rest(plan),
            drive: Drive::undeformed(plan),
            scales: QpScales::default(),
            force_scale: 0.0,
            penalty: if plan.problem.resolved.is_rubber() {
                plan.first_penalty()
            } else {
                0.0
            },
            slip: SlipState::undeformed(plan),
            by_factor: false,
            wet: plan
                .problem
                .fluid_surfaces
                .iter()
                .map(|surface| surface.sources.clone())
                .collect(),
            film: film_at_rest(plan),
            supports: Vec::new(),
            surface_load: None,
            remainder: None,
        }
    }

    /// Cells of finite strain with the present volume term; none for linear bodies.
    pub(crate) fn cells(&self, prepared: &TaylorHoodData) -> Option<Arc<StrainGrid>> {
        let cells = prepared.strain.as_ref()?;
        Some(if self.penalty > 0.0 {
            Arc::new(cells.penalised(self.penalty))
        } else {
            cells.clone()
        })
    }

    /// Adds `length` times `step` `[displacement]` to the displacement.
    pub(crate) fn move_by(&mut self, length: f64, step: &[f64]) {
        match &mut self.remainder {
            Some(remainder) => remainder.add(&mut self.displacement, length, step),
            None => add_scaled(&mut self.displacement, length, step),
        }
    }

    /// Displacement as far as bodies do not move alike `[displacement]`, of which their forces are made.
    pub(crate) fn relative_displacement(&self) -> Cow<'_, [f64]> {
        match &self.remainder {
            Some(remainder) => remainder.relative(&self.displacement).into(),
            None => Cow::Borrowed(&self.displacement),
        }
    }

    /// Share of the pressure of one fluid at the nodes of its surface.
    pub(crate) fn share_of_fluid(&self, index: usize) -> Vec<f64> {
        match (self.film.get(index), self.wet.get(index)) {
            (Some(film), _) => film.clone(),
            (None, Some(wet)) => wet.iter().copied().map(f64::from).collect(),
            (None, None) => Vec::new(),
        }
    }

    /// Which multipliers lend their functions to others; empty where none does.
    pub(crate) fn lends(&self) -> Vec<bool> {
        let supports = self.supports.iter();
        supports.map(|support| support.lends()).collect()
    }

    /// Whether displacement and pressure are those of the whole body, not of its surface alone.
    pub(crate) fn is_whole(&self) -> bool {
        let moved = self.surface_load.as_ref();
        moved.is_none_or(|moved| moved.is_whole)
    }

    /// Takes the load `[displacement]` that has moved the surface to where it is, which it is
    /// under `drive` too; none where it is not known, or other loads act there.
    pub(crate) fn load_behind(&mut self, drive: &Drive) -> Option<Arc<[f64]>> {
        let moved = self.surface_load.take()?;
        let is_there = self.drive.is_loaded_like(drive);
        is_there.then_some(moved.load)
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> u64 {
        let numbers = self.displacement.len() + self.pressure.len() + self.multiplier.len();
        let load = self
            .surface_load
            .as_ref()
            .map_or(0, |moved| moved.load.len());
        let rounded_off = self.remainder.as_ref().map_or(0, Remainder::len);
        let numbers =
            numbers + load + rounded_off + 2 * self.slip.travel.len() + 2 * self.slip.total.len();
        let wet: usize = self.wet.iter().map(Vec::len).sum();
        let film: usize = self.film.iter().map(Vec::len).sum();
        (8 * (numbers + film) + self.status.len() + wet) as u64 + self.drive.given.bytes()
    }
}

/// Open where an obstacle is met, closed where a support holds the normal component.
fn statuses_at_rest(plan: &Plan) -> Vec<Status> {
    let mut statuses = vec![Status::Stick; plan.unknowns().contact as usize];
    let contacts = statuses.len() - plan.problem.guided_multipliers;
    statuses[..contacts].fill(Status::Open);
    statuses
}
