use std::collections::BTreeMap;

use super::*;

fn report() -> v1::StepReport {
    let obstacle = v1::ObstacleResult {
        force: vec![0.0, 0.0, -0.0177],
        force_error: Some(4e-5),
        contact_area: 0.0375,
        max_pressure: 0.6,
        ..Default::default()
    };
    let pose = v1::ObstaclePose {
        name: "ball".to_owned(),
        translation: vec![0.0, 0.0, -0.05],
        ..Default::default()
    };
    v1::StepReport {
        step: 1,
        increment: 2,
        termination: v1::Termination::NotConverged.into(),
        cause: v1::Cause::LineSearch.into(),
        error_estimate: Some(0.0442),
        obstacles: BTreeMap::from([("ball".to_owned(), obstacle)]),
        obstacle_poses: vec![pose],
        ..Default::default()
    }
}

fn omission() -> v1::Plan {
    let (what, reason) = ("friction".to_owned(), "no obstacle has it".to_owned());
    let left_out = vec![v1::PlanOmission { what, reason }];
    v1::Plan {
        name: "block".to_owned(),
        left_out,
        ..Default::default()
    }
}

fn travels(report: &v1::StepReport) -> Travels {
    let mut travels = Travels::default();
    travels.see(report);
    travels
}

fn told(reports: &[v1::StepReport], detail: Detail) -> String {
    let travels = reports.first().map(travels).unwrap_or_default();
    results(&omission(), reports, &travels, detail)
}

#[test]
fn the_result_names_force_area_pressure_error_and_cause() {
    let text = told(&[report()], Detail::Short);
    for part in [
        "not_converged (line_search): step 1, increment 2",
        "why                no motion came nearer to an equilibrium",
        "obstacle ball      force 0.017700 ± 0.000040 along its travel, of 0.05 so far: (0, 0, -0.0177)",
        "                   contact area 0.0375, pressure 0.6 at most",
        "error estimate     4.4 % of the deformation",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
}

#[test]
fn the_words_of_the_solver_are_for_those_who_ask() {
    let (short, full) = (
        told(&[report()], Detail::Short),
        told(&[report()], Detail::Full),
    );
    for word in ["SQP", "Krylov", "left out", "unknowns", "preconditioner"] {
        assert!(!short.contains(word), "{word}\n{short}");
        assert!(full.contains(word), "{word}\n{full}");
    }
}

#[test]
fn finite_strain_says_how_far_cells_are_from_turning_inside_out() {
    let mut report = report();
    assert!(!told(&[report.clone()], Detail::Short).contains("det F"));
    report.min_jacobian = Some(0.9);
    report.min_jacobian_bound = Some(0.85);
    report.stability = v1::Stability::Minimum.into();
    let obstacle = report.obstacles.get_mut("ball").unwrap();
    obstacle.max_pressure_undeformed = Some(0.55);
    let text = told(&[report.clone()], Detail::Short);
    for part in [
        "det F              0.9 at least, nowhere below 0.85",
        "last equilibrium   minimum of the energy",
        "pressure 0.6 (0.55 per undeformed area) at most",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    report.termination = v1::Termination::Converged.into();
    let text = told(&[report], Detail::Short);
    assert!(text.contains("\nequilibrium        minimum"), "{text}");
}

#[test]
fn a_fluid_is_told_to_be_tight_or_between_which_pressures_it_leaks() {
    let mut report = report();
    assert!(!told(&[report.clone()], Detail::Short).contains("fluid"));
    let water = v1::FluidResult {
        pressure: 2.0,
        tightness: v1::Tightness::Tight.into(),
        wet_area: 0.5,
        force: vec![0.0, -1.0, 0.0],
        leak_path: Some(v1::LeakPath {
            margin: 3.5,
            margin_over_pressure: 1.5,
            sealed_width: 0.25,
            ..Default::default()
        }),
        rounds: 3,
        ..Default::default()
    };
    report.fluids = BTreeMap::from([("water".to_owned(), water)]);
    let text = told(&[report.clone()], Detail::Short);
    for part in [
        "fluid water        tight at pressure 2\n",
        "margin 3.5, 1.5 above its pressure, which contact exceeds over a width of 0.25",
        "wet area 0.5, force (0, -1, 0), its front found in 3 rounds",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    let water = report.fluids.get_mut("water").unwrap();
    water.tightness = v1::Tightness::Leaks.into();
    (water.blow_off_low, water.blow_off_high) = (Some(2.0), Some(2.02));
    (water.conductance, water.flow_rate) = (Some(0.5), Some(1.01));
    let text = told(&[report.clone()], Detail::Short);
    let said = "fluid water        leaks between pressures 2 and 2.02";
    assert!(text.contains(said), "{text}");
    let flow = "flow rate 1.01, 0.5 for a unit of pressure";
    assert!(text.contains(flow), "{text}");
    let row = Rows::default().row(&report, &Travels::default());
    assert!(
        row.contains("water leaks between pressures 2 and 2.02"),
        "{row}"
    );
}

#[test]
fn contact_says_how_far_it_extends_and_where_it_presses_most() {
    let mut report = report();
    assert!(!told(&[report.clone()], Detail::Short).contains("deformed area"));
    let obstacle = report.obstacles.get_mut("ball").unwrap();
    obstacle.deformed_contact_area = 0.04;
    obstacle.mean_pressure = Some(0.44);
    obstacle.peak_pressure = 0.61;
    obstacle.peak_pressure_place = vec![0.5, 0.0, 1.0];
    let text = told(&[report.clone()], Detail::Short);
    let said = "deformed area 0.04, mean pressure 0.44, peak 0.61 at (0.5, 0, 1)";
    assert!(text.contains(said), "{text}");
    let obstacle = report.obstacles.get_mut("ball").unwrap();
    obstacle.contact_width = Some(0.04);
    obstacle.contact_intervals = vec![v1::ContactInterval::default(); 2];
    let text = told(&[report], Detail::Short);
    assert!(
        text.contains("0.04, width 0.04 in 2 intervals, mean"),
        "{text}"
    );
}

#[test]
fn warnings_of_all_increments_are_told_once() {
    let warned = |increment: i32, kinds: &[&str]| v1::StepReport {
        increment,
        warnings: kinds
            .iter()
            .map(|&kind| v1::Warning {
                kind: kind.to_owned(),
                message: format!("it {kind}"),
                ..Default::default()
            })
            .collect(),
        ..report()
    };
    let reports = [
        warned(1, &["snapped"]),
        warned(2, &["snapped", "large_strain"]),
        warned(3, &["large_strain"]),
    ];
    let text = told(&reports, Detail::Short);
    let told: Vec<&str> = text.lines().filter(|l| l.starts_with("warning")).collect();
    let expected = [
        "warning            it large_strain",
        "warning            step 1, increment 1: it snapped",
    ];
    assert_eq!(told, expected, "{text}");
}

#[test]
fn every_increment_has_a_row_with_the_signed_force_and_what_is_unusual() {
    let (mut rows, report) = (Rows::default(), report());
    let travels = travels(&report);
    let first = rows.row(&report, &travels);
    let [legend, _, header, row] = first.lines().collect::<Vec<_>>().try_into().unwrap();
    assert!(legend.contains("along its motion; |NAME|: magnitude"));
    assert_eq!(
        header,
        "step incr                  ball    error touching  seconds"
    );
    assert_eq!(
        row,
        "   1    2   0.017700 ± 0.000040    4.4 %        0    0.000  not converged, line search"
    );
    let resting = Rows::default().row(&report, &Travels::default());
    assert!(
        resting.contains("                |ball|    error"),
        "{resting}"
    );
    let second = rows.row(&report, &travels);
    assert_eq!(second.trim_end(), row);
}

#[test]
fn names_cannot_break_a_row() {
    let mut report = report();
    let obstacle = report.obstacles.remove("ball").unwrap();
    let name = "b\u{1b}[2J\nall".to_owned();
    report.obstacles.insert(name, obstacle);
    let text = Rows::default().row(&report, &Travels::default());
    assert_eq!(text.lines().count(), 4, "{text}");
    assert!(!text.contains('\u{1b}'));
    let told = told(&[report], Detail::Full);
    assert!(
        !told.contains('\u{1b}') && told.contains("b\\u{1b}[2J\\nall"),
        "{told}"
    );
}

#[test]
fn an_obstacle_that_never_touches_is_told_and_one_that_does_later_is_not_doubted() {
    let open = |mut report: v1::StepReport| {
        report.obstacles.get_mut("ball").unwrap().contact_area = 0.0;
        report.warnings = vec![v1::Warning {
            kind: UNTOUCHED.to_owned(),
            subject: "ball".to_owned(),
            message: "it waits".to_owned(),
            ..Default::default()
        }];
        report
    };
    let away = v1::StepReport {
        warnings: Vec::new(),
        ..open(report())
    };
    let text = told(&[away], Detail::Short);
    assert!(text.contains("`ball` touched nothing in any"), "{text}");
    let text = told(&[open(report()), report()], Detail::Short);
    assert!(!text.contains("warning"), "{text}");
    let text = told(&[open(report())], Detail::Short);
    assert_eq!(text.matches("warning").count(), 1, "{text}");
}

#[test]
fn supports_that_move_have_a_column_where_there_is_no_obstacle() {
    let support = v1::SupportResult {
        force: vec![3.0, 4.0, 0.0],
        ..Default::default()
    };
    let report = v1::StepReport {
        obstacles: BTreeMap::new(),
        error_estimate: None,
        supports: BTreeMap::from([("pin".to_owned(), support)]),
        ..report()
    };
    let target = v1::SupportTarget {
        name: "pin".to_owned(),
        translation: vec![0.0, 2.0, 0.0],
        ..Default::default()
    };
    let step = v1::LoadStep {
        supports: vec![target],
        ..Default::default()
    };
    let text = Rows::default().row(&report, &Travels::of(&[step]));
    let [_, header, row] = text.lines().collect::<Vec<_>>().try_into().unwrap();
    assert_eq!(header, "step incr           pin  seconds");
    assert!(row.starts_with("   1    2             4    0.000"), "{row}");
}
