//! Slips of two surfaces, and what tractions do: differences and balances.

use super::rims::plates;
use super::*;
use crate::geometry::RigidMotion;
use crate::geometry::vector3::sub;
use crate::pairs::space::frames::{Tangents, TangentsAt};
use crate::pairs::space::normals::Row;
use crate::pairs::space::sliding::From;
use crate::pairs::space::slips::Before;

/// Bodies, and where their nodes were when the increment began.
type Slid = (Bodies, Vec<[f64; 3]>);

/// Shaken and slid by a bit since; closed surfaces, and ones that end over faces.
fn slid() -> [Slid; 2] {
    [balls(2, 3), plates(0.02, 0.01)].map(|bodies| {
        let shaken = |(k, &[x, y, z]): (usize, &[f64; 3])| {
            let by = |i: usize| 0.005 * scattered(3 * k + i);
            [x + by(0), y + by(1), z + by(2)]
        };
        let start = bodies.places.iter().enumerate().map(shaken).collect();
        (bodies, start)
    })
}

fn before(bodies: &Bodies, start: &[[f64; 3]]) -> Before {
    let place: &PlaceOf<'_> = &|node: u32| start[node as usize];
    let patches = bodies.pair.carrier.patches(place);
    Before {
        own: bodies.pair.carrier.rayed(&patches).1,
        others: bodies.pair.other.patches(place),
    }
}

/// V of all functions, by components.
fn slips(bodies: &Bodies, start: &[[f64; 3]]) -> Vec<f64> {
    let before = before(bodies, start);
    bodies.see(|gaps| gaps.slid(&before)).concat()
}

fn pulls(bodies: &Bodies) -> Vec<Row> {
    bodies.see(|gaps| gaps.pulls(From::Start(&[])))
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |size: f64, x| size.max(x.abs()))
}

/// The numbers of corners.
fn corners(bodies: &Bodies) -> std::collections::BTreeSet<u32> {
    let pair = &bodies.pair;
    let faces = pair.carrier.faces.iter().chain(&pair.other.faces);
    faces.flat_map(|face| face.nodes[..3].to_vec()).collect()
}

#[test]
fn nothing_has_slid_in_space_where_the_same_points_are_opposite() {
    for (bodies, _) in slid() {
        let none = largest(&slips(&bodies, &bodies.places));
        assert!(none < 1e-14, "{none:e}");
        // Nor where all bodies have turned and moved as one since.
        let motion = RigidMotion {
            rotation: [0.3, -0.9, 0.5],
            translation: [0.2, 0.1, -0.4],
            ..RigidMotion::default()
        };
        let vertices = corners(&bodies);
        let carried = |(node, x): (usize, &[f64; 3])| {
            let [to, zero] = [*x, [0.0; 3]].map(|x| motion.apply(x));
            if vertices.contains(&(node as u32)) {
                to
            } else {
                sub(to, zero)
            }
        };
        let start: Vec<[f64; 3]> = bodies.places.iter().enumerate().map(carried).collect();
        let none = largest(&slips(&bodies, &start));
        assert!(none < 1e-13, "{none:e}");
    }
}

/// Notes how much differences over h of `ends` miss entries of `rows` by, and the largest of those.
fn see(
    rows: &[Row],
    (unknown, h): (usize, f64),
    ends: &[Vec<f64>; 2],
    (miss, size): (&mut f64, &mut f64),
) {
    for (k, row) in rows.iter().enumerate() {
        let own = row.iter().filter(|(j, _)| *j as usize == unknown);
        let own: f64 = own.map(|(_, value)| value).sum();
        let change = (ends[1][k] - ends[0][k]) / (2.0 * h);
        *miss = miss.max((change - own).abs());
        *size = size.max(own.abs());
    }
}

#[test]
fn derivatives_of_slips_in_space_are_those_of_differences() {
    let h = 1e-6;
    for ((bodies, start), bound) in slid().into_iter().zip([1e-4, 1e-3]) {
        let before = before(&bodies, &start);
        let rows = bodies.see(|gaps| gaps.slid_slopes(&before));
        let (mut miss, mut size) = (0.0_f64, 0.0_f64);
        for unknown in (0..3 * bodies.places.len()).step_by(13) {
            let ends = [-h, h].map(|by| slips(&bodies.moved(unknown, by), &start));
            see(&rows, (unknown, h), &ends, (&mut miss, &mut size));
        }
        assert!(miss < bound * size, "{miss:e} {size:e}");
    }
}

#[test]
fn tractions_in_space_pull_both_surfaces_alike_and_without_a_moment() {
    for (bodies, _) in slid() {
        let vertices = corners(&bodies);
        for row in pulls(&bodies) {
            let (mut force, mut moment, mut size) = ([0.0; 3], [0.0; 3], 0.0);
            for (k, value) in row {
                let (node, i) = (k / 3, (k % 3) as usize);
                let mut own = [0.0; 3];
                own[i] = value;
                size += value.abs();
                moment = add(moment, cross(bodies.places[node as usize], own));
                if vertices.contains(&node) {
                    force = add(force, own);
                }
            }
            let miss = norm(force).max(norm(moment));
            assert!(miss <= 1e-13 * size.max(1e-2), "{miss:e} {size:e}");
        }
    }
}

#[test]
fn changes_of_tractions_in_space_are_those_of_differences() {
    let h = 1e-6;
    for ((bodies, _), bound) in slid().into_iter().zip([1e-4, 1e-2]) {
        let count = 6 * bodies.pair.carrier.faces.len();
        let vector = |k: usize| [0, 1, 2].map(|i| scattered(3 * k + i));
        let tractions: Vec<[f64; 3]> = (0..count).map(vector).collect();
        let rows = bodies.see(|gaps| gaps.pull_changes(&tractions));
        let force = |bodies: &Bodies| {
            let mut force = vec![0.0; 3 * bodies.places.len()];
            for (row, factor) in pulls(bodies).iter().zip(tractions.as_flattened()) {
                row.iter()
                    .for_each(|(k, value)| force[*k as usize] += factor * value);
            }
            force
        };
        let (mut miss, mut size) = (0.0_f64, 0.0_f64);
        for unknown in (0..rows.len()).step_by(17) {
            let ends = [-h, h].map(|by| force(&bodies.moved(unknown, by)));
            see(&rows, (unknown, h), &ends, (&mut miss, &mut size));
        }
        assert!(miss < bound * size, "{miss:e} {size:e}");
    }
}

#[test]
fn tangents_follow_the_faces_by_the_derivatives_of_differences() {
    let (h, parts) = (1e-6, [0.7, -1.1]);
    let bodies = balls(2, 2);
    let skin = &bodies.pair.carrier;
    for walls in [[None; 3], [Some([0, 0]), None, None]] {
        let tangents = Tangents {
            faces: vec![0, 1, 2],
            ends: [1, 2],
            walls,
        };
        let at = |bodies: &Bodies| {
            let patches = skin.patches(&|node| bodies.places[node as usize]);
            let here = TangentsAt::new(&tangents, &patches);
            let [first, second] = here.frame(&|_, _| true);
            let vector = add(scale(parts[0], first), scale(parts[1], second));
            (vector, here.rows(skin, parts))
        };
        let (_, rows) = at(&bodies);
        for unknown in rows[0].iter().map(|(k, _)| *k as usize) {
            let ends = [-h, h].map(|by| at(&bodies.moved(unknown, by)).0);
            for (i, row) in rows.iter().enumerate() {
                let own = row.iter().find(|(k, _)| *k as usize == unknown);
                let change = (ends[1][i] - ends[0][i]) / (2.0 * h);
                let miss = (change - own.map_or(0.0, |own| own.1)).abs();
                assert!(miss < 1e-8, "{unknown} {i} {miss:e}");
            }
        }
    }
}
