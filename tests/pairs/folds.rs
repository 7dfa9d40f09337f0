//! A body that meets itself: cases of two independent codes.

use std::sync::Arc;

use super::scenes::between;
use crate::common::meshes::{file_parts, mesh, with_pad};
use crate::common::scenes::{mooney_rivlin, rubber, support};
use crate::common::{close, solve};
use signorini::scene::{ContactPair, RubberModel, SupportTarget};
use signorini::{Group, GroupKind, Mesh, MeshParts, Scene, Step, StepReport};

/// `parts` with the facets of some groups as one more group.
pub(crate) fn with_union(mut parts: MeshParts, name: &str, of: &[&str]) -> MeshParts {
    let own = parts
        .groups
        .iter()
        .filter(|one| of.contains(&&one.name[..]));
    let mut members: Vec<u32> = own.flat_map(|group| group.members.clone()).collect();
    members.sort_unstable();
    members.dedup();
    parts.groups.push(Group {
        name: name.to_owned(),
        kind: GroupKind::Facets,
        members,
    });
    parts
}

/// A contact named `pair` of a surface with itself.
pub(crate) fn of_itself(surface: &str) -> Vec<ContactPair> {
    vec![ContactPair {
        name: "pair".to_owned(),
        between: [0, 1].map(|_| surface.to_owned()),
        ..ContactPair::default()
    }]
}

/// Supports that go together by `way` each.
pub(crate) fn together([upper, lower]: [&str; 2], way: f64) -> Step {
    let target = |name: &str, way: f64| SupportTarget {
        name: name.to_owned(),
        displacement: [None, Some(way), None],
        ..SupportTarget::default()
    };
    Step {
        supports: vec![target(upper, -way), target(lower, way)],
        ..Step::default()
    }
}

/// A block with a slit from its end, closed there by its top and its bottom.
fn fold() -> Arc<Mesh> {
    let parts = file_parts("fold_12_10");
    let outer = |[x, ..]: [f64; 3]| x >= 1.8 - 1e-9;
    let parts = with_pad(parts, ("up", "f_top"), outer);
    let parts = with_pad(parts, ("low", "f_bottom"), outer);
    let parts = with_union(parts, "slit", &["f_upper", "f_end", "f_lower"]);
    mesh(parts)
}

fn folded(contacts: Vec<ContactPair>) -> Vec<StepReport> {
    let law = rubber(mooney_rivlin(), None);
    let vertical = [None, Some(0.0), None];
    let mut scene = Scene {
        supports: vec![
            support("f_left", [Some(0.0), None, None]),
            support("up", vertical),
            support("low", vertical),
        ],
        contacts,
        ..law
    };
    scene.materials[0].group = "body_f".to_owned();
    scene.solver.tolerance = 1e-10;
    let ways = [0.04, 0.1, 0.13, 0.16, 0.18, 0.2, 0.22, 0.24];
    let steps: Vec<Step> = ways.map(|way| together(["up", "low"], way)).into();
    solve(&scene, &steps, &fold())
}

#[test]
fn a_slit_that_folds_is_as_an_independent_code_has_it() {
    for (contacts, sign) in [
        (between("f_upper", "f_lower"), 1.0),
        (between("f_lower", "f_upper"), -1.0),
        (of_itself("slit"), -1.0),
    ] {
        let reports = folded(contacts);
        // That code has the invariants of F, not of F without its volume: next to the same bodies, to
        // 1e-4 before the lips touch.
        let open = &reports[1];
        assert!(close(open.strain_energy, 0.0021005907952, 1e-4));
        let last = &reports[reports.len() - 1];
        assert!(close(last.strain_energy, 0.0621579136307, 6e-4));
        assert!(close(-last.supports["up"].force[1], 0.65115331044, 6e-4));
        let force = last.contacts["pair"].force;
        assert!(close(sign * force[1], 0.613437519844, 6e-4), "{force:?}");
        let programs = reports.iter().map(|report| report.sqp_iterations).max();
        assert!(programs <= Some(5), "{programs:?}");
    }
}

/// A block with a slit like a lens.
pub(crate) fn lens() -> MeshParts {
    let parts = file_parts("slit_12_9");
    let middle = |[x, ..]: [f64; 3]| x.abs() < 0.06;
    let parts = with_pad(parts, ("top_pin", "top"), |[x, ..]| {
        (-1e-9..0.11).contains(&x)
    });
    let parts = with_pad(parts, ("bot_pin", "bot"), middle);
    with_union(parts, "slit", &["low", "up"])
}

/// Its scene, held at top and bottom.
pub(crate) fn lens_scene(contacts: Vec<ContactPair>) -> Scene {
    let law = rubber(RubberModel::NeoHookean { shear_modulus: 1.0 }, None);
    let mut scene = Scene {
        supports: vec![
            support("top", [None, Some(0.0), None]),
            support("bot", [None, Some(0.0), None]),
            support("top_pin", [Some(0.0), None, None]),
            support("bot_pin", [Some(0.0), None, None]),
        ],
        contacts,
        ..law
    };
    scene.materials[0].group = "block".to_owned();
    scene.solver.tolerance = 1e-10;
    scene
}

fn closed(contacts: Vec<ContactPair>, increments: u32) -> StepReport {
    let step = Step {
        increments,
        ..together(["top", "bot"], 0.1)
    };
    let mut reports = solve(&lens_scene(contacts), &[step], &mesh(lens()));
    reports.pop().expect("a report")
}

#[test]
fn a_slit_like_a_lens_closes_from_both_ends() {
    for increments in [1, 4] {
        for (contacts, sign) in [
            (between("low", "up"), -1.0),
            (between("up", "low"), 1.0),
            (of_itself("slit"), -1.0),
        ] {
            let report = closed(contacts, increments);
            // That code measures by closest points, and pins a node where this scene pins a facet.
            assert!(close(report.strain_energy, 0.0703308610426, 1e-3));
            let force = report.contacts["pair"].force;
            assert!(close(sign * force[1], 0.32420131833, 1.5e-2), "{force:?}");
            // Shut from one end to the other, each as long as the block is wide now.
            let width = report.contacts["pair"].contact_width;
            assert!(close(width, 1.107, 1e-3), "{width}");
            assert!(report.sqp_iterations <= 5, "{}", report.sqp_iterations);
        }
    }
}
