//! What diagrams have across: quantities of a run, with their names.

use crate::peers::Peer;
use crate::row::Row;

/// A quantity that a run has whatever its scene.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Axis {
    /// In names of files.
    pub(crate) name: &'static str,
    /// In titles.
    pub(crate) word: &'static str,
    /// Along the axis, with the unit.
    pub(crate) label: &'static str,
    /// Its value in a run of ours.
    pub(crate) of: fn(&Row) -> Option<f64>,
    /// Its least and greatest value where several runs stand behind a row.
    pub(crate) spread: fn(&Row) -> Option<(f64, f64)>,
    /// Its value in a run of another solver.
    pub(crate) of_peer: fn(&Peer) -> Option<f64>,
}

/// Seconds of the solve.
pub(crate) const TIME: Axis = Axis {
    name: "seconds",
    word: "time",
    label: "wall time of the solve, cold process (s)",
    of: |row| Some(row.numbers.seconds),
    spread: |row| (row.repeats > 1).then_some((row.least_seconds, row.most_seconds)),
    of_peer: |peer| Some(peer.seconds),
};

/// Megabytes of the process.
pub(crate) const MEMORY: Axis = Axis {
    name: "memory",
    word: "memory",
    label: "peak memory of the process (MB)",
    of: Row::peak_memory_mb,
    spread: |_| None,
    of_peer: |peer| peer.peak_memory_mb,
};

/// All unknowns; none of a run that ended before it had any.
pub(crate) const SIZE: Axis = Axis {
    name: "unknowns",
    word: "unknowns",
    label: "unknowns (displacement, pressure, contact)",
    of: |row| Some(row.unknowns()).filter(|count| *count > 0.0),
    spread: |_| None,
    of_peer: |peer| peer.unknowns,
};

/// The tolerance that was asked for.
pub(crate) const TOLERANCE: Axis = Axis {
    name: "tolerance",
    word: "the tolerance",
    label: "tolerance of the residuals",
    of: |row| Some(row.case.tolerance),
    spread: |_| None,
    of_peer: |_| None,
};
