//! The arguments of `signorini bench`.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;

use crate::extent::Extent;
use crate::families;
use crate::family::{Family, Level};
use crate::method::Method;
use crate::plan::Wishes;
use crate::study::{self, Study};

/// What to measure, for how long, and where to write it.
#[derive(Args, Clone, Debug)]
pub struct Arguments {
    /// Small meshes only, two minutes at most
    #[arg(long)]
    quick: bool,
    /// Folder for bench.csv, index.html and the figures
    #[arg(long, value_name = "DIR", default_value = "results/bench")]
    pub(crate) out: PathBuf,
    /// A1m, cube-bend, hertz-sphere, hertz-plane, mr-uniax, mr-block, mr-sphere, cube-drag or
    /// hertz-press, several times; default: all
    #[arg(long = "scene", value_name = "NAME", value_parser = families::find)]
    scenes: Vec<&'static Family>,
    /// Question to answer by its own runs, such as element or saddle, several times; default:
    /// all, unless scenes, levels, methods or tolerances are named
    #[arg(long = "study", value_name = "NAME", value_parser = study::find)]
    studies: Vec<&'static Study>,
    /// Meshes, such as n6,n10,l1: cells an edge of the cubes, numbers of the Gmsh meshes
    #[arg(long, value_name = "LEVELS", value_delimiter = ',')]
    levels: Vec<Level>,
    /// auto or KEY=VALUE[,KEY=VALUE] of [solver] (of the scene where KEY has a dot), several times
    #[arg(long = "method", value_name = "METHOD")]
    methods: Vec<Method>,
    /// Tolerances, such as 1e-8,1e-3
    #[arg(long = "tolerances", value_name = "TOLERANCES", value_delimiter = ',')]
    tolerances: Vec<f64>,
    /// Runs of each case, whose median counts; default: 3
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..))]
    repeats: Option<u8>,
    /// Time after which a run is stopped and counts as failed
    #[arg(long, value_name = "SECONDS", value_parser = clap::value_parser!(u64).range(1..))]
    run_limit: Option<u64>,
    /// Time after which no more is measured; default: 2300, with --quick 105
    #[arg(long, value_name = "SECONDS", value_parser = clap::value_parser!(u64).range(1..))]
    budget: Option<u64>,
    /// Folder of Gmsh meshes that replace or add to those of this program
    #[arg(long, value_name = "DIR")]
    pub(crate) meshes: Option<PathBuf>,
    /// CSV file with figures of other solvers, drawn beside ours; default: those of this program
    #[arg(long, value_name = "FILE")]
    pub(crate) peers: Option<PathBuf>,
}

impl Arguments {
    /// What they ask the plan for.
    pub(crate) fn wishes(&self) -> Wishes {
        let extent = if self.quick {
            Extent::Quick
        } else {
            Extent::Full
        };
        Wishes {
            extent,
            scenes: self.scenes.clone(),
            studies: self.studies.clone(),
            levels: self.levels.clone(),
            methods: self.methods.clone(),
            tolerances: self.tolerances.clone(),
            repeats: self.repeats.map(usize::from),
            run_limit: self.run_limit.map(Duration::from_secs),
            budget: self.budget.map(Duration::from_secs),
            meshes: self.meshes.clone(),
        }
    }
}
