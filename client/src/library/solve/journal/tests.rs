//! The order of messages over connections that come and go.

use super::*;

fn opened(accepted: i64, finished: i64, last_event: i64) -> v1::StreamOpened {
    let session = v1::Session {
        last_accepted_sequence: accepted,
        last_finished_sequence: finished,
        ..Default::default()
    };
    v1::StreamOpened {
        session: Some(session),
        max_in_flight: 3,
        last_event,
    }
}

fn update(sequence: i64) -> Order {
    let update = v1::LoadStepUpdate {
        sequence,
        ..Default::default()
    };
    Order::Update(sequence, Box::new(Request::LoadStep(update)))
}

fn result(sequence: i64, event: i64, place: Place) -> Event {
    Event::Increment(Box::new(Increment {
        sequence,
        event,
        report: v1::StepReport::default(),
        last: matches!(place, Place::Last),
        fields: Vec::new(),
        fields_dropped: false,
    }))
}

enum Place {
    More,
    Last,
}

fn rejection(sequence: i64) -> Event {
    let Event::Rejected { refusal, .. } = gap(sequence, 0) else {
        unreachable!()
    };
    let reason = "SCENE_INVALID".to_owned();
    let refusal = Box::new(Refusal { reason, ..*refusal });
    Event::Rejected { sequence, refusal }
}

/// Everything that may be sent now: updates by sequence, cancels negative.
fn sent(journal: &mut Journal) -> Vec<i64> {
    let number = |request| match request {
        Request::LoadStep(update) => update.sequence,
        Request::Cancel(cancel) => -cancel.sequence,
        Request::Open(_) | Request::ObstacleUpdate(_) => unreachable!(),
    };
    std::iter::from_fn(|| journal.next_request())
        .map(number)
        .collect()
}

fn journal(updates: i64) -> Journal {
    let mut journal = Journal::new(None, &opened(0, 0, 0));
    for sequence in 1..=updates {
        assert_eq!(journal.order(update(sequence)), None);
    }
    journal
}

fn rejected(events: &[Event]) -> Vec<(i64, &str)> {
    let rejected = events.iter().filter_map(|event| match event {
        Event::Rejected { sequence, refusal } => Some((*sequence, refusal.reason.as_str())),
        Event::Increment(_)
        | Event::Iteration(_)
        | Event::Heartbeat(_)
        | Event::ConnectionLost { .. }
        | Event::Reconnected { .. } => None,
    });
    rejected.collect()
}

#[test]
fn no_more_is_sent_than_the_server_holds() {
    let mut journal = journal(5);
    assert_eq!(sent(&mut journal), [1, 2, 3]);
    assert!(!journal.is_sent());
    journal.take(result(1, 1, Place::Last)).unwrap();
    assert_eq!(sent(&mut journal), [4]);
    journal.take(result(2, 2, Place::More)).unwrap();
    assert!(!journal.has_request());
}

#[test]
fn a_new_connection_gets_what_was_not_accepted_and_nothing_else() {
    let mut journal = journal(5);
    sent(&mut journal);
    journal.take(result(1, 1, Place::Last)).unwrap();
    // Two arrived, the third was lost on the way.
    journal.resume(&opened(2, 1, 1)).unwrap();
    assert_eq!(sent(&mut journal), [3, 4]);
    // What is sent again goes once.
    assert_eq!(sent(&mut journal), [0_i64; 0]);
}

#[test]
fn results_come_once_and_in_order_over_connections() {
    let mut journal = journal(2);
    sent(&mut journal);
    assert_eq!(journal.take(result(1, 1, Place::More)).unwrap().len(), 1);
    journal.resume(&opened(2, 1, 2)).unwrap();
    assert_eq!(journal.seen(), 1);
    assert_eq!(journal.take(result(1, 1, Place::More)).unwrap(), []);
    assert_eq!(journal.take(result(1, 2, Place::Last)).unwrap().len(), 1);
    assert!(!journal.is_answered());
    assert_eq!(journal.take(result(2, 3, Place::Last)).unwrap().len(), 1);
    assert!(journal.is_answered() && journal.is_sent());
}

#[test]
fn results_that_are_no_longer_kept_are_an_error() {
    let mut journal = journal(1);
    sent(&mut journal);
    journal.take(result(1, 1, Place::More)).unwrap();
    journal.resume(&opened(1, 0, 9)).unwrap();
    let error = journal.take(result(1, 5, Place::More)).unwrap_err();
    assert!(
        matches!(error, ClientError::ResultsLost { first: 2, last: 4 }),
        "{error}"
    );
}

#[test]
fn whoever_asks_for_kept_results_may_come_too_late_for_the_first_ones() {
    let mut journal = Journal::new(Some(0), &opened(9, 9, 90));
    assert_eq!(journal.take(result(8, 80, Place::More)).unwrap().len(), 1);
    assert!(journal.take(result(8, 82, Place::More)).is_err());
}

#[test]
fn a_session_that_has_lost_results_is_another_session() {
    let mut journal = journal(1);
    sent(&mut journal);
    journal.take(result(1, 1, Place::Last)).unwrap();
    assert!(journal.resume(&opened(0, 0, 0)).is_err());
}

#[test]
fn a_rejected_update_takes_those_after_it_with_it_once() {
    let mut journal = journal(5);
    sent(&mut journal);
    let events = journal.take(rejection(2)).unwrap();
    assert_eq!(
        rejected(&events),
        [
            (2, "SCENE_INVALID"),
            (3, "SEQUENCE_GAP"),
            (4, "SEQUENCE_GAP"),
            (5, "SEQUENCE_GAP")
        ]
    );
    // On its way before the user knew.
    assert_eq!(
        rejected(&journal.order(update(6)).into_iter().collect::<Vec<_>>()),
        [(6, "SEQUENCE_GAP")]
    );
    assert_eq!(journal.order(update(2)), None);
    assert_eq!(journal.order(update(3)), None);
    assert_eq!(sent(&mut journal), [2, 3]);
    // The server's own answer to the old third update, then one to the new one.
    assert_eq!(journal.take(rejection(3)).unwrap(), []);
    assert_eq!(
        rejected(&journal.take(rejection(3)).unwrap()),
        [(3, "SCENE_INVALID")]
    );
}

#[test]
fn updates_after_a_rejected_one_are_not_sent_on_a_new_connection() {
    let mut journal = journal(3);
    sent(&mut journal);
    journal.take(rejection(2)).unwrap();
    assert_eq!(journal.order(update(2)), None);
    journal.resume(&opened(1, 0, 0)).unwrap();
    assert_eq!(sent(&mut journal), [2]);
    // The old ones died with their connection: this one is about the new update.
    assert_eq!(journal.order(update(3)), None);
    assert_eq!(
        rejected(&journal.take(rejection(3)).unwrap()),
        [(3, "SCENE_INVALID")]
    );
}

#[test]
fn a_cancel_overtakes_updates_but_not_its_own() {
    let mut journal = journal(5);
    journal.order(Order::Cancel(0));
    journal.order(Order::Cancel(5));
    assert_eq!(sent(&mut journal), [1, 0, 2, 3]);
    journal.take(result(1, 1, Place::Last)).unwrap();
    journal.take(result(2, 2, Place::Last)).unwrap();
    assert_eq!(sent(&mut journal), [4, 5, -5]);
}

#[test]
fn a_cancel_is_repeated_for_the_step_that_it_meant_until_that_is_finished() {
    let mut journal = journal(2);
    assert_eq!(sent(&mut journal), [1, 2]);
    journal.order(Order::Cancel(0));
    assert_eq!(sent(&mut journal), [0]);
    journal.resume(&opened(2, 0, 0)).unwrap();
    assert_eq!(sent(&mut journal), [-1]);
    // It ended unseen: what runs now was not meant.
    journal.resume(&opened(2, 1, 1)).unwrap();
    assert_eq!(sent(&mut journal), [0_i64; 0]);
}

#[test]
fn a_cancel_of_nothing_is_sent_and_forgotten() {
    let mut journal = journal(0);
    journal.order(Order::Cancel(0));
    assert_eq!(sent(&mut journal), [0]);
    journal.resume(&opened(0, 0, 0)).unwrap();
    assert_eq!(sent(&mut journal), [0_i64; 0]);
    assert!(journal.is_sent());
}
