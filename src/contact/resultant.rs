//! Force, moment, area and centre of the contact pressure of one obstacle, by
//! the gap's own rule, so that they balance the multipliers exactly.

use super::gap::Deformed;
use super::surface::ContactSurface;
use crate::obstacle::Obstacle;

/// Resultants on the body, non-dimensional.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Resultant {
    /// int lambda n dS.
    pub force: [f64; 3],
    /// int (x + u - reference) x lambda n dS.
    pub moment: [f64; 3],
    /// Undeformed area of active vertices.
    pub area: f64,
    /// Largest lambda.
    pub max_pressure: f64,
    /// int lambda (x + u) dS / int lambda dS; zero without pressure.
    pub centre: [f64; 3],
}

/// Resultants of `pressure` `[multipliers]`; `active` marks vertices in contact.
pub fn resultant(
    body: &Deformed<'_>,
    surface: &ContactSurface,
    obstacle: &dyn Obstacle,
    reference: [f64; 3],
    pressure: &[f64],
    active: &[bool],
) -> Resultant {
    let mut out = Resultant::default();
    let mut total = 0.0;
    for face in &surface.faces {
        if face
            .multipliers
            .iter()
            .all(|&m| pressure[m as usize] == 0.0)
        {
            continue;
        }
        for point in body.points(face) {
            let at_corners = face.multipliers.iter().zip(&point.hats);
            let local: f64 = at_corners.map(|(&m, hat)| hat * pressure[m as usize]).sum();
            let weight = point.weight * local;
            let normal = obstacle.distance(point.deformed).normal;
            let force = normal.map(|n| weight * n);
            let arm: [f64; 3] = std::array::from_fn(|i| point.deformed[i] - reference[i]);
            total += weight;
            for i in 0..3 {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                out.force[i] += force[i];
                out.moment[i] += arm[j] * force[k] - arm[k] * force[j];
                out.centre[i] += weight * point.deformed[i];
            }
        }
    }
    out.centre = match total > 0.0 {
        true => out.centre.map(|x| x / total),
        false => [0.0; 3],
    };
    for (index, &is_active) in active.iter().enumerate() {
        if is_active {
            out.area += surface.weights[index];
        }
        out.max_pressure = out.max_pressure.max(pressure[index]);
    }
    out
}
