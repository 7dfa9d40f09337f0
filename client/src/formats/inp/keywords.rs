//! Keywords that are no part of a mesh, and what is told of them.

/// Keywords that make a mesh instead of holding it.
pub(super) const MAKERS: [&str; 8] = [
    "ELCOPY",
    "ELGEN",
    "IMPORT",
    "NCOPY",
    "NFILL",
    "NGEN",
    "NMAP",
    "PARAMETER",
];
/// Keywords that a mesh does not have, and a scene says in its own way.
pub(super) const OF_THE_SCENE: [&str; 7] = [
    "BOUNDARY",
    "CLOAD",
    "CONTACT PAIR",
    "DLOAD",
    "DSLOAD",
    "MATERIAL",
    "STEP",
];
/// Keywords that join nodes to each other.
pub(super) const CONSTRAINTS: [&str; 6] = [
    "COUPLING",
    "DISTRIBUTING COUPLING",
    "EMBEDDED ELEMENT",
    "EQUATION",
    "KINEMATIC COUPLING",
    "MPC",
];
/// What is told of ties.
pub(super) const TIES: &str = "ties (*TIE) are not solved yet: the bodies that they join stay separate; mesh them with common nodes, or hold each by itself";
/// What is told of what a scene says.
pub const OF_THE_FILE: &str = "materials, supports, loads and steps are those of the scene; `signorini init` writes one from the deck";

/// What is told of elements that are none of the body.
pub(super) fn no_cells(name: &str) -> String {
    format!("elements of type {name} are no cells, and are left out")
}

/// What is told of a keyword that joins nodes.
pub(super) fn constraint(name: &str) -> String {
    format!(
        "constraints between nodes (*{name}) are not read: a face that moves as one is a [[support]] of the scene"
    )
}
