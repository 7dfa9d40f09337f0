//! Numbers as tables and figures give them.

/// Where there is nothing to tell.
pub(crate) const NOTHING: &str = "–";

/// A value as `text` gives it, or the mark of one that is not there.
pub(crate) fn told<T>(value: Option<T>, text: impl FnOnce(T) -> String) -> String {
    value.map_or_else(|| NOTHING.to_owned(), text)
}

/// The number of six significant digits nearest to a value.
pub(crate) fn rounded(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

/// Seconds in three digits, milliseconds at the finest.
pub(crate) fn in_seconds(seconds: f64) -> String {
    let decimals = (2.0 - seconds.log10().floor()).clamp(0.0, 3.0) as usize;
    format!("{seconds:.decimals$} s")
}

/// A ratio in two digits.
pub(crate) fn times(ratio: f64) -> String {
    let decimals = usize::from(ratio < 9.95) + usize::from(ratio < 0.995);
    format!("{ratio:.decimals$}\u{a0}×")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_and_ratios_have_the_digits_that_runs_repeat() {
        assert_eq!(
            [in_seconds(0.0123), in_seconds(1.234), in_seconds(120.4)],
            ["0.012 s", "1.23 s", "120 s"]
        );
        assert_eq!(
            [times(1.94), times(31.2), times(0.771)],
            ["1.9\u{a0}×", "31\u{a0}×", "0.77\u{a0}×"]
        );
    }

    #[test]
    fn limits_are_shown_in_six_significant_digits() {
        for (value, text) in [
            (-0.017_049_385, "-0.0170494"),
            (123_456.7, "123457"),
            (0.1 + 0.2, "0.3"),
            (0.0, "0"),
        ] {
            assert_eq!(rounded(value).to_string(), text);
        }
    }
}
