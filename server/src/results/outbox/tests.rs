use std::future::{Future, poll_fn};
use std::pin::pin;
use std::task::Poll;

use signorini::report::FieldData;

use super::*;
use crate::convert::field::KeptField;
use crate::results::iterations::Iterations;

const HOUR: Duration = Duration::from_secs(3600);

fn outbox(limit: u64) -> (Arc<Outbox>, Arc<Notify>) {
    let room = Arc::new(Notify::new());
    let wanted = Wanted {
        fields: vec![FieldName::Gap],
        encoding: Encoding::Double,
    };
    let limit = Limit {
        bytes: limit,
        results: 3,
    };
    (Outbox::new(limit, wanted, &room), room)
}

fn heartbeat(sequence: i64) -> Message {
    Message::Heartbeat(wire::StreamHeartbeat {
        running_sequence: sequence,
        ..Default::default()
    })
}

fn result(event: i64, values: usize) -> Arc<KeptResult> {
    let field = FieldData {
        name: FieldName::Gap,
        components: 1,
        values: vec![1.0; values],
    };
    Arc::new(KeptResult {
        sequence: event,
        event,
        report: (&wire::StepReport::default()).into(),
        last: true,
        asked: Some(vec![FieldName::Gap]),
        fields: vec![KeptField::new(&field)],
        dropped: false,
        needs: 0,
    })
}

async fn read(outbox: &Outbox, iterations: &mut IterationReader) -> Message {
    match outbox.next(iterations, HOUR).await {
        Next::Message(response) => response.message.unwrap(),
        other @ (Next::End(_) | Next::Silence) => panic!("{other:?} instead of a message"),
    }
}

async fn is_pending(work: impl Future<Output = ()>) -> bool {
    let mut work = pin!(work);
    poll_fn(|context| Poll::Ready(work.as_mut().poll(context).is_pending())).await
}

#[tokio::test]
async fn a_result_comes_after_its_last_iteration_with_its_fields_and_before_the_end() {
    let (outbox, _) = outbox(1 << 30);
    let iterations = Iterations::default();
    let mut reader = iterations.reader(Duration::ZERO);
    iterations.publish(1, 0, wire::IterationReport::default());
    iterations.publish(1, 0, wire::IterationReport::default());
    outbox.result(&result(1, 300_000), Some(iterations.newest()));
    outbox.push(heartbeat(2));
    outbox.end(StreamEnd::Done);
    outbox.end(StreamEnd::Fault(Fault::Internal));
    let Message::Iteration(iteration) = read(&outbox, &mut reader).await else {
        panic!("the iteration comes first");
    };
    assert_eq!(iteration.skipped_count, 1);
    assert!(matches!(
        read(&outbox, &mut reader).await,
        Message::StepFinished(_)
    ));
    for last in [false, false, true] {
        let Message::Field(chunk) = read(&outbox, &mut reader).await else {
            panic!("a slice of the field is due");
        };
        assert_eq!(chunk.last, last);
    }
    assert_eq!(read(&outbox, &mut reader).await, heartbeat(2));
    assert_eq!(
        outbox.next(&mut reader, HOUR).await,
        Next::End(StreamEnd::Done)
    );
}

#[tokio::test]
async fn unread_bytes_close_the_room_until_they_are_read_and_the_session_is_woken() {
    let (outbox, room) = outbox(1000);
    let mut reader = Iterations::default().reader(Duration::ZERO);
    assert!(outbox.has_room());
    outbox.result(&result(1, 1000), None);
    assert!(!outbox.has_room());
    assert!(is_pending(room.notified()).await);
    read(&outbox, &mut reader).await;
    assert!(!outbox.has_room());
    read(&outbox, &mut reader).await;
    room.notified().await;
    assert!(outbox.has_room());
}

#[tokio::test]
async fn a_number_of_unread_results_closes_the_room_too() {
    let (outbox, room) = outbox(1 << 30);
    let mut reader = Iterations::default().reader(Duration::ZERO);
    for event in 1..=3 {
        assert!(outbox.has_room());
        outbox.result(&result(event, 0), None);
    }
    assert!(!outbox.has_room());
    read(&outbox, &mut reader).await;
    room.notified().await;
    assert!(outbox.has_room());
}

#[tokio::test]
async fn an_iteration_of_a_result_that_was_read_is_not_sent_after_it() {
    let (outbox, _) = outbox(1000);
    let iterations = Iterations::default();
    let mut reader = iterations.reader(Duration::ZERO);
    iterations.publish(1, 0, wire::IterationReport::default());
    outbox.result(&result(1, 0), None);
    read(&outbox, &mut reader).await;
    read(&outbox, &mut reader).await;
    assert_eq!(
        outbox.next(&mut reader, Duration::ZERO).await,
        Next::Silence
    );
}

#[tokio::test]
async fn a_flood_of_unread_answers_stops_the_reading_of_messages() {
    let (outbox, _) = outbox(1000);
    let mut reader = Iterations::default().reader(Duration::ZERO);
    for sequence in 0..=MOST_ANSWERS as i64 {
        assert!(!is_pending(outbox.answerable()).await);
        outbox.push(heartbeat(sequence));
    }
    assert!(is_pending(outbox.answerable()).await);
    read(&outbox, &mut reader).await;
    outbox.answerable().await;
}
