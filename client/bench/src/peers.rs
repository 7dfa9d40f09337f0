//! Figures of other solvers, from a CSV file: the one that the program carries, or another.
//!
//! Columns, by name: `scene`, `level`, `solver`, `seconds`, `unknowns` (of failures it may
//! be empty) and, each may be empty or left out, `failure` (what went wrong, after
//! `seconds`), `peak_memory_mb`, `iterations` and `error_QUANTITY` (relative) or
//! `value_QUANTITY` (compared with the limit of its family), for [`Quantity`] names; other columns are for readers. Lines that begin
//! with `#` are comments: versions, machine, how to measure again. A peer without
//! an error of its own is given that of the exact discrete solution on its mesh.

use std::path::Path;

use crate::commented::reader;
use crate::family::{Level, Quantity};
use crate::reference::References;

const SHIPPED: &str = include_str!("../peers.csv");

/// One run of another solver.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Peer {
    pub(crate) scene: String,
    pub(crate) level: Level,
    pub(crate) solver: String,
    /// None of some failures.
    pub(crate) unknowns: Option<f64>,
    /// To the result, or to the failure.
    pub(crate) seconds: f64,
    /// Why it has no result.
    pub(crate) failure: Option<String>,
    pub(crate) peak_memory_mb: Option<f64>,
    pub(crate) iterations: Option<f64>,
    errors: Vec<(Quantity, f64)>,
    values: Vec<(Quantity, f64)>,
}

/// A file of peers.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Peers {
    pub(crate) rows: Vec<Peer>,
    /// Its comments, line by line.
    pub(crate) about: Vec<String>,
}

impl Peer {
    /// Its relative error; none of a failure.
    pub(crate) fn error(&self, quantity: Quantity, references: &References) -> Option<f64> {
        if self.failure.is_some() {
            return None;
        }
        let find = |list: &[(Quantity, f64)]| {
            let mut list = list.iter();
            list.find(|item| item.0 == quantity).map(|item| item.1)
        };
        let of_value = || references.relative(&self.scene, quantity, find(&self.values)?);
        find(&self.errors)
            .or_else(of_value)
            .or_else(|| references.error(&self.scene, quantity, self.level))
    }
}

/// Reads a file of peers.
///
/// # Errors
/// The file, the line and what is wrong with it.
pub(crate) fn read(path: &Path) -> Result<Peers, String> {
    let about = |message: String| format!("{}: {message}", path.display());
    let text = std::fs::read_to_string(path).map_err(|error| about(error.to_string()))?;
    with_comments(&text).map_err(about)
}

/// The peers that the program carries.
///
/// # Errors
/// A line that cannot be read, which a test excludes.
pub(crate) fn shipped() -> Result<Peers, String> {
    with_comments(SHIPPED)
}

fn with_comments(text: &str) -> Result<Peers, String> {
    let comments = text.lines().filter_map(|line| line.strip_prefix('#'));
    Ok(Peers {
        about: comments.map(|line| line.trim_end().to_owned()).collect(),
        rows: parse(text)?,
    })
}

/// The rows of a table of peers; `text` is CSV with the columns above.
///
/// # Errors
/// The line and what is wrong with it.
pub(crate) fn parse(text: &str) -> Result<Vec<Peer>, String> {
    let mut reader = reader(text.as_bytes());
    let header = reader.headers().map_err(|error| error.to_string())?.clone();
    let mut peers = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|error| error.to_string())?;
        let line = record.position().map_or(0, csv::Position::line);
        let columns = Columns {
            header: &header,
            record: &record,
        };
        peers.push(peer(&columns).map_err(|message| format!("line {line}: {message}"))?);
    }
    Ok(peers)
}

struct Columns<'a> {
    header: &'a csv::StringRecord,
    record: &'a csv::StringRecord,
}

impl<'a> Columns<'a> {
    fn text(&self, name: &str) -> Option<&'a str> {
        let column = self.header.iter().position(|title| title == name)?;
        self.record.get(column).filter(|text| !text.is_empty())
    }

    fn required(&self, name: &str) -> Result<&'a str, String> {
        self.text(name).ok_or_else(|| format!("{name} is missing"))
    }

    fn number(&self, name: &str) -> Result<Option<f64>, String> {
        let Some(text) = self.text(name) else {
            return Ok(None);
        };
        let number = text
            .parse()
            .ok()
            .filter(|number: &f64| *number > 0.0 && number.is_finite());
        number
            .map(Some)
            .ok_or_else(|| format!("{name}: \"{text}\" is no number above zero"))
    }

    fn required_number(&self, name: &str) -> Result<f64, String> {
        self.number(name)?
            .ok_or_else(|| format!("{name} is missing"))
    }
}

fn peer(columns: &Columns<'_>) -> Result<Peer, String> {
    let numbers = |kind: &str| -> Result<Vec<(Quantity, f64)>, String> {
        let mut found = Vec::new();
        for quantity in Quantity::ALL {
            let number = columns.number(&format!("{kind}_{}", quantity.name()))?;
            found.extend(number.map(|number| (quantity, number)));
        }
        Ok(found)
    };
    let failure = columns.text("failure");
    Ok(Peer {
        scene: columns.required("scene")?.to_owned(),
        level: columns.required("level")?.parse()?,
        solver: columns.required("solver")?.to_owned(),
        unknowns: match failure {
            Some(_) => columns.number("unknowns")?,
            None => Some(columns.required_number("unknowns")?),
        },
        seconds: columns.required_number("seconds")?,
        failure: failure.map(str::to_owned),
        peak_memory_mb: columns.number("peak_memory_mb")?,
        iterations: columns.number("iterations")?,
        errors: numbers("error")?,
        values: numbers("value")?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str =
        "scene,level,solver,unknowns,seconds,peak_memory_mb,error_force,value_force\n";

    #[test]
    fn peers_are_read_by_the_names_of_columns() {
        let text = format!(
            "# a machine\n{HEADER}hertz-plane,l2,Other 1.0,7648,1.5,330,0.01,\nA1m,n6,Other 1.0,6934,0.2,,,\n"
        );
        let peers = parse(&text).unwrap();
        let references = References::shipped().unwrap();
        assert_eq!(peers.len(), 2);
        assert_eq!(peers[0].error(Quantity::Force, &references), Some(0.01));
        assert_eq!(peers[1].peak_memory_mb, None);
        let level = peers[1].level;
        assert_eq!(
            peers[1].error(Quantity::PressureL2, &references),
            references.error("A1m", Quantity::PressureL2, level)
        );
    }

    #[test]
    fn a_value_is_compared_with_the_limit() {
        let text = format!("{HEADER}hertz-plane,l2,Other 1.0,7648,1.5,330,,0.0703\n");
        let peers = parse(&text).unwrap();
        let references = References::shipped().unwrap();
        let expected = references.relative("hertz-plane", Quantity::Force, 0.0703);
        assert!(expected.is_some_and(|error| error > 1e-3));
        assert_eq!(peers[0].error(Quantity::Force, &references), expected);
    }

    #[test]
    fn a_failure_has_seconds_and_a_reason_but_no_error() {
        let text = "scene,level,solver,unknowns,seconds,failure\n\
            hertz-plane,l2,Other,,300,no convergence\n";
        let peers = parse(text).unwrap();
        let references = References::shipped().unwrap();
        assert_eq!(peers[0].failure.as_deref(), Some("no convergence"));
        assert_eq!(peers[0].unknowns, None);
        assert_eq!(peers[0].error(Quantity::Force, &references), None);
        let fault = parse(&text.replace("no convergence", "")).unwrap_err();
        assert_eq!(fault, "line 2: unknowns is missing");
    }

    #[test]
    fn faults_are_named_with_their_line() {
        for (row, message) in [
            ("A1m,n6,Other,6934,,,,", "line 2: seconds is missing"),
            (
                "A1m,n6,Other,6934,fast,,,",
                "line 2: seconds: \"fast\" is no number above zero",
            ),
            ("A1m,six,Other,6934,1,,,", "line 2: n1 to n99"),
        ] {
            let fault = parse(&format!("{HEADER}{row}\n")).unwrap_err();
            assert!(fault.starts_with(message), "{fault}");
        }
    }

    #[test]
    fn the_shipped_peers_can_be_read() {
        let peers = shipped().unwrap();
        assert!(peers.rows.iter().any(|peer| peer.scene == "hertz-plane"));
        let about = peers.about.join(" ");
        assert!(
            about.contains("Machine") && about.contains("NGSolve 6"),
            "{about}"
        );
    }
}
