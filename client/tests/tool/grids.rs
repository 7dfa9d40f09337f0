//! Tools on grids: the files beside a scene, their faults, and what comes of them.
#![cfg(feature = "embedded")]

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use signorini_client::formats::stl;

use crate::common::process::serve;
use crate::common::{Run, example, folder, run};

/// The key of the tool of the example.
const BALL: &str = "{ kind = \"sphere\", centre = [0.0, 0.0, 1.0], radius = 1.0 }";

/// Numbers at nodes, the last axis fastest.
fn grid(counts: &[usize], (origin, spacing): (f64, f64), of: impl Fn(&[f64]) -> f64) -> String {
    let all =
        |word: &str, number: f64| format!("{word}{}\n", format!(" {number}").repeat(counts.len()));
    let mut text = "# made for a test\ncounts".to_owned();
    counts
        .iter()
        .for_each(|count| write!(text, " {count}").unwrap());
    text += &format!("\n{}{}", all("origin", origin), all("spacing", spacing));
    for index in 0..counts.iter().product() {
        let mut rest = index;
        let mut place = vec![0.0; counts.len()];
        for (axis, count) in counts.iter().enumerate().rev() {
            place[axis] = origin + (rest % count) as f64 * spacing;
            rest /= count;
        }
        writeln!(text, "{}", of(&place)).unwrap();
    }
    text
}

/// A ball around (0, 0, 1) of radius 1, at nodes 0.1 apart.
fn ball() -> String {
    let distance = |x: &[f64]| x[0].hypot(x[1]).hypot(x[2] - 1.0) - 1.0;
    grid(&[33, 33, 38], (-1.6, 0.1), distance)
}

/// Its lower cap.
fn cap() -> String {
    let height = |x: &[f64]| 1.0 - (1.0 - x[0] * x[0] - x[1] * x[1]).sqrt();
    grid(&[15, 15], (-0.56, 0.08), height)
}

/// The example on a coarse mesh with another tool, its file beside it.
fn scene(test: &str, shape: &str, (name, text): (&str, &str)) -> PathBuf {
    let original = std::fs::read_to_string(example("hertz-sphere.toml")).unwrap();
    let folder = folder(test);
    let mesh = example("meshes/indent_l2.msh");
    let changed = original.replace(BALL, shape);
    assert_ne!(changed, original);
    let changed = changed.replace("meshes/indent_l3.msh", mesh.to_str().unwrap());
    std::fs::write(folder.join(name), text).unwrap();
    let path = folder.join("scene.toml");
    std::fs::write(&path, changed).unwrap();
    path
}

fn command(word: &str, scene: &Path, more: &[&str]) -> Run {
    let arguments = [word, scene.to_str().unwrap()];
    run(arguments.into_iter().chain(more.iter().copied()))
}

fn force(scene: &Path) -> f64 {
    let run = command("solve", scene, &["--json"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let last = run.events("step").pop().unwrap();
    assert_eq!(last["termination"], "converged");
    last["obstacles"]["ball"]["force"][2].as_f64().unwrap()
}

#[test]
fn a_ball_of_distances_or_heights_is_the_ball() {
    let plain = scene(
        "grid_plain",
        "{ kind = \"sphere\", radius = 1, centre = [0, 0, 1] }",
        ("unused", ""),
    );
    let exact = force(&plain);
    let shape = "{ kind = \"distance-grid\", file = \"ball.grid\" }";
    let distances = scene("grid_ball", shape, ("ball.grid", &ball()));
    let shape = "{ kind = \"height-field\", file = \"cap.grid\", inside = true }";
    let heights = scene("grid_cap", shape, ("cap.grid", &cap()));
    for scene in [distances, heights] {
        let found = force(&scene);
        assert!(
            (found - exact).abs() < 1e-4 * exact.abs(),
            "{found} {exact}"
        );
        let plan = command("plan", &scene, &[]);
        assert_eq!(plan.code, Some(0), "{}", plan.stderr);
    }
}

/// Triangles of the tool in the picture of a run.
fn triangles(scene: &Path) -> usize {
    let out = scene.with_file_name("out");
    let run = command("solve", scene, &["--out", out.to_str().unwrap()]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    triangles_of(&out)
}

/// The same in a folder of results.
fn triangles_of(out: &Path) -> usize {
    let picture = std::fs::read(out.join("hertz-sphere_ball_0001.vtp")).unwrap();
    let picture = String::from_utf8_lossy(&picture);
    let (_, rest) = picture.split_once("NumberOfPolys=\"").unwrap();
    rest.split('"').next().unwrap().parse().unwrap()
}

/// An octahedron around (0, 0, 1), three facets of which meet at each end of the axes.
fn octahedron() -> String {
    let corner = |axis: usize, sign: f64| {
        let mut place = [0.0, 0.0, 1.0];
        place[axis] += sign;
        format!("vertex {} {} {}\n", place[0], place[1], place[2])
    };
    let mut text = "solid tool\n".to_owned();
    for octant in 0..8 {
        let sign = |axis: usize| if octant >> axis & 1 == 0 { 1.0 } else { -1.0 };
        let mut axes = [0, 1, 2];
        if sign(0) * sign(1) * sign(2) < 0.0 {
            axes.swap(0, 1);
        }
        let corners = axes.map(|axis| corner(axis, sign(axis))).concat();
        text += &format!("facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet\n");
    }
    text + "endsolid tool\n"
}

#[test]
fn tools_from_files_are_drawn() {
    let shape = "{ kind = \"distance-grid\", file = \"ball.grid\" }";
    let distances = scene("drawn_ball", shape, ("ball.grid", &ball()));
    assert!(triangles(&distances) > 100);
    let shape = "{ kind = \"height-field\", file = \"cap.grid\", inside = true }";
    let heights = scene("drawn_cap", shape, ("cap.grid", &cap()));
    assert!(triangles(&heights) > 100);
    let shape = "{ kind = \"surface\", file = \"tool.stl\", facets = true }";
    let facets = scene("drawn_facets", shape, ("tool.stl", &octahedron()));
    assert!(triangles(&facets) >= 4);
}

#[test]
fn a_tool_that_was_sent_is_fetched_back_as_its_file_and_into_pictures() {
    let (process, url) = serve("127.0.0.1:0", "fetched_tool", "");
    let shape = "{ kind = \"surface\", file = \"tool.stl\", facets = true }";
    let scene = scene("fetched_facets", shape, ("tool.stl", &octahedron()));
    let to = ["--server", &url];
    let sent = command(
        "solve",
        &scene,
        &[&to[..], &["--detach", "--name", "pressed"]].concat(),
    );
    assert_eq!(sent.code, Some(0), "{}", sent.stderr);
    let watched = run(["watch", "pressed"].into_iter().chain(to));
    assert_eq!(watched.code, Some(0), "{}", watched.stderr);
    let shown = run(["session", "show", "pressed", "--json"]
        .into_iter()
        .chain(to));
    let name = shown.lines()[0]["tools"]["ball"]
        .as_str()
        .unwrap()
        .to_owned();
    let told = run(["session", "show", "pressed"].into_iter().chain(to)).stdout;
    assert!(told.contains(&format!("obstacle ball is {name}")), "{told}");
    let file = scene.with_file_name("back.stl");
    let fetched = run(["fetch", &name, "--out", file.to_str().unwrap()]
        .into_iter()
        .chain(to));
    assert_eq!(fetched.code, Some(0), "{}", fetched.stderr);
    let read = |path: &Path| stl::read(&std::fs::read(path).unwrap()).unwrap();
    assert_eq!(read(&file), read(&scene.with_file_name("tool.stl")));
    let out = scene.with_file_name("fetched");
    let fetched = run(["fetch", "pressed", "--out", out.to_str().unwrap()]
        .into_iter()
        .chain(to));
    assert_eq!(fetched.code, Some(0), "{}", fetched.stderr);
    assert!(triangles_of(&out) >= 4);
    let nowhere = run(["fetch", &name].into_iter().chain(to));
    assert_eq!(nowhere.code, Some(2), "{}", nowhere.stderr);
    assert!(
        nowhere.stderr.contains("--out names the STL file"),
        "{}",
        nowhere.stderr
    );
    let unknown = name.replace(char::is_numeric, "0");
    let unknown = run(["fetch", &unknown, "--out", "x.stl"].into_iter().chain(to));
    assert_eq!(unknown.code, Some(4), "{}", unknown.stderr);
    drop(process);
}

#[test]
fn faults_of_grids_name_the_file_or_the_key() {
    let refused = |test: &str, shape: &str, text: &str, part: &str| {
        let scene = scene(test, shape, ("tool.grid", text));
        let run = command("solve", &scene, &[]);
        assert_eq!(run.code, Some(4), "{}", run.stderr);
        assert!(
            run.stderr.contains(part),
            "\"{part}\" is not in: {}",
            run.stderr
        );
    };
    let distances = "{ kind = \"distance-grid\", file = \"tool.grid\" }";
    let heights = "{ kind = \"height-field\", file = \"tool.grid\" }";
    refused(
        "grid_axes",
        distances,
        &cap(),
        "obstacle.ball.shape.file: names no grid of distances, with three axes",
    );
    refused(
        "grid_heights",
        heights,
        &ball(),
        "obstacle.ball.shape.file: names no grid of heights, with two axes",
    );
    let small = |x: &[f64]| x[0].hypot(x[1]).hypot(x[2] - 1.0) - 0.3;
    let coarse = grid(&[20, 20, 28], (-1.2, 0.125), small);
    refused(
        "grid_coarse",
        distances,
        &coarse,
        "tool.grid: surface: near node [7, 7, 16] the surface has a radius of 2.9",
    );
    let empty = grid(&[4, 4, 4], (0.0, 1.0), |_| 1.0);
    refused("grid_empty", distances, &empty, "no value is below zero");
    refused(
        "grid_cut",
        heights,
        "counts 4 4\norigin 0 0\n0.5",
        "tool.grid: `spacing` is missing",
    );
    let few = grid(&[3, 4], (0.0, 1.0), |_| 1.0);
    refused("grid_few", heights, &few, "has 3 nodes along axis 0");
    let plate = grid(&[4, 4, 4], (-1.5, 1.0), |x| x[2]);
    let cavity = "{ kind = \"distance-grid\", file = \"tool.grid\", inside = true }";
    refused("grid_open", cavity, &plate, "obstacle.ball.shape.inside: ");
    let missing = "{ kind = \"distance-grid\", file = \"other.grid\" }";
    refused("grid_missing", missing, &plate, "other.grid");
}
