//! Spaces that Taylor-Hood is compared with.

pub(crate) mod enriched;
