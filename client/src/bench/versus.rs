//! Seconds of other solvers over ours, mesh by mesh: both solve the same discrete
//! problem, so that equal meshes are equal errors.

use super::answer::{in_seconds, times};
use super::family::{Family, Level};
use super::figures::Results;
use super::row::Row;

/// One mesh that somebody else solved too.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Duel {
    pub(crate) solver: String,
    pub(crate) level: Level,
    pub(crate) ours: f64,
    pub(crate) theirs: f64,
}

impl Duel {
    /// How many times as long the other solver takes.
    pub(crate) fn ratio(&self) -> f64 {
        self.theirs / self.ours
    }
}

/// All meshes of a family that both solved, at the tightest of our tolerances.
pub(crate) fn duels(results: &Results, family: &Family) -> Vec<Duel> {
    let peers = results.peers.rows.iter();
    let peers = peers.filter(|peer| peer.scene == family.name);
    peers
        .filter_map(|peer| {
            let ours = tightest(results, family, peer.level)?;
            Some(Duel {
                solver: peer.solver.clone(),
                level: peer.level,
                ours: ours.numbers.seconds,
                theirs: peer.seconds,
            })
        })
        .collect()
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

/// One sentence a solver; none without common meshes.
pub(crate) fn sentences(results: &Results, family: &Family) -> Vec<String> {
    let duels = duels(results, family);
    let mut solvers: Vec<&str> = Vec::new();
    for duel in &duels {
        if !solvers.contains(&duel.solver.as_str()) {
            solvers.push(&duel.solver);
        }
    }
    solvers
        .into_iter()
        .map(|solver| sentence(solver, duels.iter().filter(|duel| duel.solver == solver)))
        .collect()
}

fn sentence<'a>(solver: &str, duels: impl Iterator<Item = &'a Duel>) -> String {
    let told: Vec<String> = duels
        .map(|duel| {
            format!(
                "{} as long on {} ({} against {})",
                times(duel.ratio()),
                duel.level,
                in_seconds(duel.theirs),
                in_seconds(duel.ours)
            )
        })
        .collect();
    format!("{solver} takes {}.", told.join(", "))
}
