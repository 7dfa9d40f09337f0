//! What is made of results: files, tables and a page.
//!
//! | file | what it does |
//! |---|---|
//! | `record` | all that a command makes of the results of a session |
//! | `results` | the folder of `--out`: series of VTU and VTP files beside the result lines |
//! | `results_csv` | one row an increment |
//! | `table` | plans and results as text for people |
//! | `page` | `report.html`: a folder of results as one page |
//! | `travel` | along what the force of an obstacle is told |
//! | `units` | names of units, as the scene has them |

pub(crate) mod page;
pub(crate) mod record;
pub(crate) mod results;
pub(crate) mod results_csv;
pub(crate) mod table;
mod travel;
pub(crate) mod units;
