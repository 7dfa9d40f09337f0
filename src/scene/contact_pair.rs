//! Contact between two soft bodies, as a caller writes it.

/// Two surfaces of the bodies of one mesh that may touch and leave each other, or one that may meet
/// itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactPair {
    /// Name of the contact, unique among contacts and different from those of obstacles and
    /// supports; results refer to it.
    pub name: String,
    /// Names of the two groups of surface facets; the same one twice for a surface that meets itself.
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

impl ContactPair {
    /// Whether it is contact of one surface with itself.
    pub fn is_of_one_surface(&self) -> bool {
        self.between[0] == self.between[1]
    }
}
