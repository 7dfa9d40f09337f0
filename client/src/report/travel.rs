//! Along what the force of an obstacle is told.
//!
//! An obstacle that travels is judged along its first travel, in every increment: a
//! plate that closes and opens again presses with one sign, and force against travel
//! is one curve. Of an obstacle that never travels the size of its force is told.

use std::collections::BTreeMap;

use signorini_proto::v1;

type Vector = [f64; 3];

/// First travels, as unit vectors by name.
#[derive(Clone, Debug, Default)]
pub(crate) struct Travels {
    /// Of obstacles.
    obstacles: BTreeMap<String, Vector>,
    /// Of the supports that a step names or that have moved; none of those that only turn or stay.
    supports: BTreeMap<String, Option<Vector>>,
}

impl Travels {
    /// As the steps of a scene ask for them.
    pub(crate) fn of(steps: &[v1::LoadStep]) -> Self {
        let mut travels = Self::default();
        for target in steps.iter().flat_map(|step| &step.obstacles) {
            travels.learn(&target.name, &target.translation);
        }
        for target in steps.iter().flat_map(|step| &step.supports) {
            let known = travels.supports.entry(target.name.clone()).or_default();
            *known = known.or_else(|| unit(&target.translation));
        }
        travels
    }

    /// Names of the supports that a step moves.
    pub(crate) fn supports(&self) -> impl Iterator<Item = &String> {
        self.supports.keys()
    }

    /// Whether a support has a direction along which its reaction is told.
    pub(crate) fn has_moved(&self, name: &str) -> bool {
        self.supports.get(name).copied().flatten().is_some()
    }

    /// Whether an obstacle has a travel along which its force is told.
    pub(crate) fn has_travelled(&self, name: &str) -> bool {
        self.obstacles.contains_key(name)
    }

    /// Along its travel, what a support does to the body; without a travel its size.
    pub(crate) fn reaction(&self, name: &str, support: &v1::SupportResult) -> f64 {
        let direction = self.supports.get(name).copied().flatten();
        let size = || dot(&support.force, &support.force).sqrt();
        direction.map_or_else(size, |direction| dot(&support.force, &direction))
    }

    /// Learns from the poses of a result what no step has said: obstacles and supports driven by
    /// a force, and steps that came from elsewhere.
    pub(crate) fn see(&mut self, report: &v1::StepReport) {
        for pose in &report.obstacle_poses {
            self.learn(&pose.name, &pose.translation);
        }
        for (name, support) in &report.supports {
            if let Some(direction) = unit(&support.translation) {
                let known = self.supports.entry(name.clone()).or_default();
                known.get_or_insert(direction);
            }
        }
    }

    /// Takes a translation for the first travel of an obstacle, unless it has one or
    /// this is none.
    pub(crate) fn learn(&mut self, name: &str, translation: &[f64]) {
        if self.obstacles.contains_key(name) {
            return;
        }
        if let Some(direction) = unit(translation) {
            self.obstacles.insert(name.to_owned(), direction);
        }
    }

    /// The part of a vector along the travel of an obstacle; none without a travel.
    pub(crate) fn along(&self, name: &str, vector: &[f64]) -> Option<f64> {
        let direction = self.obstacles.get(name)?;
        Some(dot(vector, direction))
    }

    /// Along its travel, what an obstacle does to the body; without a travel its size.
    pub(crate) fn force(&self, name: &str, obstacle: &v1::ObstacleResult) -> f64 {
        let size = || dot(&obstacle.force, &obstacle.force).sqrt();
        self.along(name, &obstacle.force).unwrap_or_else(size)
    }

    /// Bound of the error of [`Self::force`], from those of the components that it is made of; none
    /// where one of them has none, or is of another force: that of a goal across an axis of revolution is radial,
    /// the component is zero.
    pub(crate) fn force_bound(&self, name: &str, report: &v1::StepReport) -> Option<f64> {
        let direction = self.obstacles.get(name)?;
        let force = &report.obstacles.get(name)?.force;
        let mut sum = 0.0;
        for ((share, axis), component) in direction.iter().zip(["x", "y", "z"]).zip(force) {
            if *share != 0.0 {
                let goal = report.goals.get(&format!("force.{name}.{axis}"))?;
                if *component == 0.0 && goal.value != 0.0 {
                    return None;
                }
                sum += share.abs() * goal.bound?.total;
            }
        }
        Some(sum)
    }

    /// The bound of the error of the force where there is one, else its estimate.
    pub(crate) fn force_error(&self, name: &str, report: &v1::StepReport) -> Option<f64> {
        let estimate = || report.obstacles.get(name)?.force_error;
        self.force_bound(name, report).or_else(estimate)
    }

    /// How far an obstacle is along its travel.
    pub(crate) fn distance(&self, name: &str, report: &v1::StepReport) -> Option<f64> {
        let pose = report.obstacle_poses.iter().find(|pose| pose.name == name);
        let translation = pose.map(|pose| pose.translation.as_slice());
        self.along(name, translation.unwrap_or_default())
    }
}

/// The direction of a vector; none of zero.
fn unit(vector: &[f64]) -> Option<Vector> {
    let size = dot(vector, vector).sqrt();
    let mut unit = [0.0; 3];
    for (unit, x) in unit.iter_mut().zip(vector) {
        *unit = x / size;
    }
    (size > 0.0 && size.is_finite()).then_some(unit)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step(name: &str, translation: [f64; 3]) -> v1::LoadStep {
        let target = v1::ObstacleTarget {
            name: name.to_owned(),
            translation: translation.to_vec(),
            ..Default::default()
        };
        v1::LoadStep {
            obstacles: vec![target],
            ..Default::default()
        }
    }

    fn pressed(force: [f64; 3]) -> v1::ObstacleResult {
        v1::ObstacleResult {
            force: force.to_vec(),
            ..Default::default()
        }
    }

    fn at(name: &str, translation: [f64; 3]) -> v1::StepReport {
        let pose = v1::ObstaclePose {
            name: name.to_owned(),
            translation: translation.to_vec(),
            ..Default::default()
        };
        v1::StepReport {
            obstacle_poses: vec![pose],
            ..Default::default()
        }
    }

    #[test]
    fn a_plate_that_opens_again_presses_with_one_sign() {
        let steps = [step("top", [0.0, 0.0, -0.5]), step("top", [0.0; 3])];
        let travels = Travels::of(&steps);
        let force = travels.force("top", &pressed([0.1, 0.0, -2.0]));
        let distance = travels.distance("top", &at("top", [0.0, 0.0, -0.25]));
        assert!((force - 2.0).abs() < 1e-15);
        assert_eq!(distance, Some(0.25));
    }

    #[test]
    fn an_obstacle_that_stands_tells_the_size_of_its_force() {
        let travels = Travels::of(&[step("top", [0.0; 3])]);
        let force = travels.force("top", &pressed([3.0, 0.0, -4.0]));
        assert!((force - 5.0).abs() < 1e-15);
        assert_eq!(travels.distance("top", &at("top", [0.0; 3])), None);
    }

    #[test]
    fn a_support_that_its_force_moves_is_told_along_its_way() {
        let support = v1::SupportResult {
            force: vec![-3.0, 4.0, 0.0],
            translation: vec![-0.5, 0.0, 0.0],
            ..Default::default()
        };
        let mut travels = Travels::default();
        travels.see(&v1::StepReport {
            supports: BTreeMap::from([("pin".to_owned(), support.clone())]),
            ..Default::default()
        });
        assert_eq!(travels.supports().collect::<Vec<_>>(), ["pin"]);
        assert!((travels.reaction("pin", &support) - 3.0).abs() < 1e-15);
    }

    #[test]
    fn a_travel_that_no_step_names_is_learnt_from_a_pose() {
        let mut travels = Travels::default();
        travels.see(&at("pin", [2.0, 0.0, 0.0]));
        travels.see(&at("pin", [0.0, 9.0, 0.0]));
        let force = travels.force("pin", &pressed([-1.5, 7.0, 0.0]));
        assert!((force + 1.5).abs() < 1e-15);
    }
}
