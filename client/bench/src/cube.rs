//! The unit cube of n^3 cells, each of six Kuhn tetrahedra, as MSH 2.2 text.
//!
//! Vertex (i, j, k) has the number 1 + i + (n + 1) (j + (n + 1) k); each
//! tetrahedron walks from a cell's first corner to its last along the axes in
//! one of their six orders. Groups: `body`, and the sides `x0` .. `z1`.

use std::fmt::{self, Write as _};

/// Orders of the axes, and whether the walk turns the other way.
const WALKS: [([usize; 3], Turn); 6] = [
    ([0, 1, 2], Turn::Left),
    ([0, 2, 1], Turn::Right),
    ([1, 0, 2], Turn::Right),
    ([1, 2, 0], Turn::Left),
    ([2, 0, 1], Turn::Left),
    ([2, 1, 0], Turn::Right),
];

/// Sides of the body: axis, end, physical number, name.
const SIDES: [(usize, u32, u32, &str); 6] = [
    (0, 0, 11, "x0"),
    (0, 1, 12, "x1"),
    (1, 0, 13, "y0"),
    (1, 1, 14, "y1"),
    (2, 0, 15, "z0"),
    (2, 1, 16, "z1"),
];

#[derive(Clone, Copy)]
enum Turn {
    Left,
    Right,
}

type Place = [u32; 3];

/// The mesh of `count`^3 cells: 6 `count`^3 tetrahedra, 12 `count`^2 triangles.
pub(crate) fn msh(count: u32) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _infallible = write(&mut text, count);
    text
}

fn write(out: &mut String, count: u32) -> fmt::Result {
    out.push_str("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n");
    names(out)?;
    let side = count + 1;
    writeln!(out, "$Nodes\n{}", side.pow(3))?;
    for place in lattice(side) {
        let [x, y, z] = place.map(|step| f64::from(step) / f64::from(count));
        writeln!(out, "{} {x} {y} {z}", number(place, count))?;
    }
    out.push_str("$EndNodes\n");
    elements(out, count)
}

fn names(out: &mut String) -> fmt::Result {
    writeln!(out, "$PhysicalNames\n{}", SIDES.len() + 1)?;
    for (_, _, tag, name) in SIDES {
        writeln!(out, "2 {tag} \"{name}\"")?;
    }
    out.push_str("3 1 \"body\"\n$EndPhysicalNames\n");
    Ok(())
}

fn elements(out: &mut String, count: u32) -> fmt::Result {
    let total = 6 * count.pow(3) + 12 * count.pow(2);
    writeln!(out, "$Elements\n{total}")?;
    let mut next = 1..;
    for (entity, side) in (1..).zip(SIDES) {
        for cell in lattice(count).flat_map(tetrahedra) {
            let Some(triangle) = facet_on(&cell, side, count) else {
                continue;
            };
            let numbers = triangle.map(|place| number(place, count));
            element(out, &mut next, "2 2", (side.2, entity), &numbers)?;
        }
    }
    for cell in lattice(count).flat_map(tetrahedra) {
        let numbers = cell.map(|place| number(place, count));
        element(out, &mut next, "4 2", (1, 1), &numbers)?;
    }
    out.push_str("$EndElements\n");
    Ok(())
}

fn element(
    out: &mut String,
    next: &mut std::ops::RangeFrom<u32>,
    kind: &str,
    (tag, entity): (u32, u32),
    vertices: &[u32],
) -> fmt::Result {
    let id = next.next().unwrap_or_default();
    write!(out, "{id} {kind} {tag} {entity}")?;
    for vertex in vertices {
        write!(out, " {vertex}")?;
    }
    writeln!(out)
}

fn lattice(side: u32) -> impl Iterator<Item = Place> {
    (0..side.pow(3)).map(move |index| [index % side, index / side % side, index / (side * side)])
}

fn number([x, y, z]: Place, count: u32) -> u32 {
    let side = count + 1;
    1 + x + side * (y + side * z)
}

/// The six tetrahedra of the cell whose first corner is `corner`.
fn tetrahedra(corner: Place) -> impl Iterator<Item = [Place; 4]> {
    WALKS.into_iter().map(move |([first, second, _], turn)| {
        let one = stepped(corner, first);
        let two = stepped(one, second);
        let last = corner.map(|step| step + 1);
        match turn {
            Turn::Left => [corner, one, two, last],
            Turn::Right => [corner, one, last, two],
        }
    })
}

fn stepped(mut place: Place, axis: usize) -> Place {
    if let Some(step) = place.get_mut(axis) {
        *step += 1;
    }
    place
}

/// The facet of a cell that lies on a side, turned outwards.
fn facet_on(
    &[a, b, c, d]: &[Place; 4],
    (axis, end, _, _): (usize, u32, u32, &str),
    count: u32,
) -> Option<[Place; 3]> {
    let facets = [[a, c, b], [a, b, d], [a, d, c], [b, c, d]];
    let on_side = |place: &Place| place.get(axis) == Some(&(end * count));
    facets.into_iter().find(|facet| facet.iter().all(on_side))
}

#[cfg(test)]
mod tests {
    use signorini_client::formats::msh::{self, MeshFile};

    use super::*;

    fn cube(count: u32) -> MeshFile {
        msh::read(msh(count).as_bytes()).unwrap()
    }

    fn corner(mesh: &MeshFile, vertex: u32) -> [f64; 3] {
        mesh.coordinates[vertex as usize]
    }

    fn volume(mesh: &MeshFile, cell: &[u32]) -> f64 {
        let [a, b, c, d] = [0, 1, 2, 3].map(|local| corner(mesh, cell[local]));
        let edge = |point: [f64; 3]| [0, 1, 2].map(|axis| point[axis] - a[axis]);
        let ([u, v, w], m) = ([edge(b), edge(c), edge(d)], |p: f64, q: f64| p * q);
        let minor = |i: usize, j: usize| m(v[i], w[j]) - m(v[j], w[i]);
        (u[0] * minor(1, 2) - u[1] * minor(0, 2) + u[2] * minor(0, 1)) / 6.0
    }

    #[test]
    fn the_cube_has_its_counts_and_its_volume() {
        for count in [1, 3, 6] {
            let mesh = cube(count);
            assert_eq!(mesh.coordinates.len(), (count as usize + 1).pow(3));
            assert_eq!(mesh.cell_count(), 6 * (count as usize).pow(3));
            assert_eq!(mesh.facet_count(), 12 * (count as usize).pow(2));
            let one = 1.0 / f64::from(6 * count.pow(3));
            for cell in mesh.cells.chunks(4) {
                assert!((volume(&mesh, cell) - one).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn every_side_is_a_group_of_its_triangles() {
        let mesh = cube(4);
        let names: Vec<_> = mesh.groups.iter().map(|group| &group.name).collect();
        assert_eq!(names, ["x0", "x1", "y0", "y1", "z0", "z1", "body"]);
        for (group, (axis, end, _, _)) in mesh.groups.iter().zip(SIDES) {
            assert_eq!(group.members.len(), 2 * 4 * 4);
            for facet in &group.members {
                let vertices = &mesh.facets[3 * *facet as usize..][..3];
                for vertex in vertices {
                    let place = corner(&mesh, *vertex)[axis];
                    assert!((place - f64::from(end)).abs() < 1e-15);
                }
            }
        }
    }

    #[test]
    fn the_cube_is_that_of_the_shipped_mesh() {
        let path = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../examples/meshes/cube_n6.msh"
        );
        let shipped = msh::read(&std::fs::read(path).unwrap()).unwrap();
        let written = cube(6);
        // The tetrahedra, whatever the numbers of their vertices.
        let places = |mesh: &MeshFile| {
            let whole = |x: f64| (x * 6.0).round() as u32;
            let place = |vertex: &u32| corner(mesh, *vertex).map(whole);
            let mut cells: Vec<Vec<Place>> = mesh
                .cells
                .chunks(4)
                .map(|cell| {
                    let mut cell: Vec<Place> = cell.iter().map(place).collect();
                    cell.sort_unstable();
                    cell
                })
                .collect();
            cells.sort_unstable();
            cells
        };
        assert_eq!(places(&shipped), places(&written));
    }
}
