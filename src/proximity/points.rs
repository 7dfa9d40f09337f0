//! How near an obstacle is to points of the body at rest `[points][3]`. Cost: one distance a point.

use crate::obstacle::{Contact, Derivatives, Obstacle};

/// Signed distance of each point, with its gradient no further than a gap asks for `[points]`.
pub fn contacts<O: Obstacle + ?Sized>(obstacle: &O, points: &[[f64; 3]]) -> Vec<Contact> {
    let mut found = vec![Contact::default(); points.len()];
    obstacle.probe(points, Derivatives::Gap, &mut found);
    found
}

/// The least signed distance; infinite without points.
pub fn least<O: Obstacle + ?Sized>(obstacle: &O, points: &[[f64; 3]]) -> f64 {
    let found = contacts(obstacle, points).into_iter();
    let distances = found.map(|contact| contact.distance);
    distances.fold(f64::INFINITY, f64::min)
}

/// The nearest point, its number and its distance; none without points.
pub fn nearest<O: Obstacle + ?Sized>(obstacle: &O, points: &[[f64; 3]]) -> Option<(usize, f64)> {
    let found = contacts(obstacle, points).into_iter();
    let distances = found.map(|contact| contact.distance).enumerate();
    distances.min_by(|a, b| a.1.total_cmp(&b.1))
}
