//! What is known of a goal of an increment: value, derivatives, error.

/// Error of a goal by the mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GoalBound {
    /// The exact value less the computed one, estimated with its sign: of little worth where contact
    /// ends inside faces.
    pub estimate: f64,
    /// What the error of the mesh is not above, about: the sum of the parts of the cells.
    pub discretisation: f64,
    /// What the residuals that the solver left make of the value, to first order.
    pub solver: f64,
    /// What flat facets make of a force where they stand for a curved surface, about; zero where
    /// they do not.
    pub geometry: f64,
    /// Part of each cell of `discretisation` `[cells]`.
    pub cells: Vec<f64>,
}

impl GoalBound {
    /// All parts together.
    pub fn total(&self) -> f64 {
        self.discretisation + self.solver + self.geometry
    }
}

/// One goal at the end of an increment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GoalReport {
    /// The functional, as scenes name it.
    pub goal: String,
    /// Its value, in the caller's units.
    pub value: f64,
    /// Parameters as scenes name them, each with the derivative by it, in the caller's units.
    pub derivatives: Vec<(String, f64)>,
    /// By the places of the vertices that cells use `[vertices][3]`, in the caller's units; none where
    /// that was not asked for.
    pub by_nodes: Option<Vec<[f64; 3]>>,
    /// Contacts at the border of closing or opening: where there are any derivatives are one-sided.
    pub borderline: u32,
    /// What the residuals that the solver left make of the value, to first order.
    pub solver_error: f64,
    /// Estimate and bound of the error; none where they were not asked for.
    pub bound: Option<GoalBound>,
    /// True residual of the dual solution over its scale.
    pub dual_residual: f64,
    /// Applications of the displacement preconditioner that the dual solution took.
    pub applications: u32,
    /// Wall seconds of it.
    pub seconds: f64,
}
