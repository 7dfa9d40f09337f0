//! A finer mesh and the constants of a law for a scene, from the command line.
#![cfg(feature = "embedded")]

use std::path::Path;

use serde_json::Value;

use crate::common::{Run, example, folder, run};

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn assert_done(run: &Run) {
    assert_eq!(run.code, Some(0), "{}", run.stderr);
}

/// Force of the floor and cells of a scene on a mesh.
fn force(scene: &Path, mesh: &Path) -> f64 {
    let set = format!("mesh={}", text(mesh));
    let run = run(["solve", text(scene), "--set", &set, "--json", "--quiet"]);
    assert_done(&run);
    let steps = run.events("step");
    let obstacles = steps.last().unwrap()["obstacles"].as_object().unwrap();
    let force = &obstacles.values().next().unwrap()["force"];
    let square = force
        .as_array()
        .unwrap()
        .iter()
        .map(|f| f.as_f64().unwrap().powi(2));
    square.sum::<f64>().sqrt()
}

#[test]
fn a_refined_mesh_has_the_groups_of_the_scene_and_a_force_nearer_to_the_limit() {
    let folder = folder("a_refined_mesh");
    let scene = example("hertz-plane.toml");
    let fine = folder.join("fine.msh");
    let near = ["--near", "0", "0", "-1", "0.35", "--levels", "1"];
    let arguments = [&["refine", text(&scene), "-o", text(&fine)], &near[..]].concat();
    let run = run(arguments);
    assert_done(&run);
    assert!(run.stdout.contains("cells and"), "{}", run.stdout);
    let coarse = force(&scene, &example("meshes/hemi_l1.msh"));
    let [given, refined] = [example("meshes/hemi_l2.msh"), fine].map(|mesh| force(&scene, &mesh));
    // From coarse to fine the force of the ball grows towards its limit, as the chords of the
    // surface do towards the sphere; what is refined is between its mesh and the limit, or close.
    assert!(coarse < given, "{coarse} {given}");
    assert!((refined - given).abs() < 0.05 * given, "{given} {refined}");
}

#[test]
fn what_refine_cannot_do_is_told_with_its_exit_code() {
    let folder = folder("what_refine_cannot_do");
    let scene = example("mr-block.toml");
    let scene = text(&scene);
    let fine = folder.join("fine.msh");
    let vtu = folder.join("fine.vtu");
    let other = run(["refine", scene, "-o", text(&vtu)]);
    assert_eq!(other.code, Some(2));
    assert!(other.stderr.contains("end it in .msh"), "{}", other.stderr);
    let unknown = run(["refine", scene, "-o", text(&fine), "--on", "lid"]);
    assert_eq!(unknown.code, Some(2));
    assert!(
        unknown.stderr.contains("no facet group \"lid\"; it has: "),
        "{}",
        unknown.stderr
    );
    let few = ["refine", scene, "-o", text(&fine), "--max-cells", "2000"];
    let few = run(few);
    assert_eq!(few.code, Some(6), "{}", few.stderr);
    assert!(
        few.stderr.contains("more than 2000 cells"),
        "{}",
        few.stderr
    );
    assert!(!fine.exists());
}

/// Curves of Mooney-Rivlin rubber, c10 = 0.3 and c01 = 0.07, by the formulas of the books.
fn curves() -> String {
    let mut table = "test,stretch,stress\n".to_owned();
    for step in 1..=15 {
        let l = 1.0 + 0.15 * f64::from(step);
        let uniaxial = 2.0 * (l - l.powi(-2)) * (0.3 + 0.07 / l);
        let planar = 2.0 * (l - l.powi(-3)) * 0.37;
        let equibiaxial = 2.0 * (l - l.powi(-5)) * (0.3 + 0.07 * l * l);
        table.push_str(&format!("uniaxial,{l},{uniaxial}\nplanar,{l},{planar}\n"));
        table.push_str(&format!("equibiaxial,{l},{equibiaxial}\n"));
    }
    table
}

#[test]
fn constants_are_printed_as_the_material_of_the_scene() {
    let folder = folder("constants_are_printed");
    let scene = example("mr-block.toml");
    let (data, plot) = (folder.join("tests.csv"), folder.join("fit.svg"));
    std::fs::write(&data, curves()).unwrap();
    let fit = run(["fit", text(&scene), text(&data), "--plot", text(&plot)]);
    assert_done(&fit);
    let table: toml::Table = fit.stdout.parse().unwrap();
    let body = &table["material"]["body"];
    assert_eq!(body["model"].as_str(), Some("mooney-rivlin"));
    for (key, known) in [("c10", 0.3), ("c01", 0.07)] {
        let found = body[key].as_float().unwrap();
        assert!((found - known).abs() < 1e-8, "{key}: {found}");
    }
    let svg = std::fs::read_to_string(plot).unwrap();
    assert!(svg.starts_with("<svg") && svg.contains("equibiaxial"));

    let other = [
        "fit",
        text(&scene),
        text(&data),
        "--model",
        "yeoh",
        "--json",
    ];
    let other = run(other);
    assert_done(&other);
    let object: Value = serde_json::from_str(&other.stdout).unwrap();
    assert_eq!(object["model"], "yeoh");
    assert_eq!(object["points"], 45);
    assert!(object["error"].as_f64().unwrap() > 1e-3);
    assert_eq!(object["constants"].as_array().unwrap().len(), 3);
}

#[test]
fn tests_that_say_too_little_are_refused_or_warned_of() {
    let folder = folder("tests_that_say_too_little");
    let scene = example("mr-block.toml");
    let data = folder.join("tests.csv");
    let fit = |table: &str| {
        std::fs::write(&data, table).unwrap();
        run(["fit", text(&scene), text(&data)])
    };
    let one = fit("test,stretch,stress\nuniaxial,1.5,0.6\n");
    assert_eq!(one.code, Some(4), "{}", one.stderr);
    assert!(
        one.stderr.contains("1 points do not determine 2 constants"),
        "{}",
        one.stderr
    );
    let faulty = fit("test,stretch,stress\nuniaxial,x,0.6\n");
    assert_eq!(faulty.code, Some(4));
    assert!(faulty.stderr.contains("line 2"), "{}", faulty.stderr);
    let alone = fit("test,stretch,stress\nuniaxial,1.5,0.6\nuniaxial,2,1\nuniaxial,3,1.6\n");
    assert_done(&alone);
    assert!(
        alone.stderr.contains("tests of one kind"),
        "{}",
        alone.stderr
    );
}

/// Forces of the press of the example by its constants, as if they had been measured.
fn squeeze(scene: &Path, sets: &[&str]) -> String {
    let arguments = ["solve", text(scene), "--json", "--quiet"];
    let run = run(arguments.into_iter().chain(sets.iter().copied()));
    assert_done(&run);
    let mut table = "time,force.press.z\n".to_owned();
    for step in run.events("step") {
        let [time, force] = [&step["time"], &step["obstacles"]["press"]["force"][2]];
        table.push_str(&format!("{time},{force}\n"));
    }
    table
}

#[test]
fn constants_come_back_from_the_force_of_a_press_through_contact() {
    let folder = folder("constants_come_back");
    let scene = example("mr-block.toml");
    let sets = ["--set", "step.0.increments=4"];
    let data = folder.join("squeeze.csv");
    std::fs::write(&data, squeeze(&scene, &sets)).unwrap();
    let known: toml::Table = std::fs::read_to_string(&scene).unwrap().parse().unwrap();
    let known = &known["material"]["body"];
    let plot = folder.join("fit.svg");
    let away = [
        "--set",
        "material.body.c10=0.15",
        "--set",
        "material.body.c01=0.2",
    ];
    let fit = [
        "fit",
        text(&scene),
        text(&data),
        "--json",
        "--plot",
        text(&plot),
    ];
    let fit = run(fit.into_iter().chain(sets).chain(away));
    assert_done(&fit);
    let object: Value = serde_json::from_str(&fit.stdout).unwrap();
    assert!(object["solves"].as_u64().unwrap() <= 15, "{object}");
    assert_eq!(object["points"], 4);
    for constant in object["constants"].as_array().unwrap() {
        let name = constant["name"].as_str().unwrap();
        let exact = known[name].as_float().unwrap();
        let found = constant["value"].as_f64().unwrap();
        assert!(
            (found - exact).abs() < 1e-5 * exact.abs(),
            "{name}: {found} {exact}"
        );
    }
    assert!(
        std::fs::read_to_string(plot)
            .unwrap()
            .contains("force.press.z")
    );

    std::fs::write(&data, "time,force.press.z\n1.5,-1\n").unwrap();
    let late = run(["fit", text(&scene), text(&data)]);
    assert_eq!(late.code, Some(4));
    assert!(late.stderr.contains("line 2: time 1.5"), "{}", late.stderr);
    let law = run(["fit", text(&scene), text(&data), "--model", "yeoh"]);
    assert_eq!(law.code, Some(2), "{}", law.stderr);
}
