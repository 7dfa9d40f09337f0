//! Methods beside the solver's own that the program brings along.

use std::sync::Arc;

use signorini::Comparisons;

/// What a scene may be solved by beside the solver's own methods; by default nothing.
#[derive(Clone, Debug, Default)]
pub struct Compared(Option<Arc<dyn Comparisons>>);

impl Compared {
    /// By these methods, too.
    pub fn with(methods: impl Comparisons + 'static) -> Self {
        Self(Some(Arc::new(methods)))
    }

    /// The methods, if there are any.
    pub(crate) fn methods(&self) -> Option<Arc<dyn Comparisons>> {
        self.0.clone()
    }
}

/// A program has one list of methods or none.
impl PartialEq for Compared {
    fn eq(&self, other: &Self) -> bool {
        self.0.is_some() == other.0.is_some()
    }
}

impl Eq for Compared {}
