//! Seconds of other solvers over ours, mesh by mesh: both solve the same discrete
//! problem, so that equal meshes are equal errors.

use crate::family::{Family, Level};
use crate::peers::Peer;
use crate::results::Results;
use crate::row::Row;
use crate::table::{Column, Table};
use crate::text::{in_seconds, times};

/// All meshes of a family that both solved, at the tightest of our tolerances.
pub(crate) fn table(results: &Results, family: &Family) -> Table {
    let peers = results.peers.rows.iter();
    let peers = peers.filter(|peer| peer.scene == family.name);
    let mut peers: Vec<&Peer> = peers.collect();
    peers.sort_by_key(|peer| peer.level);
    let columns = [
        Column::Group("mesh"),
        Column::Text("other solver"),
        Column::Number("its seconds"),
        Column::Number("Signorini"),
        Column::Number("its over Signorini's"),
    ];
    let duels = peers
        .into_iter()
        .filter_map(|peer| Some(duel(peer, tightest(results, family, peer.level)?)));
    Table::new(columns).with(duels)
}

fn duel(peer: &Peer, ours: &Row) -> [String; 5] {
    let seconds = ours.numbers.seconds;
    [
        peer.level.to_string(),
        peer.solver.clone(),
        in_seconds(peer.seconds),
        in_seconds(seconds),
        times(peer.seconds / seconds),
    ]
}

/// The row of the default method at the tightest tolerance.
fn tightest<'a>(results: &'a Results, family: &Family, level: Level) -> Option<&'a Row> {
    let rows = results.rows.iter().filter(|row| {
        let case = &row.case;
        row.converged()
            && case.family.name == family.name
            && case.level == level
            && case.method.overrides().next().is_none()
    });
    rows.filter(|row| row.case.tolerance <= 1e-7)
        .max_by(|a, b| a.case.tolerance.total_cmp(&b.case.tolerance))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::families::find;
    use crate::peers::parse;
    use crate::samples;

    #[test]
    fn other_solvers_are_timed_on_the_meshes_of_ours() {
        let rows = vec![samples::row("hertz-plane", "l2", "auto", 2.0)];
        let mut results = samples::results(rows);
        let peers = "scene,level,solver,unknowns,seconds\n\
            hertz-plane,l2,Other,100,9\nhertz-plane,l3,Other,900,70\n";
        results.peers.rows = parse(peers).unwrap();
        let table = table(&results, find("hertz-plane").unwrap());
        let line = ["l2", "Other", "9.00 s", "2.00 s", "4.5\u{a0}×"];
        assert_eq!(table.rows(), [line.map(str::to_owned)]);
    }
}
