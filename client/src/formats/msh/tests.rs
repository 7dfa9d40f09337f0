//! One mesh in four spellings, and files that are wrong in every way.

use std::fmt::Write as _;

use proptest::prelude::*;

use super::{Fault, MeshFile, MshError, Position, read};
use crate::formats::mesh::{MeshFault, MeshGroup};

/// Two tetrahedra on a shared face, two marked facets, one unnamed group.
const POINTS: [[f64; 3]; 5] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.25, 0.5, 1.0],
    [1.0, 1.0, 0.125],
];
const CELLS: [[u32; 4]; 2] = [[1, 2, 3, 4], [2, 5, 3, 4]];
const FLOOR: [u32; 3] = [1, 3, 2];
const SIDE: [u32; 3] = [1, 2, 4];
const NAMES: &str = "$PhysicalNames\n2\n2 7 \"floor plate\"\n3 1 \"body\"\n$EndPhysicalNames\n";

fn expected() -> MeshFile {
    let group = |name: &str, dimension, members: &[u32]| MeshGroup {
        name: name.into(),
        dimension,
        members: members.to_vec(),
    };
    MeshFile {
        vertices_per_cell: 4,
        coordinates: POINTS.to_vec(),
        cells: CELLS.iter().flatten().map(|tag| tag - 1).collect(),
        facets: FLOOR.iter().chain(&SIDE).map(|tag| tag - 1).collect(),
        groups: vec![
            group("floor plate", 2, &[0]),
            group("9", 2, &[1]),
            group("body", 3, &[0, 1]),
        ],
        curved: Vec::new(),
        warnings: Vec::new(),
    }
}

fn text_22() -> Vec<u8> {
    let mut text = format!("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n{NAMES}$Nodes\n5\n");
    for (index, [x, y, z]) in POINTS.iter().enumerate() {
        writeln!(text, "{} {x} {y} {z}", index + 1).unwrap();
    }
    text += "$EndNodes\n$Elements\n4\n1 2 2 7 7 1 3 2\n2 2 2 9 9 1 2 4\n";
    text += "3 4 2 1 1 1 2 3 4\n4 4 2 1 1 2 5 3 4\n$EndElements\n";
    text.into_bytes()
}

fn text_41() -> Vec<u8> {
    let mut text = format!("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n{NAMES}");
    text += "$Entities\n1 0 2 1\n1 0 0 0 0\n7 0 0 0 1 1 1 1 7 0\n9 0 0 0 1 1 1 1 9 1 3\n";
    text += "1 0 0 0 1 1 1 1 1 2 7 -9\n$EndEntities\n$Nodes\n1 5 1 5\n3 1 0 5\n1\n2\n3\n4\n5\n";
    for [x, y, z] in POINTS {
        writeln!(text, "{x} {y} {z}").unwrap();
    }
    text += "$EndNodes\n$Elements\n3 4 1 4\n2 7 2 1\n1 1 3 2\n2 9 2 1\n2 1 2 4\n";
    text += "3 1 4 2\n3 1 2 3 4\n4 2 5 3 4\n$EndElements\n";
    text.into_bytes()
}

/// Collects little-endian values.
#[derive(Default)]
struct Bytes(Vec<u8>);

impl Bytes {
    fn text(&mut self, text: &str) -> &mut Self {
        self.0.extend(text.as_bytes());
        self
    }

    fn ints(&mut self, values: &[i32]) -> &mut Self {
        self.0
            .extend(values.iter().flat_map(|value| value.to_le_bytes()));
        self
    }

    fn sizes(&mut self, values: &[u64]) -> &mut Self {
        self.0
            .extend(values.iter().flat_map(|value| value.to_le_bytes()));
        self
    }

    fn reals(&mut self, values: &[f64]) -> &mut Self {
        self.0
            .extend(values.iter().flat_map(|value| value.to_le_bytes()));
        self
    }
}

fn head(version: &str) -> Bytes {
    let mut out = Bytes::default();
    out.text(&format!("$MeshFormat\n{version} 1 8\n"))
        .ints(&[1]);
    out.text("\n$EndMeshFormat\n").text(NAMES);
    out
}

fn binary_22() -> Vec<u8> {
    let mut out = head("2.2");
    out.text("$Nodes\n5\n");
    for (index, point) in POINTS.iter().enumerate() {
        out.ints(&[index as i32 + 1]).reals(point);
    }
    out.text("\n$EndNodes\n$Elements\n4\n");
    out.ints(&[2, 2, 2, 1, 7, 7, 1, 3, 2, 2, 9, 9, 1, 2, 4]);
    out.ints(&[4, 2, 2, 3, 1, 1, 1, 2, 3, 4, 4, 1, 1, 2, 5, 3, 4]);
    out.text("\n$EndElements\n");
    out.0
}

fn binary_41() -> Vec<u8> {
    let mut out = head("4.1");
    out.text("$Entities\n").sizes(&[1, 0, 2, 1]);
    out.ints(&[1]).reals(&[0.0; 3]).sizes(&[0]);
    for (entity, bounding) in [(7, &[][..]), (9, &[3][..])] {
        out.ints(&[entity])
            .reals(&[0.0; 6])
            .sizes(&[1])
            .ints(&[entity]);
        out.sizes(&[bounding.len() as u64]).ints(bounding);
    }
    out.ints(&[1])
        .reals(&[0.0; 6])
        .sizes(&[1])
        .ints(&[1])
        .sizes(&[2])
        .ints(&[7, -9]);
    out.text("\n$EndEntities\n$Nodes\n")
        .sizes(&[1, 5, 1, 5])
        .ints(&[3, 1, 0]);
    out.sizes(&[5, 1, 2, 3, 4, 5]).reals(&POINTS.concat());
    out.text("\n$EndNodes\n$Elements\n").sizes(&[3, 4, 1, 4]);
    out.ints(&[2, 7, 2]).sizes(&[1, 1, 1, 3, 2]);
    out.ints(&[2, 9, 2]).sizes(&[1, 2, 1, 2, 4]);
    out.ints(&[3, 1, 4])
        .sizes(&[2, 3, 1, 2, 3, 4, 4, 2, 5, 3, 4]);
    out.text("\n$EndElements\n");
    out.0
}

fn spellings() -> [Vec<u8>; 4] {
    [text_22(), text_41(), binary_22(), binary_41()]
}

fn replaced(from: &str, to: &str) -> Result<MeshFile, MshError> {
    let text = String::from_utf8(text_22()).unwrap();
    assert!(text.contains(from));
    read(text.replacen(from, to, 1).as_bytes())
}

fn fault(from: &str, to: &str) -> Fault {
    replaced(from, to).unwrap_err().fault
}

#[test]
fn versions_and_encodings_of_one_mesh_are_equal() {
    for bytes in spellings() {
        assert_eq!(read(&bytes).unwrap(), expected());
    }
}

#[test]
fn unknown_sections_are_skipped() {
    let mesh = replaced("$Nodes", "$Comments\nany $thing\n$EndComments\n$Nodes").unwrap();
    assert_eq!(mesh, expected());
}

#[test]
fn vertices_are_ordered_by_node_number() {
    let mesh = replaced("5 1 1 0.125", "50 1 1 0.125");
    let mesh = mesh.unwrap_err();
    assert_eq!(mesh.fault, Fault::Mesh(MeshFault::UnknownNode(5)));
    let text = String::from_utf8(text_22()).unwrap();
    let text = text
        .replace("\n5 1 1 0.125", "\n50 1 1 0.125")
        .replace("2 5 3 4", "2 50 3 4");
    assert_eq!(read(text.as_bytes()).unwrap(), expected());
}

#[test]
fn version_2_copies_of_an_element_are_one_element_in_two_groups() {
    let copy = "$Elements\n5\n9 2 2 8 7 1 3 2\n";
    let mesh = replaced("$Elements\n4\n", copy).unwrap();
    assert_eq!(mesh.facet_count(), 2);
    let names: Vec<_> = mesh
        .groups
        .iter()
        .map(|group| (group.name.as_str(), &*group.members))
        .collect();
    assert_eq!(
        names,
        [
            ("floor plate", &[0_u32][..]),
            ("8", &[0]),
            ("9", &[1]),
            ("body", &[0, 1])
        ]
    );
}

#[test]
fn repeated_cells_of_one_group_are_kept_for_the_solver_to_refuse() {
    let mesh = replaced("$Elements\n4\n", "$Elements\n5\n9 4 2 1 1 1 2 3 4\n").unwrap();
    assert_eq!(mesh.cell_count(), 3);
}

#[test]
fn second_order_cells_of_straight_edges_are_read_with_a_warning() {
    let text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n6\n1 0 0 0\n2 0.5 0 0\n3 1 0 0\n4 0 1 0\n\
                5 0.5 0.5 0\n6 0 0.5 0\n$EndNodes\n$Elements\n2\n1 9 2 4 4 1 3 4 2 5 6\n2 8 2 5 5 1 3 2\n$EndElements\n";
    let mesh = read(text.as_bytes()).unwrap();
    assert_eq!((mesh.vertices_per_cell, mesh.coordinates.len()), (3, 3));
    assert_eq!((mesh.cells, mesh.facets), (vec![0, 1, 2], vec![0, 1]));
    assert!(mesh.warnings[0].starts_with("1 cells are of second order"));
    assert!(mesh.curved.is_empty());
}

#[test]
fn triangles_outside_the_plane_are_refused() {
    let text = |z: &str| {
        format!(
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n3\n1 0 0 {z}\n2 1 0 0\n3 0 1 0\n$EndNodes\n\
                 $Elements\n1\n1 2 2 4 4 1 2 3\n$EndElements\n"
        )
    };
    let mesh = read(text("1e-13").as_bytes()).unwrap();
    assert_eq!(mesh.coordinates[0][2].to_bits(), 0);
    let error = read(text("1e-11").as_bytes()).unwrap_err();
    assert!(error.to_string().contains("plane z = 0"), "{error}");
}

#[test]
fn tags_without_an_absolute_value_are_refused() {
    let unexpected = || Fault::Unexpected {
        expected: "a physical group",
        found: i64::MIN.to_string(),
    };
    let tagged = format!("2 2 2 {} 9 1 2 4", i64::MIN);
    assert_eq!(fault("2 2 2 9 9 1 2 4", &tagged), unexpected());
    let text = String::from_utf8(text_41()).unwrap();
    let text = text.replacen("1 9 1 3", &format!("1 {} 1 3", i64::MIN), 1);
    assert_eq!(read(text.as_bytes()).unwrap_err().fault, unexpected());
}

#[test]
fn names_of_a_negative_dimension_are_refused() {
    let names = "$PhysicalNames\n1\n-2 7 \"top\"\n$EndPhysicalNames\n$Nodes";
    let unexpected = Fault::Unexpected {
        expected: "a dimension",
        found: "-2".into(),
    };
    assert_eq!(fault("$Nodes", names), unexpected);
}

#[test]
fn a_mesh_of_lines_only_has_no_cells() {
    let text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n2\n1 0 0 0\n2 1 0 0\n$EndNodes\n\
                $Elements\n1\n1 1 2 4 4 1 2\n$EndElements\n";
    let error = read(text.as_bytes()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "no triangles, quadrangles, tetrahedra, hexahedra, wedges or pyramids"
    );
}

#[test]
fn faults_are_named_with_their_section_and_place() {
    let error = replaced("0.25 0.5 1", "0.25 half 1").unwrap_err();
    assert_eq!(error.section.as_deref(), Some("Nodes"));
    assert_eq!(error.position, Some(Position::Line(14)));
    assert_eq!(
        error.to_string(),
        "line 14: in $Nodes: a coordinate is expected, found \"half\""
    );
}

#[test]
fn binary_faults_are_placed_by_byte() {
    let bytes = binary_41();
    let error = read(&bytes[..bytes.len() - 60]).unwrap_err();
    assert!(matches!(error.position, Some(Position::Byte(_))), "{error}");
    assert_eq!(error.section.as_deref(), Some("Elements"));
}

#[test]
fn each_kind_of_bad_file_has_its_fault() {
    assert_eq!(read(b"solid ascii").unwrap_err().fault, Fault::NotMsh);
    assert_eq!(read(b"").unwrap_err().fault, Fault::NotMsh);
    assert_eq!(fault("2.2 0 8", "4 0 8"), Fault::Version("4".into()));
    assert_eq!(fault("2.2 0 8", "2.2 0 4"), Fault::DataSize(4));
    assert_eq!(
        fault("$Nodes", "$Elements\n0\n$EndElements\n$Nodes"),
        Fault::RepeatedSection("Elements")
    );
    assert_eq!(
        fault("1 0 0 0", "1 inf 0 0"),
        Fault::Mesh(MeshFault::NotFinite(1))
    );
    assert_eq!(
        fault("\n2 1 0 0\n", "\n1 1 0 0\n"),
        Fault::Mesh(MeshFault::DuplicateNode(1))
    );
    assert!(matches!(
        fault("1 2 2 7 7 1 3 2", "1 20 2 7 7 1 3 2 4 1 3 2 4 1"),
        Fault::UnsupportedElement(_)
    ));
    assert!(matches!(
        fault("1 2 2 7 7 1 3 2", "1 92 2 7 7 1 3 2 4 1 3 2 4"),
        Fault::UnsupportedElement(_)
    ));
    assert!(matches!(fault("$EndNodes\n", ""), Fault::Unexpected { .. }));
    assert!(matches!(fault("$EndElements\n", ""), Fault::Truncated(_)));
    assert_eq!(
        read(b"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n")
            .unwrap_err()
            .fault,
        Fault::MissingSection("Nodes")
    );
}

#[test]
fn foreign_byte_order_is_refused_by_name() {
    let mut bytes = binary_41();
    let mark = "$MeshFormat\n4.1 1 8\n".len();
    bytes[mark..mark + 4].reverse();
    assert_eq!(read(&bytes).unwrap_err().fault, Fault::ForeignByteOrder);
}

#[test]
fn counts_beyond_the_file_are_refused_before_anything_is_stored() {
    for count in ["6000000000000000000", "900000"] {
        let error = fault("$Nodes\n5\n", &format!("$Nodes\n{count}\n"));
        assert!(matches!(error, Fault::Count { .. }), "{error}");
    }
    assert!(matches!(
        fault("$Nodes\n5\n", "$Nodes\n-5\n"),
        Fault::Unexpected { .. }
    ));
}

#[test]
fn the_example_meshes_have_their_known_sizes() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/meshes");
    for (name, nodes, vertices) in [("cube_n6", 6591 / 3, 343), ("hemi_l2", 7146 / 3, 378)] {
        let bytes = std::fs::read(format!("{folder}/{name}.msh")).unwrap();
        let mesh = read(&bytes).unwrap();
        let edges = crate::formats::vtu::unique_edges(4, &mesh.cells);
        assert_eq!(
            (mesh.coordinates.len() + edges.len(), mesh.coordinates.len()),
            (nodes, vertices),
            "{name}"
        );
        assert!(mesh.warnings.is_empty());
    }
}

proptest! {
    #[test]
    fn truncation_is_an_error_and_never_a_panic(spelling in 0_usize..4, cut in 0.0_f64..1.0) {
        let bytes = &spellings()[spelling];
        let whole = bytes.len() - "$EndElements\n".len();
        let end = (cut * whole as f64) as usize;
        prop_assert!(read(&bytes[..end]).is_err());
    }

    #[test]
    fn flipped_bytes_never_panic(
        spelling in 0_usize..4,
        flips in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
    ) {
        let mut bytes = spellings()[spelling].clone();
        for (place, value) in flips {
            let place = place.index(bytes.len());
            bytes[place] = value;
        }
        if let Ok(mesh) = read(&bytes) {
            let count = mesh.coordinates.len();
            prop_assert!(mesh.cells.iter().all(|vertex| (*vertex as usize) < count));
        }
    }

    #[test]
    fn random_bytes_after_a_good_head_never_panic(
        version in prop::sample::select(vec!["2.2", "4.1"]),
        section in prop::sample::select(vec!["PhysicalNames", "Entities", "Nodes", "Elements"]),
        noise in proptest::collection::vec(any::<u8>(), 0..200),
    ) {
        let mut bytes = head(version).0;
        bytes.extend(format!("${section}\n").as_bytes());
        bytes.extend(noise);
        prop_assert!(read(&bytes).is_err());
    }
}
