//! Which obstacles are frictional, what that asks of a scene, and how many tractions it takes:
//! one or two at each multiplier of a frictional obstacle.

use super::Plan;
use super::pairs::PlannedPair;
use super::surfaces::ContactLayout;
use crate::scene::validate::ResolvedObstacle;
use crate::scene::{ObstacleTarget, SceneError, Step, Violation};

impl Plan {
    /// Refuses friction on an obstacle that has none in the scene and its steps: tractions
    /// have multipliers from the start or never.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] with the key.
    pub(crate) fn check_friction(&self, step: &Step) -> Result<(), SceneError> {
        let is_smooth = |target: &&ObstacleTarget| {
            let mut obstacles = self.problem.obstacles.iter();
            let named = obstacles.find(|one| one.name == target.name);
            target.friction.is_some_and(|value| value > 0.0)
                && named.is_some_and(|obstacle| !obstacle.is_frictional)
        };
        match step.obstacles.iter().find(is_smooth) {
            None => Ok(()),
            Some(target) => Err(SceneError::Invalid(vec![Violation {
                path: format!("step.obstacle.{}.friction", target.name),
                message: "the obstacle was made without friction: give it some in the scene"
                    .to_owned(),
            }])),
        }
    }
}

/// Gives obstacles friction to which some step gives it.
pub(super) fn assign_friction(obstacles: &mut [ResolvedObstacle], steps: &[Step]) {
    let targets = steps.iter().flat_map(|step| &step.obstacles);
    for target in targets.filter(|target| target.friction.is_some_and(|value| value > 0.0)) {
        let mut named = obstacles.iter_mut().filter(|one| one.name == target.name);
        if let Some(obstacle) = named.next() {
            obstacle.is_frictional = true;
        }
    }
}

/// Number of tractions of friction: one or two at each multiplier of a frictional obstacle or contact
/// between bodies.
pub(super) fn tangential_multipliers(
    (obstacles, layouts): (&[ResolvedObstacle], &[ContactLayout]),
    (bodies, carriers): (&[PlannedPair], &[ContactLayout]),
    dimension: usize,
) -> usize {
    let pairs = obstacles.iter().zip(layouts);
    let frictional = pairs.filter(|(obstacle, _)| obstacle.is_frictional);
    let own = frictional.map(|(_, layout)| layout);
    let between = bodies.iter().zip(carriers);
    let between = between.filter(|(pair, _)| pair.is_frictional());
    let all = own.chain(between.map(|(_, layout)| layout));
    let points: usize = all.map(|layout| layout.multipliers.len()).sum();
    points * (dimension - 1)
}
