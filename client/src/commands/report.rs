//! `report`: the page of a folder of results, made again.

use std::path::Path;

use crate::report::page;
use crate::terminal::exit::{Exit, Failure};
use crate::terminal::stdout::print;

pub(super) fn run(folder: &Path) -> Result<Exit, Failure> {
    let page = page::write(folder)?;
    print(&format!("{}\n", page.display()))?;
    Ok(Exit::Ok)
}
