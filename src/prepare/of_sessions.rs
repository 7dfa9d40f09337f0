//! What sessions on the same prepared data make of them, each to the same bits: held by those that
//! use it, found here by the others, gone with the last of them.

use std::any::Any;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

/// What may be shared.
type Made = dyn Any + Send + Sync;

/// What sessions have made.
#[derive(Default)]
pub(crate) struct OfSessions(Mutex<Vec<Weak<Made>>>);

impl OfSessions {
    /// What some session has made and `is_wanted`.
    pub(crate) fn find<T: Any + Send + Sync>(
        &self,
        is_wanted: impl Fn(&T) -> bool,
    ) -> Option<Arc<T>> {
        found(&self.lock(), is_wanted)
    }

    /// What was made meanwhile and `is_same`, or else `made`, for others to find.
    pub(crate) fn offer<T: Any + Send + Sync>(
        &self,
        made: T,
        is_same: impl Fn(&T, &T) -> bool,
    ) -> Arc<T> {
        let mut all = self.lock();
        if let Some(other) = found(&all, |other| is_same(other, &made)) {
            return other;
        }
        let made = Arc::new(made);
        let shared: Arc<Made> = made.clone();
        all.retain(|other| other.strong_count() > 0);
        all.push(Arc::downgrade(&shared));
        made
    }

    fn lock(&self) -> MutexGuard<'_, Vec<Weak<Made>>> {
        // Nothing that may panic leaves the list in parts.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn found<T: Any + Send + Sync>(
    all: &[Weak<Made>],
    is_wanted: impl Fn(&T) -> bool,
) -> Option<Arc<T>> {
    let held = all.iter().filter_map(Weak::upgrade);
    let mut of_kind = held.filter_map(|one| one.downcast::<T>().ok());
    of_kind.find(|one| is_wanted(one))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_one_session_has_made_the_next_one_finds_until_the_last_is_gone() {
        let shared = OfSessions::default();
        assert!(shared.find(|_: &u32| true).is_none());
        let first = shared.offer(7_u32, u32::eq);
        let second = shared.offer(7_u32, u32::eq);
        assert!(Arc::ptr_eq(&first, &second));
        let other = shared.offer(8_u32, u32::eq);
        assert!(shared.find(|one: &u64| *one == 7).is_none());
        let found = shared.find(|one: &u32| *one == 8).expect("it is held");
        assert!(Arc::ptr_eq(&other, &found));
        drop((first, second));
        assert!(shared.find(|one: &u32| *one == 7).is_none());
    }
}
