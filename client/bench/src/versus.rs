//! Seconds of other solvers over ours, mesh by mesh. Without friction both solve the same
//! discrete problem, so that equal meshes are equal errors.

use crate::family::{Family, Level, Quantity};
use crate::peers::Peer;
use crate::results::Results;
use crate::row::Row;
use crate::table::{Column, Table};
use crate::text::{NOTHING, in_seconds, times, told};

/// All meshes of a family that both took, at the tightest of our tolerances; errors are
/// those of the family's first figure.
pub(crate) fn table(results: &Results, family: &Family) -> Table {
    let columns = [
        Column::Group("mesh"),
        Column::Text("other solver"),
        Column::Number("its seconds"),
        Column::Number("Signorini"),
        Column::Number("its over Signorini's"),
        Column::Number("its error"),
        Column::Number("Signorini's error"),
    ];
    let duels = duels(results, family).into_iter();
    let lines = duels.map(|(peer, ours)| duel(results, family.quantities.first(), peer, ours));
    Table::new(columns).with(lines)
}

/// Runs of others on meshes that ours took too, coarse meshes first.
pub(crate) fn duels<'a>(results: &'a Results, family: &Family) -> Vec<(&'a Peer, &'a Row)> {
    let peers = results.peers.rows.iter();
    let peers = peers.filter(|peer| peer.scene == family.name);
    let duels = peers.filter_map(|peer| Some((peer, tightest(results, family, peer.level)?)));
    let mut duels: Vec<_> = duels.collect();
    duels.sort_by_key(|(peer, _)| peer.level);
    duels
}

fn duel(results: &Results, quantity: Option<&Quantity>, peer: &Peer, ours: &Row) -> [String; 7] {
    let seconds = ours.numbers.seconds;
    let own = quantity.and_then(|&quantity| ours.error(quantity));
    let its = quantity.and_then(|&quantity| peer.error(quantity, &results.references));
    let error = |error: f64| format!("{error:.1e}");
    let (time, ratio) = match &peer.failure {
        None => (in_seconds(peer.seconds), times(peer.seconds / seconds)),
        Some(reason) => {
            let after = in_seconds(peer.seconds);
            (format!("{reason}, {after}"), NOTHING.to_owned())
        }
    };
    [
        peer.level.to_string(),
        peer.solver.clone(),
        time,
        in_seconds(seconds),
        ratio,
        told(its, error),
        told(own, error),
    ]
}

/// The row of the default method at the tightest tolerance.
pub(crate) fn tightest<'a>(results: &'a Results, family: &Family, level: Level) -> Option<&'a Row> {
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
        assert_eq!(table.rows().len(), 1);
        assert_eq!(table.rows()[0][..5], line);
    }

    #[test]
    fn a_failure_is_told_with_its_reason_and_without_a_ratio() {
        let mut ours = samples::row("cube-drag", "n4", "auto", 2.0);
        ours.errors = vec![(Quantity::Force, 0.003)];
        let mut results = samples::results(vec![ours]);
        let peers = "scene,level,solver,unknowns,seconds,failure\n\
            cube-drag,n4,Other,,30,no convergence\n";
        results.peers.rows = parse(peers).unwrap();
        let table = table(&results, find("cube-drag").unwrap());
        let line = ["no convergence, 30.0 s", "2.00 s", "–", "–", "3.0e-3"];
        assert_eq!(table.rows()[0][2..], line);
    }
}
