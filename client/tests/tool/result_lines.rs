//! Result lines keep to their schema.

use std::collections::BTreeMap;

use crate::common::schema::{fault, result_lines};
use serde_json::{Value, json};
use signorini_client::result_line::{self, Totals};
use signorini_proto::v1;

fn report() -> v1::StepReport {
    let vector = vec![0.5, -1.0, 0.0];
    let obstacle = v1::ObstacleResult {
        force: vector.clone(),
        moment: vector.clone(),
        centre_of_pressure: vector.clone(),
        tangential_force: vector.clone(),
        contact_area: 0.25,
        contact_intervals: vec![v1::ContactInterval {
            start: vector.clone(),
            end: vector.clone(),
            width: 0.5,
            force: vector.clone(),
        }],
        ..Default::default()
    };
    let support = v1::SupportResult {
        force: vector.clone(),
        moment: vec![0.1, 0.0, 0.0],
        reference_point: vector.clone(),
        translation: vector.clone(),
        rotation: vec![0.0; 3],
    };
    let probe = v1::ProbeResult {
        displacement: vector.clone(),
        pressure: None,
    };
    v1::StepReport {
        step: 1,
        increment: 2,
        time: 0.5,
        load: 1.0,
        termination: v1::Termination::NotConverged.into(),
        cause: v1::Cause::LineSearch.into(),
        krylov_iterations: 7,
        residuals: Some(v1::Residuals {
            gap: 1e-9,
            ..Default::default()
        }),
        obstacles: BTreeMap::from([("ball".to_owned(), obstacle)]),
        supports: BTreeMap::from([("base".to_owned(), support)]),
        probes: BTreeMap::from([("pole".to_owned(), probe)]),
        errors: Some(v1::ManufacturedErrors {
            displacement_l2: 0.1,
            ..Default::default()
        }),
        seconds: Some(v1::Seconds {
            total: 1.5,
            ..Default::default()
        }),
        unknowns: Some(v1::Unknowns {
            displacement: 30,
            pressure: 4,
            contact: 0,
        }),
        obstacle_poses: vec![v1::ObstaclePose {
            name: "ball".to_owned(),
            translation: vector.clone(),
            rotation: vector,
        }],
        ..Default::default()
    }
}

fn plan() -> v1::Plan {
    let text = |text: &str| text.to_owned();
    v1::Plan {
        name: text("block"),
        kind: v1::SceneKind::PlaneStrain.into(),
        formulation: v1::Formulation::Mixed.into(),
        decisions: vec![v1::PlanEntry {
            what: text("saddle"),
            choice: text("gcr"),
            reason: text("mixed"),
        }],
        left_out: vec![v1::PlanOmission {
            what: text("friction"),
            reason: text("no obstacle has it"),
        }],
        ..Default::default()
    }
}

fn assert_matches(line: &Value) {
    assert_eq!(fault(&result_lines(), line), None, "{line}");
}

#[test]
fn every_kind_of_line_matches_the_schema() {
    let mut totals = Totals::default();
    assert_matches(&totals.summary(0.1, None, &[]));
    totals.add(&report());
    let iteration = v1::IterationStatistics {
        sequence: 1,
        report: None,
        skipped_count: 3,
    };
    for line in [
        result_line::plan(&plan(), None),
        result_line::plan(&plan(), Some(&v1::UnitNames::default())),
        result_line::iteration(&iteration),
        result_line::step(&report()),
        totals.summary(2.0, Some(1 << 20), &["nothing touched".to_owned()]),
        result_line::session("sessions/a"),
        result_line::cancel("sessions/a", 3),
        result_line::cancel("sessions/a", 0),
    ] {
        assert_matches(&line);
    }
}

/// A fluid that leaks on a path past a ball.
fn leaking() -> v1::FluidResult {
    let path = v1::LeakPath {
        margin: 3.25,
        margin_over_pressure: 0.25,
        sealed_width: 0.5,
        points: vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0],
        pressures: vec![3.25, 0.0],
    };
    v1::FluidResult {
        pressure: 3.0,
        tightness: v1::Tightness::Leaks.into(),
        blow_off_low: Some(3.0),
        blow_off_high: Some(3.03),
        wet_area: 0.5,
        force: vec![0.0, -1.0, 0.0],
        leak_path: Some(path.clone()),
        leak_paths: BTreeMap::from([("ball".to_owned(), path)]),
        rounds: 2,
        conductance: Some(0.5),
        flow_rate: Some(1.515),
    }
}

#[test]
fn fluids_are_told_with_their_paths_and_scenes_without_have_no_word_of_them() {
    let dry = result_line::step(&report());
    assert!(dry.get("fluids").is_none());
    let unknown = v1::FluidResult {
        tightness: v1::Tightness::Tight.into(),
        force: vec![0.0; 3],
        ..Default::default()
    };
    let line = result_line::step(&v1::StepReport {
        fluids: BTreeMap::from([("water".to_owned(), leaking()), ("oil".to_owned(), unknown)]),
        ..report()
    });
    assert_matches(&line);
    let water = &line["fluids"]["water"];
    assert_eq!(
        (&water["tightness"], &water["blow_off_high"]),
        (&json!("leaks"), &json!(3.03))
    );
    let points = json!([[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]]);
    assert_eq!(water["leak_paths"]["ball"]["points"], points);
    assert_eq!(water["flow_rate"], json!(1.515));
    assert_eq!(line["fluids"]["oil"]["leak_path"], Value::Null);
    assert_eq!(line["fluids"]["oil"]["conductance"], Value::Null);
}

#[test]
fn goals_are_told_with_bounds_and_derivatives_and_scenes_without_have_no_word_of_them() {
    let line = result_line::step(&report());
    assert!(line.get("goals").is_none() && line.get("goals_refused").is_none());
    let bounded = v1::GoalResult {
        value: -2.0,
        bound: Some(v1::GoalBound {
            total: 0.5,
            ..Default::default()
        }),
        ..Default::default()
    };
    let differentiated = v1::GoalResult {
        derivatives: BTreeMap::from([("material.body.c10".to_owned(), 3.5)]),
        ..Default::default()
    };
    let line = result_line::step(&v1::StepReport {
        goals: BTreeMap::from([
            ("force.ball.y".to_owned(), bounded),
            ("displacement.pole.x".to_owned(), differentiated),
        ]),
        goals_refused: Some("cancelled".to_owned()),
        ..report()
    });
    assert_matches(&line);
    assert_eq!(line["goals"]["force.ball.y"]["bound"]["total"], json!(0.5));
    let other = &line["goals"]["displacement.pole.x"];
    assert_eq!(other["derivatives"]["material.body.c10"], json!(3.5));
    assert_eq!(other["bound"], Value::Null);
}

#[test]
fn contacts_between_bodies_are_told_and_scenes_without_have_no_word_of_them() {
    assert!(result_line::step(&report()).get("contacts").is_none());
    let seat = v1::BodyContactResult {
        force: vec![0.0, 2.5, 0.0],
        moment: vec![0.0, 0.0, 0.5],
        contact_area: 0.5,
        contact_width: 0.5,
        contact_intervals: vec![v1::ContactInterval {
            start: vec![0.0; 3],
            end: vec![0.5, 0.0, 0.0],
            width: 0.5,
            force: vec![0.0, 2.5, 0.0],
        }],
        mean_pressure: Some(5.0),
        peak_pressure: 7.0,
        peak_pressure_place: vec![0.25, 0.0, 0.0],
        friction: Some(v1::BodyFriction {
            tangential_force: vec![0.5, 0.0, 0.0],
            slip_vertices: 3,
            ..Default::default()
        }),
    };
    let open = v1::BodyContactResult {
        force: vec![0.0; 3],
        moment: vec![0.0; 3],
        ..Default::default()
    };
    let line = result_line::step(&v1::StepReport {
        contacts: BTreeMap::from([("seat".to_owned(), seat), ("gap".to_owned(), open)]),
        ..report()
    });
    assert_matches(&line);
    let contacts = &line["contacts"];
    assert_eq!(
        contacts["seat"]["contact_intervals"][0]["width"],
        json!(0.5)
    );
    assert_eq!(contacts["gap"]["mean_pressure"], Value::Null);
    assert_eq!(contacts["seat"]["friction"]["slip_vertices"], json!(3));
    assert!(contacts["gap"].get("friction").is_none());
}

#[test]
fn ties_between_bodies_are_told_and_scenes_without_have_no_word_of_them() {
    assert!(result_line::step(&report()).get("ties").is_none());
    let bond = v1::TieResult {
        force: vec![0.0, 2.5, 0.0],
        moment: vec![0.0, 0.0, 0.5],
        area: 0.5,
        gap: 1e-3,
        peak_traction: 7.0,
        peak_traction_place: vec![0.25, 0.0, 0.0],
    };
    let line = result_line::step(&v1::StepReport {
        ties: BTreeMap::from([("bond".to_owned(), bond)]),
        ..report()
    });
    assert_matches(&line);
    assert_eq!(line["ties"]["bond"]["peak_traction"], json!(7.0));
}

#[test]
fn the_schema_refuses_missing_unknown_and_mistyped_keys() {
    let schema = result_lines();
    for (key, value) in [
        ("load", Value::Null),
        ("extra", json!(1)),
        ("termination", json!("done")),
    ] {
        let mut line = result_line::step(&report());
        line[key] = value;
        assert!(fault(&schema, &line).is_some(), "{key}");
    }
    let mut line = result_line::step(&report());
    line.as_object_mut().unwrap().remove("residuals");
    assert!(fault(&schema, &line).is_some());
}

#[test]
fn names_are_those_of_the_contract() {
    let line = result_line::step(&report());
    assert_eq!(
        (&line["termination"], &line["cause"]),
        (&json!("not_converged"), &json!("line_search"))
    );
    assert_eq!(line["obstacles"]["ball"]["force"], json!([0.5, -1.0, 0.0]));
    assert_eq!(line["probes"]["pole"]["pressure"], Value::Null);
    assert_eq!(result_line::plan(&plan(), None)["kind"], "plane-strain");
    let converged = v1::StepReport {
        termination: v1::Termination::Converged.into(),
        ..report()
    };
    assert_eq!(
        result_line::step(&v1::StepReport {
            cause: 0,
            ..converged
        })["cause"],
        Value::Null
    );
}

#[test]
fn every_cause_and_kind_of_equilibrium_keeps_to_the_schema() {
    let schema = result_lines();
    let causes = (0..100).filter_map(|number| v1::Cause::try_from(number).ok());
    let kinds = (0..).map_while(|number| v1::Stability::try_from(number).ok());
    let (causes, kinds): (Vec<_>, Vec<_>) = (causes.collect(), kinds.collect());
    assert!(causes.contains(&v1::Cause::NegativeJacobian) && kinds.len() == 4);
    for (cause, kind) in causes
        .iter()
        .flat_map(|c| kinds.iter().map(move |k| (c, k)))
    {
        let line = result_line::step(&v1::StepReport {
            cause: (*cause).into(),
            stability: (*kind).into(),
            min_jacobian: Some(0.7),
            min_jacobian_bound: Some(0.6),
            ..report()
        });
        assert_eq!(fault(&schema, &line), None);
        assert_eq!(line["min_jacobian_bound"], 0.6);
        let is_known = *kind != v1::Stability::Unspecified;
        assert_eq!(line["stability"].is_string(), is_known);
    }
}

#[test]
fn totals_add_up_over_increments() {
    let mut totals = Totals::default();
    totals.add(&report());
    totals.add(&report());
    let line = totals.summary(2.0, None, &[]);
    assert_eq!(line["totals"]["krylov_iterations"], 14);
    assert_eq!(line["totals"]["seconds"]["total"], 3.0);
    assert_eq!(
        (&line["totals"]["converged"], &line["termination"]),
        (&json!(0), &json!("not_converged"))
    );
}

#[test]
fn numbers_survive_printing_bit_for_bit() {
    let report = v1::StepReport {
        strain_energy: 0.1 + 0.2,
        ..report()
    };
    let text = result_line::step(&report).to_string();
    let line: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(
        line["strain_energy"].as_f64().map(f64::to_bits),
        Some((0.1_f64 + 0.2).to_bits())
    );
}

#[test]
fn the_pose_of_an_obstacle_stands_with_what_it_does() {
    let pose = v1::ObstaclePose {
        name: "ball".to_owned(),
        translation: vec![0.0, 0.0, -0.5],
        rotation: vec![0.0; 3],
    };
    let report = v1::StepReport {
        obstacles: [("ball".to_owned(), v1::ObstacleResult::default())].into(),
        obstacle_poses: vec![pose],
        ..Default::default()
    };
    let line = result_line::step(&report);
    let expected = json!({"translation": [0.0, 0.0, -0.5], "rotation": [0.0, 0.0, 0.0]});
    assert_eq!(line["obstacles"]["ball"]["pose"], expected);
    assert_eq!(line.get("poses"), None);
}

#[test]
fn the_keys_of_a_result_keep_their_order() {
    let expected = [
        r#"{"event":"step","step":0,"increment":0,"time":0.0,"load":0.0,"#,
        r#""termination":"unspecified","cause":null,"cause_site":null,"#,
        r#""snapped":null,"warnings":[],"sqp_iterations":0,"#,
        r#""krylov_iterations":0,"preconditioner_applications":0,"#,
        r#""eigenvalue_applications":0,"compliance_columns":0,"contact_products":0,"#,
        r#""active_set_changes":0,"newton_steps":0,"threshold_passes":0,"cut_backs":0,"attempts":[],"factorisations":0,"active_vertices":0,"#,
        r#""strain_energy":0.0,"volume_ratio":0.0,"min_jacobian":null,"#,
        r#""min_jacobian_bound":null,"stability":null,"penalty":0.0,"#,
        r#""max_penetration":0.0,"residuals":null,"tolerance":0.0,"obstacles":{},"#,
        r#""supports":{},"probes":{},"error_estimate":null,"errors":null,"#,
        r#""seconds":{"prepare":0.0,"assemble":0.0,"factorise":0.0,"krylov":0.0,"#,
        r#""contact":0.0,"stability":0.0,"error_norms":0.0,"total":0.0},"unknowns":{"displacement":0,"#,
        r#""pressure":0,"contact":0},"memory_bytes":0,"reused":[],"instruction_set":"","#,
        r#""verification":null,"left_out":[]}"#,
    ];
    let line = result_line::step(&v1::StepReport::default());
    assert_eq!(line.to_string(), expected.concat());
}
