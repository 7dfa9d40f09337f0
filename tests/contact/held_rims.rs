//! Surfaces that end at nodes which a support holds across a flat tool: half of a cavity on its
//! plane of symmetry.

use crate::common::meshes::{cube, mesh, moved};
use crate::common::scenes::{HELD, elastic, obstacle, plane, pull, rubber, support};
use crate::common::{assert_converged, close, solve_one};
use signorini::scene::RubberModel;
use signorini::{Group, GroupKind, MeshParts, Scene, StepReport};

/// The upper half of a block with a cavity like a lens, of half the width, a twentieth high; groups
/// `hole` and `cut` beside it.
fn half_of_a_lens(count: usize) -> MeshParts {
    let high = |x: f64| 0.05 * (1.0 - ((x - 0.5) / 0.25).powi(2)).max(0.0);
    let mut parts = moved(cube(count), |[x, y, z]| [x, y, z + (1.0 - z) * high(x)]);
    let low = parts.groups.iter().position(|group| group.name == "z0");
    let low = parts.groups.remove(low.expect("a lower side"));
    let middle = |facet: u32| {
        let corners = &parts.facets[3 * facet as usize..][..3];
        let places = corners
            .iter()
            .map(|&corner| parts.coordinates[corner as usize][0]);
        places.sum::<f64>() / 3.0
    };
    let (hole, cut) = low
        .members
        .into_iter()
        .partition(|&facet| (middle(facet) - 0.5).abs() < 0.25);
    let group = |name: &str, members: Vec<u32>| Group {
        name: name.to_owned(),
        kind: GroupKind::Facets,
        members,
    };
    let new = [group("hole", hole), group("cut", cut)];
    parts.groups.extend(new);
    parts
}

/// Pressed until the cavity is shut in its middle.
fn shut(law: Scene, count: usize) -> StepReport {
    let scene = Scene {
        supports: vec![
            support("z1", HELD),
            support("cut", [None, None, Some(0.0)]),
            support("y0", [None, Some(0.0), None]),
            support("y1", [None, Some(0.0), None]),
        ],
        obstacles: vec![obstacle("floor", "hole", plane([0.0; 3], [0.0, 0.0, 1.0]))],
        ..law
    };
    let step = pull("z1", [Some(0.0), Some(0.0), Some(-0.15)], 1);
    let report = solve_one(&scene, &step, &mesh(half_of_a_lens(count)));
    assert_converged(&report);
    report
}

#[test]
fn half_of_a_cavity_closes_on_its_plane_of_symmetry() {
    let law = RubberModel::NeoHookean { shear_modulus: 1.0 };
    for scene in [elastic(0.3), rubber(law, Some(20.0))] {
        let [coarse, fine] = [8, 12].map(|count| shut(scene.clone(), count));
        let peaks = [&coarse, &fine].map(|report| report.obstacles["floor"].peak_pressure);
        let forces = [&coarse, &fine].map(|report| report.obstacles["floor"].force[2]);
        assert!(
            forces[0] > 0.0 && close(forces[0], forces[1], 0.1),
            "{forces:?}"
        );
        assert!(close(peaks[0], peaks[1], 0.3), "{peaks:?}");
    }
}
