//! Methods that a scene may ask for by name: one closed list of names each.
//!
//! A scene holds a [`Choice`]: `auto`, where the plan decides, or one name of a
//! list. Text becomes a choice once, where it enters the program; a name that no
//! list has is an [`UnknownName`], which tells the nearest one.

mod contact;
mod displacement;
mod element;
mod estimate;
mod p1;
mod report;
mod response;
mod saddle;
mod stability;

pub use contact::{ContactMethod, ContactSpace, MetricKind};
pub use displacement::DisplacementMethod;
pub use element::ElementKind;
pub use estimate::ErrorEstimate;
pub use p1::P1Solver;
pub use report::ReportScope;
pub use response::ResponseMethod;
pub use saddle::SaddleMethod;
pub use stability::{OnInstability, StabilityCheck};

use super::names::hint;

/// The name of a choice that is left to the plan.
const AUTO: &str = "auto";

/// A closed list of names.
pub trait Named: Copy + Eq + 'static {
    /// All of them, in the order in which messages list them.
    const ALL: &'static [Self];

    /// The name in scenes, ASCII.
    fn name(self) -> &'static str;
}

/// Declares an enum and, from the same lines, its list of names.
macro_rules! named {
    (
        $(#[$about:meta])*
        pub enum $list:ident { $($(#[$doc:meta])* $variant:ident = $name:literal,)+ }
    ) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $list { $($(#[$doc])* $variant,)+ }

        impl $crate::scene::choices::Named for $list {
            const ALL: &'static [Self] = &[$(Self::$variant,)+];

            fn name(self) -> &'static str {
                match self { $(Self::$variant => $name,)+ }
            }
        }
    };
}
use named;

/// A method that the plan decides on, or one that the scene asks for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Choice<T> {
    /// The plan decides, and says why.
    #[default]
    Auto,
    /// The scene has the last word; the plan may refuse, but not choose otherwise.
    Named(T),
}

impl<T: Named> Choice<T> {
    /// The method that is asked for, if one is.
    pub fn named(self) -> Option<T> {
        match self {
            Self::Auto => None,
            Self::Named(method) => Some(method),
        }
    }

    /// The name in scenes, `auto` or one of the list.
    pub fn name(self) -> &'static str {
        self.named().map_or(AUTO, T::name)
    }

    /// All names that a scene may write, `auto` being the last.
    pub fn names() -> impl Iterator<Item = &'static str> {
        T::ALL.iter().map(|method| method.name()).chain([AUTO])
    }
}

impl<T: Named> std::str::FromStr for Choice<T> {
    type Err = UnknownName;

    fn from_str(text: &str) -> Result<Self, UnknownName> {
        if text == AUTO {
            return Ok(Self::Auto);
        }
        let known = T::ALL.iter().find(|method| method.name() == text);
        known
            .map(|&method| Self::Named(method))
            .ok_or_else(|| UnknownName {
                name: text.to_owned(),
                hint: hint(text, Self::names()),
            })
    }
}

/// A name that the list of its key does not have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown method `{name}`{hint}")]
pub struct UnknownName {
    /// The name that was given.
    name: String,
    /// The nearest name of the list, or all of them where none is near.
    hint: String,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every name is read back as what it names, and no two are alike.
    fn assert_read_back<T: Named + std::fmt::Debug>() {
        assert_eq!(AUTO.parse(), Ok(Choice::<T>::Auto));
        for &method in T::ALL {
            assert_eq!(method.name().parse(), Ok(Choice::Named(method)));
            assert_eq!(Choice::Named(method).name(), method.name());
        }
        let mut names: Vec<&str> = Choice::<T>::names().collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), T::ALL.len() + 1);
    }

    #[test]
    fn every_name_of_every_list_is_read_back() {
        assert_read_back::<ContactMethod>();
        assert_read_back::<DisplacementMethod>();
        assert_read_back::<ElementKind>();
        assert_read_back::<ErrorEstimate>();
        assert_read_back::<MetricKind>();
        assert_read_back::<P1Solver>();
        assert_read_back::<SaddleMethod>();
        assert_read_back::<StabilityCheck>();
        assert_read_back::<OnInstability>();
    }

    fn message<T: Named + std::fmt::Debug>(text: &str) -> String {
        let read: Result<Choice<T>, UnknownName> = text.parse();
        read.expect_err("an unknown name").to_string()
    }

    #[test]
    fn an_unknown_name_is_told_with_the_nearest_one_or_with_all() {
        let cases = [
            (
                message::<SaddleMethod>("gccr"),
                "unknown method `gccr`; did you mean `gcr`?",
            ),
            (
                message::<MetricKind>("fractionel"),
                "unknown method `fractionel`; did you mean `fractional`?",
            ),
            (
                message::<P1Solver>("Amg"),
                "unknown method `Amg`; did you mean `amg`?",
            ),
            (
                message::<P1Solver>("pardiso"),
                "unknown method `pardiso`; known: cholesky, amg, ic-cg, auto",
            ),
            (
                message::<ErrorEstimate>(""),
                "unknown method ``; known: off, auto",
            ),
        ];
        for (found, expected) in cases {
            assert_eq!(found, expected);
        }
    }
}
