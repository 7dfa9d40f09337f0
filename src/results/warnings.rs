//! What a mechanic would doubt in an increment, found from its end:
//!
//! | warning | found by |
//! |---|---|
//! | missed contact | distances between the points of the contact integrals, on faces without pressure, depths of cells beside all faces, of vertices that supports hold, and between the nodes of pressed faces |
//! | untouched obstacle | no pressure, and the obstacle no farther than before |
//! | contact that presses nowhere | no pressure between two bodies |
//! | large sliding | how far linear bodies have slid on each other, over the facets of the carrier |
//! | bridged gap | how far the undeformed surfaces of a tie are apart |
//! | pushed out | no equilibrium at the upper end of a blow-off |
//! | passed through | no pressure, and cells inside the obstacle; poses on the way at which it is inside, of one that presses deeper than one that slides |
//! | begins inside | distances before the first increment |
//! | free motion | rigid modes that supports leave, and no contact, or one that pushes with forces of rounding |
//! | large strain | the largest strain at the centroid of a cell, of a linear solid |
//! | coarse contact | pressure on a few functions of a curved contact |
//! | coarse facets | how far facets are off the surface that they stand for, over the squeeze |
//! | lost digits | displacements, or of rubber lengths, whose rounding is a strain of some share of the largest |
//! | snapped, unstable equilibrium, not unique | what the solver did |
//!
//! Cost: 45 distances a face, again at poses as far apart as the obstacle is from the body
//! where it touches nothing, and a gradient a cell.

use std::collections::BTreeMap;

use crate::geometry::vector3::{norm, sub};
use crate::model::Model;
use crate::model::ending::Ending;
use crate::model::interfaces::Interface;
use crate::model::state::{Start, State};
use crate::model::values::gradient_at;
use crate::report::{ObstacleResult, Stability, Termination, Warning, WarningKind};
use crate::results::digits::digits;
use crate::results::passage::{begun_inside, passed, passed_and_presses, untouched};
use crate::results::touch::Touch;
use crate::scene::ContactSpace;

/// Strain of a linear law beyond what it is meant for.
const LARGE_STRAIN: f64 = 0.1;
/// Closed functions of a curved contact that are few, in the plane and in space: those of
/// vertices, and those of vertices and edges.
const FEW: [usize; 2] = [3, 6];
const FEW_QUADRATIC: [usize; 2] = [4, 10];
/// Times as many that are enough.
const ENOUGH: usize = 4;
/// Depth over the length of the body from which on an obstacle is inside it that no face
/// overlaps, or that a support presses the body into.
const INSIDE: f64 = 1e-3;
/// Sagitta of facets over the squeeze that is worth a word.
const COARSE_FACETS: f64 = 0.05;
/// Gap of a tie over the length of its facets that is worth a word, without unit: flat blocks lose .6 % of their
/// force at .01, 1.6 at .02, 7 at .05, 23 at .1.
const BRIDGED: f64 = 0.01;
/// Rounding of strains over the largest strain that is worth a word.
const LOST: f64 = 1e-6;
/// What residuals leave of the displacements over the largest strain that is too much.
const WRONG: f64 = 0.1;

/// All warnings of the increment that led from `start` to `state`, with what each obstacle
/// `touches`.
pub(crate) fn warnings(
    model: &Model<'_>,
    (start, state): (&Start, &State),
    (ending, touches): (&Ending, &[Touch<'_>]),
) -> Vec<Warning> {
    let mut all = Vec::new();
    of_stability(model, ending, &mut all);
    let contacts = model.interfaces.list.iter();
    let contacts = contacts.filter(|interface| interface.is_contact());
    all.extend(contacts.filter_map(|interface| begun_inside(model, start, interface)));
    if ending.termination != Termination::Converged {
        return all;
    }
    for touch in touches {
        let interface = touch.interface;
        all.extend(missed(model, &interface.name, touch.overlap()));
        all.extend(held_inside(model, touch));
        if touch.acts.contains(&true) {
            all.extend(beside(model, touch));
            all.extend(sunk(model, touch));
            all.extend(passed_and_presses(model, (start, state), interface));
        } else {
            all.extend(untouched(model, (start, touch)));
            let way = || passed(model, (start, state), interface);
            all.extend(interior_penetration(model, touch).or_else(way));
        }
        all.extend(coarse(model, state, touch));
    }
    all.extend(apart(model, state));
    all.extend(bridged(model));
    all.extend(slid(model, state));
    all.extend(pushed_out(model, ending));
    of_the_body(model, state, ending, &mut all);
    all
}

/// Contacts between bodies that press nowhere: surfaces look for each other as far as their reach.
fn apart<'m>(model: &'m Model<'_>, state: &'m State) -> impl Iterator<Item = Warning> + 'm {
    let pairs = model
        .interfaces
        .list
        .iter()
        .filter(|one| one.pair().is_some());
    let presses = |interface: &Interface| interface.places().any(|m| state.multiplier[m] > 0.0);
    pairs.filter(move |one| !presses(one)).map(|interface| {
        let name = &interface.name;
        Warning::new(
            WarningKind::UntouchedObstacle,
            name,
            None,
            format!("contact `{name}` presses nowhere: its surfaces are apart, or farther from or inside each other than the reach, a quarter of the extent of the smaller one"),
        )
    })
}

/// Linear bodies that have slid on each other by more than a facet: they meet where they were at rest.
fn slid<'m>(model: &'m Model<'_>, state: &'m State) -> impl Iterator<Item = Warning> + 'm {
    let length = model.plan.problem.units.length;
    let body = model.deformed(&state.displacement);
    let list = model.interfaces.list.iter();
    let met = list.filter_map(|interface| Some((interface, interface.pair()?)));
    met.filter_map(move |(interface, pair)| {
        let way = pair.slid(&body, &interface.own(&state.multiplier))?;
        let faces = &interface.surface.faces;
        let longest = faces.iter().map(|face| edge(model, &face.corners));
        let facet = longest.fold(0.0, f64::max) * model.plan.problem.units.coordinate_scale;
        let name = &interface.name;
        (way > facet).then(|| {
            let [told, facet] = [way * length, facet * length].map(digits);
            Warning::new(
                WarningKind::LargeSliding,
                name,
                Some(way * length),
                format!("contact `{name}` has slid by {told}, its facets are up to {facet}: linear bodies go on pressing where they met at rest, a law of rubber meets what is there"),
            )
        })
    })
}

/// Ties across gaps, or overlaps, that are wide beside their facets.
fn bridged<'m>(model: &'m Model<'_>) -> impl Iterator<Item = Warning> + 'm {
    let units = &model.plan.problem.units;
    let ties = model.plan.problem.ties.iter();
    ties.filter_map(move |tie| {
        let (gap, name) = (tie.seam.gap?.width, &tie.pair.name);
        let mut interfaces = model.interfaces.list.iter();
        let own = interfaces.find(|one| one.tie().is_some() && one.name == *name)?;
        let faces = own.surface.faces.iter();
        let lengths: Vec<f64> = faces.map(|face| edge(model, &face.corners)).collect();
        let share = gap * lengths.len() as f64 / lengths.iter().sum::<f64>();
        (share > BRIDGED).then(|| {
            let width = gap * units.coordinate_scale * units.length;
            Warning::new(
                WarningKind::CoarseFacets,
                name,
                Some(width),
                format!("tie `{name}` bridges a gap or overlap of {}, {:.0} % of a facet: one per cent costs about one of its force, ten a quarter; bring its surfaces together, or mesh curved ones finer or of second order", digits(width), 100.0 * share),
            )
        })
    })
}

/// Length of the first edge of a face, in the mesh's lengths.
fn edge(model: &Model<'_>, corners: &[u32]) -> f64 {
    let places = model.mesh.coordinates();
    match corners {
        [a, b, ..] => norm(sub(places[*a as usize], places[*b as usize])),
        _ => 0.0,
    }
}

/// A fluid whose blow-off leaves the body without an equilibrium.
fn pushed_out(model: &Model<'_>, ending: &Ending) -> Option<Warning> {
    let leak = ending.leak.filter(|leak| leak.is_pushed_out)?;
    let name = &model.plan.problem.resolved.fluids[leak.fluid].name;
    let pressure = leak.pressures[1];
    Some(Warning::new(
        WarningKind::PushedOut,
        name,
        Some(pressure),
        format!(
            "fluid `{name}` does not creep through: at a pressure of {} nothing holds the body any more, it is lifted or slides out",
            digits(pressure)
        ),
    ))
}

/// A snap-through on the way, and a saddle at the end.
fn of_stability(model: &Model<'_>, ending: &Ending, all: &mut Vec<Warning>) {
    if let Some(snap) = ending.snapped {
        let snapped = snap.in_units(&model.plan.problem.units);
        let [x, y, z] = snapped.point;
        all.push(Warning::new(
            WarningKind::Snapped,
            "",
            Some(snapped.largest_motion),
            format!(
                "{}: the point ({x:.4}, {y:.4}, {z:.4}) moved by {:.4}",
                if snap.was_lost { "the body snapped to another equilibrium" } else { "the way of the body could not be followed, though no motion was seen to be unstable, and it went down its energy to an equilibrium that may be another one" },
                snapped.largest_motion
            ),
        ));
    }
    if let Some(alternative) = ending.alternative {
        let [own, other] = [alternative.own, alternative.other]
            .map(|[stick, slip, open]| format!("{stick} stick, {slip} slip and {open} are open"));
        all.push(Warning::new(
            WarningKind::NotUnique,
            "",
            Some(alternative.indicator),
            format!("friction may admit another equilibrium: here {own}, there {other}; which one a body takes depends on its path, try smaller increments (indicator {:.2}, from 1 on)", alternative.indicator),
        ));
    }
    let is_saddle = ending.stability == Some(Stability::Saddle);
    if is_saddle && ending.termination == Termination::Converged {
        all.push(Warning::new(
            WarningKind::UnstableEquilibrium,
            "",
            None,
            "the equilibrium is a saddle of the energy: the body would leave it".to_owned(),
        ));
    }
}

/// An obstacle inside the body where nothing presses.
fn missed(model: &Model<'_>, name: &str, overlap: f64) -> Option<Warning> {
    let deepest = overlap * model.plan.problem.units.length;
    (deepest > 0.0).then(|| {
        Warning::new(
            WarningKind::MissedContact,
            name,
            Some(deepest),
            format!("obstacle `{name}` overlaps the body by {} between the nodes of a face: the mesh is too coarse to feel it", digits(deepest)),
        )
    })
}

/// An obstacle inside the body where a support holds it.
fn held_inside(model: &Model<'_>, touch: &Touch<'_>) -> Option<Warning> {
    (touch.held_inside > INSIDE).then(|| {
        let name = &touch.interface.name;
        let depth = touch.held_inside * model.plan.problem.units.length;
        Warning::new(
            WarningKind::MissedContact,
            name,
            Some(depth),
            format!("obstacle `{name}` is {} deep inside the body where a support holds it: supports come first, so that nothing presses there", digits(depth)),
        )
    })
}

/// An obstacle that lies inside the body and presses nowhere.
fn interior_penetration(model: &Model<'_>, touch: &Touch<'_>) -> Option<Warning> {
    let is_felt = touch.overlap() > 0.0;
    (touch.inside > INSIDE && !is_felt).then(|| {
        let (name, depth) = (&touch.interface.name, touch.inside * model.plan.problem.units.length);
        Warning::new(
            WarningKind::PassedThrough,
            name,
            Some(depth),
            format!("obstacle `{name}` is {} deep inside the body and presses nowhere: it has slipped in between the nodes of its surface, smaller faces or more increments would feel it", digits(depth)),
        )
    })
}

/// An obstacle that presses on nodes while the faces between them bulge far into it.
fn sunk(model: &Model<'_>, touch: &Touch<'_>) -> Option<Warning> {
    touch.sunk().map(|(depth, size)| {
        let name = &touch.interface.name;
        let [depth, size] = [depth, size].map(|x| x * model.plan.problem.units.length);
        Warning::new(
            WarningKind::MissedContact,
            name,
            Some(depth),
            format!("the body bulges by {} into obstacle `{name}` between the nodes of a pressed face of {}: where it is confined this volume is missing in the force; use smaller faces", digits(depth), digits(size)),
        )
    })
}

/// An obstacle that presses, and lies inside the body where the scene lets it press nowhere.
fn beside(model: &Model<'_>, touch: &Touch<'_>) -> Option<Warning> {
    (touch.inside > INSIDE.max(touch.usual_depth())).then(|| {
        let (name, depth) = (&touch.interface.name, touch.inside * model.plan.problem.units.length);
        Warning::new(
            WarningKind::MissedContact,
            name,
            Some(depth),
            format!("obstacle `{name}` is {} deep inside a part of the body that its `on` does not name, and presses nowhere there", digits(depth)),
        )
    })
}

/// Obstacles under which facets stand for a curved surface too coarsely, by their results.
pub(crate) fn coarse_facets(results: &BTreeMap<String, ObstacleResult>) -> Vec<Warning> {
    let coarse = |(name, result): (&String, &ObstacleResult)| {
        let error = result
            .geometry_error
            .filter(|&error| error > COARSE_FACETS)?;
        let percent = 100.0 * error;
        Some(Warning::new(
            WarningKind::CoarseFacets,
            name,
            Some(error),
            format!(
                "the facets under obstacle `{name}` are off the curved surface by {percent:.0} % of its squeeze: use a mesh of second order or `surface = \"smooth\"`"
            ),
        ))
    };
    results.iter().filter_map(coarse).collect()
}

/// A curved contact on a few functions, and the size of faces that would resolve it.
fn coarse(model: &Model<'_>, state: &State, touch: &Touch<'_>) -> Option<Warning> {
    let status = touch.interface.own(&state.status);
    let closed = status.iter().filter(|status| status.is_closed()).count();
    let surface_dimension = model.plan.problem.units.dimension - 1;
    let few = match model.plan.problem.contact_space {
        ContactSpace::Linear => FEW,
        ContactSpace::Quadratic => FEW_QUADRATIC,
    }[surface_dimension - 1];
    (touch.is_curved && (1..=few).contains(&closed)).then(|| {
        let name = &touch.interface.name;
        let share = closed as f64 / (ENOUGH * few) as f64;
        let size = touch.pressed_size() * share.powf(1.0 / surface_dimension as f64);
        let size = size * model.plan.problem.units.length;
        Warning::new(
            WarningKind::CoarseContact,
            name,
            Some(closed as f64),
            format!("obstacle `{name}` presses on {closed} functions of the mesh only: force and pressure are inexact, faces of {} there would resolve them", digits(size)),
        )
    })
}

/// Rigid motions, strains and digits.
fn of_the_body(model: &Model<'_>, state: &State, ending: &Ending, all: &mut Vec<Warning>) {
    let strain = largest_strain(model, state);
    let lost = lost_digits(model, state, ending, strain);
    all.extend(unheld(model, state, lost.is_some()));
    let resolved = &model.plan.problem.resolved;
    // A manufactured field is no motion that anyone has seen.
    let is_field = resolved.is_flow() || resolved.manufactured.is_some();
    if !model.is_rubber() && !is_field && strain > LARGE_STRAIN {
        all.push(Warning::new(
            WarningKind::LargeStrain,
            "",
            Some(strain),
            format!(
                "strains reach {:.0} %: linear elasticity is not meant for this",
                100.0 * strain
            ),
        ));
    }
    let lost = lost.or_else(|| lost_in_contrast(model));
    all.extend(lost.or_else(|| lost_to_rounding(ending)));
}

/// A body that supports leave free, and obstacles too: one alone pushes it before it, with forces
/// that are rounding, so that digits are lost.
fn unheld(model: &Model<'_>, state: &State, is_lost: bool) -> Option<Warning> {
    let list = model.interfaces.list.iter();
    let touching = list.filter(|one| one.tie().is_none()).filter(|interface| {
        let own = interface.own(&state.status);
        own.iter().any(|status| status.is_closed())
    });
    let is_held = match touching.count() {
        0 => false,
        1 => !is_lost || has_loads(model, state),
        _ => true,
    };
    (model.plan.is_floating() && !is_held).then(|| {
        let modes = model.plan.problem.resolved.free_modes.join(", ");
        Warning::new(
            WarningKind::FreeMotion,
            "",
            None,
            format!("nothing holds the body: supports leave {modes}, and no obstacle presses it onto another one"),
        )
    })
}

/// Whether anything but tools and supports presses on the body.
fn has_loads(model: &Model<'_>, state: &State) -> bool {
    state.drive.has_loads(model.plan) || state.drive.has_fluid_pressure()
}

/// Moduli so far apart that the rounding of the stiff part's forces shows in the soft one's.
fn lost_in_contrast(model: &Model<'_>) -> Option<Warning> {
    let contrast = model.plan.problem.contrast();
    let rounding = f64::EPSILON * contrast;
    (rounding > LOST).then(|| {
        Warning::new(
            WarningKind::LostDigits,
            "",
            Some(contrast),
            format!("moduli are {contrast:.0e} apart: the relative accuracy of forces in the soft part is about {rounding:.0e}"),
        )
    })
}

/// Stretched cells, or moduli far apart, on which rounding leaves more out of balance than the
/// tolerance.
fn lost_to_rounding(ending: &Ending) -> Option<Warning> {
    let left = ending.residuals.largest();
    let is_solved = ending.termination == Termination::Converged;
    (is_solved && left > ending.tolerance).then(|| {
        Warning::new(
            WarningKind::LostDigits,
            "",
            Some(left),
            format!("rounding leaves {left:.0e} of the forces out of balance: cells are very flat, or moduli far apart"),
        )
    })
}

/// Displacements so large, or strains of rubber so small, that rounding shows in the forces.
fn lost_digits(model: &Model<'_>, state: &State, ending: &Ending, strain: f64) -> Option<Warning> {
    let sizes = state.displacement.iter().map(|u| u.abs());
    let largest = sizes.fold(0.0, f64::max);
    // Gaps, and gradients of rubber, are those of a body of length one. What has come to rest is
    // all rounding.
    let touches = state.status.iter().any(|status| status.is_closed());
    let is_driven = touches || state.drive.moves_supports() || has_loads(model, state);
    let length = if touches || (model.is_rubber() && is_driven) {
        largest.max(1.0)
    } else {
        largest
    };
    let rounding = f64::EPSILON * length * (model.mesh.cell_count() as f64).cbrt();
    let unsolved = ending.residuals.largest() * largest;
    let bound = strain.min(1.0);
    (strain > 0.0 && (rounding > LOST * bound || unsolved > WRONG * bound)).then(|| {
        Warning::new(
            WarningKind::LostDigits,
            "",
            Some(largest * model.plan.problem.units.length),
            format!("strains of {strain:.1e} are so small beside displacements and lengths that digits of the forces are lost"),
        )
    })
}

/// Largest entry of the strain at the centroids of the cells.
fn largest_strain(model: &Model<'_>, state: &State) -> f64 {
    let corners = model.mesh.cell_kind().vertices();
    let mut centroid = [0.0; 4];
    centroid[..corners].fill(1.0 / corners as f64);
    let of_cell = |cell: usize| {
        let gradient = gradient_at(model, state, cell, &centroid);
        let entries = (0..3).flat_map(|i| (0..3).map(move |j| (i, j)));
        entries
            .map(|(i, j)| 0.5 * (gradient[i][j] + gradient[j][i]).abs())
            .fold(0.0, f64::max)
    };
    (0..model.mesh.cell_count())
        .map(of_cell)
        .fold(0.0, f64::max)
}
