//! Numbers as base64, in 16 bits.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde::Serialize;

/// Rows of numbers: 0 stands for the lowest of a column, 65535 for that and `span`.
#[derive(Debug, Serialize)]
pub(super) struct Coded {
    /// Of each column.
    low: Vec<f64>,
    /// Of all columns, so that a picture keeps its angles.
    span: f64,
    /// Little-endian 16-bit numbers.
    data: String,
}

/// Vectors.
pub(super) fn vectors(rows: &[[f64; 3]]) -> Coded {
    coded(rows)
}

/// Numbers.
pub(super) fn scalars(values: &[f64]) -> Coded {
    coded(values.as_chunks::<1>().0)
}

/// Numbers that are not finite become the lowest of their column.
fn coded<const N: usize>(rows: &[[f64; N]]) -> Coded {
    let mut ranges = [(f64::INFINITY, f64::NEG_INFINITY); N];
    for (range, value) in rows.iter().flat_map(ranges_of) {
        if let Some((low, high)) = ranges.get_mut(range) {
            *low = low.min(value);
            *high = high.max(value);
        }
    }
    let spans = ranges.iter().map(|(low, high)| high - low);
    let span = spans.filter(|span| span.is_finite()).fold(0.0, f64::max);
    let lows = ranges.map(|(low, _)| if low.is_finite() { low } else { 0.0 });
    let scale = if span > 0.0 {
        f64::from(u16::MAX) / span
    } else {
        0.0
    };
    let values = rows.iter().flat_map(|row| row.iter().zip(lows));
    // A cast of what is not a number gives zero.
    let numbers = values.map(|(value, low)| ((value - low) * scale).round() as u16);
    Coded {
        low: lows.to_vec(),
        span,
        data: STANDARD.encode(numbers.flat_map(u16::to_le_bytes).collect::<Vec<u8>>()),
    }
}

/// The finite values of a row with their columns.
fn ranges_of<const N: usize>(row: &[f64; N]) -> impl Iterator<Item = (usize, f64)> {
    let values = row.iter().copied().enumerate();
    values.filter(|(_, value)| value.is_finite())
}

/// Indices below 65536.
pub(super) fn indices(values: &[u32]) -> String {
    let bytes = values
        .iter()
        .flat_map(|value| (*value as u16).to_le_bytes());
    STANDARD.encode(bytes.collect::<Vec<u8>>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_is_cut_into_65535_parts() {
        let coded = scalars(&[-1.0, 1.0, f64::NAN, 0.0]);
        assert_eq!((coded.low, coded.span), (vec![-1.0], 2.0));
        let bytes = STANDARD.decode(&coded.data).unwrap();
        assert_eq!(bytes, [0, 0, 255, 255, 0, 0, 0, 128]);
        let constant = scalars(&[3.0, 3.0]);
        assert_eq!(constant.data, STANDARD.encode([0; 4]));
        assert_eq!(scalars(&[]).low, [0.0]);
    }

    #[test]
    fn columns_far_from_the_origin_keep_their_digits() {
        let coded = vectors(&[[1000.0, 0.0, 5.0], [1001.0, 2.0, 5.0]]);
        assert_eq!((coded.low, coded.span), (vec![1000.0, 0.0, 5.0], 2.0));
        let bytes = STANDARD.decode(&coded.data).unwrap();
        assert_eq!(bytes, [0, 0, 0, 0, 0, 0, 0, 128, 255, 255, 0, 0]);
    }
}
