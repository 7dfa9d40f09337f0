//! One self-contained page: what was measured, figures, failures, all numbers.

use super::chart::escaped;
use super::figures::{Chapter, Results};
use super::row::Row;

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
</style>
</head>
<body>
"#;

const TERMS: &str = "<h2>How to read the figures</h2>
<dl>
<dt>Better is to the left and below</dt>
<dd>Each curve runs over meshes, from coarse to fine; each point is one scene on one mesh. Names such as n16 stand for 16 cells an edge, l3 for the third of the Gmsh meshes.</dd>
<dt>Time</dt>
<dd>From the accepted load step to its result, in a fresh process with nothing prepared: assembly, set-up and solution, without reading the mesh. Each point is the median of its runs. A1m includes the loads and error norms of its exact solution.</dd>
<dt>Memory</dt>
<dd>The largest resident memory of the whole process, mesh file included.</dd>
<dt>Relative error</dt>
<dd>A1m has an exact solution: the L2 norm of the error (or of its gradient: H1) divided by that of the exact field. The other scenes are compared with a limit, extrapolated from their meshes; the dotted line is the uncertainty of that limit, and hollow points below it prove no more than that.</dd>
<dt>Tolerance</dt>
<dd>The algebraic residuals at which the solver stops. Where two tolerances give the same error, the looser one is the better bargain.</dd>
<dt>Crosses</dt>
<dd>Failures, at the time they took; at the upper edge where there is no result at all.</dd>
</dl>
";

/// The page.
pub(crate) fn html(results: &Results, chapters: &[Chapter], left_out: &[LeftOut]) -> String {
    let mut page = String::from(HEAD);
    page.push_str("<h1>Signorini: error against run time</h1>\n");
    let machine = results.machine.line(&results.instruction_sets());
    page.push_str(&format!("<p>{}</p>\n", escaped(&machine)));
    page.push_str(TERMS);
    for chapter in chapters {
        page.push_str(&section(chapter));
    }
    page.push_str(&failures(&results.rows, left_out));
    page.push_str(&numbers(&results.rows));
    page.push_str(&about_peers(&results.peers.about));
    page.push_str("</body>\n</html>\n");
    page
}

fn section(chapter: &Chapter) -> String {
    let family = chapter.family;
    let mut text = format!(
        "<h2>{}</h2>\n<p>{}</p>\n<div class=\"figures\">\n",
        escaped(family.name),
        escaped(family.about)
    );
    for figure in &chapter.figures {
        text.push_str(&format!(
            "<figure id=\"{}\">{}</figure>\n",
            escaped(&figure.name),
            figure.svg
        ));
    }
    text.push_str("</div>\n");
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
    let mut text = String::from("<h2>Failures and what was left out</h2>\n");
    let failed: Vec<&Row> = rows.iter().filter(|row| !row.converged()).collect();
    if failed.is_empty() && left_out.is_empty() {
        text.push_str("<p>None: every case met its tolerance.</p>\n");
        return text;
    }
    text.push_str("<div class=\"table\"><table>\n<tr><th class=\"text\">case</th><th class=\"text\">what happened</th><th>seconds</th></tr>\n");
    for row in failed {
        let what = format!(
            "{} {}",
            row.outcome.word().replace('_', " "),
            row.outcome.detail()
        );
        let seconds = format!("{:.2}", row.numbers.seconds);
        text.push_str(&failure(&row.case.name(), what.trim(), &seconds));
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
    let mut text = String::from(
        "<h2>All numbers</h2>\n<div class=\"table\"><table>\n<tr><th class=\"text\">scene</th>\
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
