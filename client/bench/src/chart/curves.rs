//! Curves through points, with failures marked as such.

use super::axes::{BOTTOM, Frame, LEFT, RIGHT, TOP, legend};
use super::scale::Kind;
use super::svg::{Anchor, FAINT, GRID, Svg, TINY, colour, escaped, width_of};

/// What a point stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum State {
    /// A result.
    Good,
    /// A result below the uncertainty of what it is compared with.
    Uncertain,
    /// No result that meets its tolerance.
    Failed,
}

/// One run.
#[derive(Clone, Debug)]
pub(crate) struct Point {
    pub(crate) x: f64,
    /// None for failures without a result: they are drawn at the upper edge.
    pub(crate) y: Option<f64>,
    pub(crate) state: State,
    /// Such as `n16`.
    pub(crate) name: String,
    /// Least and greatest `x` of the runs that the point stands for.
    pub(crate) spread: Option<(f64, f64)>,
}

/// How a line is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stroke {
    /// For this program.
    Solid,
    /// For others.
    Dashed,
}

/// Points of one method.
#[derive(Clone, Debug)]
pub(crate) struct Curve {
    pub(crate) label: String,
    pub(crate) stroke: Stroke,
    pub(crate) points: Vec<Point>,
}

/// A horizontal line with a name.
#[derive(Clone, Debug)]
pub(crate) struct Level {
    pub(crate) value: f64,
    pub(crate) label: String,
}

/// Curves over two axes.
#[derive(Clone, Debug)]
pub(crate) struct Diagram {
    pub(crate) title: String,
    pub(crate) x: (Kind, String),
    pub(crate) y: (Kind, String),
    pub(crate) curves: Vec<Curve>,
    pub(crate) level: Option<Level>,
    /// Small print below.
    pub(crate) footer: Vec<String>,
}

impl Diagram {
    /// Whether there is anything to draw.
    pub(crate) fn is_empty(&self) -> bool {
        self.curves.iter().all(|curve| curve.points.is_empty())
    }

    /// Whether one of the curves has a slope to be read.
    pub(crate) fn has_slope(&self) -> bool {
        self.curves.iter().any(|curve| curve.points.len() > 1)
    }

    /// The picture.
    pub(crate) fn svg(&self) -> String {
        let mut svg = Svg::default();
        let frame = self.frame();
        let below = frame.draw(&mut svg, &self.title, (&self.x.1, &self.y.1));
        self.draw_level(&mut svg, &frame);
        for (index, curve) in self.curves.iter().enumerate() {
            draw_line(&mut svg, &frame, index, curve);
        }
        let mut names = Names::default();
        for (index, curve) in self.curves.iter().enumerate() {
            draw_points(&mut svg, &frame, index, curve, &mut names);
        }
        let below = self.draw_legend(&mut svg, below);
        let height = svg.small_print(below, &self.footer) + 12.0;
        svg.finish(height, &self.title)
    }

    fn frame(&self) -> Frame {
        let points = || self.curves.iter().flat_map(|curve| &curve.points);
        let across = points().flat_map(|point| {
            let (least, most) = point.spread.unwrap_or((point.x, point.x));
            [point.x, least, most]
        });
        let level = self.level.iter().map(|level| level.value);
        let up = points().filter_map(|point| point.y).chain(level);
        Frame::new((self.x.0, self.y.0), across, up)
    }

    fn draw_level(&self, svg: &mut Svg, frame: &Frame) {
        let Some(level) = &self.level else { return };
        let y = frame.up(level.value);
        let (width, height) = (RIGHT - LEFT, (BOTTOM - y).max(0.0));
        svg.add(format_args!(
            "<rect x=\"{LEFT}\" y=\"{y:.1}\" width=\"{width}\" height=\"{height:.1}\" fill=\"{GRID}\" fill-opacity=\"0.45\"/>"
        ));
        let style = format!("stroke=\"{FAINT}\" stroke-dasharray=\"2 3\"");
        svg.line((LEFT, y), (RIGHT, y), &style);
        // Falling curves leave the left of a low line free.
        svg.text((LEFT + 6.0, y - 5.0), Anchor::Start, TINY, &level.label);
    }

    fn draw_legend(&self, svg: &mut Svg, top: f64) -> f64 {
        let curves = self.curves.iter().enumerate();
        let drawn = curves.filter(|(_, curve)| !curve.points.is_empty());
        let mut entries: Vec<Entry<'_>> = drawn
            .map(|(index, curve)| Entry::of(index, curve))
            .collect();
        let states = [State::Uncertain, State::Failed].into_iter();
        entries.extend(
            states
                .filter(|state| self.shows(*state))
                .map(Entry::meaning),
        );
        let labels: Vec<String> = entries.iter().map(|entry| entry.label.to_owned()).collect();
        legend(svg, top, &labels, |svg, index, place| {
            if let Some(entry) = entries.get(index) {
                entry.draw(svg, place);
            }
        })
    }

    fn shows(&self, state: State) -> bool {
        let mut points = self.curves.iter().flat_map(|curve| &curve.points);
        points.any(|point| point.state == state)
    }
}

/// An entry of the legend.
struct Entry<'a> {
    label: &'a str,
    sign: Sign,
    /// None for the meaning of a filling.
    stroke: Option<Stroke>,
}

impl<'a> Entry<'a> {
    fn of(index: usize, curve: &'a Curve) -> Self {
        let (state, stroke) = (State::Good, Some(curve.stroke));
        let sign = Sign { index, state };
        let label = &curve.label;
        Self {
            label,
            sign,
            stroke,
        }
    }

    fn meaning(state: State) -> Self {
        let sign = Sign {
            index: NEUTRAL,
            state,
        };
        let label = meaning(state);
        Self {
            label,
            sign,
            stroke: None,
        }
    }

    fn draw(&self, svg: &mut Svg, (x, y): (f64, f64)) {
        if let Some(stroke) = self.stroke {
            svg.line((x, y), (x + 28.0, y), &line_style(self.sign.index, stroke));
        }
        marker(svg, (x + 14.0, y), self.sign, "");
    }
}

/// The grey of the colours.
const NEUTRAL: usize = 7;

fn meaning(state: State) -> &'static str {
    match state {
        State::Good => "result",
        State::Uncertain => "below the uncertainty of the limit",
        State::Failed => "failure",
    }
}

fn line_style(index: usize, stroke: Stroke) -> String {
    let colour = colour(index);
    let dashes = match stroke {
        Stroke::Solid => "stroke-width=\"2.4\"",
        Stroke::Dashed => "stroke-width=\"1.6\" stroke-dasharray=\"6 4\"",
    };
    format!("fill=\"none\" stroke=\"{colour}\" {dashes}")
}

/// Through the points that have a result.
fn draw_line(svg: &mut Svg, frame: &Frame, index: usize, curve: &Curve) {
    let good = curve
        .points
        .iter()
        .filter(|point| point.state != State::Failed);
    let places: Vec<String> = good
        .filter_map(|point| {
            Some(format!(
                "{:.1},{:.1}",
                frame.across(point.x),
                frame.up(point.y?)
            ))
        })
        .collect();
    if places.len() > 1 {
        let style = line_style(index, curve.stroke);
        svg.add(format_args!(
            "<polyline points=\"{}\" {style}/>",
            places.join(" ")
        ));
    }
}

/// Places of names that are there: a name that would cover another is left out.
#[derive(Default)]
struct Names {
    taken: Vec<(f64, f64)>,
}

impl Names {
    /// Whether a name of `text` may begin here.
    fn take(&mut self, (x, y): (f64, f64), text: &str) -> bool {
        let width = width_of(text, TINY) + 4.0;
        let covers = |place: &(f64, f64)| (place.0 - x).abs() < width && (place.1 - y).abs() < 13.0;
        let free = !text.is_empty() && !self.taken.iter().any(covers);
        if free {
            self.taken.push((x, y));
        }
        free
    }
}

fn draw_points(svg: &mut Svg, frame: &Frame, index: usize, curve: &Curve, names: &mut Names) {
    for point in &curve.points {
        let state = point.state;
        draw_spread(svg, frame, index, point);
        let note = format!("{}, {}", curve.label, point.name);
        marker(svg, place(frame, point), Sign { index, state }, &note);
        // One curve names its meshes; more names would cover each other.
        if state == State::Failed {
            let (x, y) = place(frame, point);
            if names.take((x, y), &point.name) {
                svg.text((x - 11.0, y + 4.0), Anchor::End, TINY, &point.name);
            }
        } else if index == 0 && names.take(place(frame, point), &point.name) {
            draw_name(svg, place(frame, point), slope(curve), &point.name);
        }
    }
}

/// A bar over the runs of a point, where it is longer than its sign.
fn draw_spread(svg: &mut Svg, frame: &Frame, index: usize, point: &Point) {
    let Some((least, most)) = point.spread else {
        return;
    };
    let (left, right, y) = (
        frame.across(least),
        frame.across(most),
        place(frame, point).1,
    );
    if right - left > 2.0 {
        let style = format!("stroke=\"{}\" stroke-width=\"1.2\"", colour(index));
        svg.line((left, y), (right, y), &style);
        for end in [left, right] {
            svg.line((end, y - 3.5), (end, y + 3.5), &style);
        }
    }
}

fn place(frame: &Frame, point: &Point) -> (f64, f64) {
    let y = point.y.map_or(TOP, |y| frame.up(y));
    (frame.across(point.x), y.clamp(TOP + 10.0, BOTTOM))
}

/// Whether a curve ends higher than it begins: greater if so.
fn slope(curve: &Curve) -> std::cmp::Ordering {
    let end = |point: Option<&Point>| point.and_then(|point| point.y).unwrap_or_default();
    end(curve.points.last()).total_cmp(&end(curve.points.first()))
}

/// Above the point, on the side that its curve leaves free.
fn draw_name(svg: &mut Svg, (x, y): (f64, f64), slope: std::cmp::Ordering, name: &str) {
    let leaves = x + 8.0 + width_of(name, TINY) > RIGHT + 12.0;
    let (across, anchor) = if slope.is_gt() || leaves {
        (-7.0, Anchor::End)
    } else {
        (8.0, Anchor::Start)
    };
    svg.text((x + across, y - 7.0), anchor, TINY, name);
}

/// Colour and shape by series, filling by state.
#[derive(Clone, Copy)]
struct Sign {
    index: usize,
    state: State,
}

fn marker(svg: &mut Svg, (x, y): (f64, f64), sign: Sign, note: &str) {
    let colour = colour(sign.index);
    if sign.state == State::Failed {
        let path = format!("M{:.1} {:.1}l12 12m0 -12l-12 12", x - 6.0, y - 6.0);
        svg.add(format_args!(
            "<path d=\"{path}\" stroke=\"{colour}\" stroke-width=\"3\">{}</path>",
            title(note)
        ));
        return;
    }
    let fill = match sign.state {
        State::Uncertain => "#ffffff",
        State::Good | State::Failed => colour,
    };
    let style = format!("fill=\"{fill}\" stroke=\"{colour}\" stroke-width=\"1.5\"");
    let outline = match sign.index % 4 {
        0 => "m-5 0a5 5 0 1 0 10 0a5 5 0 1 0 -10 0z",
        1 => "m-4.5 -4.5h9v9h-9z",
        2 => "m0 -6l5.5 10h-11z",
        _ => "m0 -6l5.5 6l-5.5 6l-5.5 -6z",
    };
    svg.add(format_args!(
        "<path d=\"M{x:.1} {y:.1}{outline}\" {style}>{}</path>",
        title(note)
    ));
}

fn title(note: &str) -> String {
    match note {
        "" => String::new(),
        note => format!("<title>{}</title>", escaped(note)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(x: f64, y: Option<f64>, state: State) -> Point {
        Point {
            x,
            y,
            state,
            name: "n6".to_owned(),
            spread: None,
        }
    }

    fn diagram(points: Vec<Point>) -> Diagram {
        Diagram {
            title: "Error & time".to_owned(),
            x: (Kind::Logarithmic, "seconds".to_owned()),
            y: (Kind::Logarithmic, "error".to_owned()),
            curves: vec![Curve {
                label: "auto".to_owned(),
                stroke: Stroke::Solid,
                points,
            }],
            level: None,
            footer: vec!["two cores".to_owned()],
        }
    }

    #[test]
    fn failures_are_crosses_and_not_on_the_line() {
        let points = vec![
            point(0.1, Some(1e-2), State::Good),
            point(1.0, Some(1e-3), State::Good),
            point(20.0, None, State::Failed),
        ];
        let svg = diagram(points).svg();
        assert_eq!(
            svg.matches("l12 12m0 -12l-12 12").count(),
            2,
            "point and legend"
        );
        let line = svg
            .lines()
            .find(|line| line.starts_with("<polyline"))
            .unwrap();
        assert_eq!(line.matches(',').count(), 2, "{line}");
        assert!(svg.contains(">failure</text>"));
    }

    #[test]
    fn the_spread_of_the_runs_is_a_bar_that_fits_the_frame() {
        let mut good = point(1.0, Some(1e-2), State::Good);
        let narrow = diagram(vec![good.clone()]).svg();
        good.spread = Some((0.5, 2.0));
        let wide = diagram(vec![good]).svg();
        let lines = |svg: &str| svg.matches("stroke-width=\"1.2\"").count();
        assert_eq!((lines(&narrow), lines(&wide)), (0, 3));
    }

    #[test]
    fn pictures_name_their_axes_and_their_machine() {
        let svg = diagram(vec![point(0.1, Some(1e-2), State::Uncertain)]).svg();
        for text in [
            ">seconds<",
            ">error<",
            ">two cores<",
            "Error &amp; time",
            "below the uncertainty",
        ] {
            assert!(svg.contains(text), "{text}");
        }
        assert!(diagram(Vec::new()).is_empty());
    }

    #[test]
    fn two_points_of_one_curve_make_a_slope() {
        let good = |seconds| point(seconds, Some(1e-2), State::Good);
        let mut dots = diagram(vec![good(0.1)]);
        dots.curves.extend(diagram(vec![good(1.0)]).curves);
        assert!(!dots.has_slope());
        assert!(diagram(vec![good(0.1), good(1.0)]).has_slope());
    }
}
