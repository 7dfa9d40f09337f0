//! `man`: manual pages, made from the definition of the arguments.

use std::path::Path;

use clap::CommandFactory as _;

use crate::arguments::Arguments;
use crate::terminal::exit::{Exit, Failure};

pub(super) fn run(folder: &Path) -> Result<Exit, Failure> {
    let made = std::fs::create_dir_all(folder)
        .and_then(|()| clap_mangen::generate_to(Arguments::command(), folder));
    made.map_err(|error| Failure::unwritable(folder, &error))?;
    Ok(Exit::Ok)
}
