//! Contact between two surfaces of the body: who meets whom, and the gap between them, measured by
//! its volume, with exact first and second derivatives by the nodes of both.
//!
//! One surface carries the multipliers Lam_j >= 0 with functions psi_j that add up to one. The rays of
//! its averaged normals sweep the space up to the other surface, and
//!
//! ```text
//! G_j = int psi_j dV >= 0,   sum_j G_j = V,   L = E - sum_j Lam_j G_j
//! ```
//!
//! V the volume between the surfaces. An even pressure then works on the volume of the bodies and of
//! the gap, which stays what it is, so that it has no second variation whatever its size; Lam is the
//! Cauchy pressure on both surfaces. Rays are cut where their partner ends (segments), so that every
//! integral is one of smooth functions. Forces are derivatives of objective gaps: their sum and their
//! moment vanish. In the plane, about an axis and in space.
//!
//! | file | part |
//! |---|---|
//! | [`number`] | numbers with first and second derivatives |
//! | [`piece`] | the gap of a piece of a face on one partner |
//! | [`choice`] | which pieces have which partners |
//! | [`chain`] | surfaces: neighbours, corners, ends |
//! | [`force`] | forces on both surfaces |
//! | `fading` | what is open beside a corner |
//! | [`fold`] | who may meet whom on one body |
//! | `order` | which face of a surface that meets itself carries |
//! | [`tree`] | faces near a face |
//! | [`pair`] | gaps of two surfaces |
//! | `between` | what gaps have to tell, in whatever dimension |
//! | `plane` | both sides in the plane or about an axis, by functions |
//! | [`space`] | both sides in space |
//! | `ground` | what surfaces lie on |
//! | [`surface`] | gaps, coupling and curvature of a surface of multipliers |
//! | `rest` | gaps and slips of linear bodies |
//! | [`slip`] | how far a piece has slid, and what tractions do |
//! | [`support`] | functions with next to nothing to press on |
//! | [`sliding`] | slips of a surface of multipliers |
//! | `touching` | where linear bodies touch |
//! | [`probing`] | what is told of points |
//! | [`opposite`] | nodes of the other surface on the carrier |
//!
//! References: M. Puso and T. Laursen, *A mortar segment-to-segment contact method for large
//! deformation solid mechanics* (2004); A. Popp, M. Gitterle, M. Gee and W. Wall, *A dual mortar
//! approach for 3D finite deformation contact* (2010), for averaged normals and segments.

mod between;
pub mod chain;
pub mod choice;
mod fading;
pub mod fold;
pub mod force;
mod ground;
pub mod number;
pub mod opposite;
mod order;
pub mod pair;
pub mod piece;
mod plane;
pub mod probing;
mod rest;
mod slid;
pub mod sliding;
pub mod slip;
pub mod space;
pub mod support;
pub mod surface;
mod touching;
pub mod tree;

pub use chain::{Chain, ChainFace};
pub use fold::{Fold, Meets, creases};
pub use ground::Ground;
pub use pair::{Meeting, Pair, Part, Placed, Probe};
pub use piece::Section;
pub use slip::Sliding;
pub use support::{Support, lending};
pub use surface::{PairForce, PairSurface};

#[cfg(test)]
mod tests;
