//! What a reader takes away: one figure and three sentences.

use crate::chart::escaped;
use crate::families::FAMILIES;
use crate::family::{Family, Quantity};
use crate::figures::Chapter;
use crate::peers::Peer;
use crate::picture::Figure;
use crate::results::Results;
use crate::row::Row;
use crate::text::times;
use crate::versus;

/// The top of the page; nothing where no chapter was measured.
pub(crate) fn html(results: &Results, chapters: &[Chapter]) -> String {
    let Some(Figure { svg, .. }) = figure(results, chapters) else {
        return String::new();
    };
    let sentences = [others(results), tolerances(results), failures(results)];
    let said = sentences.iter().flatten();
    let items: String = said
        .map(|text| format!("<li>{}</li>\n", escaped(text)))
        .collect();
    format!(
        "<h2 id=\"summary\">In short</h2>\n<ul class=\"summary\">\n{items}</ul>\n\
         <div class=\"figures\">\n<figure>{svg}</figure>\n</div>\n"
    )
}

/// The force of the chapter without friction that most other solvers took, else the first.
fn figure<'a>(results: &Results, chapters: &'a [Chapter]) -> Option<&'a Figure> {
    let force = |chapter: &&Chapter| chapter.family.quantities.contains(&Quantity::Force);
    let frictionless = chapters.iter().filter(force);
    let frictionless = frictionless.filter(|chapter| is_frictionless(chapter.family));
    let count = |chapter: &&Chapter| versus::duels(results, chapter.family).len();
    // The first of equals, as the page goes on.
    let best = frictionless.rev().max_by_key(count);
    let named = best.and_then(|chapter| {
        let name = format!("{}-force-seconds", chapter.family.name);
        chapter.figures.iter().find(|figure| figure.name == name)
    });
    named.or_else(|| chapters.first()?.figures.first())
}

/// Other solvers have contact conditions of their own with friction.
fn is_frictionless(family: &Family) -> bool {
    !family.quantities.contains(&Quantity::TangentialForce)
}

/// A mesh that others took: the fastest of them, and ours.
type Duel<'a> = (&'a Peer, &'a Row);

fn fastest<'a>(results: &'a Results, family: &Family) -> Vec<Duel<'a>> {
    let mut best: Vec<Duel<'a>> = Vec::new();
    for duel in versus::duels(results, family) {
        if duel.0.failure.is_some() {
            continue;
        }
        match best.iter_mut().find(|(peer, _)| peer.level == duel.0.level) {
            Some(known) if known.0.seconds <= duel.0.seconds => {}
            Some(known) => *known = duel,
            None => best.push(duel),
        }
    }
    best
}

/// Seconds of other solvers over ours, where both have the same discrete problem.
fn others(results: &Results) -> Option<String> {
    let families = FAMILIES.iter().filter(|family| is_frictionless(family));
    let duels: Vec<Duel<'_>> = families
        .flat_map(|family| fastest(results, family))
        .collect();
    let ratio = |duel: &Duel<'_>| duel.0.seconds / duel.1.numbers.seconds;
    let (least, most) = extremes(&duels, ratio)?;
    Some(format!(
        "On {} meshes without friction that other solvers took too, the fastest of them needs \
         between {} ({}) and {} ({}) the seconds of Signorini at its tight tolerance; {}.",
        duels.len(),
        times(ratio(least)),
        met(least),
        times(ratio(most)),
        met(most),
        beyond_spread(&duels),
    ))
}

/// How many meshes tell the solvers apart; a single run has no spread.
fn beyond_spread(duels: &[Duel<'_>]) -> String {
    let repeated: Vec<_> = duels.iter().filter(|duel| duel.1.repeats > 1).collect();
    if repeated.is_empty() {
        return "it was run once on each, so that no spread is known".to_owned();
    }
    let slower = repeated
        .iter()
        .filter(|duel| duel.0.seconds < duel.1.least_seconds);
    let faster = repeated
        .iter()
        .filter(|duel| duel.0.seconds > duel.1.most_seconds);
    let once = match duels.len() - repeated.len() {
        0 => String::new(),
        once => format!(" ({once} with one run do not count)"),
    };
    format!(
        "Signorini is faster beyond the spread of its runs on {}, slower on {}{once}",
        faster.count(),
        slower.count()
    )
}

fn met((peer, row): &Duel<'_>) -> String {
    format!("{} {}, {}", row.case.family.name, peer.level, peer.solver)
}

/// What a loose tolerance costs in error and saves in time.
fn tolerances(results: &Results) -> Option<String> {
    let pairs: Vec<Pair<'_>> = results
        .rows
        .iter()
        .filter_map(|row| pair(results, row))
        .collect();
    let same = pairs.iter().filter(|pair| pair.error <= 1.1).count();
    let (_, worst) = extremes(&pairs, |pair| pair.error)?;
    let mut seconds: Vec<f64> = pairs.iter().map(|pair| pair.seconds).collect();
    seconds.sort_by(f64::total_cmp);
    let median = seconds.get(seconds.len() / 2)?;
    let case = &worst.loose.case;
    Some(format!(
        "Tolerance {:e} has the error of the tight one to a tenth on {same} of {} meshes, in {} its \
         time (median); at worst ({} {}) its error is {} as large.",
        case.tolerance,
        pairs.len(),
        times(*median),
        case.family.name,
        case.level,
        times(worst.error),
    ))
}

/// A loose run over the tight one on the same mesh.
struct Pair<'a> {
    loose: &'a Row,
    error: f64,
    seconds: f64,
}

fn pair<'a>(results: &Results, loose: &'a Row) -> Option<Pair<'a>> {
    let case = &loose.case;
    let quantity = *case.family.quantities.first()?;
    let is_loose = case.tolerance >= 1e-4 && loose.converged();
    let tight = versus::tightest(results, case.family, case.level)?;
    let is_default = case.method.overrides().next().is_none();
    // A homogeneous state has the error of the algebra alone.
    let limit = results.references.limit(case.family.name, quantity);
    let is_exact = limit.is_some_and(|limit| limit.is_exact());
    (is_loose && is_default && !is_exact).then_some(())?;
    Some(Pair {
        loose,
        error: loose.error(quantity)? / tight.error(quantity)?,
        seconds: loose.numbers.seconds / tight.numbers.seconds,
    })
}

fn failures(results: &Results) -> Option<String> {
    let rows = &results.rows;
    let failed = rows.iter().filter(|row| !row.converged()).count();
    let peers = |peer: &&Peer| {
        let mut rows = rows.iter();
        rows.any(|row| row.case.family.name == peer.scene && row.case.level == peer.level)
    };
    let taken: Vec<&Peer> = results.peers.rows.iter().filter(peers).collect();
    let lost = taken.iter().filter(|peer| peer.failure.is_some()).count();
    (!rows.is_empty()).then(|| {
        format!(
            "{failed} of {} cases failed, and {lost} of {} of other solvers on the same meshes: \
             crosses in the figures, with their reasons under failures.",
            rows.len(),
            taken.len(),
        )
    })
}

/// The items with the least and the greatest value.
fn extremes<T>(items: &[T], value: impl Fn(&T) -> f64) -> Option<(&T, &T)> {
    let order = |a: &&T, b: &&T| value(a).total_cmp(&value(b));
    Some((items.iter().min_by(order)?, items.iter().max_by(order)?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::peers::parse;
    use crate::samples;

    fn measured(level: &str, tolerance: f64, seconds: f64, error: f64) -> Row {
        let mut row = samples::row("hertz-plane", level, "auto", seconds);
        (row.case.tolerance, row.case.place) = (tolerance, crate::plan::Place::Chapter);
        row.errors = vec![(Quantity::Force, error)];
        row.repeats = 3;
        row
    }

    #[test]
    fn the_fastest_other_solver_of_each_mesh_counts() {
        let rows = vec![
            measured("l1", 1e-8, 1.0, 0.1),
            measured("l2", 1e-8, 2.0, 0.05),
        ];
        let mut results = samples::results(rows);
        let peers = "scene,level,solver,unknowns,seconds\nhertz-plane,l1,Slow,1,9\n\
            hertz-plane,l1,Quick,1,0.5\nhertz-plane,l2,Slow,1,8\n";
        results.peers.rows = parse(peers).unwrap();
        let text = others(&results).unwrap();
        let expected = "On 2 meshes without friction that other solvers took too, the fastest of \
            them needs between 0.50\u{a0}× (hertz-plane l1, Quick) and 4.0\u{a0}× (hertz-plane l2, \
            Slow) the seconds of Signorini at its tight tolerance; Signorini is faster beyond the \
            spread of its runs on 1, slower on 1.";
        assert_eq!(text, expected);
    }

    #[test]
    fn seconds_within_the_spread_of_ours_are_neither_faster_nor_slower() {
        let mut row = measured("l1", 1e-8, 1.0, 0.1);
        (row.least_seconds, row.most_seconds) = (0.9, 1.3);
        let mut results = samples::results(vec![row]);
        let peers = "scene,level,solver,unknowns,seconds\nhertz-plane,l1,Other,1,1.2\n";
        results.peers.rows = parse(peers).unwrap();
        assert!(others(&results).unwrap().ends_with("on 0, slower on 0."));
    }

    #[test]
    fn a_single_run_is_neither_faster_nor_slower() {
        let mut once = measured("l1", 1e-8, 1.0, 0.1);
        once.repeats = 1;
        let mut results = samples::results(vec![once]);
        let peers = "scene,level,solver,unknowns,seconds\nhertz-plane,l1,Other,1,9\n\
            hertz-plane,l2,Other,1,9\n";
        results.peers.rows = parse(peers).unwrap();
        assert!(others(&results).unwrap().ends_with("no spread is known."));
        results.rows.push(measured("l2", 1e-8, 1.0, 0.1));
        let said = "on 1, slower on 0 (1 with one run do not count).";
        assert!(others(&results).unwrap().ends_with(said));
    }

    #[test]
    fn the_loose_tolerance_is_told_with_its_worst_mesh() {
        let tight = [
            measured("l1", 1e-8, 1.0, 0.1),
            measured("l2", 1e-8, 4.0, 0.01),
        ];
        let loose = [
            measured("l1", 1e-3, 0.5, 0.1),
            measured("l2", 1e-3, 1.0, 0.03),
        ];
        let results = samples::results(tight.into_iter().chain(loose).collect());
        let text = tolerances(&results).unwrap();
        let expected = "Tolerance 1e-3 has the error of the tight one to a tenth on 1 of 2 meshes";
        assert!(text.starts_with(expected), "{text}");
        assert!(
            text.ends_with("(hertz-plane l2) its error is 3.0\u{a0}× as large."),
            "{text}"
        );
    }

    #[test]
    fn the_top_of_the_page_has_a_figure_and_nothing_without_rows() {
        assert_eq!(html(&samples::results(Vec::new()), &[]), "");
        let results = samples::results(vec![measured("l1", 1e-8, 1.0, 0.1)]);
        let page = html(&results, &results.chapters());
        assert!(page.contains("hertz-plane: error of the contact force against time"));
        assert!(page.contains("0 of 1 cases failed, and 0 of 0 of other solvers"));
    }
}
