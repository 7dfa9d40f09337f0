//! The command line tool, run as a process of its own: what it prints, writes and answers.

#[path = "../common/mod.rs"]
mod common;

mod adapted;
mod bench;
mod bodies;
mod cli;
mod contact_patch;
mod contact_path;
mod detached;
mod examples;
mod fluids;
mod goals;
mod grids;
mod hexahedra;
mod interrupt;
mod killed;
mod manual;
mod methods;
mod published;
mod refine_and_fit;
mod refusals;
mod result_lines;
mod serve;
mod stl_weld;
mod study;
mod whole_run;
