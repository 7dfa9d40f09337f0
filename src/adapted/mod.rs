//! A mesh that is refined until goals are known as well as is asked for.
//!
//! ```text
//! solve on mesh k; for each goal J:  e = bound of |J(u) - J(u_h)|           one dual solution
//! e <= tolerance |J| for all:        done
//! else mark the fewest cells K with  sum b_K >= s of all,  b_K = sum over goals not known well
//!                                    enough of their parts of e / (tolerance |J|)
//! halve the marked cells, carry the state over, bring it into equilibrium again
//! ```
//!
//! s = 1/2, less where less has to go (W. Dorfler, SIAM J. Numer. Anal. 33, 1996; R. Becker and R. Rannacher, Acta Numerica 10, 2001;
//! decision 71.) Goals are judged where the last step ends, which is the state that every round has:
//! the bound of an early increment over its own small force would be that of a contact on a cell or
//! two. On the first mesh all steps are solved; on each one that follows only the last state is
//! brought into equilibrium, from that of the mesh before, which is the same function there. Under
//! friction, whose slip counts from where increments began, beside fluids, which only advance, and
//! beside contact and ties between bodies, whose multipliers belong to both meshes, all steps are
//! solved on each mesh.
//!
//! What flat facets make of a goal where they stand for a curved surface is no error that
//! halving takes away: vertices of the halves lie on the facets. It counts in the bound as on the
//! first mesh, and ends the loop where it alone is too much. Arcs fitted over facets (`smooth`) are
//! fitted once, to the first mesh; its refinements follow them.
//!
//! The same request gives the same meshes and bits, whatever the number of threads, unless a limit
//! of time ends it. Units are the caller's.
//!
//! | file | what it has |
//! |---|---|
//! | `accuracy` | what is asked for, and how far the loop may go |
//! | `round` | what a mesh gave, and how the loop ended |
//! | `judge` | whether goals are known well enough; which cells are halved |
//! | `rounds` | the loop |
//! | `error` | why there is no result |

mod accuracy;
mod error;
mod judge;
mod round;
mod rounds;

pub use accuracy::{Accuracy, AccuracyLimits, Target};
pub use error::AdaptionError;
pub use round::{End, GoalRound, Round};
pub use rounds::{Adapted, Problem, Watch, adapt};
