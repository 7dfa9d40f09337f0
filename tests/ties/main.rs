//! Stories of bodies that are tied to each other, whose meshes do not match.

#[path = "../common/mod.rs"]
mod common;

mod carriers;
mod patches;
mod refusals;
mod rings;
mod scenes;
