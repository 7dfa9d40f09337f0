//! Meshes that are refined until a force is known as well as is asked for.

use std::sync::Arc;

use crate::common::meshes::{cube, file, mesh, square};
use crate::common::scenes::{
    HELD, elastic, hertz_plane, mooney_rivlin, obstacle, push, rollers, rubber, support,
};
use crate::common::{close, run};
use signorini::adapted::{
    Accuracy, AccuracyLimits, Adapted, AdaptionError, End, Problem, Round, Target, Watch, adapt,
};
use signorini::report::{Silent, Termination};
use signorini::scene::{GoalErrors, GoalQuestions, Probe, Shape, SurfaceGeometry};
use signorini::{CancelToken, Mesh, Scene, Step};

/// A block bonded below, under a ball off its middle.
struct Pressed {
    scene: Scene,
    step: Step,
    goal: &'static str,
}

fn block(mut scene: Scene, depth: f64, increments: u32) -> Pressed {
    scene.solver.verify = false;
    scene.supports = vec![support("y0", HELD)];
    scene.supports[0].displacement[2] = None;
    let shape = Shape::Sphere {
        centre: [0.4, 2.0, 0.0],
        radius: 1.0,
    };
    scene.obstacles = vec![obstacle("ball", "y1", shape)];
    let mut step = push("ball", [0.0, -depth, 0.0]);
    step.increments = increments;
    Pressed {
        scene,
        step,
        goal: "force.ball.y",
    }
}

fn solid(mut scene: Scene, depth: f64, increments: u32) -> Pressed {
    scene.solver.verify = false;
    scene.supports = vec![support("z0", HELD)];
    let shape = Shape::Sphere {
        centre: [0.45, 0.55, 2.0],
        radius: 1.0,
    };
    scene.obstacles = vec![obstacle("ball", "z1", shape)];
    let mut step = push("ball", [0.0, 0.0, -depth]);
    step.increments = increments;
    Pressed {
        scene,
        step,
        goal: "force.ball.z",
    }
}

impl Pressed {
    fn adapted(&self, mesh: &Arc<Mesh>, tolerance: f64) -> Result<Adapted, AdaptionError> {
        self.within(mesh, tolerance, AccuracyLimits::default())
    }

    fn within(
        &self,
        mesh: &Arc<Mesh>,
        tolerance: f64,
        limits: AccuracyLimits,
    ) -> Result<Adapted, AdaptionError> {
        let accuracy = self.accuracy(tolerance, limits);
        let watch = Watch {
            rounds: &mut |_| (),
            observer: &mut Silent,
            room: &mut |_| true,
            cancel: &CancelToken::new(),
        };
        adapt(self.problem(mesh), &accuracy, watch)
    }

    fn accuracy(&self, tolerance: f64, limits: AccuracyLimits) -> Accuracy {
        let goal = self.goal.parse().expect("a goal");
        Accuracy {
            targets: vec![Target { goal, tolerance }],
            limits,
        }
    }

    fn problem<'a>(&'a self, mesh: &'a Arc<Mesh>) -> Problem<'a> {
        Problem {
            scene: &self.scene,
            steps: std::slice::from_ref(&self.step),
            mesh,
        }
    }

    /// The force and the unknowns of a mesh.
    fn solved(&self, mesh: &Arc<Mesh>) -> (f64, u64) {
        let (session, reports) = run(&self.scene, std::slice::from_ref(&self.step), mesh);
        let all = session.plan().unknowns();
        let axis = if self.goal.ends_with('z') { 2 } else { 1 };
        let force = reports.last().expect("a report").obstacles["ball"].force[axis];
        (force, all.displacement + all.pressure + all.contact)
    }
}

fn last(adapted: &Adapted) -> &Round {
    adapted.rounds.last().expect("a round")
}

/// Asserts that the force is within the tolerance of `exact`, that the bound says so, and how many
/// unknowns it took at most.
fn assert_within(adapted: &Adapted, (exact, tolerance): (f64, f64), most: u64) {
    assert_eq!(adapted.end, End::Reached);
    let round = last(adapted);
    let goal = &round.goals[0];
    let error = (goal.value - exact).abs();
    assert!(goal.bound <= tolerance * goal.value.abs(), "{goal:?}");
    assert!(error <= goal.bound, "{error} {goal:?}");
    assert!(round.unknowns <= most, "{round:?}");
    for pair in adapted.rounds.windows(2) {
        assert!(pair[0].unknowns < pair[1].unknowns, "{pair:?}");
    }
}

/// A line of contact on a bonded linear block: the reference is within 1e-4 by its own bound. Of an
/// incompressible one, whose pressure is singular at the bonded corners, a uniform mesh of eight
/// times the unknowns is farther off.
#[test]
fn the_force_on_a_linear_block_is_reached_on_a_fraction_of_a_uniform_mesh() {
    for poisson_ratio in [0.5, 0.3] {
        let problem = block(elastic(poisson_ratio), 0.03, 1);
        let start = mesh(square(4));
        let fine = problem.adapted(&start, 1e-4).expect("a result");
        let exact = last(&fine).goals[0].value;
        let found = problem.adapted(&start, 1e-3).expect("a result");
        assert_within(&found, (exact, 1e-3), 2500);
        if poisson_ratio < 0.5 {
            continue;
        }
        let round = last(&found);
        let (uniform, unknowns) = problem.solved(&mesh(square(48)));
        let errors = [uniform, round.goals[0].value].map(|force| (force / exact - 1.0).abs());
        assert!(
            unknowns > 8 * round.unknowns && errors[0] > errors[1],
            "{errors:?}"
        );
    }
}

/// Rubber on rollers under a ball, in the plane.
#[test]
fn the_force_on_rubber_is_reached_from_carried_states() {
    let mut problem = block(rubber(mooney_rivlin(), None), 0.12, 4);
    problem.scene.supports = rollers()[..2].to_vec();
    let start = mesh(square(4));
    let fine = problem.adapted(&start, 5e-4).expect("a result");
    let exact = last(&fine).goals[0].value;
    let found = problem.adapted(&start, 5e-3).expect("a result");
    assert_within(&found, (exact, 5e-3), 2000);
    // All increments on the last mesh lead to the carried state.
    let (force, unknowns) = problem.solved(found.hierarchy.mesh());
    assert_eq!(unknowns, last(&found).unknowns);
    assert!(close(last(&found).goals[0].value, force, 1e-6), "{force}");
}

#[test]
fn the_force_on_a_block_in_space_is_reached() {
    let problem = solid(rubber(mooney_rivlin(), None), 0.15, 2);
    let found = problem.adapted(&mesh(cube(2)), 0.05).expect("a result");
    // By 114 thousand unknowns, within 2.5e-3.
    assert_within(&found, (-0.2924828, 0.05), 8000);
}

/// Arcs are fitted once: halves follow them, so that the force does not go to that of the facets.
#[test]
fn fitted_arcs_belong_to_the_refined_mesh() {
    let (mut scene, step) = hertz_plane(0.3);
    scene.solver.verify = false;
    scene.solver.tolerance = 1e-8;
    scene.obstacles[0].surface = SurfaceGeometry::Smooth;
    let problem = Pressed {
        scene,
        step,
        goal: "force.floor.z",
    };
    let found = problem.adapted(&file("hemi_l1"), 0.05).expect("a result");
    assert_eq!(found.end, End::Reached);
    assert!(!found.hierarchy.mesh().edge_offsets().is_empty());
    assert_eq!(found.scene.obstacles[0].surface, SurfaceGeometry::AsMeshed);
    let mut flat = Pressed {
        goal: "force.floor.z",
        ..problem
    };
    flat.scene.obstacles[0].surface = SurfaceGeometry::AsMeshed;
    let ended = flat.adapted(&file("hemi_l1"), 1e-3).expect("a result");
    assert!(matches!(ended.end, End::Facets { .. }), "{:?}", ended.end);
    assert!(ended.end.to_string().contains("smooth"));
}

#[test]
fn limits_end_the_loop_with_their_word() {
    let problem = block(elastic(0.5), 0.03, 1);
    let start = mesh(square(4));
    let ends = |limits| {
        let found = problem.within(&start, 1e-4, limits).expect("a result");
        let unknowns = last(&found).unknowns;
        (found.end, found.rounds.len(), unknowns)
    };
    let limits = AccuracyLimits::default();
    let (end, _, unknowns) = ends(AccuracyLimits {
        unknowns: Some(500),
        ..limits
    });
    assert!(matches!(end, End::Unknowns { most: 500, .. }) && unknowns <= 500);
    let (end, rounds, _) = ends(AccuracyLimits {
        rounds: 2,
        ..limits
    });
    assert_eq!((end, rounds), (End::Rounds(2), 2));
    let (end, rounds, _) = ends(AccuracyLimits {
        seconds: Some(0.0),
        ..limits
    });
    assert_eq!((end, rounds), (End::Time { most: 0.0 }, 1));
    let (end, rounds, _) = ends(AccuracyLimits {
        bytes: Some(1),
        ..limits
    });
    assert_eq!((end.name(), rounds), ("max_memory", 1));
}

#[test]
fn a_mesh_is_asked_once_whatever_the_scene_asks_of_its_increments() {
    let mut problem = block(elastic(0.3), 0.03, 1);
    problem.scene.questions = vec![GoalQuestions {
        goals: vec![problem.goal.parse().expect("a goal")],
        errors: GoalErrors::Bounded,
        ..GoalQuestions::default()
    }];
    let adapted = problem.adapted(&mesh(square(4)), 0.02).expect("a result");
    assert!(adapted.rounds.len() > 1);
    assert!(adapted.session.plan().scene().questions.is_empty());
}

#[test]
fn time_that_is_up_on_a_finer_mesh_leaves_the_one_before() {
    let problem = block(elastic(0.3), 0.03, 1);
    let cancel = CancelToken::new();
    let mut count = 0;
    let watch = Watch {
        rounds: &mut |_| {
            count += 1;
            if count == 2 {
                cancel.expire();
            }
        },
        observer: &mut Silent,
        room: &mut |_| true,
        cancel: &cancel,
    };
    let accuracy = problem.accuracy(1e-6, AccuracyLimits::default());
    let found = adapt(problem.problem(&mesh(square(4))), &accuracy, watch).expect("a result");
    let late = End::NotConverged(Termination::DeadlineExceeded);
    assert_eq!((found.rounds.len(), found.end), (2, late));
    let cells = found.hierarchy.mesh().cell_count() as u64;
    assert_eq!(cells, found.rounds[1].cells);
}

/// The mesh of the scene is the last one: a session on it has the reports that say why.
#[test]
fn without_an_equilibrium_on_the_first_mesh_there_is_no_round() {
    let mut problem = block(rubber(mooney_rivlin(), None), 0.03, 2);
    problem.scene.solver.max_wall_time = Some(1e-9);
    let start = mesh(square(4));
    let found = problem.adapted(&start, 0.02).expect("a result");
    let end = End::NoEquilibrium {
        step: 1,
        termination: Termination::DeadlineExceeded,
    };
    assert_eq!((found.rounds.len(), found.end), (0, end));
    assert_eq!(found.hierarchy.mesh().cell_count(), start.cell_count());
}

#[test]
fn what_no_mesh_can_answer_is_refused() {
    let start = mesh(square(4));
    let mut problem = block(elastic(0.5), 0.03, 1);
    let refused = problem.adapted(&start, 0.0).expect_err("no tolerance");
    assert!(matches!(refused, AdaptionError::Malformed(_)), "{refused}");
    problem.goal = "force.lid.y";
    let refused = problem.adapted(&start, 0.1).expect_err("no such obstacle");
    assert!(refused.to_string().contains("force.lid.y"), "{refused}");
    problem.goal = "force.ball.y";
    problem.step = push("ball", [0.0, 0.1, 0.0]);
    let apart = problem.adapted(&start, 0.1).expect("a result");
    assert_eq!(apart.end, End::Zero("force.ball.y".to_owned()));
}

#[test]
fn the_same_request_gives_the_same_bits() {
    let problem = block(rubber(mooney_rivlin(), Some(30.0)), 0.1, 2);
    let start = mesh(square(4));
    let [one, other] = [1, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let found = pool
            .expect("threads")
            .install(|| problem.adapted(&start, 0.02));
        let rounds = found.expect("a result").rounds;
        let value = |round: &Round| (round.unknowns, round.goals[0].value.to_bits());
        rounds.iter().map(value).collect::<Vec<_>>()
    });
    assert_eq!(one, other);
}

/// A pushed tool: its force is given, its pose follows on every mesh, and a probe below it is known as
/// well as was asked. Reference: the same within a tenth.
#[test]
fn a_displacement_under_a_pushed_ball_is_reached() {
    let mut problem = block(elastic(0.3), 0.0, 1);
    problem.step.obstacles[0].translation = None;
    problem.step.obstacles[0].force = [None, Some(-0.1), None];
    problem.scene.probes = vec![Probe {
        name: "mid".to_owned(),
        point: [0.4, 0.8, 0.0],
    }];
    problem.goal = "displacement.mid.y";
    let start = mesh(square(4));
    let fine = problem.adapted(&start, 1e-4).expect("a result");
    let exact = last(&fine).goals[0].value;
    let found = problem.adapted(&start, 1e-3).expect("a result");
    assert_within(&found, (exact, 1e-3), 4000);
}
