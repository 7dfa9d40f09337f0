//! Parts, instances, systems of coordinates and files that are included.

use std::collections::HashMap;
use std::path::Path;

use super::{InpError, InpFault, read, read_with};
use crate::formats::mesh::MeshFile;

/// A unit square of two triangles as a part with a set, a surface and a section.
const PART: &str = "*PART, NAME=P\n*NODE\n1, 0., 0.\n2, 1., 0.\n3, 1., 1.\n4, 0., 1.\n\
    *ELEMENT, TYPE=CPE3, ELSET=all\n1, 1, 2, 3\n2, 1, 3, 4\n*NSET, NSET=top\n3, 4\n\
    *SURFACE, NAME=side\n1, S2\n*SOLID SECTION, ELSET=all, MATERIAL=Rubber\n*END PART\n";

/// The part twice: moved, and moved and turned by a right angle about the point (3, 0).
fn two() -> String {
    format!(
        "{PART}*ASSEMBLY, NAME=A\n*INSTANCE, NAME=one, PART=P\n0., 5.\n*END INSTANCE\n\
         *INSTANCE, NAME=Two, PART=p\n3., 0., 0.\n3., 0., 0., 3., 0., 1., 90.\n*END INSTANCE\n\
         *NODE\n1, 9., 9.\n*NSET, NSET=point\n1\n*NSET, NSET=ends, INSTANCE=two\n1, 2\n\
         *NSET, NSET=both\none.top, Two.\"top\"\n*ELSET, ELSET=low, INSTANCE=one, GENERATE\n\
         1, 1000, 2\n*NSET, NSET=corner\nTwo.2, Two.3\n*END ASSEMBLY\n*TIE, NAME=t\nx, y\n"
    )
}

fn names(mesh: &MeshFile) -> Vec<(&str, usize)> {
    let groups = mesh.groups.iter();
    groups
        .map(|group| (group.name.as_str(), group.members.len()))
        .collect()
}

/// Places of the corners of the facets of a group, sorted.
fn places(mesh: &MeshFile, name: &str) -> Vec<[i64; 2]> {
    let group = mesh.groups.iter().find(|group| group.name == name).unwrap();
    let corners = |member: &u32| [2 * member, 2 * member + 1].map(|at| mesh.facets[at as usize]);
    let mut places: Vec<[i64; 2]> = group
        .members
        .iter()
        .flat_map(corners)
        .map(|vertex| mesh.coordinates[vertex as usize])
        .map(|[x, y, _]| [x.round() as i64, y.round() as i64])
        .collect();
    places.sort_unstable();
    places
}

#[test]
fn instances_are_moved_and_turned_copies_with_names_of_their_own() {
    let mesh = read(two().as_bytes()).unwrap();
    assert_eq!((mesh.coordinates.len(), mesh.cell_count()), (8, 4));
    let expected = [
        ("one.side", 1),
        ("Two.side", 1),
        ("one.top", 1),
        ("Two.top", 1),
        ("ends", 1),
        ("both", 2),
        ("corner", 1),
        ("one.all", 2),
        ("Two.all", 2),
        ("low", 1),
        ("Rubber", 4),
    ];
    assert_eq!(names(&mesh), expected);
    assert_eq!(places(&mesh, "one.top"), [[0, 6], [1, 6]]);
    // (0, 1) and (1, 1) beside (3, 0), turned about it.
    assert_eq!(places(&mesh, "Two.top"), [[2, 0], [2, 1]]);
    assert_eq!(places(&mesh, "ends"), [[3, 0], [3, 1]]);
    assert_eq!(places(&mesh, "corner"), places(&mesh, "Two.side"));
    assert_eq!(mesh.warnings.len(), 1, "{:?}", mesh.warnings);
    assert!(mesh.warnings[0].contains("*TIE"), "{:?}", mesh.warnings);
}

#[test]
fn one_instance_keeps_the_names_and_numbers_of_its_part() {
    let text = format!(
        "{PART}*ASSEMBLY, NAME=A\n*INSTANCE, NAME=i, PART=P\n*END INSTANCE\n*END ASSEMBLY\n"
    );
    let mesh = read(text.as_bytes()).unwrap();
    let flat = PART
        .replace("*PART, NAME=P\n", "")
        .replace("*END PART\n", "");
    assert_eq!(mesh, read(flat.as_bytes()).unwrap());
    assert_eq!(mesh, read(PART.as_bytes()).unwrap());
}

#[test]
fn faults_of_assemblies_name_what_is_not_there() {
    let fault = |from: &str, to: &str| {
        let text = two();
        assert!(text.contains(from), "{from}");
        read(text.replacen(from, to, 1).as_bytes())
            .unwrap_err()
            .fault
    };
    assert_eq!(
        fault("PART=p\n", "PART=q\n"),
        InpFault::UnknownPart("q".into())
    );
    assert_eq!(
        fault("INSTANCE=two", "INSTANCE=three"),
        InpFault::UnknownInstance("three".into())
    );
    assert_eq!(
        fault("NAME=Two", "NAME=ONE"),
        InpFault::DuplicateInstance("ONE".into())
    );
    assert_eq!(
        fault("one.top", "one.bottom"),
        InpFault::UnknownSet("one.bottom".into())
    );
    assert_eq!(
        fault("2, 1, 3, 4", "2, 1, 3, 7"),
        InpFault::UnknownNode {
            element: 2,
            node: 7
        }
    );
    assert!(matches!(
        fault("3., 0., 1., 90.", "3., 0., 0., 90."),
        InpFault::Unsupported(_)
    ));
}

#[test]
fn copies_beyond_the_size_of_the_file_are_refused() {
    let mut text = PART.to_owned();
    for _ in 0..12 {
        text = text.replace(
            "*NSET, NSET=top\n3, 4\n",
            "*NSET, NSET=top\n3, 4\n*NSET, NSET=x\n1, 3, 1, 3, 1, 3\n",
        );
    }
    for instance in 0..400 {
        text += &format!("*INSTANCE,NAME={instance},PART=P\n");
    }
    let error = read(text.as_bytes()).unwrap_err();
    assert!(matches!(error.fault, InpFault::TooManyCopies(_)), "{error}");
}

#[test]
fn nodes_may_be_cylindrical_and_of_a_local_system() {
    let flat = "*NODE\n1, 1., 0.\n2, 2., 0.\n3, 0., 1.\n*ELEMENT, TYPE=CPE3\n1, 1, 2, 3\n";
    let turned = "*SYSTEM\n1., 1., 0., 1., 2., 0.\n0., 1., 0.\n*NODE, SYSTEM=C\n1, 1., -90.\n2, 1., 0.\n\
        *SYSTEM\n*NODE\n3, 0., 1.\n*ELEMENT, TYPE=CPE3\n1, 1, 2, 3\n";
    let (flat, turned) = (
        read(flat.as_bytes()).unwrap(),
        read(turned.as_bytes()).unwrap(),
    );
    assert_eq!(flat.cells, turned.cells);
    let expected = [[2.0, 1.0], [1.0, 2.0], [0.0, 1.0]];
    for (found, expected) in turned.coordinates.iter().zip(expected) {
        assert!(
            (found[0] - expected[0]).hypot(found[1] - expected[1]) < 1e-14,
            "{found:?}"
        );
    }
    let line = "*SYSTEM\n0., 0., 0., 1., 0., 0.\n2., 0., 0.\n";
    assert!(read(line.as_bytes()).is_err());
}

#[test]
fn runs_may_count_down_and_what_is_no_cell_is_left_out() {
    let text = "*NODE\n1, 0., 0.\n2, 1., 0.\n3, 1., 1.\n4, 0., 1.\n*ELEMENT, TYPE=CPE3, ELSET=all\n\
        1, 1, 2, 3\n2, 1, 3, 4\n*ELEMENT, TYPE=SPRINGA, ELSET=spring\n3, 1, 3\n*ELEMENT, TYPE=MASS\n4, 1\n\
        *ELEMENT, TYPE=SPRINGA\n5, 2, 4\n*NSET, NSET=down, GENERATE\n4, 1, -3\n\
        *NSET, NSET=base, GENERATE\n2, 1, -1\n";
    let mesh = read(text.as_bytes()).unwrap();
    assert_eq!(places(&mesh, "down"), [[0, 0], [0, 1]]);
    assert_eq!(places(&mesh, "base"), [[0, 0], [1, 0]]);
    let of = |name: &str| format!("elements of type {name} are no cells, and are left out");
    assert_eq!(mesh.warnings, [of("SPRINGA"), of("MASS")]);
}

/// Reads a deck whose files are in a table.
fn with_files(deck: &str, files: &[(&str, &str)]) -> Result<MeshFile, InpError> {
    let files: HashMap<&str, &str> = files.iter().copied().collect();
    let mut beside = |path: &Path| {
        let found = path.to_str().and_then(|name| files.get(name));
        found
            .map(|text| text.as_bytes().to_vec())
            .ok_or_else(|| "no such file".to_owned())
    };
    read_with(deck.as_bytes(), &mut beside)
}

#[test]
fn files_that_are_included_stand_where_they_are_named() {
    let flat = PART
        .replace("*PART, NAME=P\n", "")
        .replace("*END PART\n", "");
    let (nodes, rest) = flat.split_once("*ELEMENT").unwrap();
    let data = nodes.strip_prefix("*NODE\n").unwrap();
    let rest = format!("*ELEMENT{rest}");
    let expected = read(flat.as_bytes()).unwrap();
    let files = [
        ("all.msh", "** first\n*INCLUDE, INPUT=sub/rest.inp"),
        ("sub/rest.inp", rest.as_str()),
        ("nodes.txt", data),
    ];
    for head in [
        nodes.to_owned(),
        "*NODE, INPUT=nodes.txt\n".to_owned(),
        "*Node\n** data\n*include,\ninput=nodes.txt\n".to_owned(),
    ] {
        let deck = format!("{head}*INCLUDE, INPUT=all.msh\n*STEP\n");
        let mesh = with_files(&deck, &files).unwrap();
        assert_eq!(
            (&mesh.cells, &mesh.groups),
            (&expected.cells, &expected.groups),
            "{head}"
        );
    }
    let error = with_files("*INCLUDE, INPUT=nodes.txt\n", &[]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "line 1: in *INCLUDE: the file nodes.txt is included: no such file"
    );
}

#[test]
fn faults_in_a_file_that_is_included_name_it_and_its_line() {
    let deck = "*HEADING\n*INCLUDE, INPUT=a.inc\n*ELEMENT, TYPE=CPE3\n1, 1, 2\n";
    let file = "** nodes\n*NODE\n1, 0., 0.\n2, half, 0.\n";
    let error = with_files(deck, &[("a.inc", file)]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "a.inc: line 4: in *NODE: a coordinate is expected, found \"half\""
    );
    let error = with_files(deck, &[("a.inc", &file.replace("half", "1."))]).unwrap_err();
    assert_eq!((error.file, error.line), (None, Some(4)));
}

#[test]
fn inclusions_lead_neither_out_of_the_folder_nor_in_a_circle() {
    for name in [
        "/etc/passwd",
        "../a.inp",
        "a/../../b",
        "C:\\a",
        "",
        "a\\..\\b",
    ] {
        let error =
            with_files(&format!("*INCLUDE, INPUT={name}\n"), &[(name, "*NODE\n")]).unwrap_err();
        assert!(
            error.to_string().contains("beside the deck"),
            "{name}: {error}"
        );
    }
    let circle = [
        ("a", "*INCLUDE, INPUT=b\n"),
        ("b", "*NODE\n*INCLUDE, INPUT=a\n"),
    ];
    let error = with_files("*INCLUDE, INPUT=a\n", &circle).unwrap_err();
    assert!(
        error
            .to_string()
            .starts_with("b: line 2: in *INCLUDE: the file a is included: it includes itself"),
        "{error}"
    );
    let names: Vec<String> = (0..12).map(|at| at.to_string()).collect();
    let texts: Vec<String> = (1..13)
        .map(|at| format!("*INCLUDE, INPUT={at}\n"))
        .collect();
    let deep: Vec<(&str, &str)> = names
        .iter()
        .zip(&texts)
        .map(|(a, b)| (a.as_str(), b.as_str()))
        .collect();
    let error = with_files("*INCLUDE, INPUT=0\n", &deep).unwrap_err();
    assert!(error.to_string().contains("8 deep"), "{error}");
    let wide = [
        ("a", "*INCLUDE, INPUT=b\n".repeat(100)),
        ("b", "*INCLUDE, INPUT=c\n".repeat(100)),
        ("c", String::new()),
    ];
    let wide: Vec<(&str, &str)> = wide.iter().map(|(a, b)| (*a, b.as_str())).collect();
    let error = with_files("*INCLUDE, INPUT=a\n", &wide).unwrap_err();
    assert!(error.to_string().contains("1000 files"), "{error}");
    let told = read(b"*INCLUDE, INPUT=a.inc\n").unwrap_err().to_string();
    assert!(told.contains("give the path of the deck"), "{told}");
}
