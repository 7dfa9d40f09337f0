//! All methods for contact against the optimality conditions of the same small problems.

mod inequality;
mod linalg;

use signorini::{krylov, saddle};
