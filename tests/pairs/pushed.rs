//! Bodies that a support pushes against each other.

use std::sync::Arc;

use crate::common::meshes::{curved_file, mesh, moved, unit_grid};
use crate::common::scenes::{HELD_IN_PLANE, obstacle, plane, pull, support};
use crate::common::{assert_converged, close, solve};
use crate::scenes::{between, joined, linear, linear_of, rubber};
use signorini::report::{Cause, SupportResult, Termination};
use signorini::scene::{ContactPair, SupportTarget};
use signorini::{Mesh, MeshParts, Scene, Step, StepReport};

const FORCE: f64 = -0.1;

/// A half disc on a slab, at rest.
fn disc(scene: Scene, friction: f64) -> Scene {
    let mut contacts = between("d_con", "s_top");
    contacts[0].friction = friction;
    Scene {
        supports: vec![
            support("s_bot", HELD_IN_PLANE),
            support("d_top", HELD_IN_PLANE),
        ],
        contacts,
        ..scene
    }
}

fn push() -> Step {
    Step {
        supports: vec![SupportTarget {
            name: "d_top".to_owned(),
            force: [None, Some(FORCE), None],
            ..SupportTarget::default()
        }],
        ..Step::default()
    }
}

fn last(scene: &Scene, steps: &[Step]) -> StepReport {
    let reports = solve(scene, steps, &curved_file("pair_slide"));
    reports.iter().for_each(assert_converged);
    reports.into_iter().last().expect("a report")
}

/// How far the disc goes, which led as far exerts the force.
fn travel(scene: &Scene, before: &[Step]) -> f64 {
    let steps: Vec<Step> = before.iter().cloned().chain([push()]).collect();
    let found = last(scene, &steps);
    let force = found.contacts["pair"].force[1];
    assert!(close(force.abs(), FORCE.abs(), 1e-7), "{force}");
    let support = &found.supports["d_top"];
    support.translation[1]
}

fn assert_led_alike(scene: &Scene, way: f64) {
    let led = last(scene, &[pull("d_top", [Some(0.0), Some(way), None], 1)]);
    let force = led.contacts["pair"].force[1];
    assert!(close(force.abs(), FORCE.abs(), 1e-6), "{force}");
}

#[test]
fn a_disc_that_is_pushed_onto_a_slab_goes_as_far_as_one_that_is_led() {
    let laws = [("disc", 1.0), ("slab", 2.0)];
    for scene in [rubber(laws, None), linear(laws)] {
        let scene = disc(scene, 0.0);
        let way = travel(&scene, &[]);
        assert_led_alike(&scene, way);
        let lift = |height: f64| Step {
            supports: vec![SupportTarget {
                name: "d_top".to_owned(),
                translation: Some([0.0, height, 0.0]),
                ..SupportTarget::default()
            }],
            ..Step::default()
        };
        for height in [0.03, 0.4] {
            let found = travel(&scene, &[lift(height)]);
            assert!(close(found, way, 1e-6), "{height}: {found} {way}");
        }
    }
}

#[test]
fn a_rough_disc_that_is_pushed_finds_its_slab_too() {
    let scene = disc(rubber([("disc", 1.0), ("slab", 2.0)], None), 0.2);
    let way = travel(&scene, &[]);
    assert_led_alike(&scene, way);
}

/// A block of 3 by 3 squares whose corner is there.
fn block(place: [f64; 2]) -> MeshParts {
    moved(unit_grid(3, 3), move |[x, y, z]| {
        [place[0] + x, place[1] + y, z]
    })
}

/// Two blocks over a slab, with those gaps.
fn side_by_side(gaps: [f64; 2]) -> Arc<Mesh> {
    let slab = moved(unit_grid(9, 3), |[x, y, z]| [3.0 * x, y - 1.0, z]);
    let [u, v] = [block([0.25, gaps[0]]), block([1.75, gaps[1]])];
    mesh(joined(&[("l_", slab), ("u_", u), ("v_", v)]))
}

/// Two blocks at the sides of another.
fn around(gaps: [f64; 2]) -> Arc<Mesh> {
    let [u, v] = [block([1.0 + gaps[0], 0.1]), block([-1.0 - gaps[1], 0.1])];
    mesh(joined(&[("l_", block([0.0; 2])), ("u_", u), ("v_", v)]))
}

/// Two blocks one above the other, over a slab.
fn stacked(gaps: [f64; 2]) -> Arc<Mesh> {
    let slab = moved(unit_grid(9, 3), |[x, y, z]| [3.0 * x, y - 1.0, z]);
    let [u, v] = [block([1.1, 1.0 + gaps[0] + gaps[1]]), block([1.0, gaps[1]])];
    mesh(joined(&[("l_", slab), ("u_", u), ("v_", v)]))
}

/// Both kinds of three bodies that the sides `held` hold and `pairs` of sides meet.
fn threes(held: [&str; 3], pairs: [[&str; 2]; 2], friction: f64) -> [Scene; 2] {
    let laws = [("l_body", 1.0), ("u_body", 1.0), ("v_body", 2.0)];
    let scene = |scene: Scene| {
        let contacts = ["c", "d"]
            .into_iter()
            .zip(pairs)
            .map(|(name, [own, other])| ContactPair {
                name: name.to_owned(),
                friction,
                ..between(own, other).remove(0)
            });
        let mut scene = Scene {
            supports: held.map(|side| support(side, HELD_IN_PLANE)).into(),
            contacts: contacts.collect(),
            ..scene
        };
        scene.solver.tolerance = 1e-10;
        scene
    };
    [scene(rubber(laws, Some(20.0))), scene(linear_of(0.3, laws))]
}

/// A step that pushes supports.
fn pushes<const N: usize>(forces: [(&str, [Option<f64>; 3]); N]) -> Step {
    let push = |(name, force): (&str, [Option<f64>; 3])| SupportTarget {
        name: name.to_owned(),
        force,
        ..SupportTarget::default()
    };
    Step {
        supports: forces.map(push).into(),
        ..Step::default()
    }
}

fn end(scene: &Scene, steps: &[Step], mesh: &Arc<Mesh>) -> StepReport {
    let reports = solve(scene, steps, mesh);
    reports.iter().for_each(assert_converged);
    reports.into_iter().last().expect("a report")
}

/// The same state by supports that are led as far, one as `given`.
fn led(scene: &Scene, (found, given): (&StepReport, &Step), mesh: &Arc<Mesh>) -> StepReport {
    let target = |(name, found): (&String, &SupportResult)| SupportTarget {
        name: name.clone(),
        displacement: found.translation.map(Some),
        ..SupportTarget::default()
    };
    let mut step = Step {
        supports: found.supports.iter().map(target).collect(),
        ..Step::default()
    };
    for target in &mut step.supports {
        let own = given.supports.iter().find(|own| own.name == target.name);
        let own = own.filter(|own| own.displacement[0].is_some());
        target.displacement = own.map_or(target.displacement, |own| own.displacement);
        target.displacement[2] = None;
    }
    end(scene, &[step], mesh)
}

/// A support, an axis and the force along it.
type Goal<'a> = (&'a str, usize, f64);

/// Fails unless each support exerts what it shall, all of them nothing together, and the same where
/// they are led.
fn assert_pushed(
    scene: &Scene,
    found: &StepReport,
    (mesh, step, goals): (&Arc<Mesh>, &Step, &[Goal<'_>]),
) {
    for &(name, axis, goal) in goals {
        let force = found.supports[name].force[axis];
        assert!((force - goal).abs() < 1e-8, "{name} {axis}: {force} {goal}");
    }
    let twin = led(scene, (found, step), mesh);
    for axis in 0..2 {
        let supports = found.supports.values().map(|one| one.force[axis]);
        let obstacles = found.obstacles.values().map(|one| one.force[axis]);
        let sum: f64 = supports.chain(obstacles).sum();
        assert!(sum.abs() < 1e-8, "{sum}");
        for (name, one) in &found.supports {
            let other = twin.supports[name].force[axis];
            assert!(
                (one.force[axis] - other).abs() < 1e-7,
                "{name} {axis}: {one:?} {other}"
            );
        }
    }
}

fn assert_same_place(found: &StepReport, other: &StepReport) {
    for (name, one) in &found.supports {
        for axis in 0..2 {
            let [a, b] = [one, &other.supports[name]].map(|one| one.translation[axis]);
            assert!((a - b).abs() < 1e-7, "{name}: {a} {b}");
        }
    }
}

const GAPS: [[f64; 2]; 3] = [[0.1, 0.05], [0.0, 0.05], [0.05, 0.0]];
const ONTO_SLAB: [[&str; 2]; 2] = [["u_y0", "l_y1"], ["v_y0", "l_y1"]];

#[test]
fn bodies_that_are_pushed_from_unequal_distances_all_arrive() {
    let down = |force: f64| [None, Some(force), None];
    let (u, v) = (("u_y1", down(-0.1)), ("v_y1", down(-0.05)));
    for scene in threes(["l_y0", "u_y1", "v_y1"], ONTO_SLAB, 0.0) {
        for gaps in GAPS {
            let mesh = side_by_side(gaps);
            let step = pushes([u, v]);
            let found = end(&scene, std::slice::from_ref(&step), &mesh);
            assert_pushed(
                &scene,
                &found,
                (&mesh, &step, &[("u_y1", 1, -0.1), ("v_y1", 1, -0.05)]),
            );
            let one_by_one = end(&scene, &[pushes([v]), pushes([u])], &mesh);
            assert_same_place(&found, &one_by_one);
        }
    }
}

#[test]
fn a_body_is_pushed_beside_one_that_is_led() {
    for scene in threes(["l_y0", "u_y1", "v_y1"], ONTO_SLAB, 0.0) {
        for gaps in GAPS {
            let mesh = side_by_side(gaps);
            let mut step = pushes([("u_y1", [None, Some(-0.1), None])]);
            let way = [Some(0.0), Some(-gaps[1] - 0.05), None];
            step.supports.extend(pull("v_y1", way, 1).supports);
            let found = end(&scene, std::slice::from_ref(&step), &mesh);
            assert_pushed(&scene, &found, (&mesh, &step, &[("u_y1", 1, -0.1)]));
        }
    }
}

#[test]
fn bodies_that_are_pushed_from_both_sides_meet_the_one_between() {
    let sides = [["u_x0", "l_x1"], ["v_x1", "l_x0"]];
    let along = |force: f64| [Some(force), None, None];
    let step = pushes([("u_x1", along(-0.1)), ("v_x0", along(0.05))]);
    for friction in [0.0, 0.3] {
        for scene in threes(["l_y0", "u_x1", "v_x0"], sides, friction) {
            for gaps in GAPS {
                let mesh = around(gaps);
                let found = end(&scene, std::slice::from_ref(&step), &mesh);
                assert_pushed(
                    &scene,
                    &found,
                    (&mesh, &step, &[("u_x1", 0, -0.1), ("v_x0", 0, 0.05)]),
                );
            }
        }
    }
}

#[test]
fn a_body_that_is_pushed_onto_one_that_is_pushed_on_goes_with_it() {
    let pairs = [["u_y0", "v_y1"], ["v_y0", "l_y1"]];
    let down = |force: f64| [None, Some(force), None];
    let step = pushes([("u_y1", down(-0.1)), ("v_x0", down(-0.05))]);
    for scene in threes(["l_y0", "u_y1", "v_x0"], pairs, 0.0) {
        for gaps in GAPS {
            let mesh = stacked(gaps);
            let found = end(&scene, std::slice::from_ref(&step), &mesh);
            assert_pushed(
                &scene,
                &found,
                (&mesh, &step, &[("u_y1", 1, -0.1), ("v_x0", 1, -0.05)]),
            );
        }
    }
}

/// A block over a slab that both are turned by `angle`, held below and above.
fn sloping(gap: f64, angle: f64) -> Arc<Mesh> {
    let turned = |parts: MeshParts| {
        moved(parts, move |[x, y, z]| {
            let (sin, cos) = angle.sin_cos();
            [cos * x - sin * y, sin * x + cos * y, z]
        })
    };
    let slab = moved(unit_grid(7, 3), |[x, y, z]| [3.0 * x - 1.0, y - 1.0, z]);
    mesh(joined(&[
        ("l_", turned(slab)),
        ("u_", turned(block([0.0, gap]))),
    ]))
}

fn pair_of_blocks(friction: f64) -> [Scene; 2] {
    let laws = [("l_body", 1.0), ("u_body", 1.0)];
    let scene = |scene: Scene| {
        let mut contacts = between("u_y0", "l_y1");
        contacts[0].friction = friction;
        let mut scene = Scene {
            supports: ["l_y0", "u_y1"]
                .map(|side| support(side, HELD_IN_PLANE))
                .into(),
            contacts,
            ..scene
        };
        scene.solver.tolerance = 1e-10;
        scene
    };
    [scene(rubber(laws, Some(20.0))), scene(linear_of(0.3, laws))]
}

#[test]
fn a_rough_body_that_is_pushed_down_and_along_at_once_sticks() {
    for (angle, force) in [(0.0, [0.03, -0.1]), (0.3, [0.0, -0.1])] {
        let step = pushes([("u_y1", [Some(force[0]), Some(force[1]), None])]);
        for scene in pair_of_blocks(0.6) {
            let at_touch = end(&scene, std::slice::from_ref(&step), &sloping(0.0, angle));
            for gap in [0.0, 0.05] {
                let mesh = sloping(gap, angle);
                let found = end(&scene, std::slice::from_ref(&step), &mesh);
                assert_pushed(
                    &scene,
                    &found,
                    (
                        &mesh,
                        &step,
                        &[("u_y1", 0, force[0]), ("u_y1", 1, force[1])],
                    ),
                );
                let normal = [-angle.sin(), angle.cos()];
                for axis in 0..2 {
                    let [far, near] =
                        [&found, &at_touch].map(|one| one.supports["u_y1"].translation[axis]);
                    assert!(
                        (far + gap * normal[axis] - near).abs() < 1e-6,
                        "{far} {near}"
                    );
                }
            }
        }
    }
}

#[test]
fn a_body_that_nothing_holds_on_a_slope_has_no_equilibrium() {
    let angle = 0.2_f64;
    let step = pushes([("u_y1", [Some(0.0), Some(-0.1), None])]);
    let on_slab = pair_of_blocks(0.0).into_iter();
    let on_plane = pair_of_blocks(0.0).into_iter().map(|scene| Scene {
        contacts: Vec::new(),
        obstacles: vec![obstacle(
            "slope",
            "u_y0",
            plane([0.0; 3], [-angle.sin(), angle.cos(), 0.0]),
        )],
        ..scene
    });
    for scene in on_slab.chain(on_plane) {
        for gap in [0.0, 0.05] {
            let found = solve(&scene, std::slice::from_ref(&step), &sloping(gap, angle));
            let found = found.last().expect("a report");
            let cause = (found.termination, found.cause);
            assert_eq!(
                cause,
                (Termination::NotConverged, Some(Cause::NoEquilibrium))
            );
            let site = found.cause_site.as_ref().expect("a site");
            let key = site.key.as_deref();
            assert!(
                key.is_some_and(|key| key.starts_with("support.u_y1.force.")),
                "{key:?}"
            );
            assert!(found.sqp_iterations <= 40, "{}", found.sqp_iterations);
        }
    }
}

#[test]
fn a_linear_body_that_nothing_holds_along_its_floor_goes_to_the_wall() {
    let step = pushes([("u_y1", [Some(0.03), Some(-0.1), None])]);
    let [_, scene] = pair_of_blocks(0.0);
    let scene = Scene {
        obstacles: vec![obstacle(
            "wall",
            "u_x1",
            plane([1.3, 0.0, 0.0], [-1.0, 0.0, 0.0]),
        )],
        ..scene
    };
    for gap in [0.0, 0.05] {
        let mesh = sloping(gap, 0.0);
        let found = end(&scene, std::slice::from_ref(&step), &mesh);
        assert_pushed(
            &scene,
            &found,
            (&mesh, &step, &[("u_y1", 0, 0.03), ("u_y1", 1, -0.1)]),
        );
        assert!((found.obstacles["wall"].force[0] + 0.03).abs() < 1e-8);
    }
}
