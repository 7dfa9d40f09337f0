//! Outlines of contact patches among the files of a run.
#![cfg(feature = "embedded")]

use crate::common::{example, folder, run};
use crate::examples::vtu_array;

/// Radii of the outline under a tool of the block of `hertz-sphere`, a quarter, without what lies
/// in its planes of symmetry.
fn radii(test: &str, (shape, mesh): (Option<&str>, &str)) -> Vec<f64> {
    let folder = folder(test);
    let text = std::fs::read_to_string(example("hertz-sphere.toml")).unwrap();
    let ball = "{ kind = \"sphere\", centre = [0.0, 0.0, 1.0], radius = 1.0 }";
    let mesh = example("meshes").join(mesh);
    let changed = text.replace(ball, shape.unwrap_or(ball));
    assert_eq!(changed == text, shape.is_none());
    let changed = changed.replace("meshes/indent_l3.msh", mesh.to_str().unwrap());
    let scene = folder.join("hertz-sphere.toml");
    std::fs::write(&scene, changed).unwrap();
    let out = folder.join("out");
    let arguments = ["solve", "--quiet", "--out", out.to_str().unwrap()];
    let solved = run(arguments.into_iter().chain([scene.to_str().unwrap()]));
    assert_eq!(solved.code, Some(0), "{}", solved.stderr);
    let series = std::fs::read_to_string(out.join("hertz-sphere.pvd")).unwrap();
    let file = "hertz-sphere_ball_contact_0001.vtp";
    assert!(series.contains(file), "{series}");
    let points = vtu_array(&out.join(file), "Points");
    let (points, _) = points.as_chunks::<3>();
    // The block sinks in below the tool.
    assert!(points.iter().all(|[_, _, z]| *z < 0.0), "{points:?}");
    let off_planes = points.iter().filter(|[x, y, _]| *x > 1e-9 && *y > 1e-9);
    off_planes.map(|[x, y, _]| x.hypot(*y)).collect()
}

/// Of three refinements, behind which the block is thick against the contact.
const HERTZ_LIMIT: f64 = 0.236;

#[test]
fn the_outline_under_a_ball_is_the_circle_within_the_mesh() {
    for (mesh, points, within) in [("indent_l2.msh", 25, 0.018), ("indent_l3.msh", 40, 0.013)] {
        let radii = radii(&format!("patch_{mesh}"), (None, mesh));
        assert!(radii.len() > points, "{radii:?}");
        let far = radii.iter().map(|radius| (radius - HERTZ_LIMIT).abs());
        let worst = far.fold(0.0, f64::max);
        assert!(worst < within, "{mesh} {worst}");
    }
}

#[test]
fn the_outline_under_a_torus_leaves_the_hole_out() {
    let torus = "{ kind = \"torus\", centre = [0.0, 0.0, 0.25], axis = [0.0, 0.0, 1.0], radius = 0.35, tube_radius = 0.25 }";
    let radii = radii("patch_torus", (Some(torus), "indent_l3.msh"));
    let (inner, outer): (Vec<f64>, Vec<f64>) = radii.iter().partition(|radius| **radius < 0.35);
    assert!(inner.len() > 15 && outer.len() > 40, "{inner:?} {outer:?}");
    let spread = |arc: &[f64]| {
        let most = arc.iter().copied().fold(0.0, f64::max);
        (most - arc.iter().copied().fold(most, f64::min)) / most
    };
    assert!(
        spread(&inner) < 0.3 && spread(&outer) < 0.15,
        "{inner:?} {outer:?}"
    );
}
