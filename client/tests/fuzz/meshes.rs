//! No bytes make the readers of meshes panic or take memory beyond their budget, and
//! what they read is a mesh. `SIGNORINI_FUZZ_CASES=1000000` runs a million of each.

use crate::fuzz::memory::Budget;
use crate::fuzz::{Campaign, Corpus, Form};
use signorini_client::WireMesh;
use signorini_client::formats::mesh::MeshFile;
use signorini_client::formats::{inp, msh, vtk};

const MSH_WORDS: [&str; 16] = [
    "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n",
    "$MeshFormat\n2.2 1 8\n\x01\0\0\0\n$EndMeshFormat\n",
    "$PhysicalNames\n",
    "$EndPhysicalNames\n",
    "$Entities\n",
    "$EndEntities\n",
    "$PartitionedEntities\n",
    "$Nodes\n",
    "$EndNodes\n",
    "$Elements\n",
    "$EndElements\n",
    "$Comments\n",
    "$End",
    "$",
    "\"",
    "\r\n",
];

/// Two tetrahedra and a facet, in groups.
const TEXT_22: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n\
    $PhysicalNames\n2\n2 7 \"top\"\n3 1 \"body\"\n$EndPhysicalNames\n\
    $Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n$EndNodes\n\
    $Elements\n3\n1 2 2 7 1 1 2 3\n2 4 2 1 1 1 2 3 4\n3 4 2 1 1 2 3 4 5\n$EndElements\n";

const TEXT_41: &str = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n\
    $PhysicalNames\n2\n2 7 \"top\"\n3 1 \"body\"\n$EndPhysicalNames\n\
    $Entities\n0 0 1 1\n1 0 0 0 1 1 1 1 7 0\n1 0 0 0 1 1 1 1 1 1 1\n$EndEntities\n\
    $Nodes\n1 5 1 5\n3 1 0 5\n1\n2\n3\n4\n5\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 1 1\n$EndNodes\n\
    $Elements\n2 3 1 3\n2 1 2 1\n1 1 2 3\n3 1 4 2\n2 1 2 3 4\n3 2 3 4 5\n$EndElements\n";

const POINTS: [[f64; 3]; 5] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 1.0, 1.0],
];

/// Bytes of a binary file.
#[derive(Default)]
struct Binary(Vec<u8>);

impl Binary {
    fn text(mut self, text: &str) -> Self {
        self.0.extend(text.bytes());
        self
    }

    fn integers(mut self, values: &[i32]) -> Self {
        self.0
            .extend(values.iter().flat_map(|value| value.to_le_bytes()));
        self
    }

    fn sizes(mut self, values: &[u64]) -> Self {
        self.0
            .extend(values.iter().flat_map(|value| value.to_le_bytes()));
        self
    }

    fn reals(mut self, values: &[f64]) -> Self {
        self.0
            .extend(values.iter().flat_map(|value| value.to_le_bytes()));
        self
    }

    fn head(version: &str) -> Self {
        Self::default()
            .text(&format!("$MeshFormat\n{version} 1 8\n"))
            .integers(&[1])
            .text("\n$EndMeshFormat\n")
            .text("$PhysicalNames\n2\n2 7 \"top\"\n3 1 \"body\"\n$EndPhysicalNames\n")
    }
}

fn binary_22() -> Vec<u8> {
    let mut file = Binary::head("2.2").text("$Nodes\n5\n");
    for (number, point) in (1..).zip(POINTS) {
        file = file.integers(&[number]).reals(&point);
    }
    file.text("\n$EndNodes\n$Elements\n3\n")
        .integers(&[2, 1, 2, 1, 7, 1, 1, 2, 3])
        .integers(&[4, 2, 2, 2, 1, 1, 1, 2, 3, 4, 3, 1, 1, 2, 3, 4, 5])
        .text("\n$EndElements\n")
        .0
}

fn binary_41() -> Vec<u8> {
    let mut file = Binary::head("4.1").text("$Entities\n").sizes(&[0, 0, 1, 1]);
    for group in [7, 1] {
        file = file.integers(&[1]).reals(&[0.0, 0.0, 0.0, 1.0, 1.0, 1.0]);
        file = file.sizes(&[1]).integers(&[group]).sizes(&[0]);
    }
    file = file.text("\n$EndEntities\n$Nodes\n").sizes(&[1, 5, 1, 5]);
    file = file.integers(&[3, 1, 0]).sizes(&[5, 1, 2, 3, 4, 5]);
    file = file
        .reals(POINTS.as_flattened())
        .text("\n$EndNodes\n$Elements\n");
    file.sizes(&[2, 3, 1, 3])
        .integers(&[2, 1, 2])
        .sizes(&[1, 1, 1, 2, 3])
        .integers(&[3, 1, 4])
        .sizes(&[2, 2, 1, 2, 3, 4, 3, 2, 3, 4, 5])
        .text("\n$EndElements\n")
        .0
}

fn small_seeds() -> Vec<Vec<u8>> {
    vec![TEXT_22.into(), TEXT_41.into(), binary_22(), binary_41()]
}

fn msh_corpus() -> Corpus {
    let cook: &[u8] = include_bytes!("../../examples/meshes/cook_n16.msh");
    let cube: &[u8] = include_bytes!("../../examples/meshes/cube_n6.msh");
    // Small files more often: a change hits their structure, not their numbers.
    let mut seeds = small_seeds();
    seeds.extend(small_seeds());
    seeds.extend([cook[..4000].to_vec(), cook.to_vec(), cube[..8000].to_vec()]);
    Corpus::new(Form::File, seeds, &MSH_WORDS)
}

const INP_WORDS: [&str; 40] = [
    "*NODE\n",
    "*NODE, NSET=",
    "*ELEMENT, TYPE=C3D10M, ELSET=a\n",
    "*ELEMENT, TYPE=CPE3\n",
    "*ELEMENT, TYPE=S3R, ELSET=b\n",
    "*ELEMENT, TYPE=T2D3\n",
    "*NSET, NSET=a, GENERATE\n",
    "*NSET, NSET=c, ELSET=a\n",
    "*ELSET, ELSET=a\n",
    "*ELSET, ELSET=b, INTERNAL, INSTANCE=i, GENERATE\n",
    "*SURFACE, NAME=s\n",
    "*SURFACE, TYPE=NODE, NAME=s\n",
    "*PART, NAME=p\n",
    "*END PART\n",
    "*ASSEMBLY, NAME=x\n",
    "*END ASSEMBLY\n",
    "*INSTANCE, NAME=i, PART=p\n",
    "*END INSTANCE\n",
    "*SOLID SECTION, ELSET=a, MATERIAL=m\n",
    "*STEP\n",
    "*ELEMENT, TYPE=C3D8R, ELSET=a\n",
    "*ELEMENT, TYPE=C3D20\n",
    "*ELEMENT, TYPE=CPE4\n",
    "*ELEMENT, TYPE=SPRINGA\n",
    "*ELEMENT, TYPE=R3D4, ELSET=b\n",
    "*ELEMENT, TYPE=B31\n",
    "*EQUATION\n2\n",
    "*NODE, SYSTEM=C\n",
    "*SYSTEM\n1., 0., 0., 0., 1., 0.\n",
    "*INCLUDE, INPUT=a\n",
    "3., 0., 0., 3., 0., 1., 90.\n",
    "9, 1, -2\n",
    "** \n",
    "a, S1\n",
    "a,\n",
    "1, 18446744073709551615, 1\n",
    "i.a",
    "\"",
    ",",
    "*",
];

/// A flat file with every keyword that is read.
const INP_FLAT: &str = "*HEADING\n*NODE, NSET=all\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 0., 1., 0.\n\
    4, 0., 0., 1.\n5, 1., 1., 1.\n*ELEMENT, TYPE=C3D4H, ELSET=a\n10, 1, 2, 3, 4\n20, 2, 3, 4, 5\n\
    *ELEMENT, TYPE=S3, ELSET=b\n1, 1, 3, 2\n*NSET, NSET=floor\n1, 2, 3\n*NSET, NSET=c, ELSET=a\n\
    *ELSET, ELSET=both, GENERATE\n10, 20, 10\n*ELSET, ELSET=d\na, both, 20\n\
    *SURFACE, NAME=side\n10, S2\na, S3\n*SURFACE, NAME=skin\nboth,\n\
    *SURFACE, TYPE=NODE, NAME=nodes\nfloor, 1.\n*SOLID SECTION, ELSET=both, MATERIAL=m\n";

const INP_PART: &str = "*Heading\n*Part, name=p\n*Node\n1, 0., 0.\n2, 1., 0.\n3, 0., 1.\n\
    4, 1., 1.\n5, 1.5, 0.5\n*Element, type=CAX3H\n1, 1, 2, 3\n2, 2, 4, 3\n\
    *Element, type=T2D3, elset=line\n3, 2, 5, 4\n*End Part\n*Assembly, name=x\n\
    *Instance, name=i, part=p\n 2., 0.5, 0.\n*End Instance\n*Node\n 1, 9., 9., 0.\n\
    *Nset, nset=base, instance=i, generate\n 1, 2, 1\n*Elset, elset=e, internal, instance=i\n 1\n\
    *Surface, type=ELEMENT, name=s\ne, S3\n*Nset, nset=again\ni.base,\n*End Assembly\n";

/// Cells that are split, of first and second order, with sets and surfaces of their faces.
const INP_SPLIT: &str = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 1., 1., 0.\n4, 0., 1., 0.\n\
    5, 0., 0., 1.\n6, 1., 0., 1.\n7, 1., 1., 1.\n8, 0., 1., 1.\n9, 0.5, 0.5, 2.\n\
    *ELEMENT, TYPE=C3D8R, ELSET=a\n1, 1, 2, 3, 4, 5, 6, 7, 8\n*ELEMENT, TYPE=C3D5, ELSET=a\n\
    2, 5, 6, 7, 8, 9\n*NSET, NSET=floor\n1, 2, 3, 4\n*SURFACE, NAME=side\n1, S4\n2, S2\n\
    *SURFACE, NAME=skin\na,\n";

/// A part twice, moved and turned, with sets of both.
const INP_TWO: &str = "*PART, NAME=p\n*NODE, NSET=n\n1, 0., 0.\n2, 1., 0.\n3, 1., 1.\n4, 0., 1.\n\
    *ELEMENT, TYPE=CPE4H, ELSET=e\n1, 1, 2, 3, 4\n*SURFACE, NAME=s\n1, S2\n\
    *SOLID SECTION, ELSET=e, MATERIAL=m\n*END PART\n*ASSEMBLY, NAME=x\n*INSTANCE, NAME=i, PART=p\n\
    *END INSTANCE\n*INSTANCE, NAME=j, PART=p\n3., 0., 0.\n3., 0., 0., 3., 0., 1., 90.\n\
    *END INSTANCE\n*NSET, NSET=both\ni.n, j.n, j.3\n*ELSET, ELSET=c, INSTANCE=j, GENERATE\n1, 9, 2\n\
    *END ASSEMBLY\n*TIE, NAME=t\ns, s\n";

/// What is no part of the body, beside a cell of second order.
const INP_BESIDE: &str = "*NODE\n1, 0., 0.\n2, 1., 0.\n3, 1., 1.\n4, 0., 1.\n5, 0.5, 0.\n6, 1., 0.5\n\
    7, 0.5, 1.\n8, 0., 0.5\n9, 3., 0.\n*ELEMENT, TYPE=CAX8RH, ELSET=a\n1, 1, 2, 3, 4, 5,\n6, 7, 8\n\
    *ELEMENT, TYPE=R2D2, ELSET=b\n2, 2, 9\n3, 1, 2\n*ELEMENT, TYPE=MASS\n4, 9\n*SURFACE, NAME=s\nb, SPOS\n\
    *MPC\nBEAM, 1, 9\n*NSET, NSET=\"my base\", UNSORTED\n2,\n\n1\n";

/// What a scene says of a deck.
const INP_SCENE: &str = "*NSET, NSET=point\n900\n*MATERIAL, NAME=m\n*HYPERELASTIC, OGDEN, N=2\n\
    0.5, 4., 0.25, -2., 1e-3, 0.\n*ELASTIC\n1., 0.3\n*HYPERELASTIC, POLYNOMIAL, N=2\n1., 2., 3., 4., 5.\n\
    *HYPERFOAM, N=2\n1., 8., 2., -2., 0.1, 0.\n*HYPERELASTIC, VAN DER WAALS\n0.5, 8., 0.2, 0.1\n\
    *BOUNDARY\nfloor, ENCASTRE\npoint, 1, 6\n*SURFACE, NAME=roll, TYPE=REVOLUTION\n\
    0., 0., 1., 0., 0., 2.\nSTART, 0., 1.\nCIRCL, 2., 3., 0., 3.\n\
    *SURFACE, NAME=plate, TYPE=CYLINDER\n0., 0., 0., 0., 1., 0.\n0., 0., 1.\nSTART, 2., 1.\nLINE, -2., 1.\n\
    *RIGID BODY, REF NODE=900, ANALYTICAL SURFACE=plate\n*SURFACE INTERACTION, NAME=i\n*FRICTION\n0.3\n\
    *CONTACT PAIR, INTERACTION=i\nskin, plate\n*STEP\n*STATIC\n0.05, 1.\n*BOUNDARY\npoint, 2, 2, -0.4\n";

fn scene_corpus() -> Corpus {
    let seeds = [INP_SCENE, INP_SCENE, INP_TWO].map(|seed| seed.as_bytes().to_vec());
    Corpus::new(Form::File, seeds.to_vec(), &INP_WORDS)
}

fn inp_corpus() -> Corpus {
    let ring: &[u8] = include_bytes!("../formats/ring2.inp");
    let sphere: &[u8] = include_bytes!("../formats/sphere2.inp");
    let meshio: &[u8] = include_bytes!("../formats/meshio.inp");
    let own = [INP_FLAT, INP_PART, INP_SPLIT, INP_TWO, INP_BESIDE].map(str::as_bytes);
    let small = [own.as_slice(), &[meshio]].concat();
    let mut seeds = small.repeat(4);
    seeds.extend([ring, sphere]);
    let seeds = seeds.into_iter().map(<[u8]>::to_vec);
    Corpus::new(Form::File, seeds.collect(), &INP_WORDS)
}

const VTK_WORDS: [&str; 28] = [
    "<Piece NumberOfPoints=\"5\" NumberOfCells=\"3\">",
    "</Piece>",
    "<DataArray type=\"UInt8\" Name=\"group\" format=\"appended\" offset=\"0\"/>",
    "<DataArray type=\"Float32\" Name=\"types\" format=\"binary\">",
    "</DataArray>",
    "<AppendedData encoding=\"base64\">_",
    "<AppendedData encoding=\"raw\">\n_",
    " compressor=\"vtkZLibDataCompressor\"",
    " header_type=\"UInt64\"",
    " byte_order=\"BigEndian\"",
    " NumberOfTuples=\"2\"",
    "<!--",
    "-->",
    "&amp;",
    "<![CDATA[",
    "====",
    "AAAA",
    "BINARY\n",
    "CELL_DATA 3\n",
    "POINT_DATA 5\n",
    "SCALARS group int\n",
    "LOOKUP_TABLE default\n",
    "FIELD FieldData 2\n",
    "METADATA\n\n",
    "OFFSETS vtktypeint64\n",
    "CONNECTIVITY vtktypeint64\n",
    "VECTORS v double\n",
    "gmsh%3Aphysical 1 3 int\n",
];

fn vtk_seeds() -> Vec<Vec<u8>> {
    let files: [&[u8]; 16] = [
        include_bytes!("../formats/text.vtu"),
        include_bytes!("../formats/base64.vtu"),
        include_bytes!("../formats/zlib.vtu"),
        include_bytes!("../formats/raw.vtu"),
        include_bytes!("../formats/appended64.vtu"),
        include_bytes!("../formats/appendedzlib.vtu"),
        include_bytes!("../formats/rawzlib.vtu"),
        include_bytes!("../formats/big.vtu"),
        include_bytes!("../formats/meshio.vtu"),
        include_bytes!("../formats/meshio_ascii.vtu"),
        include_bytes!("../formats/legacy42a.vtk"),
        include_bytes!("../formats/legacy42b.vtk"),
        include_bytes!("../formats/legacy51a.vtk"),
        include_bytes!("../formats/legacy51b.vtk"),
        include_bytes!("../formats/meshio.vtk"),
        include_bytes!("../formats/meshio_ascii.vtk"),
    ];
    files.into_iter().map(<[u8]>::to_vec).collect()
}

/// What every reader of a mesh relies on.
fn check(mesh: &MeshFile) {
    assert!(matches!(mesh.vertices_per_cell, 3 | 4));
    assert_eq!(mesh.cells.len() % mesh.vertices_per_cell, 0);
    assert_eq!(mesh.facets.len() % (mesh.vertices_per_cell - 1), 0);
    let vertices = mesh.coordinates.len();
    let mut indices = mesh.cells.iter().chain(&mesh.facets);
    assert!(indices.all(|index| (*index as usize) < vertices));
    for group in &mesh.groups {
        let of_cells = group.dimension + 1 == mesh.vertices_per_cell;
        let count = if of_cells {
            mesh.cell_count()
        } else {
            mesh.facet_count()
        };
        assert!(
            group
                .members
                .iter()
                .all(|member| (*member as usize) < count)
        );
    }
}

#[test]
fn every_seed_is_a_mesh() {
    for seed in small_seeds() {
        let mesh = msh::read(&seed).unwrap();
        assert_eq!((mesh.cell_count(), mesh.facet_count()), (2, 1));
        assert_eq!(mesh.groups.len(), 2);
    }
}

/// Runs a campaign on a reader.
fn run<E: std::fmt::Display>(corpus: &Corpus, read: impl Fn(&[u8]) -> Result<MeshFile, E>) {
    let budget = Budget::of_mebibytes(64);
    let (mut meshes, mut refused) = (0_u64, 0_u64);
    Campaign::from_environment().run(corpus, |input, _| {
        match read(input) {
            Ok(mesh) => {
                meshes += 1;
                check(&mesh);
                assert_eq!(WireMesh::new(&mesh).unwrap().digest().len(), 64);
            }
            Err(error) => {
                refused += 1;
                assert!(!error.to_string().is_empty());
            }
        }
        budget.check();
    });
    eprintln!("{meshes} files read, {refused} refused");
    // Changes that only ever break the form would test nothing behind it.
    assert!(meshes > 0 || refused < 1000);
}

#[test]
fn all_bytes_are_read_as_gmsh_or_refused_within_the_budget() {
    run(&msh_corpus(), msh::read);
}

#[test]
fn all_bytes_are_read_as_abaqus_or_refused_within_the_budget() {
    run(&inp_corpus(), inp::read);
}

#[test]
fn all_bytes_are_read_as_the_scene_of_a_deck_or_refused_within_the_budget() {
    let budget = Budget::of_mebibytes(64);
    let mut refused = 0;
    Campaign::from_environment().run(&scene_corpus(), |input, _| {
        let mut beside = |_: &std::path::Path| Ok(INP_FLAT.as_bytes().to_vec());
        if let Err(error) = inp::read_scene(input, &mut beside) {
            refused += 1;
            assert!(!error.to_string().is_empty());
        }
        if let Err(error) = inp::read_with(input, &mut beside) {
            assert!(!error.to_string().is_empty());
        }
        budget.check();
    });
    assert!(refused > 0);
}

#[test]
fn all_bytes_are_read_as_vtk_or_refused_within_the_budget() {
    run(&Corpus::new(Form::File, vtk_seeds(), &VTK_WORDS), vtk::read);
}
