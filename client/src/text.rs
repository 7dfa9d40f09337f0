//! Writes to stdout and stderr, and numbers for people.

use std::io::{ErrorKind, Write};

use crate::exit::{Exit, Failure};

/// Writes to stdout. A reader that has gone away ends the output, not the work.
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    let mut stdout = std::io::stdout().lock();
    match stdout
        .write_all(text.as_bytes())
        .and_then(|()| stdout.flush())
    {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::new(Exit::Usage, format!("stdout: {error}")))
        }
        _ => Ok(()),
    }
}

/// Writes to stderr, where failing can be told to nobody.
pub(crate) fn note(text: &str) {
    let _closed = std::io::stderr().write_all(text.as_bytes());
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
    match fixed.contains('.') {
        true => fixed.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => fixed,
    }
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
    fn bytes_choose_their_unit() {
        assert_eq!(
            [bytes(12), bytes(2048), bytes(1_500_000)],
            ["12 B", "2 KiB", "1.4 MiB"]
        );
        assert_eq!(bytes(3 << 30), "3 GiB");
    }
}
