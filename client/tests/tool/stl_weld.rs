//! Tools of programs that round every facet for itself.
#![cfg(feature = "embedded")]

use signorini_client::formats::stl::{self, SurfaceFile};

use crate::common::{example, folder, run};

/// The egg of the gripper as a program writes it that rounds each facet, some 7 mm, to microns.
fn rounded() -> String {
    let egg = stl::read(&std::fs::read(example("meshes/egg.stl")).unwrap()).unwrap();
    let mut rng = fastrand::Rng::with_seed(31);
    let corners = egg.facets.as_flattened().iter();
    let size = egg
        .vertices
        .as_flattened()
        .iter()
        .fold(0.0, |most: f64, x| most.max(x.abs()));
    let mut off = || 2e-5 * size * (rng.f64() - 0.5);
    let vertices: Vec<[f64; 3]> = corners
        .map(|corner| egg.vertices[*corner as usize].map(|x| x + off()))
        .collect();
    let facets = (0..egg.facets.len() as u32).map(|facet| [0, 1, 2].map(|k| 3 * facet + k));
    stl::write(&SurfaceFile {
        vertices,
        facets: facets.collect(),
    })
}

#[test]
fn corners_that_differ_by_rounding_are_refused_by_the_key_that_makes_them_one() {
    let folder = folder("stl_weld");
    let text = std::fs::read_to_string(example("gripper.toml")).unwrap();
    let mesh = example("meshes/gripper.msh");
    let text = text.replace("meshes/gripper.msh", mesh.to_str().unwrap());
    let scene = folder.join("gripper.toml");
    std::fs::write(&scene, text.replace("meshes/egg.stl", "egg.stl")).unwrap();
    std::fs::write(folder.join("egg.stl"), rounded()).unwrap();
    let plan = |more: &[&str]| {
        let arguments = ["plan", scene.to_str().unwrap()];
        run(arguments.into_iter().chain(more.iter().copied()))
    };
    let refused = plan(&[]);
    assert_eq!(refused.code, Some(4), "{}", refused.stderr);
    for part in ["egg.stl", "not closed", "`weld`"] {
        assert!(refused.stderr.contains(part), "{part}: {}", refused.stderr);
    }
    let welded = plan(&["--set", "obstacle.egg.shape.weld=1e-4"]);
    assert_eq!(welded.code, Some(0), "{}", welded.stderr);
    let wrong = plan(&["--set", "obstacle.egg.shape.weld=0.1"]);
    assert_eq!(wrong.code, Some(4), "{}", wrong.stderr);
    assert!(
        wrong.stderr.contains("obstacle.egg.shape.weld"),
        "{}",
        wrong.stderr
    );
}
