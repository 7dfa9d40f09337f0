//! Messages of `Solve` in any order, from clients that leave, come back, send
//! nonsense or write to one session at once: results are gapless, every accepted
//! update has one last result, rejections leave the stream alive, nothing hangs.
//!
//! A campaign counts messages; each case is a session of its own.

#[allow(dead_code, unused_imports, reason = "only the campaign is used")]
#[path = "../../client/tests/common/fuzz/mod.rs"]
mod fuzz;

#[path = "fuzz_stream/client.rs"]
mod client;
mod common;
#[path = "fuzz_stream/journal.rs"]
mod journal;

use std::time::Duration;

use client::{Client, Ending};
use common::{Block, Server};
use fastrand::Rng;
use fuzz::Campaign;
use fuzz::memory::Budget;
use journal::Journal;
use signorini_proto::v1 as wire;
use signorini_server::Config;

/// Only ever reached by a server that hangs.
const HANGS: Duration = Duration::from_secs(30);

/// What a client may do next.
#[derive(Clone, Copy, Debug)]
enum Move {
    Good,
    Gap,
    Repeat,
    BelowOne,
    NotFinite,
    UnknownObstacle,
    NoObstacle,
    NoIncrement,
    TooManyIncrements,
    LongThenCancel,
    CancelRunning,
    CancelAny,
    CancelElsewhere,
    Await,
    Rival,
    Empty,
    SecondOpen,
    Leave,
    Delete,
}

/// Good moves more often; those that end a stream seldom.
const MOVES: [(Move, usize); 19] = [
    (Move::Good, 24),
    (Move::Gap, 4),
    (Move::Repeat, 4),
    (Move::BelowOne, 2),
    (Move::NotFinite, 4),
    (Move::UnknownObstacle, 4),
    (Move::NoObstacle, 2),
    (Move::NoIncrement, 2),
    (Move::TooManyIncrements, 2),
    (Move::LongThenCancel, 2),
    (Move::CancelRunning, 4),
    (Move::CancelAny, 4),
    (Move::CancelElsewhere, 2),
    (Move::Await, 8),
    (Move::Rival, 1),
    (Move::Empty, 1),
    (Move::SecondOpen, 1),
    (Move::Leave, 3),
    (Move::Delete, 1),
];

fn choose(rng: &mut Rng) -> Move {
    let total: usize = MOVES.iter().map(|(_, weight)| weight).sum();
    let mut left = rng.usize(..total);
    for (chosen, weight) in MOVES {
        if left < weight {
            return chosen;
        }
        left -= weight;
    }
    Move::Good
}

/// Tells which case it was, and its moves, when a check fails.
struct Told {
    campaign: Campaign,
    case: u64,
    moves: Vec<Move>,
}

impl Drop for Told {
    fn drop(&mut self) {
        if std::thread::panicking() {
            let case = self.campaign.describe(self.case, &[]);
            eprintln!("{case}\n{:?}", self.moves);
        }
    }
}

/// One session, played to its end.
async fn play(
    server: &Server,
    scene: wire::Scene,
    rng: &mut Rng,
    moves: &mut Vec<Move>,
) -> [u64; 3] {
    let session = server.session(scene).await;
    let mut journal = Journal::default();
    let mut client = Client::open(server, &session, &mut journal, rng).await;
    for _ in 0..4 + rng.usize(..24) {
        let next = choose(rng);
        moves.push(next);
        match next {
            Move::Delete => {
                delete(server, &session).await;
                let ending = client.end(&mut journal).await;
                assert!(
                    matches!(ending, Ending::Deleted | Ending::Invalid),
                    "{ending:?}"
                );
                return journal.totals();
            }
            Move::Leave => {
                client.leave(&mut journal);
                client = Client::open(server, &session, &mut journal, rng).await;
            }
            Move::Empty | Move::SecondOpen => {
                client.break_protocol(next, &mut journal).await;
                assert_eq!(client.end(&mut journal).await, Ending::Invalid);
                client = Client::open(server, &session, &mut journal, rng).await;
            }
            Move::Rival => client.rival(server).await,
            Move::CancelElsewhere => drop(server.cancel(&session).await),
            Move::Await => client.catch_up(server).await,
            Move::Good
            | Move::Gap
            | Move::Repeat
            | Move::BelowOne
            | Move::NotFinite
            | Move::UnknownObstacle
            | Move::NoObstacle
            | Move::NoIncrement
            | Move::TooManyIncrements
            | Move::LongThenCancel
            | Move::CancelRunning
            | Move::CancelAny => client.update(next, &mut journal, rng).await,
        }
    }
    client.half_close();
    assert_eq!(client.end(&mut journal).await, Ending::Well);
    journal.check_answers();
    settle(server, &session, &mut journal, rng).await;
    delete(server, &session).await;
    journal.totals()
}

async fn delete(server: &Server, session: &str) {
    let request = wire::DeleteSessionRequest {
        name: session.into(),
    };
    server.sessions().delete_session(request).await.unwrap();
}

/// Everything kept, asked for again, is what was told before and is complete.
async fn settle(server: &Server, session: &str, journal: &mut Journal, rng: &mut Rng) {
    let mut again = Client::open_from(server, session, journal, Some(0), rng).await;
    again.half_close();
    assert_eq!(again.end(journal).await, Ending::Well);
    let session = server.describe(session).await;
    assert_eq!(
        session.last_finished_sequence,
        session.last_accepted_sequence
    );
    journal.check_complete(session.last_finished_sequence);
}

#[tokio::test]
async fn any_order_of_messages_keeps_the_promises_of_the_stream() {
    let config = Config {
        memory_budget_bytes: 64 << 20,
        solver_slots: 1,
        threads_per_slot: 1,
        ..Config::embedded()
    };
    let (server, block) = (Server::with(config).await, Block::new(1));
    server.upload(&block).await;
    let (campaign, budget) = (Campaign::from_environment(), Budget::of_mebibytes(128));
    let (mut totals, mut case) = ([0; 3], campaign.first);
    // A message of a stream takes as long as four calls.
    while totals[0] < campaign.cases / 4 {
        let mut rng = campaign.generator(case);
        let mut told = Told {
            campaign,
            case,
            moves: Vec::new(),
        };
        let played = play(&server, block.scene(), &mut rng, &mut told.moves);
        let sent = tokio::time::timeout(HANGS, played).await;
        let played = sent.expect("every case comes to its end");
        totals = std::array::from_fn(|index| totals[index] + played[index]);
        budget.check();
        case += 1;
    }
    let [messages, results, rejections] = totals;
    eprintln!("{messages} messages, {results} results, {rejections} rejections");
    assert!(messages < 500 || (results > 0 && rejections > 0));
    let session = server.session(block.scene()).await;
    assert_eq!(server.describe(&session).await.name, session);
}
