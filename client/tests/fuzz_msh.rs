//! No bytes make the reader of Gmsh meshes panic or take memory beyond its
//! budget, and what it reads is a mesh.

mod fuzz;

use fuzz::memory::Budget;
use fuzz::{Campaign, Corpus, Form};
use signorini_client::WireMesh;
use signorini_client::formats::msh::{self, MeshFile};

const WORDS: [&str; 16] = [
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

fn corpus() -> Corpus {
    let cook: &[u8] = include_bytes!("../examples/meshes/cook_n16.msh");
    let cube: &[u8] = include_bytes!("../examples/meshes/cube_n6.msh");
    // Small files more often: a change hits their structure, not their numbers.
    let mut seeds = small_seeds();
    seeds.extend(small_seeds());
    seeds.extend([cook[..4000].to_vec(), cook.to_vec(), cube[..8000].to_vec()]);
    Corpus::new(Form::File, seeds, &WORDS)
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

#[test]
fn all_bytes_are_read_or_refused_within_the_budget() {
    let (corpus, budget) = (corpus(), Budget::of_mebibytes(64));
    let (mut read, mut refused) = (0_u64, 0_u64);
    Campaign::from_environment().run(&corpus, |input, _| {
        match msh::read(input) {
            Ok(mesh) => {
                read += 1;
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
    eprintln!("{read} files read, {refused} refused");
    // Changes that only ever break the form would test nothing behind it.
    assert!(read > 0 || refused < 1000);
}
