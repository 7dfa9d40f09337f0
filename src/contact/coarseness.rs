//! Whether faces are small enough for the pressure on a curved obstacle:
//!
//! ```text
//! c = max over the faces of lambda h kappa / (4 mu),   stable where c < 1
//! ```
//!
//! kappa: largest curvature of the obstacle, 1 / R; h: size of a face; mu: shear modulus,
//! one in units of the scaled body. The normal of a curved obstacle varies over a face, so
//! that n . u is no quadratic function there, and pressure has room for a zigzag of the
//! nodes from p of some 4 mu R / h on: a property of the mesh, not of the body. Measured on
//! confined blocks under cylinders, R / h from 16 to 128: 4 to 6. Cost: one probe a point of
//! the faces under pressure.

use super::counterpart::Counterpart;
use super::deformed::{Deformed, FacePoints, Table};
use super::face::ContactFace;
use super::surface::ContactSurface;
use crate::obstacle::What;

/// Pressure times face size times curvature, in shear moduli, up to which a mesh holds.
const BEARABLE: f64 = 4.0;

/// The face that is largest beside what its pressure allows.
#[derive(Clone, Debug, PartialEq)]
pub struct Coarsest {
    /// c of the face.
    pub ratio: f64,
    /// h, in lengths of the scaled body.
    pub size: f64,
    /// Mesh vertices of the face.
    pub corners: Vec<u32>,
}

/// The face of `surface` with the largest c under `pressure` `[multipliers]`; none where
/// nothing presses on a curved obstacle.
pub fn coarsest<C: Counterpart + ?Sized>(
    body: &Deformed<'_>,
    (surface, counterpart): (&ContactSurface, &C),
    pressure: &[f64],
) -> Option<Coarsest> {
    let coefficients = surface.shares.spread(pressure);
    let table = Table::new(body, surface.basis);
    let numbers = body.on_faces(&table, &surface.faces, 1, |points, face, number| {
        let is_loaded = |&k: &u32| coefficients[k as usize] > 0.0;
        if face.functions.iter().any(is_loaded) {
            points.probe(counterpart, face, What::Curvature);
            number[0] = size(face) * largest(points, face, &coefficients) / BEARABLE;
        }
    });
    let ratios = numbers.into_iter().zip(&surface.faces);
    let (ratio, face) = ratios.max_by(|a, b| a.0.total_cmp(&b.0))?;
    (ratio > 0.0).then(|| Coarsest {
        ratio,
        size: size(face),
        corners: face.corners.clone(),
    })
}

/// Length of a segment, leg of the half square of a triangle's area.
fn size(face: &ContactFace) -> f64 {
    match face.corners.len() {
        2 => face.flat_area,
        _ => (2.0 * face.flat_area).sqrt(),
    }
}

/// Largest pressure times curvature at the points of a face.
fn largest(points: &FacePoints<'_>, face: &ContactFace, coefficients: &[f64]) -> f64 {
    let contacts = points.contacts.iter().enumerate();
    let products = contacts.map(|(point, contact)| {
        let entries = contact.curvature.as_flattened().iter();
        let curvature = entries.map(|x| x * x).sum::<f64>().sqrt();
        curvature * points.pressure(face, point, coefficients)
    });
    products.fold(0.0, f64::max)
}
