//! A clamp: a bow that holds two pads opposite to each other, pressed shut in space. One half of it on a
//! rigid plane, to rounding.

use std::sync::Arc;

use crate::common::meshes::{mesh, moved, unit_grid, with_pad};
use crate::common::prisms::drawn_out;
use crate::common::scenes::{HELD_IN_PLANE, obstacle, plane, support};
use crate::common::{assert_converged, close, open, solve, take};
use crate::folds::{of_itself, together, with_union};
use crate::pinched::glued;
use crate::scenes::{between, joined, linear_of, rubber};
use signorini::scene::ContactPair;
use signorini::{CancelToken, MeshParts, Plan, Prepared, Reuse, Scene, Session, Step, StepReport};

/// Half the opening between the pads.
const OPEN: f64 = 0.05;
/// How far the back of each pad goes.
const WAY: f64 = 0.1;
/// Height of what is drawn out.
const HIGH: f64 = 0.5;

/// The upper half in the plane: a back along x < 0, an arm above y = 1 and a pad below it.
fn half() -> MeshParts {
    let back = moved(unit_grid(2, 4), |[s, t, z]| [s - 1.0, 2.0 * t, z]);
    let arm = moved(unit_grid(4, 2), |[s, t, z]| [2.0 * s, 1.0 + t, z]);
    let pad = moved(unit_grid(2, 2), |[s, t, z]| {
        [1.0 + s, OPEN + (1.0 - OPEN) * t, z]
    });
    let parts = glued(joined(&[("back_", back), ("arm_", arm), ("pad_", pad)]));
    let parts = with_pad(parts, ("bow", "back_x1"), |[_, y, _]| y <= 1.0);
    let parts = with_pad(parts, ("hollow", "arm_y0"), |[x, ..]| x <= 1.0);
    with_pad(parts, ("grip", "arm_y1"), |[x, ..]| x >= 1.0)
}

/// Both halves; `surface` all that the clamp may touch itself with.
fn whole() -> MeshParts {
    let mut lower = moved(half(), |[x, y, z]| [x, -y, z]);
    lower.cells.chunks_mut(3).for_each(|cell| cell.swap(1, 2));
    let parts = glued(joined(&[("up_", half()), ("low_", lower)]));
    let inside = ["bow", "hollow", "pad_x0", "pad_y0", "pad_x1", "arm_x1"];
    let all = inside.map(|name| ["up_", "low_"].map(|side| format!("{side}{name}")));
    let all: Vec<&str> = all.as_flattened().iter().map(String::as_str).collect();
    with_union(parts, "surface", &all)
}

/// A law of both halves.
type Law = fn([(&str, f64); 6]) -> Scene;

const LAWS: [Law; 2] = [
    |bodies| rubber(bodies, Some(20.0)),
    |bodies| linear_of(0.3, bodies),
];

/// Held between two planes along z.
fn scene(law: Law) -> Scene {
    let bodies = [
        "up_back_body",
        "up_arm_body",
        "up_pad_body",
        "low_back_body",
        "low_arm_body",
        "low_pad_body",
    ];
    let flat = ["z0", "z1"].map(|name| support(name, [None, None, Some(0.0)]));
    let mut scene = Scene {
        supports: flat.into(),
        ..law(bodies.map(|name| (name, 1.0)))
    };
    scene.solver.tolerance = 1e-11;
    scene
}

fn last(scene: &Scene, step: Step, parts: &MeshParts) -> StepReport {
    let mut reports = solve(scene, &[step], &mesh(drawn_out(parts, 1, HIGH)));
    reports.iter().for_each(assert_converged);
    reports.pop().expect("a report")
}

fn half_of_it(law: Law) -> StepReport {
    let mut scene = scene(law);
    scene.materials.truncate(3);
    scene.supports.push(support("up_grip", HELD_IN_PLANE));
    scene
        .supports
        .push(support("up_back_y0", [None, Some(0.0), None]));
    scene.obstacles = vec![obstacle(
        "floor",
        "up_pad_y0",
        plane([0.0; 3], [0.0, 1.0, 0.0]),
    )];
    let mut step = together(["up_grip", "low_grip"], WAY);
    step.supports.truncate(1);
    last(&scene, step, &joined(&[("up_", half())]))
}

fn clamped(law: Law, contacts: Vec<ContactPair>) -> StepReport {
    let mut scene = scene(law);
    let grips = ["up_grip", "low_grip"].map(|name| support(name, HELD_IN_PLANE));
    scene.supports.extend(grips);
    scene.contacts = contacts;
    last(&scene, together(["up_grip", "low_grip"], WAY), &whole())
}

#[test]
fn a_clamp_in_space_is_half_of_it_on_a_rigid_plane_whichever_pad_carries() {
    for law in LAWS {
        let alone = half_of_it(law);
        let expected = alone.obstacles["floor"].force[1];
        assert!(expected > 0.01, "{expected}");
        for (contacts, sign) in [
            (between("up_pad_y0", "low_pad_y0"), 1.0),
            (between("low_pad_y0", "up_pad_y0"), -1.0),
            (of_itself("surface"), 1.0),
        ] {
            let report = clamped(law, contacts);
            let [x, y, _] = report.contacts["pair"].force;
            assert!(close(sign * y, expected, 1e-9), "{y} {expected}");
            assert!(x.abs() < 1e-9 * expected, "{x}");
            assert!(close(report.strain_energy, 2.0 * alone.strain_energy, 1e-9));
        }
    }
}

/// Shut in two steps, taken up again from a checkpoint after the first one: the last checkpoint.
fn taken_up(threads: usize) -> Vec<u8> {
    let mut scene = scene(LAWS[0]);
    let grips = ["up_grip", "low_grip"].map(|name| support(name, HELD_IN_PLANE));
    scene.supports.extend(grips);
    scene.contacts = of_itself("surface");
    let to = |way: f64| together(["up_grip", "low_grip"], way);
    let mesh = mesh(drawn_out(&whole(), 1, HIGH));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.expect("a pool").install(|| {
        let mut session = open(&scene, &mesh);
        take(&mut session, &to(0.07));
        let bytes = session.export();
        let plan = Arc::new(Plan::new(&scene, &[], &mesh).expect("a valid scene"));
        let prepared = Prepared::build(&plan, &mesh, &CancelToken::new());
        let prepared = Arc::new(prepared.expect("a solvable scene"));
        let other = Session::import(plan, mesh.clone(), prepared, Reuse::Reused, &bytes);
        let [own, other] = [session, other.expect("a checkpoint")].map(|mut session| {
            let reports = take(&mut session, &to(WAY));
            assert_converged(&reports[0]);
            assert!(reports[0].contacts["pair"].force[1] > 0.01);
            session.export()
        });
        assert!(own == other);
        own
    })
}

#[test]
fn a_clamp_in_space_goes_on_with_the_same_bits_on_any_number_of_threads() {
    assert!(taken_up(1) == taken_up(3));
}
