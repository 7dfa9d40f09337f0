//! Diagrams as SVG: curves over logarithmic or linear axes, stacked bars, and
//! dots in lanes.
//!
//! Each picture stands on a light ground of its own, so that it reads the same
//! on light and dark pages; it needs no script and no font that is not there.
//! A picture is 640 units wide; its height follows from its legend and footer.

mod axes;
mod bars;
mod curves;
mod lanes;
mod scale;
mod svg;

pub(crate) use bars::{Bar, Bars};
pub(crate) use curves::{Curve, Diagram, Level, Point, State, Stroke};
pub(crate) use lanes::{Dot, Lane, Lanes, Mark};
pub(crate) use scale::Kind;
pub(crate) use svg::escaped;
