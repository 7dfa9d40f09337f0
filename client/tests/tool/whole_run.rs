//! What is told of a run as a whole: the names of its units, and doubts about all increments.

use crate::common::{Run, example, folder, run};

fn solve(more: &[&str]) -> Run {
    let scene = example("hertz-sphere.toml");
    let mesh = example("meshes/indent_l1.msh");
    let mesh = format!("mesh={:?}", mesh.to_str().unwrap());
    let arguments = ["solve", scene.to_str().unwrap(), "--json", "--set", &mesh];
    let run = run(arguments.into_iter().chain(more.iter().copied()));
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    run
}

#[test]
fn the_names_of_units_stand_in_files_lines_and_page() {
    let out = folder("units_of_files");
    let units = "units={ length = \"mm\", force = \"N\", stress = \"N/mm\u{b2}\" }";
    let run = solve(&["--set", units, "--out", out.to_str().unwrap()]);
    let plan = run.events("plan").pop().unwrap();
    assert_eq!(plan["units"]["stress"], "N/mm\u{b2}");
    let body = std::fs::read(out.join("hertz-sphere_0001.vtu")).unwrap();
    let body = String::from_utf8_lossy(&body);
    for (array, unit) in [
        ("Points", "mm"),
        ("displacement", "mm"),
        ("pressure", "N/mm\u{b2}"),
        ("contact_pressure", "N/mm\u{b2}"),
    ] {
        let (_, rest) = body.split_once(&format!("Name=\"{array}\"")).unwrap();
        let line = rest.lines().next().unwrap();
        let label =
            format!("<InformationKey name=\"UNITS_LABEL\" location=\"vtkDataArray\">{unit}<");
        assert!(line.contains(&label), "{array}: {line}");
    }
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("\"units\":{\"length\":\"mm\",\"force\":\"N\""));
    assert!(page.contains("\"name\":\"contact_pressure\""), "no picture");
}

#[test]
fn a_tool_that_goes_the_wrong_way_is_doubted_in_summary_and_table() {
    let away = ["--set", "step.0.obstacle.ball.translation=[0, 0, 0.5]"];
    let run = solve(&away);
    let summary = run.events("summary").pop().unwrap();
    let warning = summary["warnings"][0].as_str().unwrap_or_default();
    assert!(
        warning.contains("obstacle `ball` touched nothing in any increment"),
        "{summary}"
    );
    assert!(run.stderr.contains(warning), "{}", run.stderr);
    let touched = solve(&[]).events("summary").pop().unwrap();
    assert_eq!(touched["warnings"], serde_json::json!([]));
}
