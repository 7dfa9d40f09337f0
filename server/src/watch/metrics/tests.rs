use signorini::report::{
    Attempt, Cause, FluidResult, StepReport, Strategy, Termination, Tightness, Warning, WarningKind,
};
use signorini_proto::v1 as wire;

use super::*;
use crate::fault::status;

fn filled() -> Arc<Metrics> {
    let metrics = Metrics::new().unwrap();
    metrics.increment(&StepReport {
        termination: Termination::Converged,
        newton_steps: 5,
        threshold_passes: 3,
        ..StepReport::default()
    });
    metrics.step(Termination::Converged);
    metrics.cancelled(Duration::from_millis(1));
    metrics.job_started(Duration::from_millis(1));
    metrics.refused("QUEUE_FULL");
    metrics.memory(Kind::Mesh, 1);
    metrics.increment(&StepReport {
        cause: Some(Cause::Stagnation),
        attempts: vec![Attempt {
            strategy: Strategy::Part,
            cause: Some(Cause::Stagnation),
            preconditioner_applications: 7,
            followed_by: Some(Strategy::SmallerPart),
        }],
        warnings: vec![Warning {
            kind: WarningKind::LargeStrain,
            subject: String::new(),
            value: None,
            message: String::new(),
        }],
        ..StepReport::default()
    });
    metrics.iteration();
    metrics.residual(0).set(0.5);
    metrics.certificate_expiry("server", 1);
    let method = Arc::new(Method::other());
    metrics.method(&method);
    drop(metrics.call(&method));
    metrics
}

/// Lines of a page that are samples of this metric.
fn samples<'a>(page: &'a str, name: &str) -> Vec<&'a str> {
    let of = |line: &&str| {
        line.strip_prefix(name)
            .is_some_and(|rest| rest.starts_with([' ', '{']))
    };
    page.lines().filter(of).collect()
}

#[test]
fn every_histogram_has_buckets_and_every_metric_a_text() {
    let page = filled().render();
    assert!(!page.contains(" summary"), "{page}");
    for (name, ..) in HISTOGRAMS {
        assert!(page.contains(&format!("# TYPE {name} histogram")), "{name}");
    }
    for (name, _) in COUNTERS {
        assert!(page.contains(&format!("# TYPE {name} counter")), "{name}");
        assert!(name.ends_with("_total"));
    }
    for (name, _) in GAUGES {
        assert!(page.contains(&format!("# TYPE {name} gauge")), "{name}");
    }
    let count = |start| page.lines().filter(|line| line.starts_with(start)).count();
    assert_eq!(count("# HELP"), count("# TYPE"));
}

#[test]
fn every_metric_and_reason_is_in_the_manual() {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../client/manual/operations.md"
    );
    let page = std::fs::read_to_string(path).unwrap();
    let quoted: Vec<&str> = page.split('`').skip(1).step_by(2).collect();
    let metrics = (HISTOGRAMS.iter().map(|(name, ..)| *name))
        .chain(COUNTERS.iter().map(|(name, _)| *name))
        .chain(GAUGES.iter().map(|(name, _)| *name));
    let mut known: Vec<&str> = metrics.chain(status::REASONS).collect();
    #[cfg(feature = "fleet")]
    known.extend(fleet::names());
    let told = |name: &&str| quoted.contains(name);
    let missing: Vec<&&str> = known.iter().filter(|name| !told(name)).collect();
    assert!(missing.is_empty(), "{missing:?}");
    known.retain(|name| name.starts_with("signorini_"));
    // Those of a fleet are the metrics of builds with that feature.
    let is_here = |span: &str| cfg!(feature = "fleet") || !span.starts_with("signorini_fleet_");
    let is_metric =
        |span: &&&str| span.starts_with("signorini_") && !span.contains('=') && is_here(span);
    let stale: Vec<&&str> = quoted
        .iter()
        .filter(is_metric)
        .filter(|span| !known.contains(span))
        .collect();
    assert!(stale.is_empty(), "{stale:?}");
}

/// The names of an enum of the contract but its first, in small letters; numbers are reserved
/// between them.
fn words(prefix: &str, name: impl Fn(i32) -> Option<&'static str>) -> Vec<String> {
    (1..100)
        .filter_map(name)
        .map(|word| word.strip_prefix(prefix).unwrap().to_lowercase())
        .collect()
}

#[test]
fn every_word_of_the_contract_has_a_series_before_anything_happened() {
    let page = Metrics::new().unwrap().render();
    let terminations = words("TERMINATION_", |number| {
        Some(wire::Termination::try_from(number).ok()?.as_str_name())
    });
    let causes = words("CAUSE_", |number| {
        Some(wire::Cause::try_from(number).ok()?.as_str_name())
    });
    let warnings = WarningKind::ALL.map(|kind| kind.name().to_owned()).to_vec();
    let reasons = status::REASONS.map(str::to_owned).to_vec();
    assert!(terminations.len() >= 5 && causes.len() >= 13);
    for (metric, label, words) in [
        (STEPS, "termination", &terminations),
        (INCREMENTS, "termination", &terminations),
        (FAILURES, "cause", &causes),
        (WARNINGS, "kind", &warnings),
        (REFUSED, "reason", &reasons),
    ] {
        for word in words {
            let series = format!("{metric}{{{label}=\"{word}\"}} 0");
            assert!(page.contains(&series), "{series} is missing:\n{page}");
        }
        assert_eq!(samples(&page, metric).len(), words.len(), "{metric}");
    }
}

#[test]
fn every_fluid_that_leaks_is_counted_and_tight_ones_are_not() {
    let metrics = Metrics::new().unwrap();
    let fluid = |tightness| FluidResult {
        tightness,
        ..FluidResult::default()
    };
    let named = [
        ("water", Tightness::Leaks),
        ("oil", Tightness::Tight),
        ("air", Tightness::Leaks),
    ];
    let fluids = named.map(|(name, tightness)| (name.to_owned(), fluid(tightness)));
    metrics.increment(&StepReport {
        fluids: fluids.into(),
        ..StepReport::default()
    });
    assert_eq!(
        samples(&metrics.render(), LEAKS),
        ["signorini_leaks_total 2"]
    );
}

#[test]
fn nothing_happens_first_and_then_only_values_change() {
    let names = |page: &str| -> Vec<String> {
        let series = |line: &str| Some(line.rsplit_once(' ')?.0.to_owned());
        let mut all: Vec<_> = page
            .lines()
            .filter(|line| !line.starts_with('#'))
            .filter_map(series)
            .collect();
        all.sort();
        all
    };
    let before = names(&Metrics::new().unwrap().render());
    let after = names(&filled().render());
    // A test calls no method, and has no slot and no certificate before.
    let later = ["grpc_", RESIDUAL, CERTIFICATE_EXPIRY];
    let fixed = |name: &&String| !later.iter().any(|start| name.starts_with(start));
    let after: Vec<_> = after.iter().filter(fixed).collect();
    assert_eq!(before.iter().collect::<Vec<_>>(), after);
}

#[test]
fn a_call_without_an_answer_counts_as_cancelled() {
    let page = filled().render();
    let lines = samples(&page, CALLS_HANDLED);
    assert_eq!(lines.len(), 17);
    let counted: Vec<_> = lines.iter().filter(|line| !line.ends_with(" 0")).collect();
    assert_eq!(counted.len(), 1);
    assert!(counted[0].contains("grpc_code=\"Canceled\""), "{counted:?}");
}

#[test]
fn the_process_is_measured() {
    let page = filled().render();
    for name in [
        "process_resident_memory_bytes",
        "process_cpu_seconds_total",
        "process_open_fds",
        "process_start_time_seconds",
    ] {
        let line = samples(&page, name);
        assert_eq!(line.len(), 1, "{name}:\n{page}");
    }
    assert!(!samples(&page, "process_resident_memory_bytes")[0].ends_with(" 0"));
}

#[test]
fn two_servers_of_one_process_do_not_mix() {
    let (first, second) = (filled(), Metrics::new().unwrap());
    assert!(first.render().contains("signorini_iterations_total 1"));
    assert!(second.render().contains("signorini_iterations_total 0"));
}
