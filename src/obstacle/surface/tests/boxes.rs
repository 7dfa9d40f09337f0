//! A rounded box as programs mesh it, from grids on its sides: flats that are meshed as finely as
//! the roundings beside them.

use std::f64::consts::FRAC_PI_4;

use super::*;

const HALF: [f64; 3] = [0.3, 0.25, 0.2];
const ROUNDING: f64 = 0.05;

/// A node of a side along one of its axes: its place on the box inside the roundings, and the
/// tangent of its direction there.
type Node = (f64, f64);

/// The nodes along an axis: `flat` parts of the flat, `round` of half a rounding at each end.
fn nodes(half: f64, (flat, round): (u32, u32)) -> Vec<Node> {
    let inner = half - ROUNDING;
    let tangent = |i: u32| (FRAC_PI_4 * f64::from(i) / f64::from(round)).tan();
    let below = (1..=round).rev().map(|i| (-inner, -tangent(i)));
    let along = (0..=flat).map(|i| (inner * (2.0 * f64::from(i) / f64::from(flat) - 1.0), 0.0));
    let above = (1..=round).map(|i| (inner, tangent(i)));
    below.chain(along).chain(above).collect()
}

fn rounded_box(parts: (u32, u32)) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let mut numbers = HashMap::new();
    let (mut vertices, mut facets) = (Vec::new(), Vec::new());
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let (along_u, along_v) = (nodes(HALF[u], parts), nodes(HALF[v], parts));
        for side in [-1.0, 1.0] {
            let mut number = |(on_u, to_u): Node, (on_v, to_v): Node| {
                let (mut place, mut direction) = ([0.0; 3], [0.0; 3]);
                (direction[axis], direction[u], direction[v]) = (side, to_u, to_v);
                place[axis] = side * (HALF[axis] - ROUNDING);
                (place[u], place[v]) = (on_u, on_v);
                let outwards = normalised(direction).expect("a direction");
                let place = add(place, scale(ROUNDING, outwards));
                let key = place.map(|x| (1e9 * x).round() as i64);
                *numbers.entry(key).or_insert_with(|| {
                    vertices.push(place);
                    vertices.len() as u32 - 1
                })
            };
            for u in along_u.windows(2) {
                for v in along_v.windows(2) {
                    let [a, b] = [number(u[0], v[0]), number(u[1], v[0])];
                    let [c, d] = [number(u[1], v[1]), number(u[0], v[1])];
                    let both = [[a, b, c], [a, c, d]];
                    let turned =
                        both.map(|[a, b, c]| if side > 0.0 { [a, b, c] } else { [a, c, b] });
                    facets.extend(turned);
                }
            }
        }
    }
    (vertices, facets)
}

#[test]
fn flats_and_roundings_of_a_box_keep_their_own_curvature() {
    let exact = Shape::Box {
        centre: [0.0; 3],
        half_sizes: HALF,
        rounding: ROUNDING,
    };
    let exact = exact.build(1.0).expect("a box");
    for (parts, most) in [((14, 4), 1e-5), ((6, 8), 1e-6)] {
        let surface = rounded_box(parts);
        assert_eq!(surface.1.len(), 5808);
        let tool = tool(surface, SMOOTH);
        assert!(!tool.is_smooth(), "where a flat meets a rounding");
        let mut worst = [0.0_f64; 2];
        for direction in directions(4000) {
            for step in 20..50 {
                let point = scale(0.01 * f64::from(step), direction);
                let there = exact.distance(point).distance;
                if there.abs() < 0.02 {
                    let found = tool.distance(point);
                    worst[0] = worst[0].max((found.distance - there).abs());
                }
            }
        }
        // The flat itself is flat.
        let below = tool.distance([0.11, -0.07, -0.21]);
        worst[1] = worst[1].max(norm(sub(below.normal, [0.0, 0.0, -1.0])));
        assert!(worst[0] < most, "{parts:?}: {:e}", worst[0]);
        assert!(worst[1] < 1e-13, "{parts:?}: {:e}", worst[1]);
    }
}
