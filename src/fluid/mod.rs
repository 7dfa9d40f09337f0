//! A fluid that creeps in between a body and what it touches: the surface that it can reach, the
//! part of it that is wet, and the path on which it leaks first.
//!
//! The fluid of pressure q fills the wet set W of the nodes of a surface. What the surface bears is
//!
//! ```text
//! t = q w + l,   w = sum over W of psi_j,   l >= 0,   g >= 0,   l g = 0
//! ```
//!
//! psi the quadratic Bernstein functions: in W at least the pressure of the fluid, which follows the
//! deformed surface, and l, the contact pressure, what obstacles press besides. W is consistent
//! where every dry node beside a wet one is pressed by at least a threshold, by default q, p the values
//! of q w + l at the nodes:
//!
//! ```text
//! flood:   every open node that open nodes join to W is in W
//! advance: where there is none, every node that nodes of p < threshold join to W is in W where p < threshold
//! ```
//!
//! after each equilibrium, until nothing changes; W only grows, so that it takes at most as many
//! rounds as there are nodes. With a wrong front the pressure has a singularity there, so that
//! other thresholds lead to the same front on fine meshes.
//!
//! | file | part |
//! |---|---|
//! | [`surface`] | nodes, who is beside whom, what is wet at first and what shall stay dry |
//! | [`front`] | how the fluid advances |
//! | [`across`] | what lies across contacts between bodies |
//! | [`leak_path`] | the path from wet to dry on which it leaks first |
//! | [`flow`] | how much flows through what is open |
//!
//! Where bodies touch, the surface has a part of each, and W is that of the part that carries the
//! contact pressure: of the other one those nodes are wet that lie on what is.
//!
//! Neighbours are joined by the edges of the parts into which the midpoints divide a facet.
//! Reference for the lower bound on the traction: contact with pressure penetration as commercial
//! programs have it; for the affine sealing pressure V. A. Yastrebov, A. Shvarts, arXiv 1712.06312.
//! Cost: sorts of the surface's nodes.

pub mod across;
pub mod flow;
pub mod front;
pub mod leak_path;
pub mod surface;
