//! A queue that is fair between clients: start-time fair queueing.
//!
//! Each job starts at the virtual time `S = max(V, F)`: `V` is the start of the
//! job served last, `F` the virtual time at which the client's earlier jobs
//! ended, which grows by the seconds they took. Served first is the client with
//! the fewest jobs running, then the smallest `S`, then the job that came first.
//! A client that floods the queue so waits behind everybody else, and one that
//! was away has saved up nothing. Reference: Goyal, Vin, Cheng, "Start-time fair
//! queueing", SIGCOMM 1996. Cost: one look at every client that waits.

use std::collections::{HashMap, VecDeque};
use std::hash::Hash;

/// Clients without jobs whose shares are remembered.
const REMEMBERED: usize = 1024;

struct Client<T> {
    /// Jobs that wait, with their numbers of arrival.
    waiting: VecDeque<(u64, T)>,
    running: usize,
    /// Virtual time, seconds, at which its finished jobs ended.
    finish: f64,
}

impl<T> Default for Client<T> {
    fn default() -> Self {
        Self {
            waiting: VecDeque::new(),
            running: 0,
            finish: 0.0,
        }
    }
}

/// Jobs of clients `K`.
pub(crate) struct FairQueue<K, T> {
    clients: HashMap<K, Client<T>>,
    /// Virtual time, seconds.
    now: f64,
    arrivals: u64,
}

impl<K, T> Default for FairQueue<K, T> {
    fn default() -> Self {
        Self {
            clients: HashMap::new(),
            now: 0.0,
            arrivals: 0,
        }
    }
}

impl<K: Copy + Eq + Hash, T> FairQueue<K, T> {
    /// Appends a job of a client.
    pub(crate) fn push(&mut self, client: K, job: T) {
        self.arrivals += 1;
        let number = self.arrivals;
        self.forget_idle();
        let entry = self.clients.entry(client).or_default();
        entry.waiting.push_back((number, job));
    }

    /// The job to run next, which counts as running until [`FairQueue::finished`].
    pub(crate) fn pop(&mut self) -> Option<(K, T)> {
        let client = self.next_client()?;
        let now = self.now;
        let entry = self.clients.get_mut(&client)?;
        let (_, job) = entry.waiting.pop_front()?;
        entry.running += 1;
        entry.finish = entry.finish.max(now);
        self.now = entry.finish;
        Some((client, job))
    }

    /// A job of `client` ended after `seconds`.
    pub(crate) fn finished(&mut self, client: K, seconds: f64) {
        if let Some(entry) = self.clients.get_mut(&client) {
            entry.running = entry.running.saturating_sub(1);
            entry.finish += seconds;
        }
    }

    /// Whether a next job of `client`, which has none waiting, would be served
    /// before all that wait.
    pub(crate) fn would_be_next(&self, client: K) -> bool {
        let Some(own) = self.clients.get(&client) else {
            return false;
        };
        let best = self.next_client().and_then(|best| self.clients.get(&best));
        own.waiting.is_empty() && best.is_some_and(|best| self.rank(own) < self.rank(best))
    }

    /// Jobs of `client` that wait.
    pub(crate) fn waiting(&self, client: K) -> usize {
        self.clients.get(&client).map_or(0, |one| one.waiting.len())
    }

    /// Jobs that wait.
    pub(crate) fn len(&self) -> usize {
        self.clients.values().map(|one| one.waiting.len()).sum()
    }

    fn next_client(&self) -> Option<K> {
        let waiting = self.clients.iter().filter_map(|(client, one)| {
            let (number, _) = one.waiting.front()?;
            Some((self.rank(one), *number, *client))
        });
        let order = |a: &(Rank, u64, K), b: &(Rank, u64, K)| a.0.order(b.0).then(a.1.cmp(&b.1));
        waiting.min_by(order).map(|(_, _, client)| client)
    }

    fn rank(&self, client: &Client<T>) -> Rank {
        Rank {
            running: client.running,
            start: client.finish.max(self.now),
        }
    }

    fn forget_idle(&mut self) {
        if self.clients.len() > REMEMBERED {
            let now = self.now;
            self.clients
                .retain(|_, one| !one.waiting.is_empty() || one.running > 0 || one.finish > now);
        }
    }
}

#[derive(Clone, Copy, PartialEq, PartialOrd)]
struct Rank {
    running: usize,
    start: f64,
}

impl Rank {
    fn order(self, other: Self) -> std::cmp::Ordering {
        let start = self.start.total_cmp(&other.start);
        self.running.cmp(&other.running).then(start)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs the next job for a second and says whose it was.
    fn serve(queue: &mut FairQueue<char, u32>) -> char {
        let (client, _) = queue.pop().unwrap();
        queue.finished(client, 1.0);
        client
    }

    #[test]
    fn a_flood_and_a_single_client_take_turns() {
        let mut queue = FairQueue::default();
        (0..100).for_each(|job| queue.push('f', job));
        (0..3).for_each(|job| queue.push('c', job));
        let order: String = (0..8).map(|_| serve(&mut queue)).collect();
        assert_eq!(order, "fcfcfcff");
    }

    #[test]
    fn jobs_of_one_client_keep_their_order() {
        let mut queue = FairQueue::default();
        (0..3).for_each(|job| queue.push('a', job));
        let order: Vec<u32> = (0..3).map(|_| queue.pop().unwrap().1).collect();
        assert_eq!(order, [0, 1, 2]);
        assert!(queue.pop().is_none());
    }

    #[test]
    fn whoever_has_nothing_running_comes_first() {
        let mut queue = FairQueue::default();
        queue.push('c', 0);
        assert_eq!(serve(&mut queue), 'c');
        (0..2).for_each(|job| queue.push('f', job));
        assert_eq!(queue.pop().unwrap().0, 'f');
        assert!(queue.would_be_next('c'));
        queue.push('c', 1);
        assert_eq!(queue.pop().unwrap().0, 'c');
        assert!(!queue.would_be_next('c'));
    }

    #[test]
    fn long_jobs_cost_more_turns_than_short_ones() {
        let mut queue = FairQueue::default();
        for job in 0..20 {
            queue.push('l', job);
            queue.push('s', job);
        }
        let mut served = HashMap::new();
        for _ in 0..12 {
            let (client, _) = queue.pop().unwrap();
            queue.finished(client, if client == 'l' { 5.0 } else { 1.0 });
            *served.entry(client).or_insert(0) += 1;
        }
        assert_eq!((served[&'l'], served[&'s']), (2, 10));
    }

    #[test]
    fn a_client_that_was_away_has_saved_up_nothing() {
        let mut queue = FairQueue::default();
        (0..20).for_each(|job| queue.push('a', job));
        for _ in 0..10 {
            serve(&mut queue);
        }
        (0..10).for_each(|job| queue.push('b', job));
        let order: String = (0..6).map(|_| serve(&mut queue)).collect();
        assert_eq!(order.matches('b').count(), 3, "{order}");
    }

    #[test]
    fn clients_without_jobs_are_forgotten() {
        let mut queue = FairQueue::default();
        for client in 0..5000_u32 {
            queue.push(client, 0);
            let (client, _) = queue.pop().unwrap();
            queue.finished(client, 0.0);
        }
        assert!(queue.clients.len() <= REMEMBERED + 1);
    }
}
