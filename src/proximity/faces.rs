//! How near the faces of a surface are to what they meet, between the points of the contact
//! integrals as well:
//!
//! ```text
//! d_f = min over a grid of barycentric points of d(x + u)   for each face f
//! ```
//!
//! Negative inside. Lengths are those of the scaled body. A distance changes by no more than
//! the point moves: a face that can neither be the nearest one nor inside, by its distance in the
//! middle and its size, has that lower bound in place of d_f. Around the best point of a face that
//! may be touched finer grids follow, each a quarter of the last. Cost: one distance a face; of
//! those that are near, 45 in space, 17 in the plane, and as many again for each finer grid.

use crate::contact::quadratic_face::{QuadraticFace, towards};
use crate::contact::surface::ContactSurface;
use crate::contact::{ContactFace, Deformed};
use crate::obstacle::{Contact, Derivatives, Obstacle};
use crate::parallel;

/// Above one by more than all rounding, and by what distances to patches miss of a true distance.
const CAREFUL: f64 = 1.01;
/// What a finer grid may find nearer than the first one, over the size of a face: no point of
/// a face of usual shape is farther from the first grid.
const REACH: f64 = 0.25;
/// Intervals of the grid on a face in space.
const IN_SPACE: u32 = 8;
/// Intervals on a face in the plane.
const IN_THE_PLANE: u32 = 16;
/// Finer grids around the best point of a face.
const ROUNDS: u32 = 4;
/// Fewer faces are not worth a second thread.
const FEW: usize = 16;

/// The least distance of each face `[faces]`, or a bound below it where it is neither the least of
/// all nor negative.
pub fn distances<O: Obstacle + ?Sized>(
    body: &Deformed<'_>,
    surface: &ContactSurface,
    obstacle: &O,
) -> Vec<f64> {
    let search = Search {
        grid: grid(body.space.components),
        obstacle,
        body,
    };
    let bounds = parallel::map(surface.faces.len(), 4 * FEW, &|face| {
        search.bounds(&surface.faces[face])
    });
    let upper = bounds.iter().map(|bound| bound[1]);
    let least_of_all = upper.fold(f64::INFINITY, f64::min).max(0.0);
    let mut all: Vec<f64> = bounds.iter().map(|bound| bound[0]).collect();
    let is_near = |face: &usize| all[*face] <= least_of_all;
    let near: Vec<usize> = (0..all.len()).filter(is_near).collect();
    let found = parallel::map(near.len(), FEW, &|k| {
        search.on_grid(&surface.faces[near[k]])
    });
    let least = found.iter().map(|found| found.distance);
    let least = least.fold(f64::INFINITY, f64::min).max(0.0);
    let power = 1.0 / (body.space.components as f64 - 1.0);
    let refined = parallel::map(near.len(), FEW / 4, &|k| {
        let found = &found[k];
        let size = surface.faces[near[k]].flat_area.powf(power);
        if found.distance < least + REACH * size {
            search.refined(found)
        } else {
            found.distance
        }
    });
    for (index, distance) in near.into_iter().zip(refined) {
        all[index] = distance;
    }
    all
}

/// Distances of the faces of a body from an obstacle.
struct Search<'a, O: ?Sized> {
    /// Barycentric coordinates of points of a face `[points]`.
    grid: Vec<[f64; 3]>,
    obstacle: &'a O,
    body: &'a Deformed<'a>,
}

/// The nearest point of a face so far.
struct Found {
    distance: f64,
    at: [f64; 3],
    /// The whole face.
    shape: QuadraticFace,
}

impl<O: Obstacle + ?Sized> Search<'_, O> {
    /// Bounds of the least distance of a face from below and above, by the distance of one of its
    /// points and how far the others are from it.
    fn bounds(&self, face: &ContactFace) -> [f64; 2] {
        let shape = QuadraticFace::of(self.body, face);
        let middle = shape.at(&self.grid[self.grid.len() / 2]);
        let mut contact = [Contact::default()];
        self.obstacle
            .probe(&[middle], Derivatives::Gap, &mut contact);
        let distance = contact[0].distance;
        [distance - CAREFUL * shape.reach(middle), distance]
    }

    /// The nearest point of the grid.
    fn on_grid(&self, face: &ContactFace) -> Found {
        let shape = QuadraticFace::of(self.body, face);
        let (distance, at) = self.least(&shape);
        Found {
            distance,
            at,
            shape,
        }
    }

    /// The least distance of one face, sought around the best point so far.
    fn refined(&self, found: &Found) -> f64 {
        let (mut distance, mut best) = (found.distance, found.at);
        let mut size = 1.0;
        for _ in 0..ROUNDS {
            size *= 0.25;
            // The grid shrunk towards the best point stays on the face.
            let (least, at) = self.least(&found.shape.around(&best, size));
            if least < distance {
                (distance, best) = (least, towards(&best, size, &at));
            }
        }
        distance
    }

    /// The least distance over the grid on a part of a face, and where.
    fn least(&self, part: &QuadraticFace) -> (f64, [f64; 3]) {
        let mut points = [[0.0; 3]; MOST_POINTS];
        let mut contacts = [Contact::default(); MOST_POINTS];
        let count = self.grid.len();
        for (point, l) in points.iter_mut().zip(&self.grid) {
            *point = part.at(l);
        }
        let contacts = &mut contacts[..count];
        self.obstacle
            .probe(&points[..count], Derivatives::Gap, contacts);
        let mut least = (f64::INFINITY, self.grid[0]);
        for (contact, &l) in contacts.iter().zip(&self.grid) {
            if contact.distance < least.0 {
                least = (contact.distance, l);
            }
        }
        least
    }
}

/// Points of a grid at most.
const MOST_POINTS: usize = 45;

/// Points of a face with that many corners.
fn grid(corners: usize) -> Vec<[f64; 3]> {
    let intervals = if corners == 2 { IN_THE_PLANE } else { IN_SPACE };
    let share = |count: u32| f64::from(count) / f64::from(intervals);
    let mut points = Vec::new();
    for i in 0..=intervals {
        let others = if corners == 2 {
            0..=0
        } else {
            0..=intervals - i
        };
        for j in others {
            let [a, b] = [share(i), share(j)];
            points.push([1.0 - a - b, a, b]);
        }
    }
    points
}
