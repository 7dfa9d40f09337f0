//! One self-contained page: what was measured, figures, failures, all numbers.

use crate::chart::escaped;
use crate::extremes;
use crate::family::Quantity;
use crate::figures::Chapter;
use crate::picture::Figure;
use crate::results::Results;
use crate::row::Row;
use crate::study::Measure;
use crate::study_figures::Inquiry;
use crate::table::{Column, Table};
use crate::{pictures, seed, summary, versus};

/// A case without a row, and why.
pub(crate) type LeftOut = (String, String);

const HEAD: &str = r#"<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>Signorini: error against run time</title>
<style>
body { font: 16px/1.5 Helvetica, Arial, sans-serif; max-width: 1340px; margin: 0 auto; padding: 0 12px 48px; color: CanvasText; background: Canvas; }
h1, h2 { line-height: 1.2; }
p, dl { max-width: 46em; }
dt { font-weight: bold; }
dd { margin: 0 0 .4em 1em; }
.figures { display: flex; flex-wrap: wrap; gap: 12px; }
figure { margin: 0; flex: 1 1 min(460px, 100%); max-width: 652px; }
figure svg { width: 100%; height: auto; display: block; border: 1px solid #9999; border-radius: 4px; }
.about { display: flex; gap: 16px; align-items: center; }
.about p { flex: 1 1 auto; }
.scene { flex: 0 0 auto; width: min(200px, 40%); height: auto; }
ul.summary { max-width: 46em; padding-left: 1.2em; }
ul.summary li { margin-bottom: .4em; }
summary { font-weight: bold; cursor: pointer; }
.table { overflow-x: auto; margin: 12px 0; }
table { border-collapse: collapse; font-size: 14px; font-variant-numeric: tabular-nums; }
th, td { padding: 3px 10px; text-align: right; border-bottom: 1px solid #9996; white-space: nowrap; }
th.text, td.text { text-align: left; }
td.long { white-space: normal; min-width: 12em; }
ul.contents { columns: 20em; padding-left: 1.2em; }
@media (prefers-color-scheme: dark) { figure svg [fill='#ffffff'] { fill: #161616; } figure svg [fill='#222222'] { fill: #e6e6e6; } figure svg [fill='#666666'] { fill: #aaaaaa; } figure svg [stroke='#666666'] { stroke: #999999; } figure svg [fill='#dddddd'] { fill: #3a3a3a; } figure svg [stroke='#dddddd'] { stroke: #3a3a3a; } figure svg :is(path, polyline) { filter: brightness(1.5); } }
@media print { body { max-width: none; font-size: 10pt; } .figures { display: block; } figure { break-inside: avoid; display: inline-block; width: 48%; margin-bottom: 8px; } h2 { break-after: avoid; } .table { overflow: visible; } table { font-size: 7pt; } }
</style>
</head>
<body>
"#;

const TERMS: &str = "<details>
<summary>How to read the figures</summary>
<dl>
<dt>Better is to the left and below</dt>
<dd>Each curve runs over meshes, from coarse to fine; each point is one scene on one mesh. Names such as n16 stand for 16 cells an edge, l3 for the third of the Gmsh meshes.</dd>
<dt>Time</dt>
<dd>From the accepted load step to its result, in a fresh process with nothing prepared: assembly, set-up and solution, without reading the mesh. Each point is the median of its runs. A1m includes the integrals of its loads; the norms of its error, which nobody needs to solve a problem, are taken after the time that is drawn (the table has their seconds apart), for other solvers too.</dd>
<dt>Memory</dt>
<dd>The largest resident memory of the whole process, mesh file included.</dd>
<dt>Relative error</dt>
<dd>A1m has an exact solution: the L2 norm of the error (or of its gradient: H1) divided by that of the exact field. The other scenes are compared with a limit, extrapolated from their meshes; the shaded band is the uncertainty of that limit, and hollow points in it prove no more than that.</dd>
<dt>Tolerance</dt>
<dd>The algebraic residuals at which the solver stops. Where two tolerances give the same error, the looser one is the better bargain.</dd>
<dt>Applications</dt>
<dd>How often the preconditioner of the displacement is applied, nested iterations included: what methods are compared by, since their iterations differ in cost.</dd>
<dt>Tables of the questions</dt>
<dd>On equal meshes: seconds over those of the first choice, which is what the plan takes by itself. At equal error: seconds interpolated along the curve of each choice, at the smallest error that two of them reach; ≤ where the coarsest mesh is below that error already. Over tolerances: seconds and errors over those of the tightest.</dd>
<dt>Tables of other solvers</dt>
<dd>The error is that of the first figure of the scene. Without friction the discrete problems are the same, but for GetFEM; with friction each has its own.</dd>
<dt>Crosses</dt>
<dd>Failures, at the time they took; at the upper edge where there is no result at all.</dd>
</dl>
</details>
";

/// What the page shows beside the rows.
#[derive(Debug)]
pub(crate) struct Report {
    pub(crate) chapters: Vec<Chapter>,
    pub(crate) inquiries: Vec<Inquiry>,
    pub(crate) left_out: Vec<LeftOut>,
    /// Wall minutes of the whole bench.
    pub(crate) minutes: f64,
}

impl Report {
    /// All pictures.
    pub(crate) fn figures(&self) -> impl Iterator<Item = &Figure> {
        let chapters = self.chapters.iter().flat_map(|chapter| &chapter.figures);
        let inquiries = self.inquiries.iter().flat_map(|one| &one.figures);
        chapters.chain(inquiries)
    }
}

/// The page.
pub(crate) fn html(results: &Results, report: &Report) -> String {
    let mut page = String::from(HEAD);
    page.push_str("<h1>Signorini: error against run time</h1>\n");
    let machine = results.machine.line(&results.instruction_sets());
    let runs: usize = results.rows.iter().map(|row| row.repeats).sum();
    let runs = runs + results.findings.len();
    page.push_str(&format!(
        "<p>{}. {runs} runs, {:.1} min.</p>\n",
        escaped(&machine),
        report.minutes
    ));
    page.push_str(&summary::html(results, &report.chapters));
    page.push_str(&contents(results, report));
    if !results.rows.is_empty() {
        page.push_str(TERMS);
    }
    for Chapter { family, figures } in &report.chapters {
        page.push_str(&heading(family.name));
        page.push_str(&format!(
            "<div class=\"about\">{}<p>{}</p></div>\n",
            pictures::html(family.name),
            escaped(family.about)
        ));
        page.push_str(&body(&versus::table(results, family), figures));
    }
    for one in &report.inquiries {
        let about = format!("{} {}", one.study.about, one.remark);
        let title = one.study.question;
        page.push_str(&match one.study.measure == Measure::Extremes {
            // So many lines would hide the figure.
            true => section(title, &about, &Table::new([]), &one.figures) + &one.answer.html(),
            false => section(title, &about, &one.answer, &one.figures),
        });
    }
    if !results.rows.is_empty() {
        page.push_str(&seeds(results));
        page.push_str(&failures(results, &report.left_out));
        page.push_str(&numbers(&results.rows));
    }
    let shipped = if results.findings.is_empty() {
        Vec::new()
    } else {
        extremes::peers_about()
    };
    page.push_str(&about_peers(
        &[results.peers.about.clone(), shipped].concat(),
    ));
    page.push_str("</body>\n</html>\n");
    page
}

/// Links to the parts of the page.
fn contents(results: &Results, report: &Report) -> String {
    let chapters = report.chapters.iter().map(|chapter| chapter.family.name);
    let studies = report.inquiries.iter().map(|one| one.study.question);
    let last = [SEED, FAILURES, NUMBERS].into_iter();
    let last = last.filter(|_| !results.rows.is_empty());
    let links = chapters.chain(studies).chain(last).map(|title| {
        format!(
            "<li><a href=\"#{}\">{}</a></li>\n",
            anchor(title),
            escaped(title)
        )
    });
    format!(
        "<ul class=\"contents\">\n{}</ul>\n",
        links.collect::<String>()
    )
}

const SEED: &str = "The experiments that the method comes from";
const FAILURES: &str = "Failures and what was left out";
const NUMBERS: &str = "All numbers";

/// Letters and digits of a title, joined by hyphens.
fn anchor(title: &str) -> String {
    let words = title.split(|c: char| !c.is_ascii_alphanumeric());
    let words: Vec<&str> = words.filter(|word| !word.is_empty()).collect();
    words.join("-").to_lowercase()
}

fn heading(title: &str) -> String {
    format!("<h2 id=\"{}\">{}</h2>\n", anchor(title), escaped(title))
}

/// A title, what it is about, what follows from the rows, and the figures.
fn section(title: &str, about: &str, table: &Table, figures: &[Figure]) -> String {
    let about = format!("<p>{}</p>\n", escaped(about));
    heading(title) + &about + &body(table, figures)
}

fn body(table: &Table, figures: &[Figure]) -> String {
    let mut text = table.html();
    text.push_str("<div class=\"figures\">\n");
    for Figure { name, svg } in figures {
        text.push_str(&format!(
            "<figure id=\"{}\">{svg}</figure>\n",
            escaped(name)
        ));
    }
    text.push_str("</div>\n");
    text
}

/// The tables of the seed beside ours.
fn seeds(results: &Results) -> String {
    heading(SEED) + ABOUT_SEED + &seed::table(results).html()
}

const ABOUT_SEED: &str = "<p>M. Fortin and A. El Maliki, A hierarchical preconditioner for Stokes and connected problems, slides of 23 October 2007. Their meshes, tolerance and machine are not told in full: steps can be compared with care, seconds only as an order of magnitude. Here the tolerance is 1e-8.</p>\n";

fn about_peers(lines: &[String]) -> String {
    if lines.is_empty() {
        return String::new();
    }
    let lines: Vec<String> = lines.iter().map(escaped).collect();
    format!(
        "<h2>About the other solvers</h2>\n<p>Their numbers come from files that say about themselves:</p>\n<p>{}</p>\n",
        lines.join("<br>\n")
    )
}

fn failures(results: &Results, left_out: &[LeftOut]) -> String {
    let columns = [
        Column::Text("case"),
        Column::Long("what happened"),
        Column::Number("seconds"),
    ];
    let rows = results.rows.iter();
    let failed = rows.filter(|row| !row.converged()).map(|row| {
        let seconds = format!("{:.2}", row.numbers.seconds);
        [row.case.name(), row.outcome.to_string(), seconds]
    });
    let is_measured = |scene: &str| {
        let mut rows = results.rows.iter();
        rows.any(|row| row.case.family.name == scene)
    };
    let others = results.peers.rows.iter();
    let others = others.filter(|peer| is_measured(&peer.scene));
    let others = others.filter_map(|peer| {
        let reason = peer.failure.clone()?;
        let case = format!("{} {}, {}", peer.scene, peer.level, peer.solver);
        Some([case, reason, format!("{:.2}", peer.seconds)])
    });
    let left_out = left_out.iter().cloned();
    let left_out = left_out.map(|(case, reason)| [case, reason, "–".to_owned()]);
    let table = Table::new(columns).with(failed.chain(others).chain(left_out));
    let text = if table.is_empty() {
        "<p>None: every case met its tolerance.</p>\n".to_owned()
    } else {
        table.html()
    };
    heading(FAILURES) + &text
}

fn numbers(rows: &[Row]) -> String {
    let columns = [
        Column::Text("scene"),
        Column::Text("mesh"),
        Column::Text("method"),
        Column::Number("tolerance"),
        Column::Number("unknowns"),
        Column::Number("iterations"),
        Column::Number("seconds, median"),
        Column::Number("least"),
        Column::Number("most"),
        Column::Number("runs"),
        Column::Number("peak MB"),
        Column::Long("relative errors"),
    ];
    heading(NUMBERS) + &Table::new(columns).with(rows.iter().map(number_row)).html()
}

fn number_row(row: &Row) -> [String; 12] {
    let memory = row.peak_memory_mb();
    let error =
        |error: &(Quantity, f64)| format!("{} {:.2e}", error.0.name().replace('_', " "), error.1);
    let errors: Vec<String> = row.errors.iter().map(error).collect();
    [
        row.case.family.name.to_owned(),
        row.case.level.to_string(),
        row.case.method.to_string(),
        format!("{:e}", row.case.tolerance),
        row.unknowns().to_string(),
        row.numbers.iterations.to_string(),
        format!("{:.3}", row.numbers.seconds),
        format!("{:.3}", row.least_seconds),
        format!("{:.3}", row.most_seconds),
        row.repeats.to_string(),
        memory.map_or_else(|| "–".to_owned(), |memory| format!("{memory:.0}")),
        errors.join(", "),
    ]
}
