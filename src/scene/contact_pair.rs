//! Contact between two soft bodies, as a caller writes it.

/// Two surfaces of different bodies of one mesh that may touch and leave each other.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactPair {
    /// Name of the contact, unique among contacts and different from those of obstacles and
    /// supports; results refer to it.
    pub name: String,
    /// Names of the two groups of surface facets.
    pub between: [String; 2],
    /// The group that carries the contact pressure; none for that on the softer body, of bodies
    /// that are alike the one with the smaller faces.
    pub carries: Option<String>,
    /// Coefficient of Coulomb friction, at least zero.
    pub friction: f64,
    /// Largest traction of friction where there is pressure, in place of Coulomb's bound: force per
    /// area.
    pub tresca: Option<f64>,
}
