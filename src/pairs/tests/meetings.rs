//! Whom faces meet, against a look at all of them.

use super::super::choice::{Partner, Reach, Role, pieces};
use super::super::piece::Face;
use super::gaps::volume;
use super::*;

/// A core in a ring of `count` straight faces with a corner at every vertex.
fn cornered(core: usize, count: usize) -> Bodies {
    let mut bodies = rings(core, count);
    for face in &mut bodies.pair.other.faces {
        face.beside = [None, None];
        bodies.places[face.nodes[2] as usize] = [0.0; 2];
    }
    for vertex in bodies.pair.other.faces.iter().map(|face| face.nodes[0]) {
        bodies.places[vertex as usize] = bodies.places[vertex as usize].map(|x| 1.2 * x);
    }
    bodies
}

/// The same turned as a whole.
fn turned_by(mut bodies: Bodies, angle: f64) -> Bodies {
    let (sine, cosine) = angle.sin_cos();
    for place in &mut bodies.places {
        let [x, y] = *place;
        *place = [cosine * x - sine * y, sine * x + cosine * y];
    }
    bodies
}

#[test]
fn between_faces_with_corners_the_gap_is_that_of_the_geometry_alone() {
    for (core, count) in [(40, 11), (11, 7), (5, 11)] {
        let bodies = cornered(core, count);
        let exact = bodies.gaps();
        for angle in [0.3, 0.8, 2.0] {
            let turned = turned_by(bodies.clone(), angle).gaps();
            let pairs = turned.as_flattened().iter().zip(exact.as_flattened());
            let miss = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(miss < 1e-13, "{core} {count} {angle} {miss:e}");
        }
    }
}

#[test]
fn gaps_add_up_to_the_area_between_a_core_and_a_ring_with_corners() {
    for (core, count) in [(40, 11), (41, 7), (60, 9)] {
        let bodies = cornered(core, count);
        let sum: f64 = bodies.gaps().iter().flatten().sum();
        let exact = volume(&bodies);
        let error = sum - exact;
        assert!(
            exact > 0.1 && error.abs() < 1e-13,
            "{core} {count} {error:e}"
        );
    }
}

#[test]
fn the_tree_finds_the_partners_that_a_look_at_all_faces_finds() {
    for bodies in [
        rings(30, 23),
        lines([5, 17], 0.05, 0.02),
        lines([17, 3], -0.02, 0.01),
        cornered(40, 11),
        cornered(11, 7),
        cornered(5, 11),
    ] {
        let all: Vec<Partner> = (bodies.pair.other.faces.iter())
            .map(|face| Partner {
                nodes: face.nodes.map(|node| bodies.places[node as usize]),
                range: face.range(),
                role: Role::Apart,
            })
            .collect();
        bodies.at(|placed| {
            let mut twins = Vec::new();
            for face in &bodies.pair.carrier.faces {
                let beside = face.sides();
                let [before, after] = face.beside.map(|one| one.unwrap_or([0, 0]));
                let [a, b, edge] = face.nodes;
                let nodes = [
                    a, b, edge, before[0], before[1], after[0], after[1], 0, 0, 0,
                ];
                let at = Face::new(&nodes.map(|node| bodies.places[node as usize]), beside);
                let reach = Reach {
                    open: placed.reach,
                    inside: [placed.reach; 2],
                };
                twins.extend(pieces(&at, beside, &all, reach));
            }
            let found = placed.meetings.iter();
            let found: Vec<_> = found.map(|one| (one.other, one.piece.ends)).collect();
            let twins: Vec<_> = twins
                .iter()
                .map(|(other, piece)| (*other, piece.ends))
                .collect();
            assert_eq!(found, twins);
        });
    }
}

#[test]
fn a_face_beyond_the_end_of_the_other_surface_has_no_partner() {
    let mut bodies = lines([10, 2], 0.01, 0.0);
    let first = bodies.pair.carrier.faces.len() * 2 + 1;
    // The lower body is half as long: its end goes on by 0.3 of its face.
    for place in &mut bodies.places[first..] {
        place[0] *= 0.5;
    }
    let end = bodies.pair.other.faces[0]
        .nodes
        .map(|node| bodies.places[node as usize]);
    let reach = end[0][0] + 0.3 * (end[0][0] - end[1][0]);
    bodies.at(|placed| {
        let covered: f64 = placed.covered().iter().flat_map(|own| own[0]).sum();
        assert!((covered - reach).abs() < 1e-12, "{covered} {reach}");
        let whole: f64 = placed.covered().iter().flat_map(|own| own[1]).sum();
        assert!((whole - 1.0).abs() < 1e-12);
        let probes = placed
            .meetings
            .iter()
            .flat_map(|meeting| placed.probes(meeting));
        assert!(
            probes
                .into_iter()
                .all(|one| (one.distance - 0.01).abs() < 1e-14)
        );
    });
}
