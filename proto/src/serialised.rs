//! How reports and plans become JSON: key by key in the order of the `.proto`
//! file, enum values as their [`words`], poses by the names of their obstacles,
//! points as vectors, seconds and unknowns as zeros where a message lacks them.
//!
//! `build.rs` names these functions in the attributes of the generated messages.

use serde::{Serialize, Serializer};

use crate::{v1, words};

/// Writes the word of a termination.
pub(crate) fn termination<S: Serializer>(number: &i32, serializer: S) -> Result<S::Ok, S::Error> {
    let value = v1::Termination::try_from(*number).unwrap_or_default();
    words::termination(value).serialize(serializer)
}

/// Writes the word of a cause, or null.
pub(crate) fn cause<S: Serializer>(number: &i32, serializer: S) -> Result<S::Ok, S::Error> {
    let value = v1::Cause::try_from(*number).unwrap_or_default();
    words::cause(value).serialize(serializer)
}

/// Writes the word of a strategy, or null.
pub(crate) fn strategy<S: Serializer>(number: &i32, serializer: S) -> Result<S::Ok, S::Error> {
    let value = v1::Strategy::try_from(*number).unwrap_or_default();
    words::strategy(value).serialize(serializer)
}

/// Writes the word of a kind of equilibrium, or null.
pub(crate) fn stability<S: Serializer>(number: &i32, serializer: S) -> Result<S::Ok, S::Error> {
    let value = v1::Stability::try_from(*number).unwrap_or_default();
    words::stability(value).serialize(serializer)
}

/// Writes the word of a tightness.
pub(crate) fn tightness<S: Serializer>(number: &i32, serializer: S) -> Result<S::Ok, S::Error> {
    let value = v1::Tightness::try_from(*number).unwrap_or_default();
    words::tightness(value).serialize(serializer)
}

/// Writes the word of a kind of scene.
pub(crate) fn scene_kind<S: Serializer>(number: &i32, serializer: S) -> Result<S::Ok, S::Error> {
    let value = v1::SceneKind::try_from(*number).unwrap_or_default();
    words::scene_kind(value).serialize(serializer)
}

/// Writes the word of a formulation.
pub(crate) fn formulation<S: Serializer>(number: &i32, serializer: S) -> Result<S::Ok, S::Error> {
    let value = v1::Formulation::try_from(*number).unwrap_or_default();
    words::formulation(value).serialize(serializer)
}

/// Writes a message that is always there, zeros where it is absent.
pub(crate) fn or_default<T: Serialize + Copy + Default, S: Serializer>(
    message: &Option<T>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    message.unwrap_or_default().serialize(serializer)
}

/// Writes numbers as vectors of three.
pub(crate) fn vectors<S: Serializer>(numbers: &[f64], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(numbers.as_chunks::<3>().0)
}

/// Writes poses by the names of their obstacles.
pub(crate) fn poses<S: Serializer>(
    poses: &[v1::ObstaclePose],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.collect_map(poses.iter().map(|pose| (&pose.name, pose)))
}
