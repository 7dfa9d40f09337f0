//! Linear bodies that are apart at rest, or inside each other: forces are those of bodies that begin in
//! touch, however far the gap was.

use signorini::scene::SceneKind;
use signorini::{MeshParts, Scene, Step, StepReport, Termination};

use super::scenes::{between, joined, linear_of, rubber as rubber_of};
use crate::common::meshes::{curved_file_placed, mesh, moved, unit_box, unit_grid};
use crate::common::scenes::{HELD_IN_PLANE, pull, support};
use crate::common::{run_one, solve};

/// How far the bodies are pressed beyond touch.
const PRESS: f64 = 0.05;
/// Modulus of confined compression over the shear modulus at Poisson's ratio 0.3.
const CONFINED: f64 = 2.0 * (1.0 - 0.3) / (1.0 - 2.0 * 0.3);
/// Gaps at rest over the side of the blocks.
const GAPS: [f64; 6] = [-0.24, -0.05, 0.0, 0.05, 0.1, 0.2];

/// Force across two blocks of unit side, the upper one three times as stiff, in series.
fn in_series() -> f64 {
    CONFINED * PRESS / (1.0 + 1.0 / 3.0)
}

/// The two squares `gap` apart between side walls, pressed together.
fn squares(gap: f64, kind: Option<SceneKind>, [first, second]: [&str; 2]) -> StepReport {
    let upper = moved(unit_grid(3, 3), |[x, y, z]| [x, y + 1.0 + gap, z]);
    let body = mesh(joined(&[("a_", unit_grid(4, 4)), ("b_", upper)]));
    let wall = |name: &str| support(name, [Some(0.0), None, None]);
    let end = |name: &str| support(name, [None, Some(0.0), None]);
    let mut supports = vec![end("a_y0"), end("b_y1")];
    supports.extend(["a_x1", "b_x1"].map(wall));
    if kind.is_none() {
        supports.extend(["a_x0", "b_x0"].map(wall));
    }
    let mut scene = Scene {
        kind,
        supports,
        contacts: between(first, second),
        ..linear_of(0.3, [("a_body", 1.0), ("b_body", 3.0)])
    };
    scene.solver.tolerance = 1e-12;
    let step: Step = pull("b_y1", [None, Some(-gap - PRESS), None], 1);
    run_one(&scene, &step, &body).1
}

#[test]
fn squares_press_by_what_they_are_pressed_beyond_touch() {
    for gap in GAPS {
        for sides in [["b_y0", "a_y1"], ["a_y1", "b_y0"]] {
            let plane = squares(gap, None, sides).contacts["pair"].force[1].abs();
            assert!((plane / in_series() - 1.0).abs() < 1e-8, "{gap} {plane}");
            let round = squares(gap, Some(SceneKind::Axisymmetric), sides);
            let round = round.contacts["pair"].force[1].abs() / std::f64::consts::PI;
            assert!((round / in_series() - 1.0).abs() < 1e-8, "{gap} {round}");
        }
    }
}

#[test]
fn cubes_press_by_what_they_are_pressed_beyond_touch() {
    for gap in [-0.2, 0.0, 0.1, 0.3] {
        let upper = moved(unit_box([2, 3, 2]), |[x, y, z]| [x, y, z + 1.0 + gap]);
        let body = mesh(joined(&[("a_", unit_box([3, 2, 2])), ("b_", upper)]));
        let held =
            |name: &str, axis: usize| support(name, [0, 1, 2].map(|i| (i == axis).then_some(0.0)));
        let walls = ["a", "b"].map(|own| {
            let named = |side: &str| format!("{own}_{side}");
            [("x0", 0), ("x1", 0), ("y0", 1), ("y1", 1)].map(|(side, i)| held(&named(side), i))
        });
        let ends = vec![held("a_z0", 2), held("b_z1", 2)];
        let mut scene = Scene {
            supports: walls.into_iter().flatten().chain(ends).collect(),
            contacts: between("b_z0", "a_z1"),
            ..linear_of(0.3, [("a_body", 1.0), ("b_body", 3.0)])
        };
        scene.solver.tolerance = 1e-12;
        let step = pull("b_z1", [None, None, Some(-gap - PRESS)], 1);
        let (_, report) = run_one(&scene, &step, &body);
        let force = report.contacts["pair"].force[2].abs();
        assert!((force / in_series() - 1.0).abs() < 1e-8, "{gap} {force}");
    }
}

/// A stiff block above a soft one, led through the gap in four increments: as long as it meets nothing it goes as
/// a whole, and what it leaves of forces is the rounding of its own moduli.
#[test]
fn stiff_rubber_is_led_through_a_gap_to_what_it_presses() {
    let force = |contrast: f64, increments: u32| {
        let upper = moved(unit_grid(2, 2), |[x, y, z]| [0.2 + 0.6 * x, y + 1.05, z]);
        let body = mesh(joined(&[("a_", unit_grid(4, 4)), ("b_", upper)]));
        let mut scene = Scene {
            supports: vec![
                support("a_y0", HELD_IN_PLANE),
                support("b_y1", HELD_IN_PLANE),
            ],
            contacts: between("a_y1", "b_y0"),
            ..rubber_of([("a_body", 1.0), ("b_body", contrast)], None)
        };
        scene.contacts[0].carries = Some("b_y0".to_owned());
        let step: Step = pull("b_y1", [Some(0.1), Some(-0.15), None], increments);
        let reports = solve(&scene, &[step], &body);
        let last = reports.last().expect("a report");
        assert_eq!(last.termination, Termination::Converged, "{contrast}");
        assert_eq!(reports.len(), increments as usize, "{contrast}");
        last.contacts["pair"].force[1]
    };
    for contrast in [30.0, 1e3, 1e4, 1e6] {
        let [one, four] = [1, 4].map(|increments| force(contrast, increments));
        assert!((one / four - 1.0).abs() < 1e-6, "{contrast} {one} {four}");
    }
}

/// A round tip a million times as stiff as the block beneath it, half of it about an axis: where it is just about to
/// touch forces are far below the rounding of its displacements times its moduli.
#[test]
fn stiff_tips_come_to_touch_in_any_number_of_increments() {
    let force = |kind: Option<SceneKind>, increments: u32| {
        let is_round = kind.is_some();
        let [from, width] = if is_round { [0.0, 0.5] } else { [0.2, 0.6] };
        let [curvature, centre] = if is_round { [0.2, 0.0] } else { [0.8, 0.5] };
        let tip = |[x, y, z]: [f64; 3]| {
            let raised = curvature * (x - centre).powi(2) * (1.0 - y);
            [from + width * x, 0.65 + 0.4 * y + raised, z]
        };
        let block = moved(unit_grid(12, 6), |[x, y, z]| [x, 0.6 * y, z]);
        let upper = moved(unit_grid(5, 2), tip);
        let body = mesh(joined(&[("a_", block), ("b_", upper)]));
        let mut scene = Scene {
            kind,
            supports: vec![
                support("a_y0", HELD_IN_PLANE),
                support("b_y1", HELD_IN_PLANE),
            ],
            contacts: between("a_y1", "b_y0"),
            ..rubber_of([("a_body", 1.0), ("b_body", 1e6)], None)
        };
        // Its textbook laws lose a unit in the last place of the modulus.
        scene.solver.verify = false;
        if is_round {
            let axis = ["a_x0", "b_x0"].map(|side| support(side, [Some(0.0), None, None]));
            scene.supports.extend(axis);
        }
        let reports = solve(
            &scene,
            &[pull("b_y1", [None, Some(-0.1), None], increments)],
            &body,
        );
        let last = reports.last().expect("a report");
        assert_eq!(last.termination, Termination::Converged, "{increments}");
        assert_eq!(reports.len(), increments as usize);
        last.contacts["pair"].force[1]
    };
    for kind in [None, Some(SceneKind::Axisymmetric)] {
        let [one, five, seven] = [1, 5, 7].map(|increments| force(kind, increments));
        for many in [five, seven] {
            assert!((one / many - 1.0).abs() < 1e-6, "{one} {many}");
        }
    }
}

/// Force on the lower block where the upper one, narrower by what the mesh is shifted, is lowered through
/// the gap and dragged to the side in the same increment.
fn dragged(gap: f64) -> [f64; 3] {
    let upper = moved(unit_grid(3, 3), |[x, y, z]| {
        [0.1 + 0.8 * x, y + 1.0 + gap, z]
    });
    let body = mesh(joined(&[("a_", unit_grid(4, 4)), ("b_", upper)]));
    let mut contacts = between("b_y0", "a_y1");
    contacts[0].friction = 0.3;
    let mut scene = Scene {
        supports: vec![
            support("a_y0", HELD_IN_PLANE),
            support("b_y1", HELD_IN_PLANE),
        ],
        contacts,
        ..linear_of(0.3, [("a_body", 1.0), ("b_body", 3.0)])
    };
    scene.solver.tolerance = 1e-12;
    let step = pull("b_y1", [Some(0.05), Some(-gap - PRESS), None], 1);
    run_one(&scene, &step, &body).1.contacts["pair"].force
}

#[test]
fn blocks_are_dragged_along_as_those_that_begin_in_touch() {
    let exact = dragged(0.0);
    assert!(exact[0].abs() > 0.01 && exact[1].abs() > 0.1, "{exact:?}");
    for gap in [-0.1, 0.1, 0.2] {
        let found = dragged(gap);
        for (found, exact) in found.iter().zip(&exact) {
            assert!((found - exact).abs() < 1e-7, "{gap} {found} {exact}");
        }
    }
}

/// A mesh of which one body is raised.
fn raised(mut parts: MeshParts, body: &str, by: f64) -> MeshParts {
    let group = parts.groups.iter().find(|group| group.name == body);
    let corners = parts.cell_kind.vertices();
    let cells = group.expect("a body").members.iter();
    let vertices = cells.flat_map(|&cell| &parts.cells[cell as usize * corners..][..corners]);
    let vertices: std::collections::BTreeSet<u32> = vertices.copied().collect();
    let last = parts.cell_kind.dimension() - 1;
    for vertex in vertices {
        parts.coordinates[vertex as usize][last] += by;
    }
    parts
}

/// Force of quarters of two cylinders of radius one, the upper one `gap` above the lower one, pressed
/// together by .02 beyond touch.
fn cylinders(gap: f64, carrier: [&str; 2]) -> f64 {
    let body = curved_file_placed("pair_discs", |parts| raised(parts, "slave", gap));
    let across = |name: &str| support(name, [None, Some(0.0), None]);
    let axis = |name: &str| support(name, [Some(0.0), None, None]);
    let scene = Scene {
        supports: vec![
            across("s_eq"),
            across("m_eq"),
            axis("s_axis"),
            axis("m_axis"),
        ],
        contacts: between(carrier[0], carrier[1]),
        ..linear_of(0.3, [("slave", 1.0), ("master", 1.0)])
    };
    let step = pull("s_eq", [None, Some(-gap - 0.02), None], 1);
    let (_, report) = run_one(&scene, &step, &body);
    report.contacts["pair"].force[1].abs()
}

#[test]
fn cylinders_press_by_what_they_are_pressed_beyond_touch() {
    for carrier in [["s_con", "m_con"], ["m_con", "s_con"]] {
        let exact = cylinders(0.0, carrier);
        for gap in [0.03, 0.1, 0.2] {
            let found = cylinders(gap, carrier) / exact;
            assert!((found - 1.0).abs() < 2e-4, "{carrier:?} {gap} {found}");
        }
    }
}
