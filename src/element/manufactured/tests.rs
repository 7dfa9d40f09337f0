use super::*;
use crate::element::quadrature::{Simplex, rule};
use crate::geometry::vector3::{norm, scale, sub};

const POINTS: [Vector; 4] = [
    [0.31, 0.67, 0.43],
    [0.0, 1.0, 0.25],
    [-0.7, 0.2, 0.9],
    [0.5, 0.5, 0.5],
];

/// Fields with points of their own dimension.
fn samples() -> impl Iterator<Item = (Manufactured, Vector)> {
    let fields = FIELDS.iter().map(Manufactured);
    fields.flat_map(|field| {
        POINTS.map(move |mut point| {
            point[2] *= if field.dimension() == 3 { 1.0 } else { 0.0 };
            (field, point)
        })
    })
}

/// Central difference of a vector function along an axis.
fn slope(function: impl Fn(Vector) -> Vector, point: Vector, axis: usize) -> Vector {
    let step = 1e-5;
    let (mut ahead, mut behind) = (point, point);
    ahead[axis] += step;
    behind[axis] -= step;
    scale(0.5 / step, sub(function(ahead), function(behind)))
}

#[test]
fn every_name_leads_to_a_field_in_its_dimensions() {
    for name in Manufactured::names() {
        let dimensions: Vec<usize> = (0..5)
            .filter(|&d| Manufactured::from_name(name, d).is_some())
            .collect();
        assert!(
            !dimensions.is_empty() && dimensions.iter().all(|d| (2..=3).contains(d)),
            "{name}"
        );
    }
    for (field, _) in samples() {
        assert!(Manufactured::names().contains(&field.name()));
    }
    assert!(Manufactured::from_name("vortex", 3).is_none());
    assert!(Manufactured::from_name("a1m", 3).is_none());
}

#[test]
fn gradient_is_the_derivative_of_the_displacement() {
    for (field, point) in samples() {
        let gradient = field.gradient(point);
        for axis in 0..3 {
            let expected = slope(|x| field.displacement(x), point, axis);
            let column = gradient.map(|row| row[axis]);
            assert!(
                norm(sub(column, expected)) < 1e-7,
                "{} {point:?} {axis}",
                field.name()
            );
        }
    }
}

#[test]
fn divergence_is_zero() {
    for (field, point) in samples() {
        let gradient = field.gradient(point);
        let divergence = gradient[0][0] + gradient[1][1] + gradient[2][2];
        assert!(divergence.abs() < 1e-13, "{} {divergence:e}", field.name());
    }
}

#[test]
fn body_force_balances_the_stress() {
    for shear_modulus in [1.0, 0.3] {
        for (field, point) in samples() {
            let mut divergence = [0.0; 3];
            for axis in 0..3 {
                let row = slope(|x| field.stress(x, shear_modulus)[axis], point, axis);
                divergence = sub(divergence, scale(-1.0, row));
            }
            let residual = sub(
                field.body_force(point, shear_modulus),
                scale(-1.0, divergence),
            );
            assert!(
                norm(residual) < 2e-6,
                "{} {point:?} {residual:?}",
                field.name()
            );
        }
    }
}

#[test]
fn traction_of_opposite_normals_cancels() {
    for (field, point) in samples() {
        let (normal, opposite) = ([0.6, 0.0, 0.8], [-0.6, 0.0, -0.8]);
        let sum = sub(
            field.traction(point, normal, 2.0),
            scale(-1.0, field.traction(point, opposite, 2.0)),
        );
        assert!(norm(sum) < 1e-12);
    }
    let field = Manufactured::from_name("polynomial", 3).expect("exists");
    let traction = field.traction([0.0; 3], [1.0, 0.0, 0.0], 5.0);
    assert!(
        norm(sub(traction, [-1.0, 0.0, 0.0])) < 1e-15,
        "only pressure at the origin"
    );
}

/// ∫ over the unit cube by a product of segment rules.
fn integral(function: impl Fn(Vector) -> f64) -> f64 {
    let line = rule(Simplex::Segment, 20);
    let nodes: Vec<(f64, f64)> = line
        .points
        .iter()
        .zip(&line.weights)
        .map(|(p, &w)| (p[1], w))
        .collect();
    let mut sum = 0.0;
    for &(x, along_x) in &nodes {
        for &(y, along_y) in &nodes {
            for &(z, along_z) in &nodes {
                sum += along_x * along_y * along_z * function([x, y, z]);
            }
        }
    }
    sum
}

#[test]
fn norms_of_a1m_are_the_published_ones() {
    let field = Manufactured::from_name("A1m", 3).expect("exists");
    let square = |values: &[f64]| values.iter().map(|value| value * value).sum::<f64>();
    let displacement = integral(|x| square(&field.displacement(x))).sqrt();
    let gradient = integral(|x| square(field.gradient(x).as_flattened())).sqrt();
    let pressure = integral(|x| square(&[field.pressure(x)])).sqrt();
    assert!((displacement - 1.220_536_6).abs() < 1e-7, "{displacement}");
    assert!((gradient - 5.373_791_9).abs() < 1e-7, "{gradient}");
    assert!((pressure - 0.235_702_3).abs() < 1e-7, "{pressure}");
}
