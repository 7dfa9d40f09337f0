//! No bytes make the reader of STL files panic or take memory beyond its budget, and what it reads
//! is a surface with corners that are there. `SIGNORINI_FUZZ_CASES=1000000` runs a million.

use crate::fuzz::memory::Budget;
use crate::fuzz::{Campaign, Corpus, Form};
use signorini_client::WireSurface;
use signorini_client::formats::stl::{self, SurfaceFile};

const WORDS: [&str; 14] = [
    "solid ",
    "solid\n",
    "endsolid\n",
    "facet normal 0 0 0\n",
    "endfacet\n",
    "outer loop\n",
    "endloop\n",
    "vertex 1 0 0\n",
    "vertex nan 1e999 -0.0\n",
    "facet",
    "normal",
    "\r\n",
    "\0\0\0\0",
    "SOLID",
];

/// Corners and facets of a tetrahedron.
const CORNERS: [[f32; 3]; 4] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
];
const FACETS: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];

fn text() -> Vec<u8> {
    let mut text = "solid tool\n".to_owned();
    for facet in FACETS {
        text += "facet normal 0 0 0\nouter loop\n";
        for [x, y, z] in facet.map(|corner| CORNERS[corner]) {
            text += &format!("vertex {x} {y} {z}\n");
        }
        text += "endloop\nendfacet\n";
    }
    (text + "endsolid tool\n").into()
}

fn binary(header: &str) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes[..header.len()].copy_from_slice(header.as_bytes());
    bytes.extend((FACETS.len() as u32).to_le_bytes());
    for facet in FACETS {
        bytes.extend([0; 12]);
        let corners = facet.map(|corner| CORNERS[corner]);
        bytes.extend(corners.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

fn seeds() -> Vec<Vec<u8>> {
    vec![text(), binary("solid of a program"), binary("")]
}

fn check(surface: &SurfaceFile) {
    let vertices = surface.vertices.len();
    assert!((1..=3 * surface.facets.len()).contains(&vertices));
    let mut corners = surface.facets.as_flattened().iter();
    assert!(corners.all(|corner| (*corner as usize) < vertices));
    let mut numbers = surface.vertices.as_flattened().iter();
    assert!(numbers.all(|x| x.is_finite()));
}

#[test]
fn every_seed_is_a_surface() {
    for seed in seeds() {
        let surface = stl::read(&seed).unwrap();
        assert_eq!((surface.vertices.len(), surface.facets.len()), (4, 4));
    }
}

#[test]
fn all_bytes_are_read_as_stl_or_refused_within_the_budget() {
    let budget = Budget::of_mebibytes(64);
    let (mut surfaces, mut refused) = (0_u64, 0_u64);
    let corpus = Corpus::new(Form::File, seeds(), &WORDS);
    Campaign::from_environment().run(&corpus, |input, _| {
        match stl::read(input) {
            Ok(surface) => {
                surfaces += 1;
                check(&surface);
                let wire = WireSurface::new(&surface).unwrap();
                assert!(wire.name().starts_with("surfaces/"));
            }
            Err(error) => {
                refused += 1;
                assert!(!error.to_string().is_empty());
            }
        }
        budget.check();
    });
    eprintln!("{surfaces} files read, {refused} refused");
    assert!(surfaces > 0 || refused < 1000);
}
