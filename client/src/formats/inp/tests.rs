//! One mesh in the spellings of several programs, and files that are wrong in every way.

use super::{InpError, InpFault, read};
use crate::formats::mesh::{MeshFault, MeshFile};
use crate::formats::msh;

const FLAT: &str = "*HEADING\n two tetrahedra\n** a comment\n*NODE, NSET=ALL\n\
    1, 0., 0., 0.\n2, 1., 0.\n 3, 0., 1.0D0, 0.\n4, 0., 0., 1.\n5, 1., 1., 1.\n\
    *ELEMENT, TYPE=C3D4H, ELSET=core\n10, 1, 2, 3, 4\n20, 2, 3,\n 4, 5\n\
    *NSET, NSET=Floor\n1, 2, 3\n*NSET, NSET=corner\n4\n\
    *ELSET, ELSET=upper\n 20\n*ELSET, ELSET=both, GENERATE\n10, 1000000000000, 10\n\
    *SURFACE, NAME=Side, TYPE=ELEMENT\n10, S2\nupper, S3\n\
    *SURFACE, NAME=Skin\nboth,\n*SOLID SECTION, ELSET=both, MATERIAL=Rubber\n,\n\
    *MATERIAL, NAME=Rubber\n*HYPERELASTIC\n1., 2.\n";

fn fixture(name: &str) -> Vec<u8> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/formats");
    std::fs::read(format!("{folder}/{name}")).unwrap()
}

fn groups(mesh: &MeshFile) -> Vec<(&str, usize, &[u32])> {
    let groups = mesh.groups.iter();
    groups
        .map(|group| (group.name.as_str(), group.dimension, &*group.members))
        .collect()
}

fn replaced(from: &str, to: &str) -> Result<MeshFile, InpError> {
    assert!(FLAT.contains(from), "{from}");
    read(FLAT.replacen(from, to, 1).as_bytes())
}

fn error(from: &str, to: &str) -> InpError {
    replaced(from, to).unwrap_err()
}

/// Facets of a group as sorted vertices.
fn facets(mesh: &MeshFile, name: &str) -> Vec<Vec<u32>> {
    let width = mesh.vertices_per_cell - 1;
    let group = mesh
        .groups
        .iter()
        .find(|group| group.name == name && group.dimension + 1 == width);
    let mut facets: Vec<Vec<u32>> = group
        .unwrap()
        .members
        .iter()
        .map(|member| {
            let first = *member as usize * width;
            let mut facet = mesh.facets[first..first + width].to_vec();
            facet.sort_unstable();
            facet
        })
        .collect();
    facets.sort_unstable();
    facets
}

#[test]
fn sets_surfaces_and_sections_become_groups() {
    let mesh = read(FLAT.as_bytes()).unwrap();
    assert_eq!((mesh.vertices_per_cell, mesh.coordinates.len()), (4, 5));
    assert_eq!(mesh.cells, [0, 1, 2, 3, 1, 2, 3, 4]);
    let cells: Vec<_> = groups(&mesh)
        .into_iter()
        .filter(|group| group.1 == 3)
        .collect();
    let expected: [(&str, usize, &[u32]); 4] = [
        ("core", 3, &[0, 1]),
        ("upper", 3, &[1]),
        ("both", 3, &[0, 1]),
        ("Rubber", 3, &[0, 1]),
    ];
    assert_eq!(cells, expected);
    assert_eq!(facets(&mesh, "Floor"), [[0, 1, 2]]);
    // S2 of 1, 2, 3, 4 is 1, 4, 2; S3 of 2, 3, 4, 5 is 3, 5, 4.
    assert_eq!(facets(&mesh, "Side"), [[0, 1, 3], [2, 3, 4]]);
    assert_eq!(facets(&mesh, "Skin").len(), 6);
    assert_eq!(facets(&mesh, "ALL").len(), 6);
    assert!(
        mesh.warnings
            .iter()
            .any(|warning| warning.ends_with("left out: corner"))
    );
    assert!(
        mesh.warnings
            .iter()
            .any(|warning| warning.starts_with("materials, supports"))
    );
}

#[test]
fn one_part_with_one_instance_is_that_part() {
    let text = "*Heading\n*Part, name=Part-1\n*Node\n1, 0., 0.\n2, 1., 0.\n3, 0., 1.\n\
        *Element, type=CAX3H\n1, 1, 2, 3\n*End Part\n*Assembly, name=Assembly\n\
        *Instance, name=Part-1-1, part=Part-1\n 2., 0.5, 0.\n*End Instance\n\
        *Node\n 1, 9., 9., 0.\n*Nset, nset=_RefPt, internal\n 1,\n\
        *Nset, nset=\"my base\", instance=Part-1-1, generate\n 1, 2, 1\n\
        *Elset, elset=_Surf-1_S2, internal, instance=Part-1-1\n 1\n\
        *Surface, type=ELEMENT, name=Surf-1\n_Surf-1_S2, S2\n\
        *Nset, nset=again\nPart-1-1.\"my base\",\n*End Assembly\n";
    let mesh = read(text.as_bytes()).unwrap();
    assert_eq!(
        mesh.coordinates[1].map(f64::to_bits),
        [3.0, 0.5, 0.0].map(f64::to_bits)
    );
    assert_eq!(facets(&mesh, "my base"), [[0, 1]]);
    assert_eq!(facets(&mesh, "Surf-1"), [[1, 2]]);
    assert_eq!(groups(&mesh).last(), Some(&("body", 2, &[0_u32][..])));
}

#[test]
fn a_file_without_names_has_a_body_and_a_boundary() {
    let mesh = read(&fixture("meshio.inp")).unwrap();
    let expected: [(&str, usize, &[u32]); 2] =
        [("boundary", 2, &[0, 1, 2, 3, 4, 5]), ("body", 3, &[0, 1])];
    assert_eq!(groups(&mesh), expected);
}

#[test]
fn files_of_second_order_are_those_of_gmsh_with_their_curved_sides() {
    for name in ["sphere2", "ring2"] {
        let ours = read(&fixture(&format!("{name}.inp"))).unwrap();
        let gmsh = msh::read(&fixture(&format!("{name}.msh"))).unwrap();
        assert_eq!(ours.cells, gmsh.cells, "{name}");
        assert_eq!(facets(&ours, "skin"), facets(&gmsh, "skin"), "{name}");
        let ends = |mesh: &MeshFile| mesh.curved.iter().map(|edge| edge.ends).collect::<Vec<_>>();
        assert_eq!(ends(&ours), ends(&gmsh), "{name}");
        assert!(ours.curved.len() > 10, "{name}");
        for (a, b) in ours.curved.iter().zip(&gmsh.curved) {
            let off = a.offset.iter().zip(b.offset).map(|(a, b)| (a - b).abs());
            assert!(off.fold(0.0, f64::max) < 1e-12, "{name}");
        }
    }
}

#[test]
fn faults_are_told_with_line_keyword_and_element() {
    let told = error("2, 1., 0.\n", "2, 1., half\n");
    assert_eq!(
        (told.line, told.keyword.as_deref()),
        (Some(6), Some("NODE"))
    );
    assert_eq!(
        told.to_string(),
        "line 6: in *NODE: a coordinate is expected, found \"half\""
    );
    let told = error("10, 1, 2, 3, 4", "10, 1, 2, 3, 44");
    assert_eq!(
        told.fault,
        InpFault::UnknownNode {
            element: 10,
            node: 44
        }
    );
    let told = error(" 4, 5\n", " 4, 5, 6\n");
    let count = InpFault::NodeCount {
        element: 20,
        kind: "C3D4H".into(),
        expected: 4,
        found: 5,
    };
    assert_eq!((told.line, told.fault), (Some(13), count));
}

#[test]
fn each_kind_of_bad_file_has_its_fault() {
    assert_eq!(read(b"").unwrap_err().fault, InpFault::NotInp);
    assert_eq!(read(b"solid\n").unwrap_err().fault, InpFault::NotInp);
    let fault = |from, to| error(from, to).fault;
    assert!(
        matches!(fault("*HEADING\n", "*INCLUDE, INPUT=a.inc\n"), InpFault::Include(file) if file == "a.inc")
    );
    assert!(matches!(
        fault("*NODE, NSET=ALL", "*NODE, INPUT=a"),
        InpFault::Include(_)
    ));
    assert!(matches!(
        fault("*NODE, NSET=ALL", "*NODE, SYSTEM=S"),
        InpFault::Unsupported(_)
    ));
    assert!(matches!(
        fault("*HEADING", "*NGEN"),
        InpFault::Unsupported(_)
    ));
    assert_eq!(
        fault("C3D4H", "C3D27"),
        InpFault::UnsupportedElement("C3D27".into())
    );
    assert_eq!(
        fault("TYPE=C3D4H, ", ""),
        InpFault::MissingParameter("TYPE")
    );
    assert_eq!(
        fault("20, 2, 3,", "10, 2, 3,"),
        InpFault::DuplicateElement(10)
    );
    assert_eq!(
        fault("\n 20\n", "\n none\n"),
        InpFault::UnknownSet("none".into())
    );
    assert_eq!(fault("10, S2", "30, S2"), InpFault::UnknownElement(30));
    assert_eq!(
        fault("C3D4H", "C3D8R"),
        InpFault::NodeCount {
            element: 10,
            kind: "C3D8R".into(),
            expected: 8,
            found: 9
        }
    );
    assert!(matches!(
        fault("10, S2", "10, S5"),
        InpFault::UnknownFace { element: 10, .. }
    ));
    assert!(matches!(
        fault("10, S2", "10, E2"),
        InpFault::Unexpected { .. }
    ));
    assert!(matches!(
        fault(" 4, 5\n", " 4\n"),
        InpFault::NodeCount { .. }
    ));
    assert_eq!(
        fault("5, 1., 1., 1.", "4, 1., 1., 1."),
        InpFault::Mesh(MeshFault::DuplicateNode(4))
    );
    assert_eq!(
        fault("5, 1., 1., 1.", "5, inf, 1., 1."),
        InpFault::Mesh(MeshFault::NotFinite(5))
    );
    let parts = "*PART, NAME=a\n*NODE\n1,0.,0.\n*END PART\n*PART, NAME=b\n*NODE\n1,0.,0.\n";
    assert_eq!(
        read(parts.as_bytes()).unwrap_err().fault,
        InpFault::Mesh(MeshFault::NoCells)
    );
    let lines = "*NODE\n1,0.,0.\n2,1.,0.\n*ELEMENT,TYPE=T2D2\n1,1,2\n";
    assert_eq!(
        read(lines.as_bytes()).unwrap_err().fault,
        InpFault::Mesh(MeshFault::NoCells)
    );
}

/// A unit cube of one hexahedron with a skin of its top, and sets and surfaces of its faces.
const CUBE: &str = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 1., 1., 0.\n4, 0., 1., 0.\n5, 0., 0., 1.\n\
    6, 1., 0., 1.\n7, 1., 1., 1.\n8, 0., 1., 1.\n*ELEMENT, TYPE=C3D8R, ELSET=core\n9, 1, 2, 3, 4, 5, 6, 7, 8\n\
    *ELEMENT, TYPE=S4R, ELSET=skin\n10, 5, 6, 7, 8\n*NSET, NSET=floor\n1, 2, 3, 4\n\
    *NSET, NSET=corner\n1, 2, 4, 3, 5\n*NSET, NSET=three\n1, 2, 6\n\
    *SURFACE, NAME=side\n9, S4\n*SURFACE, NAME=all\ncore,\n*SURFACE, NAME=top\n9, S2\n";

#[test]
fn faces_of_a_split_cell_are_two_facets_of_its_sets_and_surfaces() {
    let mesh = read(CUBE.as_bytes()).unwrap();
    assert_eq!((mesh.cell_count(), mesh.facet_count()), (6, 12));
    assert_eq!(facets(&mesh, "floor"), [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(facets(&mesh, "side"), [[1, 2, 6], [1, 5, 6]]);
    assert_eq!(facets(&mesh, "top"), [[4, 5, 6], [4, 6, 7]]);
    assert_eq!(facets(&mesh, "skin"), facets(&mesh, "top"));
    assert_eq!(facets(&mesh, "all").len(), 12);
    // Half a face is none.
    assert_eq!(facets(&mesh, "corner"), facets(&mesh, "floor"));
    assert!(mesh.groups.iter().all(|group| group.name != "three"));
    let core = mesh
        .groups
        .iter()
        .find(|group| group.name == "core")
        .unwrap();
    assert_eq!(core.members, [0, 1, 2, 3, 4, 5]);
}

#[test]
fn sides_of_quadrangles_are_those_of_their_triangles() {
    let text = "*NODE\n1, 0., 0.\n2, 1., 0.\n3, 1., 1.\n4, 0., 1.\n*ELEMENT, TYPE=CAX4H\n1, 1, 2, 3, 4\n\
        *SURFACE, NAME=right\n1, S2\n*SURFACE, NAME=left\n1, S4\n*NSET, NSET=top\n3, 4\n\
        *SURFACE, NAME=all\n1,\n";
    let mesh = read(text.as_bytes()).unwrap();
    assert_eq!(mesh.cells, [0, 1, 2, 0, 2, 3]);
    assert_eq!(facets(&mesh, "right"), [[1, 2]]);
    assert_eq!(facets(&mesh, "left"), [[0, 3]]);
    assert_eq!(facets(&mesh, "top"), [[2, 3]]);
    assert_eq!(facets(&mesh, "all").len(), 4);
}
