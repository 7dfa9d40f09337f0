//! Stacked bars of shares.

use super::axes::legend;
use super::svg::{Anchor, BOLD, GRID, SMALL, Svg, TINY, WIDTH, colour};

/// One bar: its parts as they add up, and what is written beside it.
#[derive(Clone, Debug)]
pub(crate) struct Bar {
    pub(crate) name: String,
    pub(crate) parts: Vec<f64>,
    pub(crate) note: String,
}

/// Bars of equal length, divided as their parts are.
#[derive(Clone, Debug)]
pub(crate) struct Bars {
    pub(crate) title: String,
    /// Names of the parts.
    pub(crate) parts: Vec<String>,
    pub(crate) bars: Vec<Bar>,
    /// Small print below.
    pub(crate) footer: Vec<String>,
}

const LEFT: f64 = 150.0;
const RIGHT: f64 = WIDTH - 120.0;
const HEIGHT: f64 = 20.0;
const PITCH: f64 = 28.0;
/// Parts with a colour; the others are what remains, and grey.
const COLOURED: usize = 5;

impl Bars {
    /// The picture.
    pub(crate) fn svg(&self) -> String {
        let mut svg = Svg::default();
        svg.text((12.0, 24.0), Anchor::Start, BOLD, &self.title);
        let mut top = 40.0;
        for bar in &self.bars {
            draw(&mut svg, top, bar);
            top += PITCH;
        }
        self.draw_shares(&mut svg, top);
        let below = legend(&mut svg, top + 16.0, &self.parts, |svg, index, (x, y)| {
            rectangle(svg, (x + 8.0, y - 7.0), (18.0, 14.0), index, "");
        });
        let height = svg.small_print(below, &self.footer) + 12.0;
        svg.finish(height, &self.title)
    }

    fn draw_shares(&self, svg: &mut Svg, top: f64) {
        for percent in [0_u32, 25, 50, 75, 100] {
            let x = LEFT + f64::from(percent) / 100.0 * (RIGHT - LEFT);
            svg.text(
                (x, top + 8.0),
                Anchor::Middle,
                TINY,
                &format!("{percent} %"),
            );
        }
    }
}

fn draw(svg: &mut Svg, top: f64, bar: &Bar) {
    let middle = top + 0.5 * HEIGHT + 4.0;
    svg.text((LEFT - 8.0, middle), Anchor::End, SMALL, &bar.name);
    svg.text((RIGHT + 8.0, middle), Anchor::Start, SMALL, &bar.note);
    let total: f64 = bar.parts.iter().sum();
    let mut x = LEFT;
    for (index, part) in bar.parts.iter().enumerate() {
        let width = part / total.max(f64::MIN_POSITIVE) * (RIGHT - LEFT);
        rectangle(svg, (x, top), (width, HEIGHT), index, "stroke=\"#ffffff\"");
        x += width;
    }
}

fn rectangle(
    svg: &mut Svg,
    (x, y): (f64, f64),
    (width, height): (f64, f64),
    index: usize,
    style: &str,
) {
    let colour = if index < COLOURED {
        colour(index)
    } else {
        GRID
    };
    svg.add(format_args!(
        "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" fill=\"{colour}\" {style}/>"
    ));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_fill_the_bar() {
        let bars = Bars {
            title: "Phases".to_owned(),
            parts: vec!["a".to_owned(), "b".to_owned()],
            bars: vec![Bar {
                name: "n6".to_owned(),
                parts: vec![1.0, 3.0],
                note: "4 s".to_owned(),
            }],
            footer: Vec::new(),
        };
        let svg = bars.svg();
        let widths: Vec<&str> = svg
            .lines()
            .filter(|line| line.contains("stroke=\"#ffffff\""))
            .collect();
        assert!(
            widths[0].contains("width=\"92.5\"") && widths[1].contains("width=\"277.5\""),
            "{widths:?}"
        );
    }
}
