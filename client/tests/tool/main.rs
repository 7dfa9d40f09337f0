//! The command line tool, run as a process of its own: what it prints, writes and answers.

#[path = "../common/mod.rs"]
mod common;

mod bench;
mod cli;
mod contact_patch;
mod detached;
mod examples;
mod grids;
mod interrupt;
mod manual;
mod methods;
mod refusals;
mod result_lines;
mod serve;
mod study;
mod whole_run;
