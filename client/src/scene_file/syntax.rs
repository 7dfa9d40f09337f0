//! Texts that are not TOML: what they may have been meant to be.

/// The message of the reader, with a way on where the mistake is a known one.
pub(super) fn explain(text: &str, error: &toml::de::Error) -> String {
    let mut message = error.to_string().trim_end().to_owned();
    let start = error.span().map_or(0, |span| span.start);
    if text.trim_start().starts_with('{') {
        message.push_str(
            "\nit looks like JSON: a scene is TOML, such as mesh = \"ring.msh\" \
             (`signorini init ring.msh` writes one)",
        );
    } else if has_decimal_comma(line_at(text, start)) {
        message.push_str("\nnumbers have a decimal point: 0.5, not 0,5");
    }
    message
}

/// The line around a byte; empty where the text has none.
fn line_at(text: &str, byte: usize) -> &str {
    let before = text.get(..byte).unwrap_or(text);
    let start = before.rfind('\n').map_or(0, |newline| newline + 1);
    let rest = text.get(start..).unwrap_or_default();
    rest.lines().next().unwrap_or_default()
}

/// Whether a value of a line is a single number with a comma in it.
fn has_decimal_comma(line: &str) -> bool {
    line.split('=').skip(1).any(is_decimal_comma)
}

fn is_decimal_comma(value: &str) -> bool {
    let value = value.trim().trim_start_matches(['-', '+']);
    let (whole, rest) = value.split_once(',').unwrap_or((value, ""));
    let is_digits = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    is_digits(whole) && rest.bytes().next().is_some_and(|b| b.is_ascii_digit())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(text: &str) -> String {
        explain(text, &text.parse::<toml::Table>().unwrap_err())
    }

    #[test]
    fn json_and_decimal_commas_are_recognised() {
        assert!(told("{\"mesh\": \"a.msh\"}").contains("a scene is TOML"));
        assert!(told("mesh = \"ä.msh\"\nradius = 0,5\n").contains("0.5, not 0,5"));
        let inline = "shape = { centre = [0, 0, 1], radius = 1,0 }";
        assert!(told(inline).contains("0.5, not 0,5"));
        for other in [
            "point = [0,5",
            "mesh = ",
            "radius = 1 mm",
            "shape = { a = 1, b }",
        ] {
            let message = told(other);
            assert!(!message.contains("not 0,5"), "{message}");
        }
    }
}
