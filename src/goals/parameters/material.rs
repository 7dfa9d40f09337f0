//! A constant of the law of a material.

use super::super::perturbed::Perturbed;
use super::place::{OF_CONSTANTS, Place};
use crate::model::Model;
use crate::model::evaluate::Terms;
use crate::model::state::State;
use crate::scene::numbers::{constant, is_linear};
use crate::scene::validate::laws;
use crate::scene::{MaterialModel, SceneKind};

/// The constant `key` of a material.
pub(super) struct Material {
    pub(super) index: usize,
    pub(super) key: String,
}

impl Place for Material {
    fn terms(&self) -> Terms {
        Terms::Body
    }

    fn is_linear(&self, model: &Model<'_>) -> bool {
        let problem = &model.plan.problem;
        let law = &problem.scene.materials[self.index].model;
        let is_beside_rubber = model.is_rubber() && !matches!(law, MaterialModel::Rubber { .. });
        problem.resolved.kind != SceneKind::PlaneStress
            && !is_beside_rubber
            && is_linear(law, &self.key)
    }

    fn step(&self, (model, _): (&Model<'_>, &State)) -> Result<f64, &'static str> {
        let (scene, units) = (&model.plan.problem.scene, &model.plan.problem.units);
        let mut law = scene.materials[self.index].model.clone();
        let found = constant(&mut law, &self.key);
        let value = *found.ok_or("the law has no such finite constant")?;
        let size = match (value == 0.0, is_stress(&self.key)) {
            (true, true) => units.stress,
            (true, false) => 1.0,
            (false, _) => value.abs(),
        };
        let room = if self.key == "poisson_ratio" {
            0.25 * (0.5 - value)
        } else {
            f64::INFINITY
        };
        if room <= 0.0 {
            return Err(
                "one half is the end of its range: it has no derivative from both sides; ask for \
                 the modulus",
            );
        }
        Ok(room.min(OF_CONSTANTS * size))
    }

    fn apply(&self, changed: &mut Perturbed<'_>, by: f64) -> Result<(), String> {
        let mesh = changed.base.mesh;
        let plan = changed.plan_mut();
        let scene = &mut plan.problem.scene;
        if let Some(value) = constant(&mut scene.materials[self.index].model, &self.key) {
            *value += by;
        }
        let found = laws(scene, mesh).map_err(|error| error.to_string())?;
        plan.problem.resolved.materials = found;
        changed.prepare_laws();
        Ok(())
    }
}

/// Whether a constant of a law is a stress, or else has no unit.
fn is_stress(key: &str) -> bool {
    let name = key.split('.').next().unwrap_or(key);
    !matches!(
        name,
        "poisson_ratio" | "alpha" | "nu" | "a" | "beta" | "limit" | "locking_stretch"
    )
}
