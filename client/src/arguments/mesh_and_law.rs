//! Arguments of `refine` and `fit`, which make a finer mesh and the constants of a law for a scene.

use std::path::PathBuf;

use clap::Args;

use super::SceneArguments;

pub(super) const REFINE_EXAMPLES: &str = "\
Examples:
  signorini refine ring.toml -o ring-fine.msh
  signorini refine ring.toml --on inside --levels 2 -o ring-fine.msh
  signorini refine ring.toml --near 10 0 0 1.5 --levels 3 -o ring-fine.msh
  signorini refine ring.toml --by results/ring_0001.vtu -o ring-fine.msh

Then mesh = \"ring-fine.msh\" in the scene, or --set mesh=ring-fine.msh.";

pub(super) const FIT_EXAMPLES: &str = "\
Examples:
  signorini fit ring.toml tests.csv
  signorini fit ring.toml tests.csv --model ogden --terms 2 --plot fit.svg
  signorini fit ring.toml squeeze.csv --plot fit.svg

tests.csv has columns test (uniaxial, planar or equibiaxial), stretch (or strain, stretch less one)
and stress (force over undeformed area), in the units of the scene. squeeze.csv has columns time
(steps that are done, 0.5 in the middle of the first) and goals, such as force.lid.y: the scene is
solved with other constants until it gives these values.";

/// What shall be halved, and how often.
#[derive(Args, Debug)]
pub(crate) struct RefineArguments {
    /// Scene file (TOML)
    pub(crate) scene: PathBuf,
    /// Mesh file to write, ending in .msh (Gmsh 2.2)
    #[arg(short, long, value_name = "MESH")]
    pub(crate) out: PathBuf,
    /// All cells; the default where nothing else is named
    #[arg(long)]
    pub(crate) all: bool,
    /// Cells of a group; again for several
    #[arg(long, value_name = "GROUP")]
    pub(crate) cells: Vec<String>,
    /// Cells at a group of the surface; again for several
    #[arg(long, value_name = "GROUP")]
    pub(crate) on: Vec<String>,
    /// Cells with a vertex in a ball, in lengths of the mesh file; again for several
    #[arg(long, num_args = 4, allow_negative_numbers = true,
        value_names = ["X", "Y", "Z", "RADIUS"])]
    pub(crate) near: Vec<f64>,
    /// Cells that hold half of the error by a file of results (VTU with error_density or error_estimate)
    #[arg(long, value_name = "FILE")]
    pub(crate) by: Option<PathBuf>,
    /// How often their edges are halved: two bisections of triangles each, three of tetrahedra
    #[arg(long, value_name = "N", default_value_t = 1,
        value_parser = clap::value_parser!(u32).range(1..=20))]
    pub(crate) levels: u32,
    /// Cells at which it stops with exit code 6
    #[arg(long, value_name = "N", default_value_t = 20_000_000)]
    pub(crate) max_cells: usize,
}

/// Which law is fitted to which tests.
#[derive(Args, Debug)]
pub(crate) struct FitArguments {
    #[command(flatten)]
    pub(crate) scene: SceneArguments,
    /// Test curves of the material (CSV: columns test, stretch or strain, stress), or curves of the scene (columns time
    /// and goals, such as force.lid.y)
    #[arg(value_name = "DATA")]
    pub(crate) data: PathBuf,
    /// The material, where the scene has several
    #[arg(long, value_name = "GROUP")]
    pub(crate) group: Option<String>,
    /// Another law than the scene's
    #[arg(long, value_name = "LAW", value_parser = [
        "neo-hookean", "mooney-rivlin", "yeoh", "ogden", "polynomial", "gent", "arruda-boyce",
        "van-der-waals",
    ])]
    pub(crate) model: Option<String>,
    /// Terms of --model ogden
    #[arg(long, value_name = "N", default_value_t = 2, requires = "model",
        value_parser = clap::value_parser!(u8).range(1..=3))]
    pub(crate) terms: u8,
    /// Errors as they are, instead of over the measured stress
    #[arg(long)]
    pub(crate) absolute: bool,
    /// Draw curves and points into this file (SVG)
    #[arg(long, value_name = "FILE")]
    pub(crate) plot: Option<PathBuf>,
    /// One JSON object
    #[arg(long)]
    pub(crate) json: bool,
}
