//! Which runs a bench consists of.

use std::path::PathBuf;
use std::time::Duration;

use crate::extent::Extent;
use crate::extremes::{self, Trial};
use crate::families::FAMILIES;
use crate::family::{Family, Level, MeshSource};
use crate::method::Method;
use crate::study::{Measure, Origin, STUDIES, Study};

/// What a bench is asked for; what is empty is chosen by its extent.
#[derive(Clone, Debug)]
pub(crate) struct Wishes {
    pub(crate) extent: Extent,
    pub(crate) scenes: Vec<&'static Family>,
    pub(crate) studies: Vec<&'static Study>,
    pub(crate) levels: Vec<Level>,
    pub(crate) methods: Vec<Method>,
    pub(crate) tolerances: Vec<f64>,
    pub(crate) repeats: Option<usize>,
    pub(crate) run_limit: Option<Duration>,
    pub(crate) budget: Option<Duration>,
    /// Its meshes finer than those of the program join the chapters.
    pub(crate) meshes: Option<PathBuf>,
}

/// Where a case is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    /// In the chapter of its family, and in the studies that it fits.
    Chapter,
    /// In studies only.
    Study,
}

/// One scene at one size, method and tolerance.
#[derive(Clone, Debug)]
pub(crate) struct Case {
    pub(crate) family: &'static Family,
    pub(crate) level: Level,
    pub(crate) method: Method,
    pub(crate) tolerance: f64,
    pub(crate) place: Place,
    /// Runs, whose median counts.
    pub(crate) repeats: usize,
    /// After which a run is stopped.
    pub(crate) run_limit: Duration,
}

impl Case {
    /// For progress and tables.
    pub(crate) fn name(&self) -> String {
        let (level, method, tolerance) = (self.level, &self.method, self.tolerance);
        format!(
            "{} {level}, {method}, tolerance {tolerance:e}",
            self.family.name
        )
    }

    /// Whether the other is the same at another size.
    pub(crate) fn is_curve_of(&self, other: &Self) -> bool {
        self.family.name == other.family.name
            && self.method == other.method
            && self.tolerance.total_cmp(&other.tolerance).is_eq()
    }

    fn is_run_of(&self, other: &Self) -> bool {
        self.level == other.level && self.is_curve_of(other)
    }
}

/// The cases, chapters first and small meshes first, and how long they may take.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub(crate) cases: Vec<Case>,
    pub(crate) studies: Vec<&'static Study>,
    /// Rows of the study of extreme cases, after all cases.
    pub(crate) trials: Vec<Trial>,
    pub(crate) trial_limit: Duration,
    pub(crate) budget: Duration,
}

impl Plan {
    /// Whether there is nothing to run.
    pub(crate) fn is_empty(&self) -> bool {
        self.cases.is_empty() && self.trials.is_empty()
    }
}

/// What an extent chooses.
struct Defaults {
    run_limit: u64,
    study_run_limit: u64,
    study_repeats: usize,
    budget: u64,
}

const QUICK: Defaults = Defaults {
    run_limit: 20,
    study_run_limit: 5,
    study_repeats: 1,
    // Leaves a few seconds of the two minutes for drawing and a late end.
    budget: 105,
};

const FULL: Defaults = Defaults {
    run_limit: 300,
    study_run_limit: 40,
    study_repeats: 3,
    budget: 2300,
};

/// Of a row of the study of extreme cases.
const TRIAL_LIMIT: u64 = 90;
const REPEATS: usize = 3;
const TOLERANCES: &[f64] = &[1e-8, 1e-3];

impl Wishes {
    /// The plan; empty when no scene has one of the levels.
    ///
    /// # Errors
    /// A default method that cannot be read, which a test excludes.
    pub(crate) fn plan(self) -> Result<Plan, String> {
        let defaults = self.defaults();
        let studies = self.chosen_studies();
        let mut cases = Vec::new();
        if self.studies.is_empty() || !self.scenes.is_empty() {
            self.add_chapters(&defaults, &mut cases)?;
        }
        for study in &studies {
            self.add_study(study, &defaults, &mut cases);
        }
        cases.sort_by_key(|(rank, case)| (case.place == Place::Study, *rank));
        let has_trials = |study: &&Study| study.measure == Measure::Extremes;
        let trials = if studies.iter().any(has_trials) {
            extremes::trials(self.extent)?
        } else {
            Vec::new()
        };
        let asked = self.budget;
        Ok(Plan {
            trial_limit: self.limit(TRIAL_LIMIT),
            trials,
            cases: cases.into_iter().map(|(_, case)| case).collect(),
            studies,
            budget: asked.unwrap_or(Duration::from_secs(defaults.budget)),
        })
    }

    fn defaults(&self) -> Defaults {
        match self.extent {
            Extent::Quick => QUICK,
            Extent::Full => FULL,
        }
    }

    /// Those asked for; all of them where nothing is narrowed down.
    fn chosen_studies(&self) -> Vec<&'static Study> {
        let narrowed = !(self.scenes.is_empty()
            && self.levels.is_empty()
            && self.methods.is_empty()
            && self.tolerances.is_empty());
        match (self.studies.is_empty(), narrowed) {
            (false, _) => self.studies.clone(),
            (true, true) => Vec::new(),
            (true, false) => STUDIES.iter().collect(),
        }
    }

    fn add_chapters(
        &self,
        defaults: &Defaults,
        cases: &mut Vec<(usize, Case)>,
    ) -> Result<(), String> {
        let tolerances = match self.tolerances.as_slice() {
            [] => TOLERANCES,
            tolerances => tolerances,
        };
        for (rank, family, level) in self.chapter_levels() {
            for method in &self.methods_of(family)? {
                for &tolerance in tolerances {
                    let case = Case {
                        family,
                        level,
                        method: method.clone(),
                        tolerance,
                        place: Place::Chapter,
                        repeats: self.repeats.unwrap_or(REPEATS),
                        run_limit: self.limit(defaults.run_limit),
                    };
                    cases.push((rank, case));
                }
            }
        }
        Ok(())
    }

    fn methods_of(&self, family: &Family) -> Result<Vec<Method>, String> {
        match self.methods.as_slice() {
            [] => family.methods.iter().map(|name| name.parse()).collect(),
            methods => Ok(methods.to_vec()),
        }
    }

    fn limit(&self, seconds: u64) -> Duration {
        self.run_limit.unwrap_or(Duration::from_secs(seconds))
    }

    /// Adds what no chapter and no earlier study measures.
    fn add_study(
        &self,
        study: &'static Study,
        defaults: &Defaults,
        cases: &mut Vec<(usize, Case)>,
    ) {
        for scope in study.scopes {
            let Some(family) = scope.family() else {
                continue;
            };
            let numbers = match self.extent {
                Extent::Quick => scope.quick,
                Extent::Full => scope.full,
            };
            let mut levels = scope.levels(numbers);
            if !self.levels.is_empty() {
                levels.retain(|level| self.levels.contains(level));
            }
            let runs = study.choices.iter();
            let runs = runs.filter(|choice| choice.origin != Origin::Recorded);
            let methods = runs.filter_map(|choice| Some((choice.method()?, choice.origin)));
            for (method, origin) in methods {
                let meshes = match origin {
                    Origin::Refined => 1,
                    Origin::Run | Origin::Recorded => levels.len(),
                };
                for &tolerance in tolerances_of(study, &method) {
                    for (rank, &level) in levels.iter().enumerate().take(meshes) {
                        let case = Case {
                            family,
                            level,
                            method: method.clone(),
                            tolerance,
                            place: Place::Study,
                            repeats: self.repeats.unwrap_or(defaults.study_repeats),
                            run_limit: self.limit(defaults.study_run_limit),
                        };
                        if !cases.iter().any(|(_, other)| other.is_run_of(&case)) {
                            cases.push((rank, case));
                        }
                    }
                }
            }
        }
    }

    /// Levels of the families, with their rank in the family.
    fn chapter_levels(&self) -> Vec<(usize, &'static Family, Level)> {
        let mut families: Vec<&'static Family> = self.scenes.clone();
        if families.is_empty() {
            families = FAMILIES
                .iter()
                .filter(|family| !family.full.is_empty())
                .collect();
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
            Extent::Quick => family.quick.to_vec(),
            Extent::Full => [family.full, &self.finer_levels(family)].concat(),
        };
        numbers
            .iter()
            .map(|&number| Level { letter, number })
            .collect()
    }

    /// Numbers beyond those of the program that the folder of meshes has.
    fn finer_levels(&self, family: &Family) -> Vec<u32> {
        let (Some(folder), MeshSource::Gmsh(prefix)) = (&self.meshes, family.source) else {
            return Vec::new();
        };
        let finest = family.full.last().copied().unwrap_or(9);
        let finer = finest + 1..=9;
        finer
            .filter(|number| folder.join(format!("{prefix}_l{number}.msh")).exists())
            .collect()
    }
}

/// A choice that names its tolerance has no other one.
fn tolerances_of<'a>(study: &'a Study, method: &Method) -> &'a [f64] {
    let own = method.to_string().starts_with("tolerance=");
    match study.tolerances {
        [.., last] if own && study.measure == Measure::Tolerance => std::slice::from_ref(last),
        tolerances => tolerances,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wishes(extent: Extent) -> Wishes {
        Wishes {
            extent,
            scenes: Vec::new(),
            studies: Vec::new(),
            levels: Vec::new(),
            methods: Vec::new(),
            tolerances: Vec::new(),
            repeats: None,
            run_limit: None,
            budget: None,
            meshes: None,
        }
    }

    #[test]
    fn every_extent_has_a_plan_with_small_meshes_first() {
        for extent in [Extent::Quick, Extent::Full] {
            let plan = wishes(extent).plan().unwrap();
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
            assert_eq!(plan.studies.len(), STUDIES.len());
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
                "mr-uniax n6, auto, tolerance 1e-6",
                "mr-block n6, auto, tolerance 1e-6",
                "cube-drag n6, auto, tolerance 1e-6",
                "cube-drag n6, contact_space=linear, tolerance 1e-6",
                "A1m n10, auto, tolerance 1e-6",
                "cube-bend n10, auto, tolerance 1e-6",
                "mr-uniax n10, auto, tolerance 1e-6",
                "mr-block n10, auto, tolerance 1e-6",
                "cube-drag n10, auto, tolerance 1e-6",
                "cube-drag n10, contact_space=linear, tolerance 1e-6",
            ]
        );
    }

    #[test]
    fn a_run_that_several_studies_need_is_one_case() {
        let plan = wishes(Extent::Full).plan().unwrap();
        for (index, case) in plan.cases.iter().enumerate() {
            let others = &plan.cases[index + 1..];
            assert!(
                !others.iter().any(|other| other.is_run_of(case)),
                "{}",
                case.name()
            );
        }
    }

    #[test]
    fn a_study_alone_measures_its_own_cases_only() {
        let mut wishes = wishes(Extent::Quick);
        wishes.studies = vec![crate::study::find("saddle").unwrap()];
        let plan = wishes.plan().unwrap();
        assert!(plan.cases.iter().all(|case| case.place == Place::Study));
        assert_eq!(plan.cases.len(), 10, "two meshes, five methods");
    }
}
