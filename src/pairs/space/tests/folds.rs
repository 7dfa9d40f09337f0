//! Who may meet whom on one body in space: a block with a slit from one side, closed at its end by a wall.

use std::collections::BTreeMap;

use super::super::creases::creases;
use super::super::shell::place_at_rest;
use super::*;
use crate::mesh::{CellKind, Mesh, MeshParts};
use crate::pairs::choice::Role;
use crate::pairs::fold::Meets;
use crate::space::TaylorHood;

/// Cells of the block along its axes; those of the slit are left out.
const CELLS: [usize; 3] = [4, 3, 1];
/// Levels of the rows of cells.
const LEVELS: [f64; 4] = [0.0, 1.0, 1.05, 2.05];
/// Axes along which the six tetrahedra of a cell step.
const PATHS: [[usize; 3]; 6] = [
    [0, 1, 2],
    [1, 2, 0],
    [2, 0, 1],
    [0, 2, 1],
    [2, 1, 0],
    [1, 0, 2],
];

fn slit_block() -> Mesh {
    let number = |[i, j, k]: [usize; 3]| ((k * 4 + j) * 5 + i) as u32;
    let mut coordinates = vec![[0.0; 3]; 40];
    let mut cells: Vec<u32> = Vec::new();
    for place in 0..40 {
        let [i, j, k] = [place % 5, place / 5 % 4, place / 20];
        coordinates[place] = [i as f64, LEVELS[j], k as f64];
        let is_cell = [i, j, k].iter().zip(CELLS).all(|(at, count)| *at < count);
        if !is_cell || (j == 1 && i >= 1) {
            continue;
        }
        for (path, axes) in PATHS.iter().enumerate() {
            let mut corner = [i, j, k];
            let mut cell = vec![number(corner)];
            for &axis in axes {
                corner[axis] += 1;
                cell.push(number(corner));
            }
            if path >= 3 {
                cell.swap(2, 3);
            }
            cells.extend(cell);
        }
    }
    let mut sides: BTreeMap<[u32; 3], usize> = BTreeMap::new();
    for cell in cells.chunks(4) {
        for left_out in 0..4 {
            let mut side = [0; 3];
            let others = (0..4).filter(|k| *k != left_out);
            side.iter_mut().zip(others).for_each(|(v, k)| *v = cell[k]);
            side.sort_unstable();
            *sides.entry(side).or_default() += 1;
        }
    }
    let once = sides.into_iter().filter(|(_, count)| *count == 1);
    let parts = MeshParts {
        cell_kind: CellKind::Tetrahedron,
        coordinates,
        cells,
        facets: once.flat_map(|(side, _)| side).collect(),
        groups: Vec::new(),
    };
    Mesh::new(parts).expect("a valid mesh")
}

/// The block with all of its surface, which meets itself.
fn folded() -> (Mesh, TaylorHood, Bodies) {
    let mesh = slit_block();
    let space = TaylorHood::new(&mesh);
    let facets: Vec<u32> = (0..mesh.facet_count() as u32).collect();
    let [carrier, other] = [0, 1].map(|_| Skin::new(&mesh, &space, &facets));
    let fold = SpaceFold::new((&mesh, &space), [&carrier, &other], Meets::Itself);
    let pair = Pair {
        carrier,
        other,
        fold,
    };
    let nodes = 0..space.nodes() as u32;
    let places = nodes.map(|node| place_at_rest((&mesh, &space), node));
    let places = places.collect();
    (mesh, space, Bodies { pair, places })
}

#[test]
fn of_two_faces_of_a_surface_in_space_one_carries() {
    let (_, _, bodies) = folded();
    let Pair {
        carrier,
        other,
        fold,
    } = &bodies.pair;
    let fold = fold.as_ref().expect("one body");
    let count = carrier.faces.len();
    for own in 0..count {
        assert_eq!(fold.role([carrier, other], [own, own]), None);
        for met in 0..own {
            let roles = [[own, met], [met, own]].map(|pair| fold.role([carrier, other], pair));
            let corners = [own, met].map(|face| &carrier.faces[face].nodes[..3]);
            let is_beside = corners[0].iter().any(|node| corners[1].contains(node));
            match roles {
                [None, None] => assert!(is_beside, "{own} {met}"),
                [Some(Role::Meets), Some(Role::Hides)] | [Some(Role::Hides), Some(Role::Meets)] => {
                }
                _ => panic!("{own} {met} {roles:?}"),
            }
        }
    }
}

#[test]
fn a_slit_in_space_is_measured_once_and_by_one_of_its_lips() {
    let (_, _, bodies) = folded();
    bodies.see(|gaps| {
        let volume: f64 = gaps.values().iter().sum();
        assert!((volume - 0.15).abs() < 1e-12, "{volume}");
        let carrier = &bodies.pair.carrier;
        let levels = gaps.placed().meetings.iter().map(|meeting| {
            let node = carrier.faces[meeting.face].nodes[0];
            bodies.places[node as usize][1].to_bits()
        });
        let mut levels: Vec<u64> = levels.collect();
        assert_eq!(levels.len(), 6);
        levels.dedup();
        assert_eq!(levels.len(), 1, "one lip carries");
    });
}

#[test]
fn the_end_of_a_slit_in_space_is_a_crease_and_outer_edges_are_none() {
    let (mesh, space, bodies) = folded();
    let facets: Vec<u32> = (0..mesh.facet_count() as u32).collect();
    let found = creases((&mesh, &space), [&facets, &facets]);
    // Two lines of two vertices and an edge.
    assert_eq!(found.len(), 6, "{found:?}");
    let vertices = found
        .iter()
        .filter(|node| (**node as usize) < space.vertices);
    for &vertex in vertices {
        let [x, y, _] = bodies.places[vertex as usize];
        assert!(
            (x - 1.0).abs() < 1e-9 && (1.0..=1.05).contains(&y),
            "{x} {y}"
        );
    }
}

#[test]
fn forces_of_a_folded_surface_in_space_add_up_to_nothing_and_have_no_moment() {
    let (_, space, mut bodies) = folded();
    for (node, place) in bodies.places.iter_mut().enumerate() {
        for (i, x) in place.iter_mut().enumerate() {
            *x += 0.02 * scattered(3 * node + i);
        }
    }
    let places = &bodies.places;
    bodies.see(|gaps| {
        let derivatives = gaps.derivatives();
        let rows = derivatives.rows.iter().filter(|row| !row.is_empty());
        assert!(rows.clone().count() >= 30);
        for row in rows {
            let (mut force, mut moment, mut size) = ([0.0; 3], [0.0; 3], 0.0_f64);
            for &(unknown, value) in row {
                let (node, i) = (unknown as usize / 3, unknown as usize % 3);
                let mut own = [0.0; 3];
                own[i] = value;
                // Edges have what they are off the mean of their ends.
                if node < space.vertices {
                    force = add(force, own);
                }
                moment = add(moment, cross(places[node], own));
                size = size.max(value.abs());
            }
            assert!(norm(force) < 1e-13 * size, "{force:?} {size}");
            // Lines beyond rims are followed by parabolas, to 1e-5 of a face, as between two bodies.
            assert!(norm(moment) < 1e-9 * size, "{moment:?} {size}");
        }
    });
}

#[test]
fn rays_in_space_look_inwards_by_half_the_wall_where_that_is_now() {
    let (_, _, bodies) = folded();
    let fold = bodies.pair.fold.as_ref().expect("one body");
    let faces = &bodies.pair.carrier.faces;
    let bottom = faces.iter().position(|face| {
        let corners = face.nodes[..3].iter();
        let all = corners.map(|node| bodies.places[*node as usize]);
        all.clone().all(|x| x[1] < 1e-9) && all.clone().any(|x| x[0] > 2.5)
    });
    let bottom = bottom.expect("a face at the bottom");
    // Pressed to a tenth, and sheared by as much as it is high now.
    for (pressed, shear) in [(1.0, 0.0), (0.1, 0.0), (0.1, 1.0)] {
        let place: &PlaceOf<'_> = &|node: u32| {
            let [x, y, z] = bodies.places[node as usize];
            [x + shear * pressed * y, pressed * y, z]
        };
        let patch = Patch {
            nodes: faces[bottom].nodes.map(place),
        };
        let wall = pressed * f64::hypot(1.0, shear);
        for (reach, expected) in [(10.0, 0.5 * wall), (0.01, 0.01)] {
            let depth = fold.inside((bottom, &patch), place, reach);
            for at in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.3, 0.3]] {
                assert!((depth.at(at) - expected).abs() < 1e-12, "{at:?} {expected}");
            }
        }
    }
}
