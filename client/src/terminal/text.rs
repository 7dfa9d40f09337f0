//! Writes to stderr, and text and numbers for people.
//!
//! Names come from files and from servers: what could move a cursor, turn the direction of
//! writing or is not seen is spelled out before it reaches a terminal.

use std::borrow::Cow;
use std::io::Write;

use signorini_server::is_unprintable;

/// Writes to stderr, where failing can be told to nobody.
pub(crate) fn note(text: &str) {
    let _closed = std::io::stderr().write_all(visible(text).as_bytes());
}

/// The text with its lines and tabs, every other control character spelled out.
pub(crate) fn visible(text: &str) -> Cow<'_, str> {
    spelled(text, |c| is_unprintable(c) && !matches!(c, '\n' | '\t'))
}

/// The text as a part of one line.
pub(crate) fn one_line(text: &str) -> Cow<'_, str> {
    spelled(text, is_unprintable)
}

fn spelled(text: &str, is_spelled: impl Fn(char) -> bool) -> Cow<'_, str> {
    if !text.contains(&is_spelled) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len() + 8);
    for c in text.chars() {
        if is_spelled(c) {
            out.extend(c.escape_default())
        } else {
            out.push(c)
        }
    }
    Cow::Owned(out)
}

/// Six significant digits, without trailing zeros.
pub(crate) fn number(value: f64) -> String {
    let magnitude = value.abs();
    if magnitude == 0.0 {
        return "0".to_owned();
    }
    if !(1e-3..1e6).contains(&magnitude) {
        return format!("{value:.5e}");
    }
    let decimals = 5 - magnitude.log10().floor() as i32;
    let fixed = format!("{value:.*}", decimals.max(0) as usize);
    if fixed.contains('.') {
        fixed.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        fixed
    }
}

/// A value with its error: two digits of the error, the value to the same place.
pub(crate) fn with_error(value: f64, error: Option<f64>) -> String {
    let usable = |error: &f64| error.is_finite() && *error > 0.0 && value.is_finite();
    let Some(error) = error.filter(usable) else {
        return number(value);
    };
    let size = value.abs().max(error);
    let exponent = if (1e-3..1e6).contains(&size) {
        0
    } else {
        size.log10().floor() as i32
    };
    let unit = 10_f64.powi(exponent);
    let decimals = (1 - (error / unit).log10().floor() as i32).clamp(0, 9) as usize;
    let text = format!("{:.decimals$} ± {:.decimals$}", value / unit, error / unit);
    match exponent {
        0 => text,
        exponent => format!("({text})e{exponent}"),
    }
}

/// Per cent in two digits.
pub(crate) fn percent(ratio: f64) -> String {
    let percent = 100.0 * ratio;
    if percent.abs() < 1e-3 {
        return "0 %".to_owned();
    }
    let decimals = 1 - percent.abs().log10().floor() as i32;
    format!("{percent:.*} %", decimals.clamp(0, 4) as usize)
}

/// Numbers in brackets.
pub(crate) fn vector(values: &[f64]) -> String {
    let values: Vec<_> = values.iter().map(|value| number(*value)).collect();
    format!("({})", values.join(", "))
}

/// Bytes in binary units.
pub(crate) fn bytes(count: i64) -> String {
    let mut value = count as f64;
    for unit in ["B", "KiB", "MiB"] {
        if value < 1024.0 {
            return format!("{} {unit}", number((value * 10.0).round() / 10.0));
        }
        value /= 1024.0;
    }
    format!("{} GiB", number((value * 10.0).round() / 10.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_six_significant_digits() {
        for (value, text) in [
            (0.0, "0"),
            (1.5, "1.5"),
            (-0.017049385, "-0.0170494"),
            (123456.7, "123457"),
            (1.0e-7, "1.00000e-7"),
            (2.5e8, "2.50000e8"),
            (100.0, "100"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(number(value), text);
        }
    }

    #[test]
    fn what_could_move_a_cursor_is_spelled_out() {
        assert_eq!(visible("a\u{1b}[2J\n\tb"), "a\\u{1b}[2J\n\tb");
        assert_eq!(one_line("a\nb\u{9b}\u{202e}"), "a\\nb\\u{9b}\\u{202e}");
        assert!(matches!(one_line("Dichtung µ"), Cow::Borrowed(_)));
    }

    #[test]
    fn errors_have_two_digits_and_values_as_many_places() {
        for (value, error, text) in [
            (0.018_274_9, Some(5.04e-5), "0.018275 ± 0.000050"),
            (246.2195, Some(1.26), "246.2 ± 1.3"),
            (-246.2195, Some(31.0), "-246 ± 31"),
            (0.0, Some(0.5), "0.00 ± 0.50"),
            (1.5e-9, Some(2.0e-11), "(1.500 ± 0.020)e-9"),
            (3.0e7, Some(1.0e4), "(3.0000 ± 0.0010)e7"),
            (1.5, Some(f64::NAN), "1.5"),
            (1.5, None, "1.5"),
        ] {
            assert_eq!(with_error(value, error), text);
        }
    }

    #[test]
    fn percents_have_two_digits() {
        let texts = [0.0442, 0.3, 0.001, 1.5, 0.0].map(percent);
        assert_eq!(texts, ["4.4 %", "30 %", "0.10 %", "150 %", "0 %"]);
    }

    #[test]
    fn bytes_choose_their_unit() {
        assert_eq!(
            [bytes(12), bytes(2048), bytes(1_500_000)],
            ["12 B", "2 KiB", "1.4 MiB"]
        );
        assert_eq!(bytes(3 << 30), "3 GiB");
    }
}
