//! `report`: the page of a folder of results, made again.

use std::path::Path;

use crate::exit::{Exit, Failure};
use crate::report_page;
use crate::stdout::print;

pub(super) fn run(folder: &Path) -> Result<Exit, Failure> {
    let page = report_page::write(folder)?;
    print(&format!("{}\n", page.display()))?;
    Ok(Exit::Ok)
}
