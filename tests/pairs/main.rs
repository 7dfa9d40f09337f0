//! Stories of contact between soft bodies in the plane, about an axis and in space: patches, shrink fits, cylinders, closed boxes.

#[path = "../common/mod.rs"]
mod common;

mod begun_apart;
mod box_of_two;
mod boxes;
mod corners;
mod cylinders;
mod ends;
mod films;
mod floating;
mod fluids;
mod folds;
mod friction;
mod grooves;
mod mirrors;
mod objectivity;
mod patches;
mod pinched;
mod pushed;
mod refusals;
mod rings;
mod scenes;
mod slid;
mod slits;
mod space;
mod tubes;
mod walls;
