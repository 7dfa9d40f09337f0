//! Stories of goals: values, derivatives and error bounds of functionals of a converged increment.

#[path = "../common/mod.rs"]
mod common;

mod adapted;
mod again;
mod bodies;
mod bounds;
mod fluids;
mod friction;
mod gradients;
mod nodes;
mod refusals;
mod scenes;
