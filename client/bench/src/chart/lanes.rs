//! Dots in lanes, one lane a group: two logarithmic scales side by side, and a column
//! of what has no number.

use super::axes::legend;
use super::scale::{Kind, Scale};
use super::svg::{Anchor, BOLD, FAINT, GRID, SMALL, Svg, TINY, colour};

/// How a dot is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mark {
    /// A disc.
    Good,
    /// A circle.
    Open,
    /// A cross.
    Bad,
}

/// One run.
#[derive(Clone, Debug)]
pub(crate) struct Dot {
    /// Value on the first scale; without it the dot stands in the column beside, but a bad
    /// one at the right end of the scale.
    pub(crate) first: Option<f64>,
    /// Value on the second scale.
    pub(crate) second: f64,
    pub(crate) mark: Mark,
    /// Shown where a pointer rests.
    pub(crate) name: String,
}

/// Dots of a group.
#[derive(Clone, Debug)]
pub(crate) struct Lane {
    pub(crate) name: String,
    pub(crate) dots: Vec<Dot>,
}

/// The picture.
#[derive(Clone, Debug)]
pub(crate) struct Lanes {
    pub(crate) title: String,
    /// Of the column without numbers, and of the scales.
    pub(crate) labels: [String; 3],
    /// Meaning of the marks, in their order.
    pub(crate) marks: [String; 3],
    pub(crate) lanes: Vec<Lane>,
    /// Small print below.
    pub(crate) footer: Vec<String>,
}

const TOP: f64 = 58.0;
const PITCH: f64 = 30.0;
/// Where lanes begin, and the first scale, its end, the second one, and its end.
const COLUMN: (f64, f64) = (194.0, 262.0);
const FIRST: (f64, f64) = (262.0, 452.0);
const SECOND: (f64, f64) = (464.0, 630.0);
/// The end of the first scale that has no numbers.
const END: f64 = 16.0;
/// Dots of a lane stand on so many lines, this far apart.
const LINES: usize = 3;
const APART: f64 = 7.0;
/// Values below are drawn there: rounding.
const LEAST: f64 = 1e-16;

const MARKS: [Mark; 3] = [Mark::Good, Mark::Open, Mark::Bad];

impl Lanes {
    /// The picture.
    pub(crate) fn svg(&self) -> String {
        let mut svg = Svg::default();
        svg.text((12.0, 24.0), Anchor::Start, BOLD, &self.title);
        let scales = self.scales();
        let bottom = self.draw_frame(&mut svg, &scales);
        for (index, lane) in self.lanes.iter().enumerate() {
            draw_dots(&mut svg, lane, top_of(index), &scales);
        }
        let below = legend(
            &mut svg,
            bottom + 24.0,
            &self.marks,
            |svg, index, (x, y)| {
                if let Some(mark) = MARKS.get(index) {
                    draw(svg, *mark, (x + 20.0, y), "");
                }
            },
        );
        let height = svg.small_print(below, &self.footer) + 12.0;
        svg.finish(height, &self.title)
    }

    fn scales(&self) -> [Scale; 2] {
        let dots = || self.lanes.iter().flat_map(|lane| &lane.dots);
        let firsts = dots().filter_map(|dot| dot.first);
        [
            Scale::new(Kind::Logarithmic, firsts.map(|value| value.max(LEAST))),
            Scale::new(Kind::Logarithmic, dots().map(|dot| dot.second)),
        ]
    }

    /// Names of the lanes, and the scales; gives the place below them.
    fn draw_frame(&self, svg: &mut Svg, [first, second]: &[Scale; 2]) -> f64 {
        for (index, lane) in self.lanes.iter().enumerate() {
            let top = top_of(index);
            svg.line((12.0, top), (SECOND.1, top), &format!("stroke=\"{GRID}\""));
            svg.text((12.0, top + 19.0), Anchor::Start, TINY, &lane.name);
        }
        let [column, one, other] = &self.labels;
        let middle = (0.5 * (COLUMN.0 + COLUMN.1), TOP - 10.0);
        svg.text(middle, Anchor::Middle, TINY, column);
        let bottom = top_of(self.lanes.len());
        draw_scale(svg, first, (FIRST, END), bottom, one);
        draw_scale(svg, second, (SECOND, 0.0), bottom, other);
        bottom
    }
}

fn top_of(lane: usize) -> f64 {
    TOP + PITCH * lane as f64
}

fn draw_scale(
    svg: &mut Svg,
    scale: &Scale,
    ((left, right), end): ((f64, f64), f64),
    bottom: f64,
    label: &str,
) {
    svg.text(
        (0.5 * (left + right), TOP - 10.0),
        Anchor::Middle,
        SMALL,
        label,
    );
    let mut free = f64::NEG_INFINITY;
    for tick in scale.ticks() {
        let Some(label) = tick.label else { continue };
        // Ticks take what is as small for zero.
        let label = if label == "0" {
            "10⁻¹⁶".to_owned()
        } else {
            label
        };
        let x = left + scale.fraction(tick.value) * (right - end - left);
        svg.line((x, TOP), (x, bottom), &format!("stroke=\"{GRID}\""));
        if x > free {
            svg.text((x, bottom + 15.0), Anchor::Middle, TINY, &label);
            free = x + 30.0;
        }
    }
    let (width, height) = (right - left, bottom - TOP);
    svg.add(format_args!(
        "<rect x=\"{left}\" y=\"{TOP}\" width=\"{width}\" height=\"{height}\" fill=\"none\" stroke=\"{FAINT}\"/>"
    ));
}

fn draw_dots(svg: &mut Svg, lane: &Lane, top: f64, [first, second]: &[Scale; 2]) {
    let line = |index: usize| {
        let line = (index % LINES) as f64 - 0.5 * (LINES - 1) as f64;
        top + 0.5 * PITCH + APART * line
    };
    let mut beside = 0;
    for (index, dot) in lane.dots.iter().enumerate() {
        let y = line(index);
        let place = match (dot.first, dot.mark) {
            (Some(value), _) => {
                let part = first.fraction(value.max(LEAST));
                (FIRST.0 + part * (FIRST.1 - END - FIRST.0), y)
            }
            (None, Mark::Bad) => (FIRST.1 - 0.5 * END, y),
            (None, Mark::Good | Mark::Open) => {
                beside += 1;
                let column = (beside - 1) / LINES + 1;
                (COLUMN.0 + 12.0 * column as f64, line(beside - 1))
            }
        };
        draw(svg, dot.mark, place, &dot.name);
        let x = SECOND.0 + second.fraction(dot.second) * (SECOND.1 - SECOND.0);
        draw(svg, dot.mark, (x, y), &dot.name);
    }
}

fn draw(svg: &mut Svg, mark: Mark, (x, y): (f64, f64), name: &str) {
    let (good, bad, name) = (colour(0), colour(1), super::svg::escaped(name));
    match mark {
        Mark::Good => svg.add(format_args!(
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3.2\" fill=\"{good}\" fill-opacity=\"0.8\"><title>{name}</title></circle>"
        )),
        Mark::Open => svg.add(format_args!(
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"2.9\" fill=\"#ffffff\" stroke=\"{FAINT}\" stroke-width=\"1.3\"><title>{name}</title></circle>"
        )),
        Mark::Bad => svg.add(format_args!(
            "<path d=\"M{:.1} {:.1}l8 8m-8 0l8 -8\" stroke=\"{bad}\" stroke-width=\"2.4\" fill=\"none\"><title>{name}</title></path>",
            x - 4.0,
            y - 4.0
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_dot_stands_on_both_scales_or_beside_the_first() {
        let dot = |first, mark| Dot {
            first,
            second: 0.5,
            mark,
            name: "a < b".to_owned(),
        };
        let words = |text: &str| [text, text, text].map(str::to_owned);
        let lanes = Lanes {
            title: "Extremes".to_owned(),
            labels: words("label"),
            marks: words("mark"),
            lanes: vec![Lane {
                name: "one".to_owned(),
                dots: vec![
                    dot(Some(0.0), Mark::Good),
                    dot(None, Mark::Good),
                    dot(None, Mark::Bad),
                ],
            }],
            footer: Vec::new(),
        };
        let svg = lanes.svg();
        let names = svg.matches("<title>a &lt; b</title>").count();
        assert_eq!(names, 6, "{svg}");
        assert!(svg.contains("cx=\"206.0\""), "beside the scale");
    }
}
