//! Closed boxes of two blocks at pressures far above their shear moduli: flat, wavy and kinked
//! surfaces between them, whose meshes do not match.

use std::sync::Arc;

use super::scenes::{between, joined, rubber};
use crate::common::meshes::{mesh, moved, unit_grid};
use crate::common::scenes::{pull, support};
use crate::common::{assert_converged, close, node_positions, run, values};
use signorini::report::Stability;
use signorini::scene::{Choice, StabilityCheck};
use signorini::{EdgeOffset, FieldName, Mesh, Scene};

/// Height of the surface between the blocks.
type Surface = fn(f64) -> f64;

const FLAT: Surface = |_| 1.0;
const WAVY: Surface = |x| 1.0 + 0.1 * (std::f64::consts::TAU * x).cos();
const KINKED: Surface = |x| 0.95 + 0.2 * (x - 0.5).abs();

/// How far the lid goes down.
const WAY: f64 = 0.1;

/// Two blocks in a box of height two, the lower one `counts[0]` cells across; edges follow the surface.
fn boxed(counts: [usize; 2], surface: Surface) -> Arc<Mesh> {
    let lower = |[x, y, z]: [f64; 3]| [x, y * surface(x), z];
    let upper = |[x, y, z]: [f64; 3]| [x, surface(x) + y * (2.0 - surface(x)), z];
    let [low, up] = counts.map(|count| unit_grid(count, count));
    let straight = mesh(joined(&[("a_", low.clone()), ("b_", up.clone())]));
    let of_lower = low.coordinates.len();
    let at = |vertex: u32, x: [f64; 3]| {
        if (vertex as usize) < of_lower {
            lower(x)
        } else {
            upper(x)
        }
    };
    let offset = |&ends: &[u32; 2]| {
        let [a, b] = ends.map(|end| straight.coordinates()[end as usize]);
        let middle = at(ends[0], [0, 1, 2].map(|i| 0.5 * (a[i] + b[i])));
        let [a, b] = [at(ends[0], a), at(ends[1], b)];
        let offset = [0, 1, 2].map(|i| middle[i] - 0.5 * (a[i] + b[i]));
        EdgeOffset { ends, offset }
    };
    let offsets = straight.edges().iter().map(offset).collect();
    let parts = joined(&[("a_", moved(low, lower)), ("b_", moved(up, upper))]);
    Arc::new(Mesh::second_order(parts, offsets).expect("a valid mesh"))
}

/// Area of the deformed bodies, by the parabolas of their cells' edges.
fn deformed_area(mesh: &Mesh, displacement: &[f64]) -> f64 {
    let places = node_positions(mesh);
    let offset = |node: usize| match node.checked_sub(mesh.vertex_count()) {
        Some(edge) => mesh.offset_of(edge),
        None => [0.0; 3],
    };
    let place = |node: usize| {
        [0, 1].map(|i| places[node][i] + offset(node)[i] + displacement[3 * node + i])
    };
    let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
    let of_edge = |[a, b]: [u32; 2]| {
        let edge = mesh.edge_between(a, b).expect("an edge") as usize;
        let middle = place(mesh.vertex_count() + edge);
        let [a, b] = [place(a as usize), place(b as usize)];
        let along = [b[0] - a[0], b[1] - a[1]];
        let bulge = [0, 1].map(|i| middle[i] - 0.5 * (a[i] + b[i]));
        0.5 * cross(a, b) + 2.0 / 3.0 * cross(bulge, along)
    };
    let of_cell = |cell: usize| -> f64 {
        let own = mesh.cell(cell);
        let corners = [own[0], own[1], own[2]];
        (0..3)
            .map(|k| of_edge([corners[k], corners[(k + 1) % 3]]))
            .sum::<f64>()
            .abs()
    };
    (0..mesh.cell_count()).map(of_cell).sum()
}

/// A box squeezed by a twentieth; what the bodies fill of it, and programs.
fn squeezed(counts: [usize; 2], surface: Surface, bulk: f64) -> (f64, u32) {
    let mesh = boxed(counts, surface);
    let side = |name: &str| support(name, [Some(0.0), None, None]);
    let mut scene = Scene {
        supports: vec![
            support("a_y0", [None, Some(0.0), None]),
            support("b_y1", [None, Some(0.0), None]),
            side("a_x0"),
            side("a_x1"),
            side("b_x0"),
            side("b_x1"),
        ],
        contacts: between("b_y0", "a_y1"),
        ..rubber([("a_body", 1.0), ("b_body", 1.0)], Some(bulk))
    };
    scene.solver.tolerance = 1e-10;
    scene.solver.stability = Choice::Named(StabilityCheck::Exact);
    let step = pull("b_y1", [None, Some(-WAY), None], 1);
    let (session, reports) = run(&scene, &[step], &mesh);
    let report = &reports[0];
    assert_converged(report);
    assert_eq!(
        report.stability,
        Some(Stability::Minimum),
        "{counts:?} {bulk}"
    );
    let contact = &report.contacts["pair"];
    // All of the volume is lost evenly: p = K (1 - J) along the whole box.
    let pressure = bulk * WAY / 2.0;
    assert!(close(contact.force[1], pressure, 0.05));
    let area = deformed_area(&mesh, &values(&session, FieldName::Displacement));
    (area, report.sqp_iterations)
}

#[test]
fn closed_boxes_are_stable_to_ten_thousand_moduli_whatever_lies_between() {
    for surface in [FLAT, WAVY, KINKED] {
        for counts in [[6, 8], [8, 6]] {
            for bulk in [2e3, 2e5] {
                let (area, programs) = squeezed(counts, surface, bulk);
                assert!((area - (2.0 - WAY)).abs() < 1e-10, "{area:e}");
                assert!(programs <= 6, "{programs}");
            }
        }
    }
}
