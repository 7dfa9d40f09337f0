//! Single fields of data lines: whole numbers, coordinates, faces.

use super::cards::{Cards, Data, Keyword, excerpt};
use super::error::{InpError, InpFault};
use super::frame::Frame;
use super::sets::Run;

/// The fault of a keyword that names another file.
pub(super) fn include(keyword: &Keyword) -> InpError {
    let file = keyword.value("INPUT").unwrap_or_default().to_owned();
    keyword.error(InpFault::Include(file))
}

fn unexpected(keyword: &Keyword, line: usize, expected: &'static str, field: &[u8]) -> InpError {
    let found = excerpt(field);
    keyword.error_at(line, InpFault::Unexpected { expected, found })
}

/// A whole number; `expected` says of what.
pub(super) fn natural(
    keyword: &Keyword,
    line: usize,
    field: &[u8],
    expected: &'static str,
) -> Result<u64, InpError> {
    let number = std::str::from_utf8(field)
        .ok()
        .and_then(|field| field.parse().ok());
    number.ok_or_else(|| unexpected(keyword, line, expected, field))
}

/// A number, with the exponents of Fortran too; nothing is zero.
pub(super) fn real(keyword: &Keyword, line: usize, field: &[u8]) -> Result<f64, InpError> {
    if field.is_empty() {
        return Ok(0.0);
    }
    let wrong = || unexpected(keyword, line, "a coordinate", field);
    let field = std::str::from_utf8(field).map_err(|_| wrong())?;
    let parsed = field
        .parse()
        .or_else(|_| field.replace(['d', 'D'], "e").parse());
    parsed.map_err(|_| wrong())
}

/// A number of a law, a condition or a profile, which the scene is to have.
pub(super) fn finite(keyword: &Keyword, line: usize, field: &[u8]) -> Result<f64, InpError> {
    let number = real(keyword, line, field).ok().filter(|x| x.is_finite());
    number.ok_or_else(|| unexpected(keyword, line, "a finite number", field))
}

/// Six numbers of a data line, three of which may be left out.
pub(super) fn points(keyword: &Keyword, data: &Data<'_>) -> Result<[[f64; 3]; 2], InpError> {
    let mut points = [[0.0; 3]; 2];
    let slots = points.as_flattened_mut().iter_mut();
    for (slot, field) in slots.zip(&data.fields) {
        *slot = real(keyword, data.line, field)?;
    }
    Ok(points)
}

/// Where an instance is: its translation, then its rotation.
pub(super) fn placement(cards: &mut Cards<'_>, keyword: &Keyword) -> Result<Frame, InpError> {
    let Some(data) = cards.data() else {
        return Ok(Frame::default());
    };
    let [by, _] = points(keyword, &data)?;
    let frame = Frame::at(by);
    let Some(data) = cards.data() else {
        return Ok(frame);
    };
    let [a, b] = points(keyword, &data)?;
    let angle = data.fields.get(6).copied().unwrap_or_default();
    let angle = real(keyword, data.line, angle)?;
    let turned = if angle == 0.0 {
        Some(frame)
    } else {
        frame.turned(a, b, angle)
    };
    turned.ok_or_else(|| {
        let what = "an axis of rotation between two points that are one".to_owned();
        keyword.error_at(data.line, InpFault::Unsupported(what))
    })
}

/// First, last and step of a line of `GENERATE`; a step below zero counts down.
pub(super) fn run(keyword: &Keyword, data: &Data<'_>) -> Result<Run, InpError> {
    let number = |at: usize| {
        let field = data.fields.get(at).copied().unwrap_or_default();
        natural(keyword, data.line, field, "a number of the set")
    };
    let (first, last) = (number(0)?, number(1)?);
    let field = data.fields.get(2).copied().unwrap_or(b"1");
    let (size, counts_down) = match field.strip_prefix(b"-") {
        Some(size) => (size, true),
        None => (field, false),
    };
    let step = natural(keyword, data.line, size, "a step of the set")?.max(1);
    if !counts_down {
        return Ok(Run { first, last, step });
    }
    // From the last number that is reached up to the first one.
    let below = first.saturating_sub(last) / step * step;
    let (low, high) = if last > first {
        (first, 0)
    } else {
        (first - below, first)
    };
    Ok(Run {
        first: low,
        last: high,
        step,
    })
}

/// The number of a face by its name.
pub(super) fn face_number(keyword: &Keyword, line: usize, name: &str) -> Result<usize, InpError> {
    let number = name
        .strip_prefix('S')
        .and_then(|number| number.parse().ok());
    number.ok_or_else(|| unexpected(keyword, line, "a face (S1 to S6)", name.as_bytes()))
}
