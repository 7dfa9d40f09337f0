//! `report.html`: a folder of results as one page that needs no network.
//!
//! Made from what the folder holds: the result lines, the last body and obstacles of its series,
//! and the last pressures along the surface. The page draws forces and convergence, and turns the surface in the
//! browser; surfaces too large for three megabytes are thinned. Cost: the lines are
//! read once, and the last file of the body.

mod data;
mod encode;
mod fluid;
mod lines;
mod shape;
mod surface;
mod thin;
mod vtk;

use std::path::{Path, PathBuf};

use crate::report::path_csv;
use crate::report::results::LINES;
use crate::terminal::exit::{Exit, Failure};
use crate::terminal::whole_file;

const TEMPLATE: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");
/// In the order in which they run.
const SCRIPTS: [&str; 7] = [
    include_str!("chart.js"),
    include_str!("body.js"),
    include_str!("view.js"),
    include_str!("parts.js"),
    include_str!("fluid.js"),
    include_str!("goals.js"),
    include_str!("page.js"),
];

/// Where the page of a folder is.
pub(crate) fn path(folder: &Path) -> PathBuf {
    folder.join("report.html")
}

/// Writes the page of a folder of results and tells where it is.
pub(crate) fn write(folder: &Path) -> Result<PathBuf, Failure> {
    let lines_path = folder.join(LINES);
    let text = std::fs::read_to_string(&lines_path)
        .map_err(|error| Failure::unreadable(&lines_path, &error))?;
    let lines = lines::read(&text).map_err(|fault| {
        let place = lines_path.display();
        Failure::new(Exit::Invalid, format!("{place}: {fault}"))
    })?;
    let picture = surface::last_picture(folder);
    let paths = path_csv::last(folder);
    let page = page(&data::of(&lines, picture, paths))?;
    let path = path(folder);
    whole_file::write(&path, page.as_bytes())
        .map_err(|error| Failure::unwritable(&path, &error))?;
    Ok(path)
}

/// The template with its parts in place.
fn page(data: &data::Page) -> Result<String, Failure> {
    let data = serde_json::to_string(data)
        .map_err(|error| Failure::new(Exit::Server, format!("the page: {error}")))?;
    // Nothing in a name may end the element that holds the data.
    let data = data.replace('<', "\\u003c");
    let script = SCRIPTS.concat();
    let mut page = String::with_capacity(TEMPLATE.len() + STYLE.len() + script.len() + data.len());
    for part in TEMPLATE.split_inclusive("}}") {
        let Some((before, slot)) = part.split_once("{{") else {
            page.push_str(part);
            continue;
        };
        page.push_str(before);
        page.push_str(match slot {
            "style}}" => STYLE,
            "script}}" => &script,
            "data}}" => &data,
            _ => "",
        });
    }
    Ok(page)
}

#[cfg(test)]
mod tests;
