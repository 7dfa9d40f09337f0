//! One mesh in every encoding, as VTK and meshio write it, and files that are wrong.

use super::{Place, VtkError, VtkFault, cell_values, read};
use crate::formats::mesh::{MeshFault, MeshFile};
use crate::formats::{Notes, msh, vtu};

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

fn check_two_tetrahedra(mesh: &MeshFile, name: &str) {
    assert_eq!(
        (mesh.vertices_per_cell, mesh.coordinates.len()),
        (4, 5),
        "{name}"
    );
    assert_eq!(mesh.cells, [0, 1, 2, 3, 1, 2, 3, 4], "{name}");
    assert_eq!(mesh.facets, [0, 2, 1], "{name}");
    let last = mesh.coordinates.last().unwrap();
    assert_eq!(
        last.map(f64::to_bits),
        [1.0_f64; 3].map(f64::to_bits),
        "{name}"
    );
}

#[test]
fn every_encoding_of_vtk_gives_one_mesh() {
    let names = [
        "text.vtu",
        "base64.vtu",
        "zlib.vtu",
        "raw.vtu",
        "appended64.vtu",
        "appendedzlib.vtu",
        "rawzlib.vtu",
        "big.vtu",
        "legacy42a.vtk",
        "legacy42b.vtk",
        "legacy51a.vtk",
        "legacy51b.vtk",
    ];
    for name in names {
        let mesh = read(&fixture(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
        check_two_tetrahedra(&mesh, name);
        let expected: [(&str, usize, &[u32]); 2] = [("floor", 2, &[0]), ("body", 3, &[0, 1])];
        assert_eq!(groups(&mesh), expected, "{name}");
        assert!(mesh.warnings.is_empty(), "{name}: {:?}", mesh.warnings);
    }
}

#[test]
fn files_of_meshio_name_groups_by_their_numbers() {
    for name in [
        "meshio.vtu",
        "meshio_ascii.vtu",
        "meshio.vtk",
        "meshio_ascii.vtk",
    ] {
        let mesh = read(&fixture(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
        check_two_tetrahedra(&mesh, name);
        let expected: [(&str, usize, &[u32]); 2] = [("7", 2, &[0]), ("1", 3, &[0, 1])];
        assert_eq!(groups(&mesh), expected, "{name}");
    }
}

#[test]
fn what_is_written_here_is_read_back_with_its_curved_edges() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/formats");
    for name in ["sphere2", "ring2"] {
        let bytes = std::fs::read(format!("{folder}/{name}.msh")).unwrap();
        let gmsh = msh::read(&bytes).unwrap();
        let mut grid =
            vtu::Grid::new(gmsh.vertices_per_cell, &gmsh.coordinates, &gmsh.cells).unwrap();
        grid.bend(gmsh.curved.iter().map(|edge| (edge.ends, edge.offset)));
        let ours = read(&grid.write(&[], &Notes::default()).unwrap()).unwrap();
        assert_eq!(
            (&ours.cells, &ours.coordinates),
            (&gmsh.cells, &gmsh.coordinates)
        );
        let ends = |mesh: &MeshFile| mesh.curved.iter().map(|edge| edge.ends).collect::<Vec<_>>();
        assert_eq!(ends(&ours), ends(&gmsh), "{name}");
        let names: Vec<_> = groups(&ours).into_iter().map(|group| group.0).collect();
        assert_eq!(names, ["boundary", "body"]);
    }
}

#[test]
fn values_of_cells_are_read_from_what_is_written_here() {
    let bytes = std::fs::read(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/tests/formats/ring2.msh"
    ));
    let mesh = msh::read(&bytes.unwrap()).unwrap();
    let grid = vtu::Grid::new(mesh.vertices_per_cell, &mesh.coordinates, &mesh.cells).unwrap();
    let values: Vec<f64> = (0..mesh.cell_count())
        .map(|cell| 0.1 * cell as f64)
        .collect();
    let field = vtu::GridField {
        name: "error_estimate",
        components: 1,
        values: &values,
    };
    let file = grid.write(&[field], &Notes::default()).unwrap();
    let read = cell_values(&file, &["error_density", "error_estimate"]).unwrap();
    assert_eq!(read, values);
    let missing = cell_values(&file, &["jacobian"]).unwrap_err();
    assert!(missing.to_string().contains("jacobian"), "{missing}");
}

fn text(from: &str, to: &str) -> Result<MeshFile, VtkError> {
    let file = String::from_utf8(fixture("text.vtu")).unwrap();
    assert!(file.contains(from), "{from}");
    read(file.replacen(from, to, 1).as_bytes())
}

fn legacy(from: &str, to: &str) -> Result<MeshFile, VtkError> {
    let file = String::from_utf8(fixture("legacy42a.vtk")).unwrap();
    assert!(file.contains(from), "{from}");
    read(file.replacen(from, to, 1).as_bytes())
}

#[test]
fn each_kind_of_bad_file_has_its_fault() {
    assert_eq!(read(b"").unwrap_err().fault, VtkFault::NotVtk);
    assert_eq!(read(b"solid").unwrap_err().fault, VtkFault::NotVtk);
    let fault = |from, to| text(from, to).unwrap_err().fault;
    assert!(matches!(fault("</Points>", ""), VtkFault::Xml(_)));
    assert!(matches!(
        fault("\"UnstructuredGrid\"", "\"PolyData\""),
        VtkFault::Unsupported(_)
    ));
    assert!(matches!(
        fault("<VTKFile ", "<VTKFile compressor=\"vtkLZ4DataCompressor\" "),
        VtkFault::Unsupported(_)
    ));
    assert!(matches!(
        fault("Name=\"offsets\"", "Name=\"ends\""),
        VtkFault::Missing(_)
    ));
    assert!(matches!(
        fault("0 1 2 3 1 2", "0 1 2 x 1 2"),
        VtkFault::Unexpected { .. }
    ));
    assert!(matches!(fault("4 8 11", "4 8"), VtkFault::Length { .. }));
    assert!(matches!(fault("4 8 11", "4 8 12"), VtkFault::Truncated(_)));
    assert!(matches!(
        fault("0 0 0 1 0 0", "nan 0 0 1 0 0"),
        VtkFault::Mesh(MeshFault::NotFinite(0))
    ));
    let told = text("3 4 0 2 1", "3 5 0 2 1").unwrap_err();
    let unknown = VtkFault::UnknownPoint { point: 5, count: 5 };
    assert_eq!((told.place, told.fault), (Some(Place::Cell(1)), unknown));
}

#[test]
fn faults_of_legacy_files_are_told_with_their_line() {
    let told = legacy("CELL_TYPES 3", "CELL_TYPES three").unwrap_err();
    assert!(told.to_string().starts_with("line "), "{told}");
    let fault = |from, to| legacy(from, to).unwrap_err().fault;
    assert!(matches!(
        fault("UNSTRUCTURED_GRID", "POLYDATA"),
        VtkFault::Unsupported(_)
    ));
    assert!(matches!(
        fault("POINTS 5", "POINTS 50000000"),
        VtkFault::Count { .. }
    ));
    assert!(matches!(
        fault("CELLS 3 14", "CELLS 2 14"),
        VtkFault::Length { .. }
    ));
    assert!(matches!(
        fault("CELLS 3 14", "CELLS 3 13"),
        VtkFault::Truncated(_)
    ));
    assert!(matches!(
        fault("\n10\n", "\n12\n"),
        VtkFault::UnsupportedCell(_)
    ));
    assert!(matches!(
        fault("\n10\n", "\n24\n"),
        VtkFault::UnsupportedCell(_)
    ));
    assert_eq!(
        fault("POINTS", "VERTICES"),
        VtkFault::Unexpected {
            expected: "a keyword",
            found: "\"VERTICES\"".into()
        }
    );
}

/// A legacy file of one cell, its points at the corners of a unit cube row by row.
fn one_cell(points: &[usize], shape: usize) -> String {
    let count = points.len();
    let points: Vec<String> = points.iter().map(usize::to_string).collect();
    let points = points.join(" ");
    format!(
        "# vtk DataFile Version 2.0\none cell\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 8 double\n\
         0 0 0 1 0 0 0 1 0 1 1 0 0 0 1 1 0 1 0 1 1 1 1 1\nCELLS 1 {}\n{count} {points}\n\
         CELL_TYPES 1\n{shape}\n",
        count + 1
    )
}

#[test]
fn voxels_and_hexahedra_are_one_cube_and_pixels_and_quadrangles_one_square() {
    let read = |points: &[usize], shape| read(one_cell(points, shape).as_bytes()).unwrap();
    let voxel = read(&[0, 1, 2, 3, 4, 5, 6, 7], 11);
    let hexahedron = read(&[0, 1, 3, 2, 4, 5, 7, 6], 12);
    assert_eq!(voxel.cells, hexahedron.cells);
    assert_eq!((voxel.cell_count(), voxel.facet_count()), (6, 12));
    assert!(voxel.warnings[0].starts_with("1 hexahedra are split into tetrahedra"));
    // VTK counts the base of a wedge the other way round than other formats do.
    for points in [[0, 2, 1, 4, 6, 5], [0, 1, 2, 4, 5, 6]] {
        assert_eq!(read(&points, 13).cell_count(), 3);
    }
    assert_eq!(read(&[0, 1, 3, 2, 4], 14).cell_count(), 2);
    let flat = |points: &[usize], shape| {
        let text = one_cell(points, shape);
        let text = text.replace("0 0 1 1 0 1 0 1 1 1 1 1", "2 0 0 3 0 0 2 1 0 3 1 0");
        super::read(text.as_bytes()).unwrap()
    };
    let (pixel, square) = (flat(&[0, 1, 2, 3], 8), flat(&[0, 1, 3, 2], 9));
    assert_eq!(pixel.cells, square.cells);
    assert_eq!((pixel.cell_count(), pixel.facet_count()), (2, 4));
}
