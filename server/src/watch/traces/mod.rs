//! Traces of what is solved, for a collector of OpenTelemetry: an update, its increments, the
//! quadratic programs of each, the Krylov iterations of each program.
//!
//! A build without the feature `otlp` has none of it: what stands in its place does nothing.

#[cfg(not(feature = "otlp"))]
mod none;
#[cfg(feature = "otlp")]
mod otlp;

#[cfg(not(feature = "otlp"))]
pub(crate) use none::{IncrementTrace, Traces, UpdateTrace};
#[cfg(feature = "otlp")]
pub(crate) use otlp::{IncrementTrace, Traces, UpdateTrace};
