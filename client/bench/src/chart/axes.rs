//! The frame of a diagram: title, axes with ticks and grid, legend.

use super::scale::{Kind, Scale, Tick};
use super::svg::{Anchor, BOLD, FAINT, GRID, SMALL, Svg, WIDTH, width_of};

/// Place of the plot.
pub(super) const LEFT: f64 = 76.0;
pub(super) const RIGHT: f64 = WIDTH - 18.0;
pub(super) const TOP: f64 = 44.0;
pub(super) const BOTTOM: f64 = 344.0;

/// Two scales and the plot between them.
pub(super) struct Frame {
    x: Scale,
    y: Scale,
}

impl Frame {
    /// A frame that shows all values of both directions.
    pub(super) fn new(
        kinds: (Kind, Kind),
        across: impl Iterator<Item = f64>,
        up: impl Iterator<Item = f64>,
    ) -> Self {
        Self {
            x: Scale::new(kinds.0, across),
            y: Scale::new(kinds.1, up),
        }
    }

    /// Where a value across lies.
    pub(super) fn across(&self, value: f64) -> f64 {
        LEFT + self.x.fraction(value) * (RIGHT - LEFT)
    }

    /// Where a value upwards lies.
    pub(super) fn up(&self, value: f64) -> f64 {
        BOTTOM - self.y.fraction(value) * (BOTTOM - TOP)
    }

    /// Draws title, grid, ticks and labels; gives the place below them.
    pub(super) fn draw(&self, svg: &mut Svg, title: &str, labels: (&str, &str)) -> f64 {
        svg.text((12.0, 24.0), Anchor::Start, BOLD, title);
        for tick in self.x.ticks() {
            self.tick_across(svg, &tick);
        }
        for tick in self.y.ticks() {
            self.tick_up(svg, &tick);
        }
        let frame = format!("fill=\"none\" stroke=\"{FAINT}\"");
        let (width, height) = (RIGHT - LEFT, BOTTOM - TOP);
        svg.add(format_args!(
            "<rect x=\"{LEFT}\" y=\"{TOP}\" width=\"{width}\" height=\"{height}\" {frame}/>"
        ));
        let middle = (0.5 * (LEFT + RIGHT), BOTTOM + 38.0);
        svg.text(middle, Anchor::Middle, SMALL, labels.0);
        svg.upwards((20.0, 0.5 * (TOP + BOTTOM)), SMALL, labels.1);
        BOTTOM + 46.0
    }

    fn tick_across(&self, svg: &mut Svg, tick: &Tick) {
        let x = self.across(tick.value);
        let mark = format!("stroke=\"{FAINT}\"");
        let Some(label) = &tick.label else {
            svg.line((x, BOTTOM), (x, BOTTOM - 4.0), &mark);
            return;
        };
        svg.line((x, TOP), (x, BOTTOM), &format!("stroke=\"{GRID}\""));
        svg.line((x, BOTTOM), (x, BOTTOM + 5.0), &mark);
        svg.text((x, BOTTOM + 19.0), Anchor::Middle, SMALL, label);
    }

    fn tick_up(&self, svg: &mut Svg, tick: &Tick) {
        let y = self.up(tick.value);
        let mark = format!("stroke=\"{FAINT}\"");
        let Some(label) = &tick.label else {
            svg.line((LEFT, y), (LEFT + 4.0, y), &mark);
            return;
        };
        svg.line((LEFT, y), (RIGHT, y), &format!("stroke=\"{GRID}\""));
        svg.line((LEFT - 5.0, y), (LEFT, y), &mark);
        svg.text((LEFT - 9.0, y + 4.0), Anchor::End, SMALL, label);
    }
}

/// Draws entries in rows from `top` on; `sample` draws the sign of one at a
/// place. Gives the place below them.
pub(super) fn legend(
    svg: &mut Svg,
    top: f64,
    labels: &[String],
    sample: impl Fn(&mut Svg, usize, (f64, f64)),
) -> f64 {
    const SIGN: f64 = 34.0;
    let (mut x, mut y) = (12.0, top + 16.0);
    for (index, label) in labels.iter().enumerate() {
        let width = SIGN + width_of(label, SMALL) + 18.0;
        if x > 12.0 && x + width > WIDTH {
            (x, y) = (12.0, y + 19.0);
        }
        sample(svg, index, (x, y - 4.0));
        svg.text((x + SIGN, y), Anchor::Start, SMALL, label);
        x += width;
    }
    y + 6.0
}
