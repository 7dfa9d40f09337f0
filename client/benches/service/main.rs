//! How the service behaves under load: a server in this process, clients over
//! loopback, figures on stdout.
//!
//! `cargo bench -p signorini-client --bench service -- NAME [COUNT]` runs one of
//! `updates`, `journal`, `overhead`, `fields`, `control`, `flood`, `cancels`, `abandon`,
//! `watchers`, `hostile`; without a name each runs with a small count.
//! `SIGNORINI_BENCH_MESH` names a larger mesh for `overhead` and `fields`.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::print_stdout,
    reason = "a bench that cannot go on has no other answer"
)]

mod cancels;
mod control;
mod fields;
mod figures;
mod hostile;
mod journal;
mod leases;
mod server;
mod updates;
mod watchers;

type Run = fn(u32) -> Job;
type Job = std::pin::Pin<Box<dyn Future<Output = ()>>>;

/// Name, what it runs, count without an argument.
const ALL: [(&str, Run, u32); 10] = [
    ("updates", |count| Box::pin(updates::run(count)), 200),
    ("journal", |count| Box::pin(journal::run(count)), 200),
    ("overhead", |count| Box::pin(updates::overhead(count)), 5),
    ("fields", |count| Box::pin(fields::run(count)), 64),
    ("control", |count| Box::pin(control::run(count)), 2000),
    ("flood", |count| Box::pin(control::flood(count)), 100),
    ("cancels", |count| Box::pin(cancels::run(count)), 300),
    ("abandon", |count| Box::pin(leases::run(count)), 300),
    ("watchers", |count| Box::pin(watchers::run(count)), 100),
    ("hostile", |count| Box::pin(hostile::run(count)), 5),
];

fn main() {
    // Cargo passes `--bench`.
    let arguments: Vec<String> = std::env::args()
        .skip(1)
        .filter(|argument| !argument.starts_with("--"))
        .collect();
    let wanted = arguments.first();
    let count = arguments.get(1).and_then(|count| count.parse().ok());
    let known = ALL
        .iter()
        .any(|(name, ..)| wanted.is_none_or(|one| one == name));
    assert!(known, "no bench of that name");
    let runtime = tokio::runtime::Runtime::new().unwrap();
    for (name, run, small) in ALL {
        if wanted.is_none_or(|one| one == name) {
            println!("== {name}");
            runtime.block_on(run(count.unwrap_or(small)));
        }
    }
}
