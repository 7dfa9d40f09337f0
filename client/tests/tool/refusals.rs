//! Scenes and meshes that cannot be solved: exit code 4 and a message that
//! names the thing.
#![cfg(feature = "embedded")]

use std::path::Path;

use crate::common::{Run, example, folder, run};

/// One tetrahedron held on its floor.
const SCENE: &str = r#"
mesh = "mesh.msh"
[material.body]
model = "linear-elastic"
shear_modulus = 1.0
poisson_ratio = 0.3
[[support]]
name = "base"
on = "floor"
displacement = { x = 0.0, y = 0.0, z = 0.0 }
[body_force]
value = [0.0, 0.0, -1.0]
"#;

const NODES: &str = "1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n";
const ELEMENTS: &str = "1 2 2 2 2 1 3 2\n2 4 2 1 1 1 2 3 4\n";

/// A mesh file of nodes and elements, one a line.
fn mesh(nodes: &str, elements: &str) -> String {
    format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n2 2 \"floor\"\n3 1 \"body\"\n$EndPhysicalNames\n\
         $Nodes\n{}\n{nodes}$EndNodes\n$Elements\n{}\n{elements}$EndElements\n",
        nodes.lines().count(),
        elements.lines().count(),
    )
}

/// Solves a scene with a mesh of its own.
fn solve(test: &str, scene: &str, mesh: &str) -> Run {
    let folder = folder(test);
    std::fs::write(folder.join("mesh.msh"), mesh).unwrap();
    let path = folder.join("scene.toml");
    std::fs::write(&path, scene).unwrap();
    run(["solve", path.to_str().unwrap()])
}

/// Solves an example with some keys changed.
fn solve_set(name: &str, changes: &[&str]) -> Run {
    let scene = example(name);
    let changes = changes.iter().flat_map(|change| ["--set", *change]);
    run(["solve", scene.to_str().unwrap()]
        .into_iter()
        .chain(changes))
}

fn assert_refused(run: &Run, parts: &[&str]) {
    assert_eq!(run.code, Some(4), "{}", run.stderr);
    for part in parts {
        assert!(
            run.stderr.contains(part),
            "\"{part}\" is not in: {}",
            run.stderr
        );
    }
    assert_eq!(run.stdout, "");
}

#[test]
fn the_small_scene_itself_is_solved() {
    let run = solve("small_scene", SCENE, &mesh(NODES, ELEMENTS));
    assert_eq!(run.code, Some(0), "{}", run.stderr);
}

#[test]
fn values_out_of_range_name_their_key() {
    for (change, key) in [
        (
            "material.body.poisson_ratio=0.6",
            "material.body.poisson_ratio: ",
        ),
        (
            "material.body.shear_modulus=nan",
            "material.body.shear_modulus: ",
        ),
        (
            "obstacle.ball.shape.radius=-1",
            "obstacle.ball.shape.radius: ",
        ),
        (
            "obstacle.ball.shape.centre=[0, inf, 0]",
            "obstacle.ball.shape.centre: ",
        ),
        ("mesh_scale=inf", "mesh_scale: "),
        ("solver.tolerance=nan", "solver.tolerance: "),
        ("support.base.on=roof", "support.base.on: "),
        ("obstacle.ball.on=roof", "obstacle.ball.on: "),
    ] {
        assert_refused(
            &solve_set("hertz-sphere.toml", &[change]),
            &["error: ", key],
        );
    }
}

#[test]
fn a_normal_of_length_zero_names_its_key() {
    let run = solve_set(
        "hertz-plane.toml",
        &["obstacle.floor.shape.normal=[0, 0, 0]"],
    );
    assert_refused(&run, &["error: obstacle.floor.shape.normal: "]);
}

#[test]
fn several_faults_are_a_line_each() {
    let run = solve_set(
        "hertz-sphere.toml",
        &["material.body.poisson_ratio=0.6", "support.base.on=roof"],
    );
    assert_refused(
        &run,
        &["material.body.poisson_ratio: ", "support.base.on: "],
    );
    assert_eq!(run.stderr.matches("error: ").count(), 2, "{}", run.stderr);
}

#[test]
fn keys_of_later_capabilities_are_not_supported_yet() {
    for change in [
        "pressure.0={ on = \"z1\", value = 1.0 }",
        "step.0.support.base={ rotation = [0, 0, 7] }",
    ] {
        assert_refused(
            &solve_set("hertz-sphere.toml", &[change]),
            &["not supported yet"],
        );
    }
}

#[test]
fn a_normal_component_stands_alone() {
    assert_refused(
        &solve_set("hertz-sphere.toml", &["support.base.normal=0.0"]),
        &["support.base.normal", "displacement"],
    );
}

#[test]
fn a_body_that_nothing_holds_names_its_free_modes() {
    let free = SCENE.replace(
        "displacement = { x = 0.0, y = 0.0, z = 0.0 }",
        "displacement = { z = 0.0 }",
    );
    let run = solve("free_body", &free, &mesh(NODES, ELEMENTS));
    assert_refused(&run, &["translation", "rotation"]);
}

#[test]
fn a_candidate_face_must_not_be_held_in_all_components() {
    let run = solve_set("hertz-sphere.toml", &["support.base.on=z1"]);
    assert_refused(&run, &["ball"]);
}

#[test]
fn bad_cells_are_named() {
    let twice = format!("{ELEMENTS}3 4 2 1 1 1 2 3 4\n");
    let flat = NODES.replace("4 0 0 1", "4 1 1 0");
    for (test, nodes, elements, word) in [
        ("flat_cell", flat.as_str(), ELEMENTS, "degenerate"),
        ("double_cell", NODES, twice.as_str(), "duplicate"),
    ] {
        assert_refused(&solve(test, SCENE, &mesh(nodes, elements)), &["cell", word]);
    }
}

#[test]
fn a_mesh_without_cells_is_refused() {
    let run = solve("no_cells", SCENE, &mesh(NODES, "1 1 2 2 2 1 2\n"));
    assert_refused(&run, &["mesh.msh: no triangles, quadrangles, tetrahedra"]);
}

#[test]
fn unused_vertices_are_counted_in_a_warning() {
    let run = solve(
        "unused_vertices",
        SCENE,
        &mesh(&format!("{NODES}5 9 9 9\n6 8 8 8\n"), ELEMENTS),
    );
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(
        run.stderr.contains("warning: ") && run.stderr.contains('2'),
        "{}",
        run.stderr
    );
}

#[test]
fn a_refused_scene_leaves_earlier_results_alone() {
    let out = folder("earlier_results");
    let lines = out.join("results.jsonl");
    std::fs::write(&lines, "earlier\n").unwrap();
    let scene = example("hertz-sphere.toml");
    let run = run([
        "solve",
        scene.to_str().unwrap(),
        "--set",
        "material.body.poisson_ratio=0.6",
        "--out",
        out.to_str().unwrap(),
    ]);
    assert_refused(&run, &["material.body.poisson_ratio: "]);
    assert_eq!(std::fs::read_to_string(&lines).unwrap(), "earlier\n");
}

#[test]
fn the_output_section_is_checked_with_and_without_a_folder() {
    let out = folder("output_checked");
    let scene = example("hertz-plane.toml");
    let arguments = ["solve", scene.to_str().unwrap(), "--set", "output.every=0"];
    let with_folder = ["--out", out.to_str().unwrap()];
    for more in [&[][..], &with_folder] {
        let run = run(arguments.into_iter().chain(more.iter().copied()));
        assert_refused(&run, &["output.every: "]);
    }
}

#[test]
fn a_scene_without_a_step_says_so() {
    let steps = [("no_step", ""), ("one_step", "[[step]]\nload = 1.0\n")];
    for (test, step) in steps {
        let solved = solve(test, &format!("{SCENE}{step}"), &mesh(NODES, ELEMENTS));
        assert_eq!(solved.code, Some(0), "{}", solved.stderr);
        let is_told = solved.stderr.contains("warning: the scene has no [[step]]");
        assert_eq!(is_told, step.is_empty(), "{}", solved.stderr);
        let scene = Path::new(env!("CARGO_TARGET_TMPDIR"))
            .join(test)
            .join("scene.toml");
        let planned = run(["plan", scene.to_str().unwrap(), "--json"]);
        let warnings = planned.lines()[0]["warnings"].to_string();
        let is_kept = warnings.contains("the scene has no [[step]]");
        assert_eq!(is_kept, step.is_empty(), "{warnings}");
    }
}

#[test]
fn a_group_in_another_case_is_the_one_that_is_meant() {
    assert_refused(
        &solve_set("hertz-sphere.toml", &["obstacle.ball.on=Z1"]),
        &["did you mean `z1`?"],
    );
}

#[test]
fn a_mesh_without_groups_tells_how_to_give_them() {
    let bare = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n".to_owned()
        + NODES
        + "$EndNodes\n$Elements\n1\n1 4 2 0 1 1 2 3 4\n$EndElements\n";
    let run = solve("no_groups", SCENE, &bare);
    assert_refused(&run, &["Physical Surface(\"top\")"]);
}

#[test]
fn a_scene_is_checked_without_being_solved() {
    let scene = example("hertz-sphere.toml");
    let scene = scene.to_str().unwrap();
    let sound = run(["check", scene]);
    assert_eq!(sound.code, Some(0), "{}", sound.stderr);
    assert!(
        sound.stdout.contains("hertz-sphere.toml: no faults"),
        "{}",
        sound.stdout
    );
    let set = |change| ["--set", change];
    let changes = [
        set("material.body.poisson_ratio=0.6"),
        set("support.base.on=roof"),
    ];
    let faulty = run(["check", scene].into_iter().chain(changes.concat()));
    assert_refused(
        &faulty,
        &["material.body.poisson_ratio: ", "support.base.on: "],
    );
}

#[test]
fn a_drafted_scene_is_sound_and_never_written_over_another() {
    let folder = folder("drafted");
    for name in ["indent_l1.msh", "square_n16.msh"] {
        let mesh = folder.join(name);
        std::fs::copy(example("meshes").join(name), &mesh).unwrap();
        let drafted = run(["init", mesh.to_str().unwrap()]);
        assert_eq!(drafted.code, Some(0), "{}", drafted.stderr);
        let scene = drafted.stdout.trim();
        let checked = run(["check", scene]);
        assert_eq!(checked.code, Some(0), "{}", checked.stderr);
        let again = run(["init", mesh.to_str().unwrap()]);
        assert_eq!(again.code, Some(2), "{}", again.stderr);
        assert!(
            again.stderr.contains("is there already"),
            "{}",
            again.stderr
        );
    }
}

#[test]
fn devices_and_pipes_are_refused_at_once() {
    // A pipe without a writer would be waited for, a device read until memory ends.
    let pipe = folder("pipes").join("mesh.msh");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    assert!(made.unwrap().success());
    for path in ["/dev/zero", pipe.to_str().unwrap()] {
        for arguments in [["solve", path], ["check", path]] {
            assert_refused(&run(arguments), &[path, "no regular file"]);
        }
        let run = run(["mesh", "info", path]);
        assert_refused(&run, &[path, "no regular file"]);
    }
}
