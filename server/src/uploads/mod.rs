//! What clients uploaded once and sessions share, under one byte budget.
//!
//! | file | what it does |
//! |---|---|
//! | `store` | meshes and prepared data |
//! | `surfaces` | surfaces of tools |

pub(crate) mod store;
pub(crate) mod surfaces;
