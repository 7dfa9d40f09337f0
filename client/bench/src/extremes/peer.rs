//! Numbers of other programs on the same scenes and meshes, measured apart.

use crate::commented::reader;

/// Written by `tests/benches/peers/ngsolve_extremes.py`.
const TEXT: &str = include_str!("peers.csv");

/// One run of another program.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Peer {
    /// Name of the row.
    pub(crate) row: String,
    pub(crate) solver: String,
    pub(crate) value: f64,
    pub(crate) seconds: f64,
    /// None of direct solvers.
    pub(crate) iterations: Option<u32>,
}

impl Peer {
    /// Whether rows of this name are compared with it: a direct solver is exact up to
    /// rounding, an iterative one is a peer only.
    pub(super) fn knows(&self, row: &str) -> bool {
        self.row == row && self.iterations.is_none()
    }
}

/// All of them.
///
/// # Errors
/// What is wrong with the file, which a test excludes.
pub(super) fn peers() -> Result<Vec<Peer>, String> {
    let mut peers = Vec::new();
    for record in reader(TEXT.as_bytes()).records() {
        let record = record.map_err(|error| error.to_string())?;
        let field = |index: usize| record.get(index).unwrap_or_default();
        let number = |index: usize| {
            let fault = |error| format!("\"{}\": {error}", field(index));
            field(index).parse::<f64>().map_err(fault)
        };
        peers.push(Peer {
            row: field(0).to_owned(),
            solver: field(1).to_owned(),
            value: number(2)?,
            seconds: number(3)?,
            iterations: field(4).parse().ok(),
        });
    }
    Ok(peers)
}

/// What the file says about itself.
pub(super) fn about() -> Vec<String> {
    let comments = TEXT.lines().filter_map(|line| line.strip_prefix('#'));
    comments.map(|line| line.trim().to_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::extremes::catalogue::trials;

    #[test]
    fn every_peer_is_of_a_row_and_says_where_it_comes_from() {
        let rows = trials().unwrap();
        let peers = peers().unwrap();
        assert!(!peers.is_empty());
        for peer in peers {
            assert!(rows.iter().any(|trial| trial.id == peer.row), "{peer:?}");
        }
        assert!(about().join(" ").contains("Machine"));
    }
}
