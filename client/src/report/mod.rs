//! What is made of results: files, tables and a page.
//!
//! | file | what it does |
//! |---|---|
//! | `record` | all that a command makes of the results of a session |
//! | `results` | the folder of `--out`: series of VTU and VTP files beside the result lines |
//! | `results_csv` | one row an increment |
//! | `path_csv` | contact pressure along the surface of a section, one row a point |
//! | `test_curves`, `curve_plot` | points of tests of a material, and their picture |
//! | `stem` | names as parts of file names |
//! | `table` | plans and results as text for people |
//! | `page` | `report.html`: a folder of results as one page |
//! | `travel` | along what the force of an obstacle is told |
//! | `units` | names of units, as the scene has them |

#[cfg(feature = "embedded")]
pub(crate) mod curve_plot;
pub(crate) mod goal_curves;
pub(crate) mod page;
pub(crate) mod path_csv;
pub(crate) mod record;
pub(crate) mod results;
pub(crate) mod results_csv;
mod rounds;
mod stem;
pub(crate) mod table;
#[cfg(feature = "embedded")]
pub(crate) mod test_curves;
mod travel;
pub(crate) mod units;
