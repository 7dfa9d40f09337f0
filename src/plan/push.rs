//! What pushes of obstacles ask of a scene: poses that follow from forces are found around the
//! solver's own element.

use super::Plan;
use crate::scene::{ElementKind, SceneError, Step, Violation};

impl Plan {
    /// Refuses a step that pushes obstacles on an element that does not know it.
    ///
    /// # Errors
    /// [`SceneError::Unsupported`] with the key.
    pub(crate) fn check_pushes(&self, step: &Step) -> Result<(), SceneError> {
        check_pushes(self.element, std::slice::from_ref(step))
    }
}

/// Refuses steps that push obstacles on an element that does not know it.
///
/// # Errors
/// [`SceneError::Unsupported`] with the key.
pub(super) fn check_pushes(element: ElementKind, steps: &[Step]) -> Result<(), SceneError> {
    let mut targets = steps.iter().flat_map(|step| &step.obstacles);
    let pushed = targets.any(|target| target.names_push());
    if !pushed || element == ElementKind::TaylorHood {
        return Ok(());
    }
    Err(SceneError::Unsupported(Violation {
        path: "solver.element".to_owned(),
        message: "obstacles are pushed on `taylor-hood` only".to_owned(),
    }))
}
