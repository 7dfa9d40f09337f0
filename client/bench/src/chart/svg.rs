//! Text of SVG, element by element.

use std::fmt::{Display, Write as _};

/// Width of every picture.
pub(super) const WIDTH: f64 = 640.0;
/// Width of a character at size one, on the safe side for sans-serif fonts.
const CHARACTER: f64 = 0.56;

const GROUND: &str = "#ffffff";
pub(super) const INK: &str = "#222222";
pub(super) const FAINT: &str = "#666666";
pub(super) const GRID: &str = "#dddddd";

/// Colours that remain apart for the colour-blind, dark enough on white.
const COLOURS: [&str; 8] = [
    "#0072b2", "#d55e00", "#009e73", "#aa4499", "#8a6d00", "#3a9bd9", "#882255", "#555555",
];

/// The colour of the series with this index.
pub(super) fn colour(index: usize) -> &'static str {
    COLOURS.get(index % COLOURS.len()).unwrap_or(&INK)
}

/// Where a text stands relative to its place.
#[derive(Clone, Copy)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// Size and colour of a text.
#[derive(Clone, Copy)]
pub(super) struct Type {
    pub(super) size: f64,
    pub(super) colour: &'static str,
    pub(super) weight: &'static str,
}

/// Labels of ticks and legends.
pub(super) const SMALL: Type = Type {
    size: 12.0,
    colour: INK,
    weight: "normal",
};
/// Footers and notes at points.
pub(super) const TINY: Type = Type {
    size: 10.5,
    colour: FAINT,
    weight: "normal",
};
/// Titles.
pub(super) const BOLD: Type = Type {
    size: 15.0,
    colour: INK,
    weight: "bold",
};

/// The width that a text takes.
pub(super) fn width_of(text: &str, kind: Type) -> f64 {
    text.chars().count() as f64 * kind.size * CHARACTER
}

/// A picture under construction.
#[derive(Default)]
pub(super) struct Svg {
    body: String,
}

impl Svg {
    /// Adds an element; writing to a string cannot fail.
    pub(super) fn add(&mut self, element: std::fmt::Arguments<'_>) {
        let _infallible = writeln!(self.body, "{element}");
    }

    pub(super) fn line(&mut self, (x1, y1): (f64, f64), (x2, y2): (f64, f64), style: &str) {
        self.add(format_args!(
            "<line x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\" {style}/>"
        ));
    }

    pub(super) fn text(&mut self, (x, y): (f64, f64), anchor: Anchor, kind: Type, text: &str) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let Type {
            size,
            colour,
            weight,
        } = kind;
        self.add(format_args!(
            "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" font-size=\"{size}\" \
             fill=\"{colour}\" font-weight=\"{weight}\">{}</text>",
            escaped(text)
        ));
    }

    /// A text that reads upwards.
    pub(super) fn upwards(&mut self, (x, y): (f64, f64), kind: Type, text: &str) {
        self.add(format_args!(
            "<g transform=\"translate({x:.1} {y:.1}) rotate(-90)\">"
        ));
        self.text((0.0, 0.0), Anchor::Middle, kind, text);
        self.add(format_args!("</g>"));
    }

    /// Lines of small print from `top` on; gives the place below them.
    pub(super) fn small_print(&mut self, mut top: f64, lines: &[String]) -> f64 {
        for line in lines {
            for part in wrapped(line, WIDTH - 24.0, TINY) {
                top += 14.0;
                self.text((12.0, top), Anchor::Start, TINY, &part);
            }
        }
        top
    }

    /// The whole picture; `about` is read out to those who do not see it.
    pub(super) fn finish(self, height: f64, about: &str) -> String {
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height:.0}\" \
             width=\"{WIDTH}\" height=\"{height:.0}\" role=\"img\" \
             font-family=\"Helvetica, Arial, sans-serif\">\n<title>{}</title>\n\
             <rect width=\"{WIDTH}\" height=\"{height:.0}\" fill=\"{GROUND}\"/>\n{}</svg>\n",
            escaped(about),
            self.body
        )
    }
}

/// Text with the characters that XML and HTML keep for themselves replaced.
pub(crate) fn escaped(text: &(impl Display + ?Sized)) -> String {
    let mut escaped = String::new();
    for character in text.to_string().chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            character => escaped.push(character),
        }
    }
    escaped
}

/// Words in lines no wider than `width`.
fn wrapped(text: &str, width: f64, kind: Type) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let Some(line) = lines.last_mut() else { break };
        if line.is_empty() {
            line.push_str(word);
        } else if width_of(line, kind) + width_of(word, kind) + kind.size < width {
            line.push(' ');
            line.push_str(word);
        } else {
            lines.push(word.to_owned());
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lines_are_wrapped_without_losing_a_word() {
        let text = "one two three four five six seven eight nine ten";
        let lines = wrapped(text, 100.0, TINY);
        assert!(lines.len() > 2 && lines.iter().all(|line| width_of(line, TINY) <= 100.0));
        assert_eq!(lines.join(" "), text);
    }

    #[test]
    fn special_characters_are_escaped() {
        assert_eq!(escaped("a<b & \"c\""), "a&lt;b &amp; &quot;c&quot;");
    }
}
