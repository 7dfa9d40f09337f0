//! A queue that is fair at every level of a tree: start-time fair queueing.
//!
//! A job belongs to a path: a client, a connection of that client, a session of that
//! connection. On each level a job starts at the virtual time `S = max(V, F)`: `V` is
//! the start of the job served last among these siblings, `F` the virtual time at
//! which the jobs of this node ended, which grows by the seconds they took. Served
//! first is the node with the fewest jobs running, then the smallest `S`, then the
//! job that came first; then the same among its children. A client that floods the
//! queue, over however many connections, so waits behind everybody else, and one
//! that was away has saved up nothing. Reference: Goyal, Vin, Cheng, "Start-time fair
//! queueing", SIGCOMM 1996. Cost: one look at every path that waits.

use std::cmp::Ordering;
use std::collections::{HashMap, VecDeque};
use std::hash::Hash;

/// Children without jobs whose shares a node remembers.
const REMEMBERED: usize = 1024;

struct Node<K, T> {
    /// Jobs that wait right here, with their numbers of arrival.
    waiting: VecDeque<(u64, T)>,
    children: HashMap<K, Node<K, T>>,
    /// Jobs of this node and those below that run.
    running: usize,
    /// Virtual time, seconds, at which its finished jobs ended.
    finish: f64,
    /// Virtual time of its children, seconds.
    now: f64,
}

impl<K, T> Default for Node<K, T> {
    fn default() -> Self {
        Self {
            waiting: VecDeque::new(),
            children: HashMap::new(),
            running: 0,
            finish: 0.0,
            now: 0.0,
        }
    }
}

#[derive(Clone, Copy)]
struct Rank {
    running: usize,
    start: f64,
}

impl Rank {
    fn order(self, other: Self) -> Ordering {
        let start = self.start.total_cmp(&other.start);
        self.running.cmp(&other.running).then(start)
    }
}

impl<K: Copy + Eq + Hash, T> Node<K, T> {
    fn child(&mut self, key: K) -> &mut Self {
        if !self.children.contains_key(&key) && self.children.len() >= REMEMBERED {
            let now = self.now;
            self.children
                .retain(|_, one| !one.is_idle() || one.finish > now);
        }
        self.children.entry(key).or_default()
    }

    fn is_idle(&self) -> bool {
        self.running == 0 && self.len() == 0
    }

    fn len(&self) -> usize {
        let below: usize = self.children.values().map(Self::len).sum();
        self.waiting.len() + below
    }

    fn rank(&self, now: f64) -> Rank {
        Rank {
            running: self.running,
            start: self.finish.max(now),
        }
    }

    /// Arrival of the oldest job at the head of its path that may be served.
    fn arrival(&self, may: &impl Fn(&T) -> bool) -> Option<u64> {
        let own = self.waiting.front().filter(|(_, job)| may(job));
        let own = own.map(|(number, _)| *number);
        let below = self.children.values().filter_map(|one| one.arrival(may));
        own.into_iter().chain(below).min()
    }

    /// The child to serve next.
    fn best(&self, may: &impl Fn(&T) -> bool) -> Option<(K, Rank)> {
        let waiting = self.children.iter().filter_map(|(key, one)| {
            let number = one.arrival(may)?;
            Some((one.rank(self.now), number, *key))
        });
        let order = |a: &(Rank, u64, K), b: &(Rank, u64, K)| a.0.order(b.0).then(a.1.cmp(&b.1));
        let (rank, _, key) = waiting.min_by(order)?;
        Some((key, rank))
    }

    fn pop(&mut self, may: &impl Fn(&T) -> bool, path: &mut Vec<K>) -> Option<T> {
        self.running += 1;
        if self.waiting.front().is_some_and(|(_, job)| may(job)) {
            return self.waiting.pop_front().map(|(_, job)| job);
        }
        let (key, _) = self.best(may)?;
        let now = self.now;
        let child = self.children.get_mut(&key)?;
        child.finish = child.finish.max(now);
        self.now = child.finish;
        path.push(key);
        child.pop(may, path)
    }
}

/// Jobs `T` by paths of keys `K`.
pub(crate) struct FairQueue<K, T> {
    root: Node<K, T>,
    arrivals: u64,
}

impl<K, T> Default for FairQueue<K, T> {
    fn default() -> Self {
        Self {
            root: Node::default(),
            arrivals: 0,
        }
    }
}

impl<K: Copy + Eq + Hash, T> FairQueue<K, T> {
    /// Appends a job.
    pub(crate) fn push(&mut self, path: &[K], job: T) {
        let number = self.arrive();
        self.node(path).waiting.push_back((number, job));
    }

    /// Puts a job before those of its path: it has begun already.
    pub(crate) fn push_front(&mut self, path: &[K], job: T) {
        let number = self.arrive();
        self.node(path).waiting.push_front((number, job));
    }

    fn arrive(&mut self) -> u64 {
        self.arrivals += 1;
        self.arrivals
    }

    fn node(&mut self, path: &[K]) -> &mut Node<K, T> {
        let mut node = &mut self.root;
        for key in path {
            node = node.child(*key);
        }
        node
    }

    fn find(&self, path: &[K]) -> Option<&Node<K, T>> {
        let root = Some(&self.root);
        path.iter().fold(root, |node, key| node?.children.get(key))
    }

    /// The next job that `may` be served; it counts as running until
    /// [`FairQueue::finished`].
    pub(crate) fn pop(&mut self, may: impl Fn(&T) -> bool) -> Option<(Vec<K>, T)> {
        self.root.arrival(&may)?;
        let mut path = Vec::new();
        let job = self.root.pop(&may, &mut path)?;
        Some((path, job))
    }

    /// Takes the job of a path for which `is` holds out of the queue.
    pub(crate) fn remove(&mut self, path: &[K], is: impl Fn(&T) -> bool) {
        self.node(path).waiting.retain(|(_, job)| !is(job));
    }

    /// A job of `path` runs again.
    pub(crate) fn started(&mut self, path: &[K]) {
        self.along(path, |node| node.running += 1);
    }

    /// A job of `path` ended, or paused, after `seconds`.
    pub(crate) fn finished(&mut self, path: &[K], seconds: f64) {
        self.along(path, |node| {
            node.running = node.running.saturating_sub(1);
            node.finish += seconds;
        });
    }

    fn along(&mut self, path: &[K], mut change: impl FnMut(&mut Node<K, T>)) {
        let mut node = &mut self.root;
        change(node);
        for key in path {
            node = node.child(*key);
            change(node);
        }
    }

    /// Whether something else waits and a job of `path` would be served before all of it.
    pub(crate) fn would_be_next(&self, path: &[K], may: impl Fn(&T) -> bool) -> bool {
        self.root.arrival(&may).is_some() && !self.comes_before(path, may)
    }

    /// Whether something waits that would be served before a job of `path`.
    pub(crate) fn comes_before(&self, path: &[K], may: impl Fn(&T) -> bool) -> bool {
        let mut node = &self.root;
        for key in path {
            let own = node.children.get(key);
            let rank = own.map_or(
                Rank {
                    running: 0,
                    start: node.now,
                },
                |own| own.rank(node.now),
            );
            match node.best(&may) {
                Some((best, of)) if best != *key => {
                    // Among equals the one that waits already.
                    if of.order(rank).is_le() {
                        return true;
                    }
                }
                Some(_) | None => {}
            }
            match own {
                Some(own) => node = own,
                None => return false,
            }
        }
        node.waiting.front().is_some_and(|(_, job)| may(job))
    }

    /// Jobs of `path` and below that wait.
    pub(crate) fn waiting(&self, path: &[K]) -> usize {
        self.find(path).map_or(0, Node::len)
    }

    /// Jobs that wait.
    pub(crate) fn len(&self) -> usize {
        self.root.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn any<T>(_: &T) -> bool {
        true
    }

    /// Runs the next job for a second and says whose it was.
    fn serve(queue: &mut FairQueue<char, u32>) -> char {
        let (path, _) = queue.pop(any).unwrap();
        queue.finished(&path, 1.0);
        path[0]
    }

    #[test]
    fn a_flood_and_a_single_client_take_turns() {
        let mut queue = FairQueue::default();
        (0..100).for_each(|job| queue.push(&['f'], job));
        (0..3).for_each(|job| queue.push(&['c'], job));
        let order: String = (0..8).map(|_| serve(&mut queue)).collect();
        assert_eq!(order, "fcfcfcff");
    }

    #[test]
    fn twelve_connections_of_a_client_have_one_share_together() {
        let mut queue = FairQueue::default();
        for connection in 'A'..='L' {
            (0..100).for_each(|job| queue.push(&['f', connection], job));
        }
        (0..100).for_each(|job| queue.push(&['c', 'x'], job));
        let order: String = (0..40).map(|_| serve(&mut queue)).collect();
        assert_eq!(order.matches('c').count(), 20, "{order}");
        assert_eq!(queue.waiting(&['c']), 80);
        assert_eq!(queue.waiting(&['f', 'A']) + 2, 100);
    }

    #[test]
    fn jobs_of_one_client_keep_their_order_and_one_that_has_begun_goes_first() {
        let mut queue = FairQueue::default();
        (0..3).for_each(|job| queue.push(&['a'], job));
        queue.push_front(&['a'], 9);
        let order: Vec<u32> = (0..4).map(|_| queue.pop(any).unwrap().1).collect();
        assert_eq!(order, [9, 0, 1, 2]);
        assert!(queue.pop(any).is_none());
    }

    #[test]
    fn what_may_not_be_served_is_passed_over() {
        let mut queue = FairQueue::default();
        queue.push(&['a', 'x'], 1);
        queue.push(&['b', 'y'], 2);
        let even = |job: &u32| job.is_multiple_of(2);
        assert_eq!(queue.pop(even), Some((vec!['b', 'y'], 2)));
        assert_eq!(queue.pop(even), None);
        queue.remove(&['a', 'x'], |job| *job == 1);
        assert_eq!(queue.len(), 0);
    }

    #[test]
    fn whoever_has_nothing_running_comes_first() {
        let mut queue = FairQueue::default();
        queue.push(&['c'], 0);
        assert_eq!(serve(&mut queue), 'c');
        (0..2).for_each(|job| queue.push(&['f'], job));
        assert_eq!(queue.pop(any).unwrap().0, ['f']);
        assert!(queue.would_be_next(&['c'], any));
        queue.push(&['c'], 1);
        assert_eq!(queue.pop(any).unwrap().0, ['c']);
        assert!(!queue.would_be_next(&['c'], any));
    }

    #[test]
    fn a_long_job_gives_way_to_whoever_had_less_and_only_to_those() {
        let mut queue = FairQueue::default();
        queue.push(&['l', 'x'], 0);
        let (path, _) = queue.pop(any).unwrap();
        queue.finished(&path, 1.0);
        assert!(!queue.comes_before(&path, any));
        queue.push(&['s', 'y'], 0);
        assert!(queue.comes_before(&path, any));
        assert_eq!(queue.pop(any).unwrap().0, ['s', 'y']);
        queue.finished(&['s', 'y'], 5.0);
        queue.push(&['s', 'y'], 1);
        assert!(!queue.comes_before(&path, any));
    }

    #[test]
    fn long_jobs_cost_more_turns_than_short_ones() {
        let mut queue = FairQueue::default();
        for job in 0..20 {
            queue.push(&['l'], job);
            queue.push(&['s'], job);
        }
        let mut served = HashMap::new();
        for _ in 0..12 {
            let (path, _) = queue.pop(any).unwrap();
            queue.finished(&path, if path == ['l'] { 5.0 } else { 1.0 });
            *served.entry(path[0]).or_insert(0) += 1;
        }
        assert_eq!((served[&'l'], served[&'s']), (2, 10));
    }

    #[test]
    fn a_client_that_was_away_has_saved_up_nothing() {
        let mut queue = FairQueue::default();
        (0..20).for_each(|job| queue.push(&['a'], job));
        for _ in 0..10 {
            serve(&mut queue);
        }
        (0..10).for_each(|job| queue.push(&['b'], job));
        let order: String = (0..6).map(|_| serve(&mut queue)).collect();
        assert_eq!(order.matches('b').count(), 3, "{order}");
    }

    #[test]
    fn clients_without_jobs_are_forgotten() {
        let mut queue = FairQueue::default();
        for client in 0..5000_u32 {
            queue.push(&[client], 0);
            let (path, _) = queue.pop(any).unwrap();
            queue.finished(&path, 0.0);
        }
        assert!(queue.root.children.len() <= REMEMBERED + 1);
    }
}
