//! Checkpoints: a session goes on in another process with the same bits, and no other
//! bytes are taken for a checkpoint.

mod common;
#[path = "checkpoint/refusals.rs"]
mod refusals;

use std::path::PathBuf;
use std::process::Command;
use std::sync::Arc;

use common::meshes::{cube, file, mesh};
use common::scenes::{
    HELD, hertz_sphere, in_parts, indented_block, mooney_rivlin, push, rubber, small_indentation,
    support, turned,
};
use common::{assert_converged, take, values};
use signorini::report::Seconds;
use signorini::scene::ObstacleTarget;
use signorini::{
    CancelToken, CheckpointError, FieldName, Mesh, Plan, Prepared, Reuse, Scene, Session, Silent,
    Step, StepReport, StepRun,
};

/// What sessions of one scene share.
#[derive(Clone)]
struct Ground {
    plan: Arc<Plan>,
    mesh: Arc<Mesh>,
    prepared: Arc<Prepared>,
}

impl Ground {
    fn new(scene: &Scene, mesh: &Arc<Mesh>) -> Self {
        let plan = Arc::new(Plan::new(scene, &[], mesh).expect("a valid scene"));
        let prepared = Prepared::build(&plan, mesh, &CancelToken::new());
        Self {
            plan,
            mesh: mesh.clone(),
            prepared: Arc::new(prepared.expect("a solvable scene")),
        }
    }

    fn session(&self) -> Session {
        let Self {
            plan,
            mesh,
            prepared,
        } = self.clone();
        Session::new(plan, mesh, prepared, Reuse::Reused)
    }

    fn import(&self, bytes: &[u8]) -> Result<Session, CheckpointError> {
        let Self {
            plan,
            mesh,
            prepared,
        } = self.clone();
        Session::import(plan, mesh, prepared, Reuse::Reused, bytes)
    }

    fn refusal(&self, bytes: &[u8]) -> CheckpointError {
        self.import(bytes).expect_err("a refusal")
    }
}

/// A program of steps that is left in the middle of one.
struct Story {
    ground: Ground,
    before: Vec<Step>,
    under_way: Step,
    done: u32,
    after: Vec<Step>,
}

/// A name, and what sets the story up.
type Named = (&'static str, fn() -> Story);

const STORIES: [Named; 4] = [
    ("linear-contact", contact),
    ("linear-contact-pushed", pushed),
    ("rubber-under-a-sphere", rubber_under_a_sphere),
    ("rubber-twisted", rubber_twisted),
];

fn contact() -> Story {
    let (mut scene, _) = hertz_sphere(0.5);
    scene.solver.verify = true;
    let ball = |depth: f64| push("ball", [0.0, 0.0, -depth]);
    Story {
        ground: Ground::new(&scene, &file("indent_l1")),
        before: vec![ball(0.01), ball(0.03)],
        under_way: in_parts(ball(0.05), 3),
        done: 1,
        after: vec![ball(0.02), ball(0.04)],
    }
}

fn pushed() -> Story {
    let push = |force: f64| Step {
        obstacles: vec![ObstacleTarget {
            name: "ball".to_owned(),
            force: [None, None, Some(-force)],
            ..ObstacleTarget::default()
        }],
        ..Step::default()
    };
    Story {
        before: vec![push(0.004)],
        under_way: in_parts(push(0.0125), 3),
        after: vec![push(0.006)],
        ..contact()
    }
}

fn rubber_under_a_sphere() -> Story {
    let (scene, under_way) = indented_block();
    Story {
        ground: Ground::new(&scene, &file("indent_l1")),
        before: Vec::new(),
        under_way,
        done: 2,
        after: vec![push("ball", [0.01, 0.0, -0.1])],
    }
}

fn rubber_twisted() -> Story {
    let mut scene = rubber(mooney_rivlin(), Some(50.0));
    scene.supports = vec![support("z0", HELD), support("z1", HELD)];
    let twist = |angle: f64, parts: u32| Step {
        supports: vec![turned("z1", [0.0, 0.0, angle], [0.5, 0.5, 1.0])],
        increments: parts,
        ..Step::default()
    };
    Story {
        ground: Ground::new(&scene, &mesh(cube(2))),
        before: vec![twist(0.1, 1)],
        under_way: twist(0.5, 4),
        done: 3,
        after: vec![twist(0.3, 2)],
    }
}

impl Story {
    /// The session where the story is left, with the step that is under way.
    fn first_half(&self) -> (Session, StepRun) {
        let mut session = self.ground.session();
        for step in &self.before {
            take(&mut session, step).iter().for_each(assert_converged);
        }
        let mut run = session.begin_step(&self.under_way).expect("a valid step");
        for _ in 0..self.done {
            assert_converged(&advance(&mut session, &mut run).expect("a report"));
        }
        (session, run)
    }

    /// All numbers of the rest of the story but times and bytes.
    fn second_half(&self, session: &mut Session, mut run: StepRun) -> String {
        let mut reports: Vec<StepReport> =
            std::iter::from_fn(|| advance(session, &mut run)).collect();
        for step in &self.after {
            reports.extend(take(session, step));
        }
        reports.iter().for_each(assert_converged);
        let reports = reports.into_iter().map(without_times);
        let fields = FieldName::ALL.into_iter().filter_map(|name| {
            let values = session.field(name)?.values.into_iter();
            let bits: Vec<u64> = values.map(f64::to_bits).collect();
            Some(format!("{name:?} {bits:?}\n"))
        });
        reports.chain(fields).collect()
    }
}

fn advance(session: &mut Session, run: &mut StepRun) -> Option<StepReport> {
    session.advance(run, &mut Silent, &CancelToken::new())
}

/// The shortest decimal form of a number names its bits.
fn without_times(mut report: StepReport) -> String {
    report.seconds = Seconds::default();
    report.memory_bytes = 0;
    // A session on kept data names it in its first report.
    report.reused.clear();
    format!("{report:?}\n")
}

/// Where the other process finds the story, and leaves its end.
const FOLDER: &str = "SIGNORINI_CHECKPOINT_STORY";

#[test]
#[ignore = "runs in the process that the stories start"]
fn the_other_process() {
    let Some(folder) = std::env::var_os(FOLDER).map(PathBuf::from) else {
        return;
    };
    let (_, story) = STORIES
        .into_iter()
        .find(|(name, _)| folder.ends_with(name))
        .expect("a story");
    let story = story();
    let bytes = std::fs::read(folder.join("checkpoint")).expect("a checkpoint");
    let mut session = story.ground.import(&bytes).expect("a good checkpoint");
    let run = session.resume_step(story.under_way.increments, story.done);
    let end = story.second_half(&mut session, run.expect("a step under way"));
    std::fs::write(folder.join("end"), end).expect("a writable folder");
}

/// Leaves a story here, and compares the two ends.
fn goes_on_elsewhere(name: &str) {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    if folder.exists() {
        std::fs::remove_dir_all(&folder).expect("an old story");
    }
    std::fs::create_dir_all(&folder).expect("a writable folder");
    let story = STORIES.iter().find(|story| story.0 == name);
    let story = story.expect("a story").1();
    let (mut session, run) = story.first_half();
    std::fs::write(folder.join("checkpoint"), session.export()).expect("a writable folder");
    let here = story.second_half(&mut session, run);
    let test = std::env::current_exe().expect("this test");
    let other = Command::new(test)
        .args(["--exact", "the_other_process", "--ignored"])
        .env(FOLDER, &folder)
        .env("RAYON_NUM_THREADS", "1")
        .output()
        .expect("another process");
    let said = String::from_utf8_lossy(&other.stdout);
    assert!(other.status.success(), "{said}");
    let there = std::fs::read_to_string(folder.join("end")).expect("the other end");
    let mut lines = here.lines().zip(there.lines());
    let differing = lines.find(|(here, there)| here != there);
    assert!(
        here.lines().count() > 3 && differing.is_none(),
        "{differing:?}"
    );
    assert_eq!(here.len(), there.len());
}

#[test]
fn linear_contact_goes_on_in_another_process_with_the_same_bits() {
    goes_on_elsewhere("linear-contact");
}

#[test]
fn a_push_goes_on_in_another_process_with_the_same_bits() {
    goes_on_elsewhere("linear-contact-pushed");
}

#[test]
fn rubber_goes_on_in_another_process_with_the_same_bits() {
    goes_on_elsewhere("rubber-under-a-sphere");
}

#[test]
fn twisted_rubber_goes_on_in_another_process_with_the_same_bits() {
    goes_on_elsewhere("rubber-twisted");
}

#[test]
fn what_is_imported_is_exported_again_byte_for_byte() {
    for (name, story) in STORIES {
        let story = story();
        let (mut session, _) = story.first_half();
        let bytes = session.export();
        assert_eq!(session.export(), bytes, "{name}");
        let mut imported = story.ground.import(&bytes).expect("a good checkpoint");
        assert_eq!(imported.export(), bytes, "{name}");
    }
}

/// A session of a small scene before a ball, one step on.
fn pressed() -> (Ground, Scene, Session) {
    let (scene, mesh) = small_indentation(2);
    let ground = Ground::new(&scene, &mesh);
    let mut session = ground.session();
    let reports = take(&mut session, &push("ball", [0.0, 0.0, -0.05]));
    reports.iter().for_each(assert_converged);
    (ground, scene, session)
}

#[test]
fn a_session_at_rest_is_a_checkpoint_too() {
    let (ground, _, mut session) = pressed();
    let mut resting = ground.import(&ground.session().export()).expect("at rest");
    assert!(resting.resume_step(1, 0).is_none());
    take(&mut resting, &push("ball", [0.0, 0.0, -0.05]));
    assert_eq!(resting.export(), session.export());
}

#[test]
fn after_an_export_there_is_nothing_to_take_back() {
    let (_, _, mut session) = pressed();
    session.export();
    let before = values(&session, FieldName::Displacement);
    assert!(session.resume_step(1, 1).is_some());
    session.take_back();
    assert_eq!(values(&session, FieldName::Displacement), before);
    assert!(session.resume_step(1, 1).is_none());
}

#[test]
fn a_step_that_is_resumed_at_its_end_has_nothing_left() {
    let (_, _, mut session) = pressed();
    for (increments, done) in [(1, 1), (2, u32::MAX), (0, 0)] {
        let mut run = session.resume_step(increments, done).expect("under way");
        assert!(advance(&mut session, &mut run).is_none());
    }
}

#[test]
fn a_session_that_goes_back_does_the_same_steps_with_the_same_bits() {
    for (name, story) in STORIES {
        let story = story();
        let (mut session, run) = story.first_half();
        let saved = session.export();
        let first = story.second_half(&mut session, run);
        for _ in 0..2 {
            session.restore(&saved).expect("what was exported");
            let run = session.resume_step(story.under_way.increments, story.done);
            let again = story.second_half(&mut session, run.expect("a step under way"));
            assert!(again == first, "{name}");
        }
    }
}

#[test]
fn a_copy_changes_no_bit_and_is_gone_back_to_with_the_same_bits() {
    for (name, story) in STORIES {
        let story = story();
        let (mut session, run) = story.first_half();
        let undisturbed = story.second_half(&mut session, run);
        let (mut session, run) = story.first_half();
        let copy = session.snapshot();
        session.to_bytes();
        assert!(copy.bytes() > 0);
        let copied = story.second_half(&mut session, run);
        assert!(copied == undisturbed, "{name}: a copy changes bits");
        for _ in 0..2 {
            session.go_back(&copy);
            let run = session.resume_step(story.under_way.increments, story.done);
            let again = story.second_half(&mut session, run.expect("a step under way"));
            assert!(again == undisturbed, "{name}: gone back");
        }
    }
}

#[test]
fn the_bytes_of_a_session_at_rest_follow_from_its_plan() {
    let (ground, _, _) = pressed();
    assert_eq!(Session::at_rest(&ground.plan), ground.session().to_bytes());
}

#[test]
fn bytes_that_are_refused_leave_a_session_as_it_was() {
    let (_, _, mut session) = pressed();
    let before = session.export();
    let mut damaged = before.clone();
    damaged[300] ^= 1;
    assert_eq!(session.restore(&damaged), Err(CheckpointError::Damaged));
    assert_eq!(session.export(), before);
}

/// In memory, of 100 k unknowns: 20 ms at most, best of five.
#[test]
#[ignore = "by hand: measures times"]
fn saving_and_going_back_take_milliseconds() {
    let (scene, mesh) = small_indentation(16);
    let ground = Ground::new(&scene, &mesh);
    let mut session = ground.session();
    take(&mut session, &push("ball", [0.0, 0.0, -0.01]));
    let timed = |work: &mut dyn FnMut()| {
        let start = std::time::Instant::now();
        work();
        start.elapsed().as_secs_f64()
    };
    let (mut save, mut back) = (f64::INFINITY, f64::INFINITY);
    for _ in 0..5 {
        let mut bytes = Vec::new();
        save = timed(&mut || bytes = session.export()).min(save);
        back = timed(&mut || session.restore(&bytes).expect("its own bytes")).min(back);
    }
    let unknowns = session.plan().report().unknowns.displacement;
    eprintln!("{unknowns} unknowns: saved in {save:.4} s, back in {back:.4} s");
    assert!(unknowns > 100_000 && save < 0.02 && back < 0.02);
}
