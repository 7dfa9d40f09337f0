//! A plot of measured points and the curves of a law, as SVG.
//!
//! Series differ by colour and by the shape of their points, which print and colour-blind readers
//! tell apart. Nothing in it is fetched. Cost: some 60 bytes a point.

use std::borrow::Cow;
use std::fmt::Write as _;

use crate::terminal::text::number;

/// Width, height and margins in pixels: left, right, top, bottom.
const SIZE: [f64; 2] = [720.0, 460.0];
const MARGINS: [f64; 4] = [70.0, 20.0, 40.0, 55.0];
/// Colours of the series.
const COLOURS: [&str; 3] = ["#0067a5", "#c0392b", "#2e7d32"];
/// Ticks of an axis at most.
const TICKS: f64 = 8.0;

/// Measured points and the curve of a law.
pub(crate) struct Series {
    pub(crate) name: Cow<'static, str>,
    pub(crate) points: Vec<[f64; 2]>,
    pub(crate) curve: Vec<[f64; 2]>,
}

/// Some series on common axes.
pub(crate) struct Plot {
    pub(crate) title: String,
    /// What stands along the axes.
    pub(crate) axes: [&'static str; 2],
    pub(crate) series: Vec<Series>,
}

/// An axis: the numbers at its ends, and the pixels.
struct Axis {
    numbers: [f64; 2],
    pixels: [f64; 2],
    step: f64,
}

impl Axis {
    /// An axis with round numbers about all `values`.
    fn new(values: impl Iterator<Item = f64>, pixels: [f64; 2]) -> Self {
        let [least, most] = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], x| {
            [least.min(x), most.max(x)]
        });
        let is_range = least.is_finite() && most > least;
        let [least, most] = if is_range { [least, most] } else { [0.0, 1.0] };
        let raw = (most - least) / TICKS;
        let unit = 10_f64.powf(raw.log10().floor());
        let steps = [1.0, 2.0, 5.0, 10.0]
            .into_iter()
            .map(|factor| factor * unit);
        let step = steps.into_iter().find(|step| *step >= raw).unwrap_or(raw);
        Self {
            numbers: [(least / step).floor() * step, (most / step).ceil() * step],
            pixels,
            step,
        }
    }

    fn place(&self, value: f64) -> f64 {
        let [least, most] = self.numbers;
        let [from, to] = self.pixels;
        from + (to - from) * (value - least) / (most - least)
    }

    fn ticks(&self) -> impl Iterator<Item = f64> {
        let [least, most] = self.numbers;
        let (step, count) = (self.step, ((most - least) / self.step).round() as u32);
        (0..=count).map(move |tick| least + step * f64::from(tick))
    }
}

/// A text with what XML reserves spelled out.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}

/// Appends to a text, which takes everything.
macro_rules! add {
    ($svg:expr, $($what:tt)*) => { let _whole = writeln!($svg, $($what)*); };
}

impl Plot {
    /// The picture.
    pub(crate) fn svg(&self) -> String {
        let [width, height] = SIZE;
        let [left, right, top, bottom] = MARGINS;
        let all = || {
            self.series
                .iter()
                .flat_map(|one| one.points.iter().chain(&one.curve))
        };
        let x = Axis::new(all().map(|point| point[0]), [left, width - right]);
        let y = Axis::new(all().map(|point| point[1]), [height - bottom, top]);
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" \
             width=\"{width}\" height=\"{height}\" font-family=\"sans-serif\" font-size=\"13\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n"
        );
        self.frame(&x, &y, &mut svg);
        for (number, (series, colour)) in self.series.iter().zip(COLOURS).enumerate() {
            series.draw([&x, &y], (number, colour), &mut svg);
        }
        svg.push_str("</svg>\n");
        svg
    }

    /// Grid, numbers and names of the axes.
    fn frame(&self, x: &Axis, y: &Axis, svg: &mut String) {
        let ([left, right], [low, high]) = (x.pixels, y.pixels);
        for tick in x.ticks() {
            let (at, text, below) = (x.place(tick), number(tick), low + 18.0);
            add!(
                svg,
                "<path d=\"M{at:.1} {low:.1}V{high:.1}\" stroke=\"#dddddd\"/>"
            );
            add!(
                svg,
                "<text x=\"{at:.1}\" y=\"{below:.1}\" text-anchor=\"middle\">{text}</text>"
            );
        }
        for tick in y.ticks() {
            let (at, text, beside) = (y.place(tick), number(tick), left - 8.0);
            add!(
                svg,
                "<path d=\"M{left:.1} {at:.1}H{right:.1}\" stroke=\"#dddddd\"/>"
            );
            add!(
                svg,
                "<text x=\"{beside:.1}\" y=\"{:.1}\" text-anchor=\"end\">{text}</text>",
                at + 4.0
            );
        }
        let [across, up] = self.axes;
        let (middle, centre) = (0.5 * (left + right), 0.5 * (low + high));
        let (title, below) = (escaped(&self.title), low + 40.0);
        add!(
            svg,
            "<text x=\"{middle:.1}\" y=\"{below:.1}\" text-anchor=\"middle\">{across}</text>"
        );
        add!(
            svg,
            "<text transform=\"translate(16 {centre:.1}) rotate(-90)\" text-anchor=\"middle\">{up}</text>"
        );
        add!(
            svg,
            "<text x=\"{left:.1}\" y=\"22\" font-weight=\"bold\">{title}</text>"
        );
    }
}

impl Series {
    fn draw(&self, [x, y]: [&Axis; 2], (number, colour): (usize, &str), svg: &mut String) {
        let place = |point: &[f64; 2]| (x.place(point[0]), y.place(point[1]));
        let line = self.curve.iter().map(|point| {
            let (x, y) = place(point);
            format!("{x:.1},{y:.1}")
        });
        let line: Vec<String> = line.collect();
        let line = line.join(" ");
        add!(
            svg,
            "<polyline points=\"{line}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"/>"
        );
        for (x, y) in self.points.iter().map(place) {
            mark((number, colour), [x, y], svg);
        }
        let (left, at) = (
            x.pixels[0] + 16.0,
            y.pixels[1] + 16.0 + 20.0 * number as f64,
        );
        mark((number, colour), [left, at - 4.0], svg);
        let name = escaped(&self.name);
        add!(
            svg,
            "<text x=\"{:.1}\" y=\"{at:.1}\">{name}</text>",
            left + 12.0
        );
    }
}

/// A circle, a square or a triangle.
fn mark((number, colour): (usize, &str), [x, y]: [f64; 2], svg: &mut String) {
    let path = match number {
        0 => format!("M{:.1} {y:.1}a4 4 0 1 0 8 0a4 4 0 1 0 -8 0", x - 4.0),
        1 => format!("M{:.1} {:.1}h7v7h-7z", x - 3.5, y - 3.5),
        _ => format!("M{x:.1} {:.1}l4.5 8h-9z", y - 5.0),
    };
    add!(
        svg,
        "<path d=\"{path}\" fill=\"#ffffff\" stroke=\"{colour}\" stroke-width=\"1.5\"/>"
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_have_round_numbers_about_all_points() {
        let axis = Axis::new([1.0, 7.61].into_iter(), [0.0, 100.0]);
        let ticks: Vec<String> = axis.ticks().map(number).collect();
        assert_eq!(ticks.join(" "), "1 2 3 4 5 6 7 8");
        assert!((axis.place(4.5) - 50.0).abs() < 1e-12);
        let nothing = Axis::new(std::iter::empty(), [0.0, 1.0]);
        assert!(nothing.place(0.5).is_finite());
    }

    #[test]
    fn a_plot_is_well_formed_and_names_its_series() {
        let plot = Plot {
            title: "a < b".to_owned(),
            axes: ["stretch", "stress"],
            series: vec![Series {
                name: "uniaxial".into(),
                points: vec![[1.0, 0.0], [2.0, 1.0]],
                curve: vec![[1.0, 0.0], [1.5, 0.6], [2.0, 1.1]],
            }],
        };
        let svg = plot.svg();
        let document = roxmltree::Document::parse(&svg).unwrap();
        let texts: Vec<&str> = document
            .descendants()
            .filter_map(|node| node.text())
            .collect();
        assert!(texts.contains(&"uniaxial") && texts.contains(&"a < b"));
    }
}
