//! Surfaces of two bodies that are bonded, as a caller writes them.

/// Two surfaces of different bodies of one mesh that move together, whose meshes need not match.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tie {
    /// Name of the tie, unique among ties and different from those of contacts, obstacles and
    /// supports; results refer to it.
    pub name: String,
    /// Names of the two groups of surface facets.
    pub between: [String; 2],
    /// The group that carries the tractions; none for that on the softer body, of bodies that are
    /// alike the one with the smaller faces.
    pub carries: Option<String>,
}
