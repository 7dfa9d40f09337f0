//! Two surfaces in space that may touch: gaps by the volume that rays along averaged normals sweep,
//!
//! ```text
//! x + g n = y,   X_k = x_,k + t n_,k,   a = int n.(X_1 x X_2) dt from 0 to g
//!              = g n.(x_,1 x x_,2) + g^2/2 n.(x_,1 x n_,2 + n_,1 x x_,2) + g^3/3 n.(n_,1 x n_,2)
//! G_j = sum over pieces of int psi_j a dl_1 dl_2
//! ```
//!
//! x a point of a face of six nodes of the carrier, l its barycentric coordinates, n linear on the face
//! between the unit normals at its corners, y on a face of the other surface; psi_j the six Bernstein
//! functions. Bodies lie behind their faces. Pieces are the parts of a face whose rays meet one face of
//! the other surface: its outline as the rays see it, clipped by the face. Derivatives are those at
//! points of the face that stay where they are: what a piece gains at a border its neighbour loses.
//! Beside are the motion of the lines beyond rims, where surfaces end, and in second derivatives that of
//! all borders.
//! Lengths are those of the caller, G_j volumes.
//!
//! | file | part |
//! |---|---|
//! | [`patch`] | a curved triangle |
//! | [`skin`] | surfaces: normals that faces share, rims, walls |
//! | [`normals`] | normals and their derivatives |
//! | [`rays`] | where rays meet |
//! | [`outline`] | polygons on a face |
//! | [`choice`] | the pieces of a face |
//! | [`point`] | the gap at a point and its derivatives |
//! | `beyond` | where a surface goes on to beyond its rims |
//! | `rims`, `rim_slips` | what lines beyond rims add to derivatives, and to slips |
//! | `kinks` | what borders between pieces add to second derivatives |
//! | `bends` | second derivatives of a face |
//! | `slips` | how far a face has slid, and what tractions do |
//! | `frames` | tangents of functions |
//! | [`pair`] | gaps of two surfaces, where they are |
//! | `fold` | who may meet whom on one body |
//! | `order` | which face of a surface that meets itself carries |
//! | `shell` | what a ray meets first at rest |
//! | `creases` | edges that close |
//! | `depth`, `still` | how deep rays look; faces at rest |
//! | `forces` | forces on both surfaces of one body |
//! | [`sides`] | both sides of a contact |
//! | `sums` | gaps, coupling and curvature by unknowns |
//! | `sliding` | slips and what tractions do by multipliers |
//! | [`probing`] | what is told of points |

mod bends;
mod beyond;
pub mod choice;
mod creases;
mod depth;
mod fold;
mod forces;
pub(super) mod frames;
mod kinks;
pub mod normals;
mod order;
pub mod outline;
pub mod pair;
pub mod patch;
pub mod point;
pub mod probing;
pub mod rays;
mod rim_slips;
mod rims;
mod shell;
pub mod sides;
pub mod skin;
pub(super) mod sliding;
mod slips;
mod still;
pub(super) mod sums;

pub use creases::creases;
pub use fold::SpaceFold;
pub use pair::{Meeting, Pair, Placed};
pub use sides::SpaceSides;
pub use skin::Skin;

#[cfg(test)]
mod tests;
