//! Fields of the current state: their names and shapes.

/// A field that a caller can ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum FieldName {
    /// `[nodes, 3]`: vertices of the uploaded mesh, then edge midpoints.
    Displacement,
    /// `[vertices, 1]`: internal pressure; absent without a pressure unknown.
    Pressure,
    /// `[nodes, 1]`: contact pressure, zero off the contact surface; `[vertices, 1]` in the
    /// linear contact space. Per deformed area for bodies of finite strain.
    ContactPressure,
    /// The same; absent for linear kinematics.
    ContactPressureDeformed,
    /// The same per undeformed area; absent for linear kinematics.
    ContactPressureUndeformed,
    /// `[vertices, 1]`: weighted gap over nodal weight, zero off the contact surface.
    Gap,
    /// `[vertices, 1]`: −1 not a candidate, 0 open, 1 in contact.
    ContactState,
    /// `[cells, 6]`: xx yy zz xy yz zx, mean over the cell.
    Stress,
    /// `[cells, 1]`: volume change of the cell, 1 + div u for linear kinematics.
    Jacobian,
    /// `[cells, 1]`: the cell's part of [`super::StepReport::error_estimate`], whose
    /// square is the sum of the parts' squares.
    ErrorEstimate,
    /// `[vertices, 3]`: traction of friction by the area of the contact pressure, zero off frictional obstacles;
    /// absent without friction.
    FrictionTraction,
    /// `[vertices, 3]`: slip against the obstacle in the last increment, a length, zero where
    /// nothing presses; absent without friction.
    Slip,
    /// `[vertices, 3]`: motion of the least stiffness at the last equilibrium, its largest
    /// vector one long; absent where nobody looked for it.
    LowestMode,
    /// `[nodes, 3]`: force that supports and obstacles exert on the body at each node; their
    /// sum over the nodes of a support is its reaction.
    NodalForce,
    /// `[points, 6]`: contact pressure along the surface in the plane and about an axis: number of
    /// the obstacle in the scene and of its interval among the contact intervals, both from zero;
    /// arc length from the start of the surface, contact pressure, place x, y in the deformed body.
    /// Both ends and the middle of every face under pressure, common ends once. The arc length is
    /// that of the surface which the pressure is per: deformed for bodies of finite strain. Absent
    /// in space.
    ContactPath,
    /// `[cells, 1]`: part of the cell in the bound of the error by the mesh of the first goal whose
    /// error is asked for, over its volume: in the plane its area, about an axis the ring's volume.
    /// Absent without such a goal.
    ErrorDensity,
    /// `[vertices, 3]`: derivative of the first goal with a gradient by `mesh`, by the place of the
    /// vertex. Absent without such a goal.
    MeshGradient,
}

impl FieldName {
    /// Every field, in the order of the documentation.
    pub const ALL: [Self; 17] = [
        Self::Displacement,
        Self::Pressure,
        Self::ContactPressure,
        Self::Gap,
        Self::ContactState,
        Self::Stress,
        Self::Jacobian,
        Self::ErrorEstimate,
        Self::ContactPressureDeformed,
        Self::ContactPressureUndeformed,
        Self::FrictionTraction,
        Self::Slip,
        Self::LowestMode,
        Self::NodalForce,
        Self::ContactPath,
        Self::ErrorDensity,
        Self::MeshGradient,
    ];

    /// The name used in scenes, on the wire and in VTU files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Displacement => "displacement",
            Self::Pressure => "pressure",
            Self::ContactPressure => "contact_pressure",
            Self::Gap => "gap",
            Self::ContactState => "contact_state",
            Self::Stress => "stress",
            Self::Jacobian => "jacobian",
            Self::ErrorEstimate => "error_estimate",
            Self::ContactPressureDeformed => "contact_pressure_deformed",
            Self::ContactPressureUndeformed => "contact_pressure_undeformed",
            Self::FrictionTraction => "friction_traction",
            Self::Slip => "slip",
            Self::LowestMode => "lowest_mode",
            Self::NodalForce => "nodal_force",
            Self::ContactPath => "contact_path",
            Self::ErrorDensity => "error_density",
            Self::MeshGradient => "mesh_gradient",
        }
    }

    /// The field of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|field| field.name() == name)
    }
}

/// One field of the current state, row-major `[rows, components]`.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldData {
    /// Which field it is.
    pub name: FieldName,
    /// Number of values in a row.
    pub components: usize,
    /// `rows * components` values in the caller's units.
    pub values: Vec<f64>,
}
