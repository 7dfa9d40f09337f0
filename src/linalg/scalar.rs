//! The number type of a preconditioner: `f32`, half the bytes and twice the numbers in a
//! register, or `f64`.

use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

use crate::linalg::Workspace;

/// `f32` or `f64`.
pub trait Scalar:
    Copy
    + Default
    + Send
    + Sync
    + std::fmt::Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + PartialEq
    + 'static
{
    /// Rounds.
    fn narrow(value: f64) -> Self;
    /// Widens exactly.
    fn widen(self) -> f64;
    /// From single precision, exactly.
    fn of_single(value: f32) -> Self;
    /// `length` unspecified values from the pool.
    fn take(work: &mut Workspace, length: usize) -> Vec<Self>;
    /// Hands a vector back to the pool.
    fn give(work: &mut Workspace, vector: Vec<Self>);
}

impl Scalar for f64 {
    fn narrow(value: f64) -> Self {
        value
    }
    fn widen(self) -> f64 {
        self
    }
    fn of_single(value: f32) -> Self {
        value.into()
    }
    fn take(work: &mut Workspace, length: usize) -> Vec<Self> {
        work.scratch(length)
    }
    fn give(work: &mut Workspace, vector: Vec<Self>) {
        work.give(vector);
    }
}

impl Scalar for f32 {
    fn narrow(value: f64) -> Self {
        value as Self
    }
    fn widen(self) -> f64 {
        Self::into(self)
    }
    fn of_single(value: f32) -> Self {
        value
    }
    fn take(work: &mut Workspace, length: usize) -> Vec<Self> {
        work.scratch_f32(length)
    }
    fn give(work: &mut Workspace, vector: Vec<Self>) {
        work.give_f32(vector);
    }
}
