//! Stories of contact between soft bodies in the plane, about an axis and in space: patches, shrink fits, cylinders, closed boxes.

#[path = "../common/mod.rs"]
mod common;

mod box_of_two;
mod boxes;
mod cylinders;
mod floating;
mod friction;
mod mirrors;
mod objectivity;
mod patches;
mod refusals;
mod rings;
mod scenes;
mod space;
mod tubes;
