//! Force, moment, area and centre of the contact pressure of one obstacle, by
//! the gap's own rule, so that they balance the multipliers exactly.
//!
//! ```text
//! F = int lambda n da,   M = int (x + u - reference) x lambda n da
//! ```
//!
//! over the deformed surface of rubber, the undeformed one of linear bodies; n the normal of what
//! is met, out of it. Cost: one probe a quadrature point of a face under pressure, and for rubber
//! the weights of all faces.

use super::counterpart::Counterpart;
use super::deformed::{Deformed, FacePoints, Table};
use super::surface::ContactSurface;
use crate::geometry::vector3::add;
use crate::obstacle::Derivatives;

/// Resultants on the body, non-dimensional.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Resultant {
    /// Force of the counterpart on the body, int lambda n da `[3]`, non-dimensional.
    pub force: [f64; 3],
    /// int lambda da, which counts pressure and no direction, non-dimensional.
    pub normal_force: f64,
    /// Moment about the reference point, int (x + u - reference) x lambda n da `[3]`,
    /// non-dimensional.
    pub moment: [f64; 3],
    /// Area that belongs to active multipliers, deformed where the pressure is per deformed area:
    /// the sum of their weights, in units of the scaled body.
    pub area: f64,
    /// Largest pressure at the nodes, in units of the smallest shear modulus.
    pub max_pressure: f64,
    /// int lambda (x + u) da / int lambda da; zero without pressure.
    pub centre: [f64; 3],
}

/// Of a point: int lambda dS, then force, moment and lambda (x + u) `[3]`.
const NUMBERS: usize = 10;

/// A contact pressure and what its moment refers to.
#[derive(Clone, Copy, Debug)]
pub struct Acting<'a> {
    /// Point of reference of the moment, non-dimensional `[3]`.
    pub reference: [f64; 3],
    /// Coefficients of the pressure `[multipliers]`.
    pub pressure: &'a [f64],
    /// Which multipliers are in contact `[multipliers]`.
    pub active: &'a [bool],
}

/// Resultants of `pressure` `[multipliers]`; `active` marks multipliers in contact.
pub fn resultant<C: Counterpart + ?Sized>(
    body: &Deformed<'_>,
    surface: &ContactSurface,
    counterpart: &C,
    at: Acting<'_>,
) -> Resultant {
    let coefficients = surface.shares.spread(at.pressure);
    let numbers = numbers(body, surface, counterpart, (&coefficients, at.reference));
    let mut sums = [0.0; NUMBERS];
    for numbers in numbers.chunks_exact(NUMBERS) {
        sums.iter_mut().zip(numbers).for_each(|(sum, x)| *sum += x);
    }
    let [total, f0, f1, f2, m0, m1, m2, c0, c1, c2] = sums;
    let weights = surface.present_weights(body);
    let weights = weights.iter().zip(at.active);
    Resultant {
        normal_force: total,
        force: [f0, f1, f2],
        moment: [m0, m1, m2],
        area: weights.fold(
            0.0,
            |sum, (weight, &is_active)| if is_active { sum + weight } else { sum },
        ),
        max_pressure: surface.largest(&coefficients),
        centre: if total > 0.0 {
            [c0, c1, c2].map(|x| x / total)
        } else {
            [0.0; 3]
        },
    }
}

/// Force of the pressure on each face `[faces][3]`, non-dimensional.
pub(super) fn face_forces<C: Counterpart + ?Sized>(
    body: &Deformed<'_>,
    surface: &ContactSurface,
    counterpart: &C,
    at: Acting<'_>,
) -> Vec<[f64; 3]> {
    let coefficients = surface.shares.spread(at.pressure);
    let numbers = numbers(body, surface, counterpart, (&coefficients, at.reference));
    let of_face = |own: &[f64]| {
        let points = own.chunks_exact(NUMBERS);
        points.fold([0.0; 3], |sum, own| add(sum, [own[1], own[2], own[3]]))
    };
    let faces = numbers.chunks_exact(NUMBERS * body.rule.len());
    faces.map(of_face).collect()
}

/// The numbers of all points `[faces, points, NUMBERS]` under the pressure with these
/// coefficients; moments about the reference point.
fn numbers<C: Counterpart + ?Sized>(
    body: &Deformed<'_>,
    surface: &ContactSurface,
    counterpart: &C,
    (coefficients, reference): (&[f64], [f64; 3]),
) -> Vec<f64> {
    let table = Table::new(body, surface.basis);
    let size = NUMBERS * table.points();
    body.on_faces(&table, &surface.faces, size, |points, face, numbers| {
        let mut functions = face.functions.iter();
        if functions.all(|&k| coefficients[k as usize] == 0.0) {
            return;
        }
        points.probe(counterpart, face, Derivatives::Normal);
        for (point, numbers) in numbers.chunks_exact_mut(NUMBERS).enumerate() {
            let lambda = points.pressure(face, point, coefficients);
            fill(points, point, (lambda, reference), numbers);
        }
    })
}

/// The numbers of one point under the pressure `lambda`.
fn fill(
    points: &FacePoints<'_>,
    point: usize,
    (lambda, reference): (f64, [f64; 3]),
    numbers: &mut [f64],
) {
    let weight = points.weights[point] * lambda;
    let position = points.deformed[point];
    let force = points.contacts[point].normal.map(|n| weight * n);
    let arm: [f64; 3] = std::array::from_fn(|i| position[i] - reference[i]);
    numbers[0] = weight;
    for i in 0..3 {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        numbers[1 + i] = force[i];
        numbers[4 + i] = arm[j] * force[k] - arm[k] * force[j];
        numbers[7 + i] = weight * position[i];
    }
}
