//! Questions about the current state: those of the scene after every increment, and any others.

use super::Session;
use crate::goals::{Answers, GoalError};
use crate::report::{
    CancelToken, FieldData, FieldName, GoalReport, StepReport, Termination, Warning, WarningKind,
};
use crate::scene::{GoalQuestions, InStep, Parameter};

impl Session {
    /// Values, derivatives and errors of functionals of the current state, which the last increment
    /// has converged to. Changes no later bit. Cost: one solve on the contacts as they are for each
    /// goal, two to four evaluations of terms of the residuals for each parameter.
    ///
    /// # Errors
    /// The first [`GoalError`], for names that the scene does not have, states that are no equilibrium or
    /// that depend on their way, and where it was cancelled.
    pub fn answer(
        &self,
        questions: &GoalQuestions,
        cancel: &CancelToken,
    ) -> Result<Vec<GoalReport>, GoalError> {
        let at = (self.previous.as_ref(), &self.state, &self.learned);
        let answers = self
            .body
            .answer(at, std::slice::from_ref(questions), cancel)?;
        match answers.refused.into_iter().next() {
            None => Ok(answers.goals),
            Some(error) => Err(error),
        }
    }

    /// Adds the answers to the questions of the scene at that place of a step to the report of a
    /// converged increment, and why others have none.
    pub(super) fn add_goals(
        &mut self,
        report: &mut StepReport,
        (place, cancel): (InStep, &CancelToken),
    ) {
        (self.parts, self.by_nodes) = (None, None);
        let all = self.plan().scene().questions.iter();
        let questions: Vec<GoalQuestions> = all.filter(|one| one.at.asks(place)).cloned().collect();
        if questions.is_empty() || report.termination != Termination::Converged {
            return;
        }
        let start = std::time::Instant::now();
        let at = (self.previous.as_ref(), &self.state, &self.learned);
        let answers = self.body.answer(at, &questions, cancel);
        let answers = answers.unwrap_or_else(|error| Answers {
            refused: vec![error],
            ..Answers::default()
        });
        report.goals_refused = joined(&answers.refused);
        report.warnings.extend(one_sided(&answers.goals));
        let mut bounds = answers.goals.iter().filter_map(|goal| goal.bound.as_ref());
        self.parts = bounds.next().map(|bound| bound.cells.clone());
        self.by_nodes = answers.goals.iter().find_map(|goal| goal.by_nodes.clone());
        report.goals = answers.goals;
        self.learned.duals.add(answers.duals);
        report.seconds.total += start.elapsed().as_secs_f64();
    }

    /// Parts of the cells in the error of the first goal whose error is bounded, over their volumes.
    pub(super) fn error_density(&self) -> Option<FieldData> {
        let parts = self.parts.clone().or_else(|| self.parts_anew())?;
        Some(FieldData {
            name: FieldName::ErrorDensity,
            components: 1,
            values: self.body.over_volumes(parts),
        })
    }

    /// Derivative of the first goal with a gradient by the mesh, at uploaded vertices.
    pub(super) fn mesh_gradient(&self) -> Option<FieldData> {
        let own = self.by_nodes.clone().or_else(|| self.by_nodes_anew())?;
        let mesh = self.body.mesh();
        let mut values = vec![[0.0; 3]; mesh.vertex_count()];
        for (&uploaded, value) in mesh.used_vertices().iter().zip(own) {
            values[uploaded as usize] = value;
        }
        Some(FieldData {
            name: FieldName::MeshGradient,
            components: 3,
            values: values.into_flattened(),
        })
    }

    /// That where no increment of this session has left any, as before the end of a step or after a checkpoint.
    fn by_nodes_anew(&self) -> Option<Vec<[f64; 3]>> {
        let mut all = self.plan().scene().questions.iter();
        let asked = all.find(|one| one.parameters.contains(&Parameter::Mesh))?;
        let questions = GoalQuestions {
            goals: asked.goals.iter().take(1).cloned().collect(),
            parameters: vec![Parameter::Mesh],
            ..GoalQuestions::default()
        };
        let answers = self.answer(&questions, &CancelToken::new()).ok()?;
        answers.into_iter().next()?.by_nodes
    }

    /// The parts where no increment of this session has left any, as before the end of a step or after a checkpoint.
    fn parts_anew(&self) -> Option<Vec<f64>> {
        let mut goals = self.plan().scene().bounded()?.clone();
        goals.goals.truncate(1);
        let answers = self.answer(&goals, &CancelToken::new()).ok()?;
        Some(answers.into_iter().next()?.bound?.cells)
    }
}

/// What was refused, in one line; none where nothing was.
fn joined(refused: &[GoalError]) -> Option<String> {
    let causes: Vec<String> = refused.iter().map(GoalError::to_string).collect();
    (!causes.is_empty()).then(|| causes.join("; "))
}

/// The warning of derivatives at the border of a contact; none where there are none.
fn one_sided(goals: &[GoalReport]) -> Option<Warning> {
    let at_border = |goal: &&GoalReport| goal.borderline > 0 && !goal.derivatives.is_empty();
    let count = goals.iter().find(at_border)?.borderline;
    let message = format!(
        "{count} contacts are about to close, to open, to stick or to slip: derivatives of goals are one-sided, those \
         with the contacts as they are"
    );
    let value = Some(f64::from(count));
    Some(Warning::new(WarningKind::OneSided, "", value, message))
}
