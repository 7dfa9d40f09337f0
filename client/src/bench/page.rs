//! One self-contained page: what was measured, figures, failures, all numbers.

use super::chart::escaped;
use super::figures::{Chapter, Figure, Results};
use super::row::Row;
use super::study_figures::Inquiry;
use super::{seed, versus};

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
.table { overflow-x: auto; }
table { border-collapse: collapse; font-size: 14px; font-variant-numeric: tabular-nums; }
th, td { padding: 3px 10px; text-align: right; border-bottom: 1px solid #9996; white-space: nowrap; }
th.text, td.text { text-align: left; }
td.long { white-space: normal; min-width: 18em; }
p.told { border-left: 3px solid #0072b2; padding-left: .8em; }
ul.contents { columns: 20em; padding-left: 1.2em; }
@media print { body { max-width: none; font-size: 10pt; } .figures { display: block; } figure { break-inside: avoid; display: inline-block; width: 48%; margin-bottom: 8px; } h2 { break-after: avoid; } .table { overflow: visible; } table { font-size: 7pt; } }
</style>
</head>
<body>
"#;

const TERMS: &str = "<h2>How to read the figures</h2>
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
<dt>Crosses</dt>
<dd>Failures, at the time they took; at the upper edge where there is no result at all.</dd>
</dl>
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
    page.push_str(&format!(
        "<p>{}. {runs} runs, {:.1} min.</p>\n",
        escaped(&machine),
        report.minutes
    ));
    page.push_str(&contents(report));
    page.push_str(TERMS);
    for chapter in &report.chapters {
        let told = versus::sentences(results, chapter.family);
        page.push_str(&section(
            chapter.family.name,
            &[chapter.family.about.to_owned()],
            &told,
            &chapter.figures,
        ));
    }
    for one in &report.inquiries {
        let about = [one.study.about.to_owned()];
        page.push_str(&section(
            one.study.question,
            &about,
            &one.answers,
            &one.figures,
        ));
    }
    page.push_str(&seeds(results));
    page.push_str(&failures(&results.rows, &report.left_out));
    page.push_str(&numbers(&results.rows));
    page.push_str(&about_peers(&results.peers.about));
    page.push_str("</body>\n</html>\n");
    page
}

/// Links to the parts of the page.
fn contents(report: &Report) -> String {
    let chapters = report.chapters.iter().map(|chapter| chapter.family.name);
    let studies = report.inquiries.iter().map(|one| one.study.question);
    let last = [SEED, FAILURES, NUMBERS];
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
fn section(title: &str, about: &[String], told: &[String], figures: &[Figure]) -> String {
    let mut text = heading(title);
    for line in about {
        text.push_str(&format!("<p>{}</p>\n", escaped(line)));
    }
    for line in told {
        text.push_str(&format!("<p class=\"told\">{}</p>\n", escaped(line)));
    }
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
    let mut text = heading(SEED);
    text.push_str("<p>M. Fortin and A. El Maliki, A hierarchical preconditioner for Stokes and connected problems, slides of 23 October 2007. Their meshes, tolerance and machine are not told in full: steps can be compared with care, seconds only as an order of magnitude. Here the tolerance is 1e-8.</p>\n<div class=\"table\"><table>\n<tr>");
    for title in seed::TITLES {
        text.push_str(&format!("<th class=\"text\">{title}</th>"));
    }
    text.push_str("</tr>\n");
    for line in seed::lines(results) {
        text.push_str("<tr>");
        for cell in &line.cells {
            text.push_str(&format!("<td class=\"text\">{}</td>", escaped(cell)));
        }
        text.push_str("</tr>\n");
    }
    text.push_str("</table></div>\n");
    text
}

fn about_peers(lines: &[String]) -> String {
    if lines.is_empty() {
        return String::new();
    }
    let lines: Vec<String> = lines.iter().map(escaped).collect();
    format!(
        "<h2>About the other solvers</h2>\n<p>The dashed curves come from a file that says about itself:</p>\n<p>{}</p>\n",
        lines.join("<br>\n")
    )
}

fn failures(rows: &[Row], left_out: &[LeftOut]) -> String {
    let mut text = heading(FAILURES);
    let failed: Vec<&Row> = rows.iter().filter(|row| !row.converged()).collect();
    if failed.is_empty() && left_out.is_empty() {
        text.push_str("<p>None: every case met its tolerance.</p>\n");
        return text;
    }
    text.push_str("<div class=\"table\"><table>\n<tr><th class=\"text\">case</th><th class=\"text\">what happened</th><th>seconds</th></tr>\n");
    for row in failed {
        let seconds = format!("{:.2}", row.numbers.seconds);
        text.push_str(&failure(
            &row.case.name(),
            &row.outcome.to_string(),
            &seconds,
        ));
    }
    for (case, reason) in left_out {
        text.push_str(&failure(case, reason, "–"));
    }
    text.push_str("</table></div>\n");
    text
}

fn failure(case: &str, what: &str, seconds: &str) -> String {
    format!(
        "<tr><td class=\"text\">{}</td><td class=\"text long\">{}</td><td>{seconds}</td></tr>\n",
        escaped(case),
        escaped(what)
    )
}

fn numbers(rows: &[Row]) -> String {
    let mut text = heading(NUMBERS);
    text.push_str(
        "<div class=\"table\"><table>\n<tr><th class=\"text\">scene</th>\
         <th class=\"text\">mesh</th><th class=\"text\">method</th><th>tolerance</th><th>unknowns</th>\
         <th>iterations</th><th>seconds, median</th><th>least</th><th>runs</th><th>peak MB</th>\
         <th class=\"text\">relative errors</th></tr>\n",
    );
    for row in rows {
        text.push_str(&number_row(row));
    }
    text.push_str("</table></div>\n");
    text
}

fn number_row(row: &Row) -> String {
    let memory = row.peak_memory_mb();
    let memory = memory.map_or_else(|| "–".to_owned(), |memory| format!("{memory:.0}"));
    let error = |error: &(super::family::Quantity, f64)| {
        format!("{} {:.2e}", error.0.name().replace('_', " "), error.1)
    };
    let errors: Vec<String> = row.errors.iter().map(error).collect();
    format!(
        "<tr><td class=\"text\">{}</td><td class=\"text\">{}</td><td class=\"text\">{}</td><td>{:e}</td>\
         <td>{}</td><td>{}</td><td>{:.3}</td><td>{:.3}</td><td>{}</td><td>{memory}</td><td class=\"text long\">{}</td></tr>\n",
        escaped(row.case.family.name),
        row.case.level,
        escaped(&row.case.method),
        row.case.tolerance,
        row.unknowns(),
        row.numbers.iterations,
        row.numbers.seconds,
        row.least_seconds,
        row.repeats,
        escaped(&errors.join(", ")),
    )
}
