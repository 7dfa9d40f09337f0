//! Loads do exact work on quadratic fields.

use super::{SCALE, Sample, samples};
use crate::assembly::load::{Integral, LoadedFacet, facet_measure};
use crate::element::quadrature::{Rule, Simplex, rule};
use crate::linalg::vector::dot;
use crate::mesh::GroupKind;

/// Hierarchical coefficients of x^2 + 2 x y in component `i`.
fn quadratic(sample: &Sample, i: usize) -> Vec<f64> {
    let value = |x: [f64; 3]| SCALE * SCALE * (x[0] * x[0] + 2.0 * x[0] * x[1]);
    let (c, points) = (sample.space.components, sample.mesh.coordinates());
    let mut field = vec![0.0; sample.unknowns()];
    for (vertex, &point) in points.iter().enumerate() {
        field[vertex * c + i] = value(point);
    }
    for (edge, ends) in sample.space.edges.iter().enumerate() {
        let [a, b] = ends.map(|v| points[v as usize]);
        let middle = std::array::from_fn(|j| 0.5 * (a[j] + b[j]));
        field[(sample.space.vertices + edge) * c + i] = value(middle) - 0.5 * (value(a) + value(b));
    }
    field
}

fn integral<'a>(sample: &'a Sample, rule: &'a Rule) -> Integral<'a> {
    Integral {
        mesh: &sample.mesh,
        space: &sample.space,
        scale: SCALE,
        rule,
    }
}

#[test]
fn a_body_force_does_exact_work_on_quadratic_fields() {
    for sample in samples() {
        let mut load = vec![0.0; sample.unknowns()];
        let rule = sample.volume_rule();
        // Linear in position: f = (x, 3, ..).
        let force = |_: usize, x: [f64; 3]| [x[0], 3.0, 0.0];
        integral(&sample, &rule).add_body_force(&sample.geometry, &force, &mut load);
        // The body is [0, 1/2]^d: int x (x^2 + 2 x y) and 3 int (x^2 + 2 x y).
        let depth = SCALE.powi(sample.space.components as i32 - 2);
        let along = SCALE.powi(5) * (0.25 + 1.0 / 3.0);
        let up = 3.0 * SCALE.powi(4) * (1.0 / 3.0 + 0.5);
        assert!((dot(&load, &quadratic(&sample, 0)) - depth * along).abs() < 1e-14);
        assert!((dot(&load, &quadratic(&sample, 1)) - depth * up).abs() < 1e-14);
    }
}

#[test]
fn a_traction_does_exact_work_on_quadratic_fields() {
    for sample in samples() {
        let mut load = vec![0.0; sample.unknowns()];
        let simplex = match sample.space.components {
            2 => Simplex::Segment,
            _ => Simplex::Triangle,
        };
        let group = sample.mesh.group("x1", GroupKind::Facets).expect("a side");
        let mut total = 0.0;
        for &facet in &group.members {
            let vertices = sample.mesh.facet(facet as usize);
            let (area, normal) = facet_measure(&sample.mesh, vertices, SCALE);
            assert!(
                (normal[0] - 1.0).abs() < 1e-14,
                "{normal:?} points outwards"
            );
            total += area;
            let value = |x: [f64; 3], _: [f64; 3]| [1.0, x[1], 0.0];
            let facet = LoadedFacet::new(&sample.mesh, vertices, SCALE);
            integral(&sample, &rule(simplex, 4)).add_traction(&facet, &value, &mut load);
        }
        let depth = SCALE.powi(sample.space.components as i32 - 2);
        assert!((total - SCALE * depth).abs() < 1e-14);
        // On x = 1/2: int (1/4 + y) and int y (1/4 + y) over y in [0, 1/2].
        let (along, up) = (depth * 0.25, depth * (1.0 / 32.0 + 1.0 / 24.0));
        assert!((dot(&load, &quadratic(&sample, 0)) - along).abs() < 1e-14);
        assert!((dot(&load, &quadratic(&sample, 1)) - up).abs() < 1e-14);
    }
}
