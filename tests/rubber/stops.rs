//! Increments of rubber that are stopped: what is kept, and that nothing else depends
//! on when it was.

use crate::common::meshes::{cube, irregular, mesh};
use crate::common::scenes::{
    HELD, bonded_cube, in_parts, mooney_rivlin, push, rubber, squeezed_cube, support, turned,
};
use crate::common::{assert_converged, close, open, take, values};
use signorini::scene::{Choice, ContactSpace};
use signorini::{
    CancelToken, FieldName, IterationRecord, Observer, Scene, Session, Silent, Step, StepReport,
    StepRun, Termination,
};

/// Stops in one way at a record.
struct Impatient {
    token: CancelToken,
    stop: fn(&CancelToken),
    left: u32,
    seen: u32,
}

impl Observer for Impatient {
    fn iteration(&mut self, _record: &IterationRecord) {
        self.seen += 1;
        if self.seen == self.left {
            (self.stop)(&self.token);
        }
    }
}

/// The next increment, stopped at record `left`, and the number of records.
fn until(
    left: u32,
    stop: fn(&CancelToken),
    session: &mut Session,
    run: &mut StepRun,
) -> (StepReport, u32) {
    let token = CancelToken::new();
    let mut observer = Impatient {
        token: token.clone(),
        stop,
        left,
        seen: 0,
    };
    let report = session.advance(run, &mut observer, &token);
    (report.expect("an increment"), observer.seen)
}

#[test]
fn what_follows_a_cancelled_increment_does_not_depend_on_what_it_did() {
    let (scene, step) = bonded_cube();
    let mesh = mesh(cube(3));
    let goes_on = |is_stopped: fn(&mut Session, &mut StepRun)| {
        let mut session = open(&scene, &mesh);
        let mut run = session.begin_step(&step).expect("a valid step");
        for _ in 0..3 {
            session.advance(&mut run, &mut Silent, &CancelToken::new());
        }
        is_stopped(&mut session, &mut run);
        let deeper = push("press", [0.0, 0.0, -0.1]);
        take(&mut session, &deeper)
            .iter()
            .for_each(assert_converged);
        let moved = values(&session, FieldName::Displacement);
        moved.into_iter().map(f64::to_bits).collect::<Vec<_>>()
    };
    let before_it = goes_on(|session, _| session.stop());
    let in_it = goes_on(|session, run| {
        let (report, _) = until(5, CancelToken::cancel, session, run);
        assert_eq!(report.termination, Termination::Cancelled);
    });
    let after_it = goes_on(|session, run| {
        session.advance(run, &mut Silent, &CancelToken::new());
        session.take_back();
    });
    assert!(before_it == in_it && before_it == after_it);
}

/// A cube twisted so far at once that the increment is done in parts.
fn twisted() -> (Scene, Step) {
    let mut scene = rubber(mooney_rivlin(), None);
    scene.supports = vec![support("z0", HELD), support("z1", HELD)];
    let twist = Step {
        supports: vec![turned("z1", [0.0, 0.0, 1.0], [0.5, 0.5, 0.0])],
        ..Step::default()
    };
    (scene, twist)
}

/// Stopped shortly before the end of its increment; then how it goes on.
fn twisted_until(stop: fn(&CancelToken)) -> (StepReport, Session, StepReport) {
    let (scene, step) = twisted();
    let mesh = mesh(irregular(cube(4), 4));
    let advance = |left| {
        let mut session = open(&scene, &mesh);
        let mut run = session.begin_step(&step).expect("a valid step");
        let (report, seen) = until(left, stop, &mut session, &mut run);
        (report, seen, session)
    };
    let (whole, records, _) = advance(u32::MAX);
    assert_converged(&whole);
    assert!(whole.cut_backs > 0);
    let (stopped, _, session) = advance(records - 3);
    (whole, session, stopped)
}

#[test]
fn a_step_whose_time_is_up_keeps_the_last_part_that_converged() {
    let (whole, mut session, stopped) = twisted_until(CancelToken::expire);
    assert_eq!(stopped.termination, Termination::DeadlineExceeded);
    assert!(0.2 < stopped.time && stopped.time < 1.0, "{}", stopped.time);
    assert!(close(stopped.load, stopped.time, 1e-12));
    assert!(stopped.residuals.largest() <= 1e-8, "{stopped:?}");
    assert!(stopped.stability.is_some());
    let still = take(&mut session, &Step::default());
    assert_converged(&still[0]);
    assert!(close(still[0].strain_energy, stopped.strain_energy, 1e-6));
    let (_, step) = twisted();
    let on = take(&mut session, &step);
    assert_converged(&on[0]);
    assert!(close(on[0].strain_energy, whole.strain_energy, 1e-6));
}

#[test]
fn a_step_whose_time_is_up_can_be_taken_back() {
    let (_, mut session, _) = twisted_until(CancelToken::expire);
    session.take_back();
    let left = values(&session, FieldName::Displacement);
    assert!(left.iter().all(|&u| u == 0.0));
}

#[test]
fn a_cancelled_step_keeps_the_state_before_its_increment() {
    let (_, session, stopped) = twisted_until(CancelToken::cancel);
    assert_eq!(stopped.termination, Termination::Cancelled);
    assert!(stopped.time == 0.0, "{}", stopped.time);
    let left = values(&session, FieldName::Displacement);
    assert!(left.iter().all(|&u| u == 0.0));
}

/// The bits of a body after it was squeezed far; its next
/// increment cancelled at record `left` if that comes.
fn squeezed_until(left: u32) -> (StepReport, u32, Vec<u64>) {
    let (mut scene, _) = squeezed_cube();
    scene.solver.contact_space = Choice::Named(ContactSpace::Linear);
    let mut session = open(&scene, &mesh(cube(4)));
    let step = in_parts(push("press", [0.0, 0.0, -0.32]), 8);
    take(&mut session, &step).iter().for_each(assert_converged);
    session.stop();
    let on = push("press", [0.0, 0.0, -0.36]);
    let mut run = session.begin_step(&on).expect("a valid step");
    let (report, seen) = until(left, CancelToken::cancel, &mut session, &mut run);
    if report.termination == Termination::Cancelled {
        let again = take(&mut session, &on).pop().expect("an increment");
        assert_converged(&again);
    }
    let moved = values(&session, FieldName::Displacement);
    let bits = moved.into_iter().map(f64::to_bits);
    (report, seen, bits.collect())
}

#[test]
fn a_cancel_in_a_hard_squeeze_leaves_no_trace() {
    let (whole, records, expected) = squeezed_until(u32::MAX);
    assert_converged(&whole);
    for share in [0.2, 0.4, 0.6, 0.8] {
        let (stopped, _, found) = squeezed_until((share * f64::from(records)) as u32);
        assert_eq!(stopped.termination, Termination::Cancelled);
        assert!((stopped.time - 1.0).abs() < 1e-12 && stopped.penalty == 0.0);
        assert!(found == expected, "{share}");
    }
}
