//! Sets of nodes and of elements, as they are written: numbers, runs of numbers, and the
//! names of other sets.
//!
//! Runs stay runs until the mesh is there, so that `1, 1000000000` costs nothing. Both
//! forms are held to a multiple of the size of the file.

use std::collections::HashMap;

use super::error::InpFault;

/// Who sees a set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Visibility {
    /// It becomes a group.
    Group,
    /// Other sets, surfaces and sections refer to it (`INTERNAL`).
    Internal,
}

/// Numbers from first to last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Run {
    pub(super) first: u64,
    pub(super) last: u64,
    /// At least 1.
    pub(super) step: u64,
}

impl Set {
    /// Whether it has no numbers, whatever they are.
    pub(super) fn is_empty(&self) -> bool {
        self.runs.is_empty()
    }
}

impl Run {
    /// One number.
    pub(super) fn one(number: u64) -> Self {
        Self {
            first: number,
            last: number,
            step: 1,
        }
    }
}

/// Numbers of a part in the deck that it is put into.
#[derive(Clone, Copy, Debug)]
pub(super) struct Numbers {
    base: u64,
    /// The largest one of the part.
    most: u64,
}

impl Numbers {
    /// Those after the largest one of a deck.
    pub(super) fn after(base: u64, most: u64) -> Result<Self, InpFault> {
        let fits = base.checked_add(most).is_some();
        let what = || "node or element numbers of this size in several instances".to_owned();
        fits.then_some(Self { base, most })
            .ok_or_else(|| InpFault::Unsupported(what()))
    }

    /// A number of the part in the deck; one that the part cannot have is no number.
    pub(super) fn of(self, number: u64) -> u64 {
        if number > self.most {
            return u64::MAX;
        }
        self.base.saturating_add(number)
    }

    /// The part of a run that the part can have.
    pub(super) fn run(self, run: Run) -> Option<Run> {
        (run.first <= self.most).then(|| Run {
            first: self.of(run.first),
            last: self.of(run.last.min(self.most)),
            ..run
        })
    }
}

/// A named set.
#[derive(Clone, Debug)]
pub(super) struct Set {
    /// As it is written first.
    pub(super) name: String,
    /// Name of the instance that it is of; empty where it is of none.
    pub(super) owner: String,
    pub(super) visibility: Visibility,
    runs: Vec<Run>,
}

/// What the sets of a file may still hold.
#[derive(Clone, Copy, Debug)]
pub(super) struct Allowance {
    limit: usize,
    left: usize,
}

impl Allowance {
    pub(super) fn new(limit: usize) -> Self {
        Self { limit, left: limit }
    }

    /// Takes a part of it.
    pub(super) fn take(&mut self, count: usize) -> Result<(), InpFault> {
        let left = self.left.checked_sub(count);
        self.left = left.ok_or(InpFault::TooManyMembers(self.limit))?;
        Ok(())
    }
}

/// All sets of one sort.
#[derive(Clone, Debug, Default)]
pub(super) struct Sets {
    pub(super) all: Vec<Set>,
    index: HashMap<String, usize>,
    /// Sets of instances by their own names; none where several have the name.
    of_instances: HashMap<String, Option<usize>>,
}

impl Sets {
    /// The set of a name, whose case does not count; made where there is none.
    pub(super) fn open(&mut self, name: &str, visibility: Visibility) -> usize {
        let key = name.to_ascii_uppercase();
        if let Some(found) = self.index.get(&key) {
            return *found;
        }
        self.all.push(Set {
            name: name.to_owned(),
            owner: String::new(),
            visibility,
            runs: Vec::new(),
        });
        self.index.insert(key, self.all.len() - 1);
        self.all.len() - 1
    }

    /// The set of a name, whose case does not count; that of an instance by `INSTANCE.SET`, or by
    /// its own name where one instance alone has it.
    pub(super) fn find(&self, name: &str) -> Option<usize> {
        let key = name.to_ascii_uppercase();
        let own = self.index.get(&key).copied();
        own.or_else(|| self.of_instances.get(&key).copied().flatten())
    }

    /// Adds the sets of a part under the name of its instance; where each of them is.
    pub(super) fn adopt(&mut self, part: &Self, owner: &str, numbers: Numbers) -> Vec<usize> {
        let mut places = Vec::with_capacity(part.all.len());
        for set in &part.all {
            let at = self.all.len();
            places.push(at);
            let own = set.name.to_ascii_uppercase();
            let key = format!("{}.{own}", owner.to_ascii_uppercase());
            self.index.entry(key).or_insert(at);
            self.of_instances
                .entry(own)
                .and_modify(|found| *found = None)
                .or_insert(Some(at));
            let runs = set.runs.iter();
            self.all.push(Set {
                owner: owner.to_owned(),
                runs: runs.filter_map(|run| numbers.run(*run)).collect(),
                ..set.clone()
            });
        }
        places
    }

    /// Sets and their runs.
    pub(super) fn size(&self) -> usize {
        self.all.iter().map(|set| 1 + set.runs.len()).sum()
    }

    /// Adds a run, joined to the last one where it goes on; one that ends before it begins is
    /// empty.
    pub(super) fn add(&mut self, set: usize, run: Run) {
        if run.last < run.first {
            return;
        }
        let Some(set) = self.all.get_mut(set) else {
            return;
        };
        match set.runs.last_mut() {
            Some(last)
                if last.step == 1
                    && run.step == 1
                    && last.last.checked_add(1) == Some(run.first) =>
            {
                last.last = run.last;
            }
            _ => set.runs.push(run),
        }
    }

    /// Adds what another set has so far.
    pub(super) fn add_set(
        &mut self,
        set: usize,
        other: usize,
        allowance: &mut Allowance,
    ) -> Result<(), InpFault> {
        let other = self.all.get(other);
        allowance.take(other.map_or(0, |other| other.runs.len()))?;
        let runs = other.map(|other| other.runs.clone()).unwrap_or_default();
        for run in runs {
            self.add(set, run);
        }
        Ok(())
    }
}

/// Numbers in ascending order with their positions in the file.
#[derive(Clone, Debug)]
pub(super) struct Order(Vec<(u64, u32)>);

impl Order {
    pub(super) fn new(numbers: impl Iterator<Item = u64>) -> Self {
        let mut order: Vec<(u64, u32)> = numbers.zip(0..).collect();
        order.sort_unstable();
        Self(order)
    }

    /// A number that is there twice.
    pub(super) fn repeated(&self) -> Option<u64> {
        let mut pairs = self.0.iter().zip(self.0.iter().skip(1));
        pairs.find(|(a, b)| a.0 == b.0).map(|(a, _)| a.0)
    }

    /// The position of a number.
    pub(super) fn position(&self, number: u64) -> Option<u32> {
        let found = self.0.binary_search_by_key(&number, |(number, _)| *number);
        found.ok().and_then(|at| self.0.get(at)).map(|(_, at)| *at)
    }

    /// Ascending positions of the members of a set; numbers that nothing has are left out.
    pub(super) fn members(
        &self,
        set: &Set,
        allowance: &mut Allowance,
    ) -> Result<Vec<u32>, InpFault> {
        let mut members = Vec::new();
        for run in &set.runs {
            let from = self.0.partition_point(|(number, _)| *number < run.first);
            let within = self
                .0
                .iter()
                .skip(from)
                .take_while(|(number, _)| *number <= run.last);
            for (number, position) in within {
                allowance.take(1)?;
                if (number - run.first).is_multiple_of(run.step) {
                    members.push(*position);
                }
            }
        }
        members.sort_unstable();
        members.dedup();
        Ok(members)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(first: u64, last: u64, step: u64) -> Run {
        Run { first, last, step }
    }

    #[test]
    fn runs_meet_the_numbers_that_are_there() {
        let mut sets = Sets::default();
        let set = sets.open("Top", Visibility::Group);
        sets.add(set, run(1, u64::MAX, 2));
        sets.add(set, Run::one(4));
        sets.add(set, Run::one(5));
        assert_eq!(sets.all[0].runs.len(), 2);
        assert_eq!(sets.find("TOP"), Some(set));
        let order = Order::new([7, 4, 9, 2, 5].into_iter());
        let members = order
            .members(&sets.all[set], &mut Allowance::new(20))
            .unwrap();
        assert_eq!(members, [0, 1, 2, 4]);
        assert!(
            order
                .members(&sets.all[set], &mut Allowance::new(3))
                .is_err()
        );
        assert_eq!((order.position(9), order.position(3)), (Some(2), None));
    }

    #[test]
    fn sets_of_sets_cannot_double_without_end() {
        let (mut sets, mut allowance) = (Sets::default(), Allowance::new(1000));
        let mut last = sets.open("0", Visibility::Group);
        sets.add(last, run(1, 9, 2));
        let mut outcome = Ok(());
        for level in 1..40 {
            let next = sets.open(&level.to_string(), Visibility::Group);
            for _ in 0..2 {
                outcome = outcome.and_then(|()| sets.add_set(next, last, &mut allowance));
            }
            last = next;
        }
        assert_eq!(outcome, Err(InpFault::TooManyMembers(1000)));
    }
}
