//! Gaps of two surfaces in space against volumes of closed surfaces, differences and balances of
//! forces.

use std::collections::BTreeMap;

use super::bends::parts_of;
use super::choice::{Candidate, Reach, pieces};
use super::depth::Depth;
use super::normals::{FanAt, normals};
use super::outline::whole;
use super::patch::{At, NODES, Patch, PlaceOf};
use super::point::{Block, Point, VECTORS, completed};
use super::rays::{Ray, Rayed, hit};
use super::skin::SkinFace;
use super::sums::SpaceGaps;
use super::*;
use crate::element::quadrature::{Simplex, rule};
use crate::geometry::vector3::{add, cross, dot, norm, scale};
use crate::pairs::between::Gaps;

mod folds;
mod rims;
mod slips;

/// Numbers in \[-1, 1\] that follow each other without order.
fn scattered(k: usize) -> f64 {
    2.0 * ((k as f64 + 1.0) * 0.618_033_988_749_895).fract() - 1.0
}

/// A face of the carrier, almost flat, with normals about along z.
fn some_face() -> Rayed {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.1, 0.05], [0.2, 0.9, -0.04]];
    let mut nodes = [[0.0; 3]; NODES];
    for (k, node) in nodes.iter_mut().enumerate() {
        let base = corners.get(k).copied().unwrap_or_default();
        *node = [0, 1, 2].map(|i| base[i] + 0.05 * scattered(3 * k + i));
    }
    let normal = |k: usize| {
        let v = [0.2 * scattered(k), 0.2 * scattered(k + 11), 1.0];
        scale(norm(v).recip(), v)
    };
    Rayed {
        patch: Patch { nodes },
        normals: [0, 1, 2].map(normal),
    }
}

/// A face above it that looks down.
fn some_other() -> Patch {
    let corners = [[-0.4, -0.3, 0.2], [0.1, 1.4, 0.3], [1.5, 0.0, 0.15]];
    let mut nodes = [[0.0; 3]; NODES];
    for (k, node) in nodes.iter_mut().enumerate() {
        let base = corners.get(k).copied().unwrap_or_default();
        *node = [0, 1, 2].map(|i| base[i] + 0.06 * scattered(3 * k + i + 40));
    }
    Patch { nodes }
}

/// The face and its partner with one coordinate moved.
fn moved((vector, i): (usize, usize), by: f64) -> (Rayed, Patch) {
    let (mut face, mut other) = (some_face(), some_other());
    match vector {
        0..6 => face.patch.nodes[vector][i] += by,
        6..9 => face.normals[vector - 6][i] += by,
        _ => other.nodes[vector - 9][i] += by,
    }
    (face, other)
}

const AT: At = [0.3, 0.45];

fn at_point((face, other): &(Rayed, Patch)) -> Point {
    Point::new(face, AT, other).expect("a hit")
}

#[test]
fn derivatives_at_a_point_are_those_of_differences() {
    let h = 1e-5;
    let here = moved((0, 0), 0.0);
    let gradient = at_point(&here).gradient(&here.1);
    let mut bend = Box::new([[Block::default(); VECTORS]; VECTORS]);
    at_point(&here).add_bend(&here.1, 1.0, &mut bend);
    completed(&mut bend);
    for vector in 0..VECTORS {
        for i in 0..3 {
            let [before, after] = [-h, h].map(|by| moved((vector, i), by));
            let values = [&before, &after].map(|one| at_point(one).swept());
            let slope = (values[1] - values[0]) / (2.0 * h);
            assert!((slope - gradient[vector][i]).abs() < 1e-8, "{vector} {i}");
            let gradients = [&before, &after].map(|one| at_point(one).gradient(&one.1));
            for other in 0..VECTORS {
                for j in 0..3 {
                    let change = (gradients[1][other][j] - gradients[0][other][j]) / (2.0 * h);
                    let miss = (change - bend[vector][other][i][j]).abs();
                    assert!(miss < 1e-8, "{vector} {other} {i} {j}: {miss:e}");
                }
            }
        }
    }
}

/// Two closed surfaces with the places of their nodes.
struct Bodies {
    pair: Pair,
    places: Vec<[f64; 3]>,
}

#[test]
fn gaps_of_linear_bodies_have_the_derivatives_of_distances_along_rays_that_stay() {
    let (face, other) = moved((0, 0), 0.0);
    let point = at_point(&(face, other));
    let (value, rows) = point.at_rest(&other);
    let normal = face.normal(AT);
    let facing = dot(normal, face.patch.area_vector(AT));
    let distance = |(face, other): (Rayed, Patch)| {
        let ray = Ray {
            from: face.patch.point(AT),
            along: normal,
        };
        facing * hit(&other, ray).expect("a hit").gap
    };
    assert!((value - distance((face, other))).abs() < 1e-14, "{value}");
    let h = 1e-5;
    for vector in 0..VECTORS {
        for i in 0..3 {
            let [before, after] = [-h, h].map(|by| distance(moved((vector, i), by)));
            let slope = (after - before) / (2.0 * h);
            assert!((rows[vector][i] - slope).abs() < 1e-8, "{vector} {i}");
        }
    }
}

/// The octahedron cut into `count`^2 triangles a side: corners of lattice points, counterclockwise from
/// outside.
fn octahedron(count: i32) -> Vec<[[i32; 3]; 3]> {
    let mut faces = Vec::new();
    for signs in 0..8 {
        let sign = [0, 1, 2].map(|i| if signs >> i & 1 == 0 { 1 } else { -1 });
        let point = |a: i32, b: i32| [sign[0] * a, sign[1] * b, sign[2] * (count - a - b)];
        let mut add = |corners: [[i32; 3]; 3]| {
            let [a, b, c] = corners;
            let is_even = sign.iter().product::<i32>() > 0;
            faces.push(if is_even { [a, b, c] } else { [a, c, b] });
        };
        for a in 0..count {
            for b in 0..count - a {
                add([point(a, b), point(a + 1, b), point(a, b + 1)]);
                if a + b + 2 <= count {
                    add([point(a + 1, b), point(a + 1, b + 1), point(a, b + 1)]);
                }
            }
        }
    }
    faces
}

/// A round surface, wavy by `wave`, turned by `angle`, whose body is inside or outside.
fn round(
    (count, radius, wave): (i32, f64, f64),
    (angle, is_inside): (f64, bool),
    places: &mut Vec<[f64; 3]>,
) -> Skin {
    let on = |x: [f64; 3]| {
        let x = scale(norm(x).recip(), x);
        let r = radius * (1.0 + wave * (3.0 * x[0] + 1.0).cos() * (4.0 * x[1]).sin());
        let (sine, cosine) = angle.sin_cos();
        let [x, y, z] = scale(r, x);
        let [x, y] = [cosine * x - sine * y, sine * x + cosine * y];
        [x, cosine * y - sine * z, sine * y + cosine * z]
    };
    let real = |p: [i32; 3]| p.map(f64::from);
    let faces = octahedron(count);
    let mut numbers: BTreeMap<Vec<[i32; 3]>, u32> = BTreeMap::new();
    let mut number = |mut key: Vec<[i32; 3]>, place: [f64; 3]| {
        key.sort_unstable();
        *numbers.entry(key).or_insert_with(|| {
            places.push(place);
            places.len() as u32 - 1
        })
    };
    let mut skin = Skin::default();
    for corners in faces {
        let corners = if is_inside {
            corners
        } else {
            [corners[0], corners[2], corners[1]]
        };
        let mut nodes = [0; NODES];
        for k in 0..3 {
            nodes[k] = number(vec![corners[k]], on(real(corners[k])));
        }
        for (k, [a, b]) in [[0, 1], [0, 2], [1, 2]].into_iter().enumerate() {
            let [a, b] = [corners[a], corners[b]];
            let middle = on(scale(0.5, add(real(a), real(b))));
            let mean = scale(0.5, add(on(real(a)), on(real(b))));
            nodes[3 + k] = number(vec![a, b], add(middle, scale(-1.0, mean)));
        }
        skin.faces.push(SkinFace {
            nodes,
            normals: [0; 3],
            rims: [true; 3],
            is_turned: false,
        });
    }
    skin
}

/// A ball in a shell.
fn balls(ball: i32, shell: i32) -> Bodies {
    let mut places = Vec::new();
    let mut carrier = round((ball, 1.0, 0.01), (0.3, true), &mut places);
    let mut other = round((shell, 1.04, 0.004), (-0.4, false), &mut places);
    let at = |node: u32| places[node as usize];
    carrier.join(&at);
    other.join(&at);
    Bodies {
        pair: Pair {
            carrier,
            other,
            fold: None,
        },
        places,
    }
}

impl Bodies {
    fn see<T>(&self, task: impl FnOnce(&SpaceGaps<'_>) -> T) -> T {
        let place: &PlaceOf<'_> = &|node: u32| self.places[node as usize];
        // Every face has functions of its own.
        let faces = self.pair.carrier.faces.len() as u32;
        let functions: Vec<[u32; NODES]> = (0..faces)
            .map(|face| std::array::from_fn(|k| 6 * face + k as u32))
            .collect();
        let sizes = [6 * faces as usize, 3 * self.places.len()];
        task(&SpaceGaps::new(&self.pair.placed(place), &functions, sizes))
    }

    fn moved(&self, unknown: usize, by: f64) -> Self {
        let mut places = self.places.clone();
        places[unknown / 3][unknown % 3] += by;
        Self {
            pair: self.pair.clone(),
            places,
        }
    }

    /// Volume between both surfaces, by Gauss.
    fn volume(&self) -> f64 {
        let rule = rule(Simplex::Triangle, 8);
        let faces = self.pair.carrier.faces.iter().chain(&self.pair.other.faces);
        let inside: f64 = faces
            .map(|face| {
                let patch = Patch {
                    nodes: face.nodes.map(|node| self.places[node as usize]),
                };
                let points = rule.points.iter().zip(&rule.weights);
                let values = points.map(|(l, weight)| {
                    let at = [l[1], l[2]];
                    0.5 * weight * dot(patch.point(at), patch.area_vector(at)) / 3.0
                });
                values.sum::<f64>()
            })
            .sum();
        -inside
    }
}

#[test]
fn gaps_add_up_to_the_volume_between_the_surfaces() {
    for (ball, shell) in [(5, 4), (4, 6)] {
        let bodies = balls(ball, shell);
        let sum: f64 = bodies.see(|gaps| gaps.values()).iter().sum();
        let error = sum / bodies.volume() - 1.0;
        assert!(error.abs() < 1e-10, "{ball} {shell} {error:e}");
    }
}

#[test]
fn pieces_cover_every_face_once() {
    let bodies = balls(5, 4);
    bodies.see(|gaps| {
        for meeting in &gaps.placed().meetings {
            let polygons = meeting.pieces.iter();
            let sum: f64 = polygons.map(|piece| whole(&piece.polygon)).sum();
            assert!((sum - 0.5).abs() < 1e-12, "{} {sum}", meeting.face);
        }
        assert_eq!(
            gaps.placed().meetings.len(),
            bodies.pair.carrier.faces.len()
        );
    });
}

#[test]
fn forces_of_every_gap_add_up_to_nothing_and_have_no_moment() {
    let bodies = balls(3, 4);
    let faces = bodies
        .pair
        .carrier
        .faces
        .iter()
        .chain(&bodies.pair.other.faces);
    let corners = faces.flat_map(|face| face.nodes[..3].to_vec());
    let corners: std::collections::BTreeSet<u32> = corners.collect();
    let rows = bodies.see(|gaps| gaps.derivatives().rows);
    for row in rows {
        let (mut force, mut moment, mut size) = ([0.0; 3], [0.0; 3], 0.0);
        for (k, value) in row {
            let (node, i) = (k / 3, (k % 3) as usize);
            let mut own = [0.0; 3];
            own[i] = value;
            size += value.abs();
            moment = add(moment, cross(bodies.places[node as usize], own));
            if corners.contains(&node) {
                force = add(force, own);
            }
        }
        let miss = norm(force).max(norm(moment));
        assert!(miss < 1e-13 * size.max(1e-2), "{miss:e} {size:e}");
    }
}

#[test]
fn the_force_of_an_even_pressure_is_the_change_of_the_volume_between_the_surfaces() {
    let bodies = balls(5, 4);
    let rows = bodies.see(|gaps| gaps.derivatives().rows);
    let mut force = vec![0.0; 3 * bodies.places.len()];
    for (k, value) in rows.into_iter().flatten() {
        force[k as usize] += value;
    }
    let mut worst = 0.0_f64;
    for unknown in (0..force.len()).step_by(29) {
        let h = 1e-4;
        let at = |by: f64| bodies.moved(unknown, by).volume();
        let exact = (at(h) - at(-h)) / (2.0 * h);
        worst = worst.max((force[unknown] - exact).abs());
    }
    assert!(worst < 1e-8, "{worst:e}");
}

#[test]
fn normals_have_the_derivatives_of_differences() {
    let bodies = balls(2, 2);
    let skin = &bodies.pair.carrier;
    let at = |bodies: &Bodies| {
        let patches = skin.patches(&|node| bodies.places[node as usize]);
        (normals(skin, &patches), patches)
    };
    let (here, patches) = at(&bodies);
    let c = [0.3, -0.7, 0.4];
    let fan = FanAt::new((skin, &patches, &here), 3);
    let own = fan.rows();
    let mut bend = vec![Vec::new(); 3 * bodies.places.len()];
    fan.add_bend(c, &mut bend);
    let of = |row: &Vec<(u32, f64)>, unknown: usize| -> f64 {
        let own = row.iter().filter(|(k, _)| *k as usize == unknown);
        own.map(|(_, value)| value).sum()
    };
    let h = 1e-5;
    let unknowns: Vec<usize> = own[0].iter().map(|(k, _)| *k as usize).collect();
    assert!(unknowns.len() > 20, "{}", unknowns.len());
    for unknown in unknowns {
        let [before, after] = [-h, h].map(|by| {
            let moved = bodies.moved(unknown, by);
            let (found, patches) = at(&moved);
            let fan = FanAt::new((skin, &patches, &found), 3);
            (found[3].unit, fan.rows())
        });
        for i in 0..3 {
            let slope = (after.0[i] - before.0[i]) / (2.0 * h);
            assert!((slope - of(&own[i], unknown)).abs() < 1e-8);
        }
        for other in (0..3 * bodies.places.len()).step_by(5) {
            let sum = |rows: &[Vec<(u32, f64)>; 3]| -> f64 {
                (0..3).map(|i| c[i] * of(&rows[i], other)).sum()
            };
            let change = (sum(&after.1) - sum(&before.1)) / (2.0 * h);
            let miss = (change - of(&bend[unknown], other)).abs();
            assert!(miss < 1e-7, "{unknown} {other} {miss:e}");
        }
    }
}

#[test]
fn a_tree_of_faces_finds_what_a_look_at_all_of_them_finds() {
    let bodies = balls(4, 5);
    let place: &PlaceOf<'_> = &|node: u32| bodies.places[node as usize];
    let placed = bodies.pair.placed(place);
    let all: Vec<Candidate> = bodies.pair.candidates(&placed.others);
    let reach = Reach {
        open: placed.reach,
        inside: Depth::even(placed.reach),
    };
    for (face, own) in placed.own.iter().enumerate() {
        let found = pieces(own, &all, reach);
        let mut meetings = placed.meetings.iter();
        let meeting = meetings.find(|meeting| meeting.face == face);
        let by_tree = meeting.map_or(&[][..], |meeting| &meeting.pieces);
        assert_eq!(found.len(), by_tree.len());
        for (a, b) in found.iter().zip(by_tree) {
            assert_eq!((a.other, &a.polygon), (b.other, &b.polygon));
        }
    }
}

#[test]
fn second_derivatives_are_those_of_differences_with_the_motion_of_the_borders() {
    assert_bends(&balls(3, 2), 41);
}

/// Faces of the ball meet more faces than are summed together.
#[test]
fn parts_of_a_face_have_the_second_derivatives_of_all_of_it() {
    let bodies = balls(1, 6);
    let factors = [0.7, 1.1, 1.3, 0.4, 1.9, 0.8];
    bodies.see(|gaps| {
        let placed = gaps.placed();
        let meeting = &placed.meetings[0];
        let [whole, parted] = [usize::MAX, 5].map(|together| {
            let mut sums = BTreeMap::new();
            for part in parts_of(meeting, together) {
                let bend = placed.face_bend(&part, factors);
                let width = 3 * bend.vectors.len();
                for (k, value) in bend.entries.iter().enumerate() {
                    let [row, column] = [k / width, k % width];
                    let at = |k: usize| (bend.vectors[k / 3], k % 3);
                    *sums.entry((at(row), at(column))).or_insert(0.0) += value;
                }
            }
            sums
        });
        assert!(meeting.pieces.len() > 20);
        for (at, value) in &whole {
            let own = parted.get(at).copied().unwrap_or_default();
            assert!((own - value).abs() < 1e-13, "{at:?} {value} {own}");
        }
    });
}

/// Asserts that second derivatives are differences of first ones by every `step`th unknown.
fn assert_bends(bodies: &Bodies, step: usize) {
    let count = 6 * bodies.pair.carrier.faces.len();
    let factors: Vec<f64> = (0..count).map(|k| 1.0 + 0.5 * scattered(k)).collect();
    let force = |bodies: &Bodies| {
        let rows = bodies.see(|gaps| gaps.derivatives().rows);
        let mut force = vec![0.0; 3 * bodies.places.len()];
        for (row, factor) in rows.into_iter().zip(&factors) {
            row.iter()
                .for_each(|(k, value)| force[*k as usize] += factor * value);
        }
        force
    };
    let rows = bodies.see(|gaps| gaps.curvature(&factors));
    let (h, mut worst) = (1e-5, [0.0_f64; 3]);
    for unknown in (0..rows.len()).step_by(step) {
        let mut own = vec![0.0; rows.len()];
        rows[unknown]
            .iter()
            .for_each(|(k, value)| own[*k as usize] += value);
        let [before, after] = [-h, h].map(|by| force(&bodies.moved(unknown, by)));
        for k in 0..own.len() {
            let change = (after[k] - before[k]) / (2.0 * h);
            worst[0] = worst[0].max((change - own[k]).abs());
            worst[1] = worst[1].max(own[k].abs());
            let turned: f64 = rows[k]
                .iter()
                .filter(|(j, _)| *j as usize == unknown)
                .map(|(_, value)| value)
                .sum();
            worst[2] = worst[2].max((turned - own[k]).abs());
        }
    }
    assert!(worst[0] < 1e-3 * worst[1] && worst[2] < 1e-12, "{worst:?}");
}
