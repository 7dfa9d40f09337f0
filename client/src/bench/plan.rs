//! Which runs a bench consists of.

use std::time::Duration;

use super::family::{FAMILIES, Family, Level};
use super::method::Method;

/// How much a bench does by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Extent {
    /// Small meshes, two minutes at most.
    Quick,
    /// All levels and methods.
    Full,
}

/// What a bench is asked for; what is empty is chosen by its extent.
#[derive(Clone, Debug)]
pub(crate) struct Wishes {
    pub(crate) extent: Extent,
    pub(crate) scenes: Vec<&'static Family>,
    pub(crate) levels: Vec<Level>,
    pub(crate) methods: Vec<Method>,
    pub(crate) tolerances: Vec<f64>,
    pub(crate) repeats: Option<usize>,
    pub(crate) run_limit: Option<Duration>,
    pub(crate) budget: Option<Duration>,
}

/// One scene at one size, method and tolerance.
#[derive(Clone, Debug)]
pub(crate) struct Case {
    pub(crate) family: &'static Family,
    pub(crate) level: Level,
    pub(crate) method: Method,
    pub(crate) tolerance: f64,
}

impl Case {
    /// For progress and tables.
    pub(crate) fn name(&self) -> String {
        let Self {
            family,
            level,
            method,
            tolerance,
        } = self;
        format!("{} {level}, {method}, tolerance {tolerance:e}", family.name)
    }

    /// Whether the other is the same at another size.
    pub(crate) fn is_curve_of(&self, other: &Self) -> bool {
        self.family.name == other.family.name
            && self.method == other.method
            && self.tolerance.total_cmp(&other.tolerance).is_eq()
    }
}

/// The cases, small meshes first, and how often and how long they may run.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub(crate) cases: Vec<Case>,
    pub(crate) repeats: usize,
    pub(crate) run_limit: Duration,
    pub(crate) budget: Option<Duration>,
}

/// What an extent chooses.
struct Defaults {
    methods: &'static [&'static str],
    tolerances: &'static [f64],
    run_limit: u64,
    budget: Option<u64>,
}

const QUICK: Defaults = Defaults {
    methods: &["auto"],
    tolerances: &[1e-8, 1e-3],
    run_limit: 20,
    // Leaves a few seconds of the two minutes for drawing and a late end.
    budget: Some(105),
};

const FULL: Defaults = Defaults {
    methods: &["auto", "p1_solver=cholesky", "p1_solver=amg"],
    tolerances: &[1e-8, 1e-3],
    run_limit: 300,
    budget: None,
};

const REPEATS: usize = 3;

impl Wishes {
    /// The plan; empty when no scene has one of the levels.
    ///
    /// # Errors
    /// A default method that cannot be read, which a test excludes.
    pub(crate) fn plan(self) -> Result<Plan, String> {
        let defaults = match self.extent {
            Extent::Quick => QUICK,
            Extent::Full => FULL,
        };
        let cases = self.cases(&defaults)?;
        let seconds = Duration::from_secs;
        Ok(Plan {
            cases,
            repeats: self.repeats.unwrap_or(REPEATS),
            run_limit: self.run_limit.unwrap_or(seconds(defaults.run_limit)),
            budget: self.budget.or(defaults.budget.map(seconds)),
        })
    }

    fn cases(&self, defaults: &Defaults) -> Result<Vec<Case>, String> {
        let methods = match self.methods.as_slice() {
            [] => defaults
                .methods
                .iter()
                .map(|name| name.parse())
                .collect::<Result<_, _>>()?,
            methods => methods.to_vec(),
        };
        let tolerances = match self.tolerances.as_slice() {
            [] => defaults.tolerances,
            tolerances => tolerances,
        };
        let mut cases = Vec::new();
        for (rank, family, level) in self.levels() {
            for method in &methods {
                let method = || method.clone();
                cases.extend(tolerances.iter().map(|&tolerance| {
                    (
                        rank,
                        Case {
                            family,
                            level,
                            method: method(),
                            tolerance,
                        },
                    )
                }));
            }
        }
        cases.sort_by_key(|case| case.0);
        Ok(cases.into_iter().map(|case| case.1).collect())
    }

    /// Levels of the families, with their rank in the family.
    fn levels(&self) -> Vec<(usize, &'static Family, Level)> {
        let mut families: Vec<&'static Family> = self.scenes.clone();
        if families.is_empty() {
            families = FAMILIES.iter().collect();
        }
        let levels = families.into_iter().flat_map(|family| {
            let levels = self.levels_of(family).into_iter().enumerate();
            levels.map(move |(rank, level)| (rank, family, level))
        });
        levels.collect()
    }

    fn levels_of(&self, family: &Family) -> Vec<Level> {
        let letter = family.source.letter();
        if !self.levels.is_empty() {
            let mut levels = self.levels.clone();
            levels.retain(|level| level.letter == letter);
            levels.sort_unstable();
            levels.dedup();
            return levels;
        }
        let numbers = match self.extent {
            Extent::Quick => family.quick,
            Extent::Full => family.full,
        };
        numbers
            .iter()
            .map(|&number| Level { letter, number })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wishes(extent: Extent) -> Wishes {
        Wishes {
            extent,
            scenes: Vec::new(),
            levels: Vec::new(),
            methods: Vec::new(),
            tolerances: Vec::new(),
            repeats: None,
            run_limit: None,
            budget: None,
        }
    }

    #[test]
    fn every_extent_has_a_plan_with_small_meshes_first() {
        for extent in [Extent::Quick, Extent::Full] {
            let plan = wishes(extent).plan().unwrap();
            assert_eq!(plan.budget.is_some(), extent == Extent::Quick);
            let first: Vec<_> = plan
                .cases
                .iter()
                .take(8)
                .map(|case| case.level.to_string())
                .collect();
            assert!(
                first.iter().all(|level| level == "n6" || level == "l1"),
                "{first:?}"
            );
        }
    }

    #[test]
    fn scenes_take_the_levels_of_their_kind() {
        let mut wishes = wishes(Extent::Quick);
        wishes.levels = vec!["n10".parse().unwrap(), "n6".parse().unwrap()];
        wishes.tolerances = vec![1e-6];
        let plan = wishes.plan().unwrap();
        let names: Vec<_> = plan.cases.iter().map(Case::name).collect();
        assert_eq!(
            names,
            [
                "A1m n6, auto, tolerance 1e-6",
                "cube-bend n6, auto, tolerance 1e-6",
                "A1m n10, auto, tolerance 1e-6",
                "cube-bend n10, auto, tolerance 1e-6",
            ]
        );
    }
}
