//! The file of a study: TOML into axes, changes and wanted values; every fault is told.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use toml::{Table, Value};

use super::axis::{Axis, Points};
use super::derived::Sought;
use super::error::StudyError;
use super::list::List;
use super::range::{Range, Spacing};
use super::sobol::{DIMENSIONS, MOST_POINTS, Sobol};
use super::wanted::{At, Wanted};
use crate::library::bounded_file;
use crate::scene_file::Override;
use crate::scene_file::keys::{Faults, Keys};

const STUDY: &[&str] = &["scene", "set", "grid", "list", "sobol", "result"];
const GRID: &[&str] = &["key", "values", "from", "to", "count", "spacing"];
const LIST: &[&str] = &["file"];
const SOBOL: &[&str] = &["points", "seed", "range"];
const RANGE: &[&str] = &["key", "from", "to", "spacing"];
const RESULT: &[&str] = &["name", "of", "at", "expression"];

/// Bytes of a table of cases.
const MOST_LIST_BYTES: u64 = 256 << 20;

/// What the file says.
#[derive(Debug)]
pub(crate) struct StudyFile {
    pub(crate) table: Table,
    pub(crate) scene: PathBuf,
    pub(crate) changes: Vec<Override>,
    pub(crate) axes: Vec<Axis>,
    pub(crate) wanted: Vec<Wanted>,
    pub(crate) sought: Vec<Sought>,
    /// The table of cases.
    pub(crate) list: Option<PathBuf>,
}

/// Reads the text; files that it names begin in the folder of `path`.
pub(crate) fn read(text: &str, path: &Path) -> Result<StudyFile, StudyError> {
    let table: Table = text.parse().map_err(|error: toml::de::Error| {
        let (path, message) = (path.to_owned(), error.to_string().trim_end().to_owned());
        StudyError::Syntax { path, message }
    })?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let faults = Faults::default();
    let keys = Keys::new(String::new(), &table, STUDY, &faults);
    let scene = folder.join(keys.required_text("scene"));
    let changes = changes(&keys, folder);
    let list = keys
        .table("list", LIST)
        .map(|list| list.required_text("file"));
    let mut axes = grids(&keys);
    axes.extend(keys.table("sobol", SOBOL).and_then(|sobol| points(&sobol)));
    let (wanted, sought) = results(&keys);
    if axes.is_empty() && list.is_none() {
        keys.fault_here("nothing varies: [[grid]], [list] or [sobol] is expected");
    }
    faults.finish().map_err(StudyError::Invalid)?;
    let list = list.map(|file| folder.join(file));
    if let Some(list) = &list {
        axes.insert(0, Axis::List(read_list(list)?));
    }
    Ok(StudyFile {
        table,
        scene,
        changes,
        axes,
        wanted,
        sought,
        list,
    })
}

fn read_list(path: &Path) -> Result<List, StudyError> {
    let bytes = bounded_file::read(path, MOST_LIST_BYTES).map_err(|source| StudyError::File {
        path: path.to_owned(),
        source,
    })?;
    List::read(bytes).map_err(|fault| StudyError::List {
        path: path.to_owned(),
        line: fault.line,
        message: fault.message,
    })
}

fn changes(keys: &Keys<'_>, folder: &Path) -> Vec<Override> {
    let texts = keys.names("set");
    let changes = texts
        .iter()
        .filter_map(|text| match text.parse::<Override>() {
            Ok(change) => Some(change.beginning_in(folder)),
            Err(fault) => {
                keys.fault("set", format!("\"{text}\": {fault}"));
                None
            }
        });
    changes.collect()
}

fn grids(keys: &Keys<'_>) -> Vec<Axis> {
    let tables = keys.tables("grid", GRID);
    tables.iter().filter_map(grid).collect()
}

fn grid(keys: &Keys<'_>) -> Option<Axis> {
    let key = keys.required_text("key");
    let ranged = ["from", "to", "count", "spacing"].into_iter();
    match (
        keys.list("values"),
        ranged.clone().find(|key| keys.has(key)),
    ) {
        (Some(_), Some(also)) => {
            keys.fault(
                also,
                "stands beside \"values\": either of the two is expected",
            );
            None
        }
        (Some([]), None) => {
            keys.fault("values", "is empty");
            None
        }
        (Some(values), None) => Some(Axis::Values(key, values.to_vec())),
        (None, None) if keys.has("values") => None,
        (None, None) => {
            keys.fault_here("\"values\", or \"from\", \"to\" and \"count\" are missing");
            None
        }
        (None, Some(_)) => {
            let count = count(keys, "count");
            Some(Axis::Steps(key, range(keys)?, count?))
        }
    }
}

/// A number of things, at least one.
fn count(keys: &Keys<'_>, key: &str) -> Option<u64> {
    let count = keys.required_whole(key)?;
    let some = u64::try_from(count).ok().filter(|count| *count > 0);
    if some.is_none() {
        keys.fault(key, format!("{count}: at least 1 is expected"));
    }
    some
}

fn range(keys: &Keys<'_>) -> Option<Range> {
    let spacing = word(keys, "spacing", Spacing::Linear)?;
    let ends = (keys.required_value("from"), keys.required_value("to"));
    let (Some(from), Some(to)) = ends else {
        return None;
    };
    let range = Range::new(from, to, spacing);
    range.map_err(|(key, fault)| keys.fault(key, fault)).ok()
}

/// One of some words, or what is meant without it.
fn word<T: FromStr<Err = String>>(keys: &Keys<'_>, key: &str, default: T) -> Option<T> {
    let Some(word) = keys.text(key) else {
        return (!keys.has(key)).then_some(default);
    };
    word.parse().map_err(|fault| keys.fault(key, fault)).ok()
}

fn points(keys: &Keys<'_>) -> Option<Axis> {
    let count = count(keys, "points");
    let seed = keys.whole("seed").map(i64::cast_unsigned);
    let tables = keys.tables("range", RANGE);
    if tables.is_empty() && !keys.has("range") {
        keys.fault("range", "[[sobol.range]] is missing");
    }
    if tables.len() > DIMENSIONS {
        let fault = format!("{} keys: at most {DIMENSIONS} vary", tables.len());
        keys.fault("range", fault);
    }
    if count.is_some_and(|count| count > MOST_POINTS) {
        keys.fault("points", format!("at most {MOST_POINTS} are there"));
    }
    let named = tables
        .iter()
        .map(|keys| Some((keys.required_text("key"), range(keys)?)));
    let ranges = named
        .collect::<Vec<_>>()
        .into_iter()
        .collect::<Option<Vec<_>>>()?;
    let sequence = Sobol::new(ranges.len(), seed);
    Some(Axis::Points(Points {
        count: count?,
        ranges,
        sequence,
    }))
}

/// What is taken from results, and what is computed from that.
fn results(keys: &Keys<'_>) -> (Vec<Wanted>, Vec<Sought>) {
    let tables = keys.tables("result", RESULT);
    let (computed, taken): (Vec<_>, Vec<_>) =
        tables.iter().partition(|keys| keys.has("expression"));
    let wanted = taken.into_iter().filter_map(wanted).collect();
    (wanted, computed.into_iter().filter_map(sought).collect())
}

fn wanted(keys: &Keys<'_>) -> Option<Wanted> {
    let of = keys.required_text("of");
    let at = word(keys, "at", At::Last)?;
    let name = keys.text("name").unwrap_or_else(|| match at {
        At::Last => of.clone(),
        At::Every | At::Max | At::Min | At::Sum => format!("{at} {of}"),
    });
    Some(Wanted { name, of, at })
}

fn sought(keys: &Keys<'_>) -> Option<Sought> {
    let (name, text) = (keys.required_text("name"), keys.text("expression")?);
    if let Some(other) = ["of", "at"].into_iter().find(|key| keys.has(key)) {
        keys.fault(
            other,
            "stands beside \"expression\": either of the two is expected",
        );
        return None;
    }
    Some(Sought { name, text })
}

impl<'a> Keys<'a> {
    fn list(&self, key: &str) -> Option<&'a [Value]> {
        self.read(key, "a list", |value| value.as_array().map(Vec::as_slice))
    }

    fn whole(&self, key: &str) -> Option<i64> {
        self.read(key, "an integer", Value::as_integer)
    }

    fn required_whole(&self, key: &str) -> Option<i64> {
        self.require(key);
        self.whole(key)
    }

    fn required_value(&self, key: &str) -> Option<&'a Value> {
        self.require(key);
        self.read(key, "a value", Some)
    }
}
