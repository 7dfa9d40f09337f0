//! Closed boxes of two blocks in space at pressures far above their shear moduli, flat and wavy.

use std::sync::Arc;

use signorini::element::quadrature::{Simplex, rule};
use signorini::report::Stability;
use signorini::scene::{Choice, StabilityCheck};
use signorini::{EdgeOffset, FieldName, GroupKind, Mesh, Scene};

use crate::common::meshes::{mesh, moved, unit_box};
use crate::common::scenes::{pull, support};
use crate::common::{assert_converged, close, node_positions, run, values};
use crate::scenes::{between, joined, rubber};

/// Height of the surface between the blocks.
type Surface = fn([f64; 2]) -> f64;

const FLAT: Surface = |_| 1.0;
const WAVY: Surface = |[x, y]| {
    let wave = |x: f64| (std::f64::consts::PI * x).cos();
    1.0 + 0.08 * wave(x) * wave(y)
};

/// How far the lid goes down.
const WAY: f64 = 0.1;

/// Two blocks in a box of height two of those cells across; edges follow the surface.
fn boxed(counts: [usize; 2], surface: Surface) -> Arc<Mesh> {
    let lower = |[x, y, z]: [f64; 3]| [x, y, z * surface([x, y])];
    let upper = |[x, y, z]: [f64; 3]| {
        let height = surface([x, y]);
        [x, y, height + z * (2.0 - height)]
    };
    let [low, up] = counts.map(|count| unit_box([count, count, 2]));
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

/// int z dx dy over a deformed surface.
fn below(mesh: &Mesh, on: &str, displacement: &[f64]) -> f64 {
    let places = node_positions(mesh);
    let place = |node: usize| {
        let offset = match node.checked_sub(mesh.vertex_count()) {
            Some(edge) => mesh.offset_of(edge),
            None => [0.0; 3],
        };
        [0, 1, 2].map(|i| places[node][i] + offset[i] + displacement[3 * node + i])
    };
    let rule = rule(Simplex::Triangle, 6);
    let group = mesh.group(on, GroupKind::Facets).expect("a side");
    let of_facet = |&facet: &u32| {
        let corners = mesh.facet(facet as usize);
        let mut nodes = Vec::from_iter(corners.iter().map(|&v| place(v as usize)));
        for [i, j] in [[0, 1], [0, 2], [1, 2]] {
            let edge = mesh.edge_between(corners[i], corners[j]).expect("an edge");
            nodes.push(place(mesh.vertex_count() + edge as usize));
        }
        let points = rule.points.iter().zip(&rule.weights);
        let values = points.map(|(l, weight)| {
            let [r, s, t, _] = *l;
            let sum = |factors: [f64; 6]| {
                [0, 1, 2].map(|i| (0..6).map(|k| factors[k] * nodes[k][i]).sum::<f64>())
            };
            let (r2, s2, t2) = (2.0 * r - 1.0, 2.0 * s - 1.0, 2.0 * t - 1.0);
            let [_, _, z] = sum([
                r * r2,
                s * s2,
                t * t2,
                4.0 * r * s,
                4.0 * r * t,
                4.0 * s * t,
            ]);
            let (r4, s4, t4) = (4.0 * r, 4.0 * s, 4.0 * t);
            let a = sum([1.0 - r4, s4 - 1.0, 0.0, r4 - s4, -t4, t4]);
            let b = sum([1.0 - r4, 0.0, t4 - 1.0, -s4, r4 - t4, s4]);
            0.5 * weight * z * (a[0] * b[1] - a[1] * b[0])
        });
        values.sum::<f64>().abs()
    };
    group.members.iter().map(of_facet).sum()
}

/// A box squeezed by a twentieth; what the upper block is above the lower one in the mean, and
/// programs.
fn squeezed(counts: [usize; 2], surface: Surface, bulk: f64) -> (f64, u32) {
    let mesh = boxed(counts, surface);
    let across = |name: &str, axis: usize| {
        support(name, std::array::from_fn(|i| (i == axis).then_some(0.0)))
    };
    let mut supports = vec![across("a_z0", 2), across("b_z1", 2)];
    for body in ["a", "b"] {
        for (axis, side) in ["x", "y"].iter().enumerate() {
            supports.push(across(&format!("{body}_{side}0"), axis));
            supports.push(across(&format!("{body}_{side}1"), axis));
        }
    }
    let mut scene = Scene {
        supports,
        contacts: between("b_z0", "a_z1"),
        ..rubber([("a_body", 1.0), ("b_body", 1.0)], Some(bulk))
    };
    scene.solver.tolerance = 1e-10;
    scene.solver.stability = Choice::Named(StabilityCheck::Exact);
    let step = pull("b_z1", [None, None, Some(-WAY)], 1);
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
    assert!(
        close(contact.force[2], pressure, 0.06),
        "{:?}",
        contact.force
    );
    let moved = values(&session, FieldName::Displacement);
    let gap = below(&mesh, "b_z0", &moved) - below(&mesh, "a_z1", &moved);
    (gap, report.sqp_iterations)
}

#[test]
fn closed_boxes_in_space_are_stable_far_above_their_moduli_flat_and_wavy() {
    // At 1e4 shear moduli a carrier that is the finer and wavy takes nine programs.
    for (surface, bulk, most) in [
        (FLAT, 2e3, 6),
        (FLAT, 2e5, 6),
        (WAVY, 2e3, 6),
        (WAVY, 2e5, 10),
    ] {
        for counts in [[3, 4], [4, 3]] {
            let (gap, programs) = squeezed(counts, surface, bulk);
            assert!(gap.abs() < 1e-10, "{gap:e}");
            assert!(programs <= most, "{programs}");
        }
    }
}
