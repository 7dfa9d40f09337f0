use proptest::prelude::*;

use super::samples::{cube, cube_parts, rectangle, rectangle_parts};
use super::*;
use crate::geometry::vector3::{cross, dot, norm, scale, sub};

fn error_of(change: impl FnOnce(&mut MeshParts)) -> MeshError {
    let mut parts = cube_parts(2);
    change(&mut parts);
    Mesh::new(parts).expect_err("the change breaks the mesh")
}

fn cell_fault(change: impl FnOnce(&mut MeshParts)) -> (CellFault, usize, usize) {
    let error = error_of(change);
    let MeshError::Cells {
        fault,
        first,
        count,
    } = error
    else {
        panic!("not about cells: {error}");
    };
    (fault, first, count)
}

fn group_fault(change: impl FnOnce(&mut MeshParts)) -> (GroupFault, usize) {
    let error = error_of(change);
    let MeshError::Group { fault, index, .. } = error else {
        panic!("not about groups: {error}");
    };
    (fault, index)
}

#[test]
fn cube_has_the_known_counts() {
    let mesh = cube(3);
    assert_eq!((mesh.vertex_count(), mesh.cell_count()), (64, 162));
    // Along axes, across squares, through cubes.
    assert_eq!(mesh.edges().len(), 3 * 3 * 16 + 3 * 9 * 4 + 27);
    assert_eq!(
        (mesh.facet_count(), mesh.boundary_facets().len()),
        (108, 108)
    );
    assert!(mesh.warnings().is_empty());
    assert!(mesh.bytes() > 10_000);
}

#[test]
fn rectangle_satisfies_eulers_formula() {
    let mesh = rectangle(4, 7);
    assert_eq!(
        mesh.vertex_count() + mesh.cell_count(),
        mesh.edges().len() + 1
    );
    assert_eq!(mesh.boundary_facets().len(), 22);
}

#[test]
fn measures_sum_to_the_whole() {
    for mesh in [cube(3), rectangle(4, 7)] {
        let measures =
            (0..mesh.cell_count()).map(|cell| mesh.cell_kind().signed_measure(&mesh.corners(cell)));
        assert!((measures.sum::<f64>() - 1.0).abs() < 1e-13);
    }
}

#[test]
fn boundary_facets_enclose_the_volume() {
    let mesh = cube(2);
    let flux = mesh.boundary_facets().iter().map(|facet| {
        let [a, b, c] = facet
            .vertices
            .map(|vertex| mesh.coordinates()[vertex as usize]);
        dot(a, cross(sub(b, a), sub(c, a))) / 6.0
    });
    assert!((flux.sum::<f64>() - 1.0).abs() < 1e-13);
}

#[test]
fn uploaded_facets_are_turned_outwards() {
    let mut parts = cube_parts(2);
    parts
        .facets
        .chunks_mut(3)
        .step_by(2)
        .for_each(|facet| facet.swap(0, 1));
    let mesh = Mesh::new(parts).expect("orientation of facets is free");
    let top = mesh.group("z1", GroupKind::Facets).expect("a side");
    for &facet in &top.members {
        let row = mesh.facet(facet as usize);
        let [a, b, c] = [row[0], row[1], row[2]].map(|vertex| mesh.coordinates()[vertex as usize]);
        assert!(norm(sub(cross(sub(b, a), sub(c, a)), [0.0, 0.0, 0.25])) < 1e-14);
        let (cell, opposite) = mesh.facet_cell(facet as usize);
        assert!(mesh.facet_is_boundary(facet as usize));
        let apex = mesh.cell(cell)[opposite];
        assert!(!row.contains(&apex));
    }
}

#[test]
fn groups_are_found_by_name_and_kind() {
    let mesh = cube(1);
    assert!(mesh.group("body", GroupKind::Cells).is_some());
    assert!(mesh.group("body", GroupKind::Facets).is_none());
    assert_eq!(mesh.groups().len(), 7);
}

#[test]
fn unused_vertices_are_dropped_with_a_count() {
    let mut parts = cube_parts(1);
    let reference = cube(1);
    for place in [0, 4] {
        parts.coordinates.insert(place, [7.0, 8.0, 9.0]);
        for vertex in parts.cells.iter_mut().chain(&mut parts.facets) {
            *vertex += u32::from(*vertex >= place as u32);
        }
    }
    let mesh = Mesh::new(parts).expect("unused vertices are allowed");
    assert_eq!(
        mesh.warnings(),
        ["2 vertices belong to no cell and are dropped"]
    );
    assert_eq!(mesh.vertex_count(), 10);
    assert_eq!(mesh.used_vertices(), [1, 2, 3, 5, 6, 7, 8, 9]);
    assert_eq!((mesh.used_vertex(5), mesh.used_vertex(4)), (Some(3), None));
    assert_eq!(mesh.coordinates(), reference.coordinates());
    assert_eq!(
        (mesh.cells(), mesh.edges()),
        (reference.cells(), reference.edges())
    );
    assert_ne!(mesh.id(), reference.id());
}

#[test]
fn edges_are_found_by_their_ends() {
    let mesh = cube(2);
    for (index, &[low, high]) in mesh.edges().iter().enumerate() {
        assert_eq!(mesh.edge_between(high, low), Some(index as u32));
    }
    assert_eq!(mesh.edge_between(0, 2), None);
}

#[test]
fn quality_names_the_worst_cell() {
    let mut parts = cube_parts(1);
    for point in &mut parts.coordinates {
        point[2] *= 0.1;
    }
    let flat = Mesh::new(parts).expect("flat but valid").quality();
    let cubic = cube(1).quality();
    assert!(flat.minimum < 0.5 * cubic.minimum);
    assert!(flat.minimum <= flat.mean && flat.mean <= 1.0);
}

#[test]
fn faulty_cells_are_named_and_counted() {
    let repeated = cell_fault(|parts| parts.cells[13] = parts.cells[12]);
    assert_eq!(repeated, (CellFault::RepeatedVertex, 3, 1));
    let outside = cell_fault(|parts| parts.cells[30] = 27);
    assert_eq!(outside, (CellFault::VertexOutOfRange, 7, 1));
    let duplicate = cell_fault(|parts| {
        let copy = [
            parts.cells[1],
            parts.cells[2],
            parts.cells[0],
            parts.cells[3],
        ];
        parts.cells.extend(copy);
    });
    assert_eq!(duplicate, (CellFault::Duplicate, 48, 1));
    let degenerate = cell_fault(|parts| {
        parts
            .coordinates
            .iter_mut()
            .for_each(|point| point[1] *= 1e-15)
    });
    assert_eq!(degenerate, (CellFault::Degenerate, 0, 48));
}

#[test]
fn cells_of_every_size_are_accepted() {
    for size in [1e-100, 1e-6, 1e6, 1e100] {
        let mut parts = cube_parts(1);
        for point in &mut parts.coordinates {
            *point = scale(size, *point);
        }
        assert!(Mesh::new(parts).is_ok(), "{size}");
    }
}

#[test]
fn faulty_arrays_are_named() {
    assert_eq!(error_of(|parts| parts.cells.clear()), MeshError::NoCells);
    let row = error_of(|parts| parts.facets.truncate(7));
    assert!(matches!(
        row,
        MeshError::ArrayLength {
            array: "facets",
            length: 7,
            row: 3
        }
    ));
    for value in [f64::NAN, f64::INFINITY] {
        let point = error_of(|parts| parts.coordinates[4][1] = value);
        assert_eq!(point, MeshError::NotFinite { first: 4, count: 1 });
    }
    let detached = error_of(|parts| parts.facets[3..6].copy_from_slice(&[0, 1, 26]));
    let fault = FacetFault::Detached;
    assert_eq!(
        detached,
        MeshError::Facets {
            fault,
            first: 1,
            count: 1
        }
    );
    let outside = error_of(|parts| parts.facets[8] = u32::MAX);
    let fault = FacetFault::VertexOutOfRange;
    assert_eq!(
        outside,
        MeshError::Facets {
            fault,
            first: 2,
            count: 1
        }
    );
}

#[test]
fn faulty_groups_are_named() {
    assert_eq!(
        group_fault(|parts| parts.groups[3].name.clear()),
        (GroupFault::Unnamed, 3)
    );
    let repeated = group_fault(|parts| parts.groups[2].name = "x0".to_owned());
    assert_eq!(repeated, (GroupFault::RepeatedName, 2));
    assert_eq!(
        group_fault(|parts| parts.groups[1].members[0] = 48),
        (GroupFault::MemberOutOfRange, 1)
    );
    let twice = group_fault(|parts| parts.groups[1].members[1] = parts.groups[1].members[0]);
    assert_eq!(twice, (GroupFault::RepeatedMember, 1));
    let copied = group_fault(|parts| {
        let copy = parts.facets[..3].to_vec();
        parts.facets.extend(copy);
        parts.groups[1].members.push(48);
    });
    assert_eq!(copied, (GroupFault::RepeatedMember, 1));
}

#[test]
fn one_name_may_serve_cells_and_facets() {
    let mut parts = cube_parts(1);
    parts.groups[1].name = "body".to_owned();
    assert!(Mesh::new(parts).is_ok());
}

#[test]
fn interior_facets_are_allowed() {
    let mut parts = rectangle_parts(1, 1);
    parts.facets.extend([0, 3]);
    let mesh = Mesh::new(parts).expect("the diagonal is a facet");
    assert_eq!(mesh.facet_cell(4), (0, 1));
    assert!(!mesh.facet_is_boundary(4));
}

#[test]
fn triangles_stay_in_their_plane() {
    let mut parts = rectangle_parts(2, 2);
    parts.coordinates[3][2] = 1e-13;
    assert!(Mesh::new(parts.clone()).is_ok());
    parts.coordinates.insert(0, [0.0, 0.0, 5.0]);
    parts
        .cells
        .iter_mut()
        .chain(&mut parts.facets)
        .for_each(|vertex| *vertex += 1);
    assert!(
        Mesh::new(parts.clone()).is_ok(),
        "an unused vertex may lie anywhere"
    );
    parts.coordinates[4][2] = 1e-3;
    assert_eq!(
        Mesh::new(parts).err(),
        Some(MeshError::OffPlane { first: 4, count: 1 })
    );
}

fn index() -> impl Strategy<Value = u32> {
    prop_oneof![40 => 0..5_u32, 1 => any::<u32>()]
}

fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![60 => (-3..4_i8).prop_map(f64::from), 1 => any::<f64>()]
}

/// Whole rows, with a broken one now and then.
fn rows(width: usize, most: usize) -> impl Strategy<Value = Vec<u32>> {
    let whole = prop::collection::vec(prop::collection::vec(index(), width), 0..=most);
    let tail = prop_oneof![20 => Just(0), 1 => 1..4_usize];
    (whole, tail).prop_map(|(rows, tail)| {
        let mut flat = rows.concat();
        flat.truncate(flat.len().saturating_sub(tail));
        flat
    })
}

fn group() -> impl Strategy<Value = Group> {
    let kind = prop_oneof![Just(GroupKind::Cells), Just(GroupKind::Facets)];
    let members = prop::collection::vec(index(), 0..2);
    ("[ab]{0,2}", kind, members).prop_map(|(name, kind, members)| Group {
        name,
        kind,
        members,
    })
}

fn garbage() -> impl Strategy<Value = MeshParts> {
    let kind = prop_oneof![Just(CellKind::Triangle), Just(CellKind::Tetrahedron)];
    (kind, 0..8_u8).prop_flat_map(|(cell_kind, height)| {
        let point = prop::array::uniform3(coordinate());
        let arrays = (
            prop::collection::vec(point, 4..8),
            rows(cell_kind.vertices(), 2),
            rows(cell_kind.facet_vertices(), 1),
            prop::collection::vec(group(), 0..2),
        );
        arrays.prop_map(move |(mut coordinates, cells, facets, groups)| {
            if cell_kind == CellKind::Triangle && height > 0 {
                coordinates.iter_mut().for_each(|point| point[2] = 0.0);
            }
            MeshParts {
                cell_kind,
                coordinates,
                cells,
                facets,
                groups,
            }
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn arbitrary_arrays_never_panic(parts in garbage()) {
        if let Ok(mesh) = Mesh::new(parts) {
            let quality = mesh.quality();
            prop_assert!(quality.minimum > 0.0 && quality.mean <= 1.0);
            let locator = Locator::new(&mesh);
            for point in mesh.coordinates() {
                prop_assert!(locator.find(&mesh, *point).is_some());
            }
        }
    }
}

#[test]
fn cells_that_are_numbered_the_other_way_round_are_turned_with_a_word() {
    let whole = cube(2);
    for step in [1, 3] {
        let mut parts = cube_parts(2);
        let cells = parts.cells.chunks_mut(4).step_by(step);
        let turned = cells.map(|cell| cell.swap(0, 1)).count();
        let mesh = Mesh::new(parts).expect("a whole mesh");
        assert!(mesh.warnings()[0].starts_with(&format!("{turned} cells are numbered")));
        assert_eq!(
            (mesh.edges(), mesh.quality()),
            (whole.edges(), whole.quality())
        );
        let kind = mesh.cell_kind();
        let measure = |cell: usize| kind.signed_measure(&mesh.corners(cell));
        assert!((0..mesh.cell_count()).all(|cell| measure(cell) > 0.0));
    }
}

#[test]
fn cells_that_lie_over_their_neighbours_are_refused() {
    let mut parts = cube_parts(2);
    // The vertex in the middle leaves the cube.
    let is_middle = |x: &&mut [f64; 3]| x.iter().all(|x| (x - 0.5).abs() < 1e-12);
    let middle = parts.coordinates.iter_mut().find(is_middle);
    middle.expect("a vertex")[2] = 1.4;
    let fault = Mesh::new(parts).expect_err("a fold");
    assert!(
        matches!(
            fault,
            MeshError::Cells {
                fault: CellFault::Inverted,
                ..
            }
        ),
        "{fault:?}"
    );
}
