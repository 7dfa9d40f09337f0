//! Numbers in sentences: three digits, as a mechanic writes them, powers of ten only where
//! zeros would have to be counted.

/// A length, a share or a force in words.
pub(super) fn digits(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || !(1e-3..1e5).contains(&size) {
        return if size == 0.0 {
            "0".to_owned()
        } else {
            format!("{value:.2e}")
        };
    }
    let places = (2 - size.log10().floor() as i32).max(0);
    format!("{value:.*}", places as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_digits_are_told_and_powers_of_ten_where_zeros_would_be_counted() {
        let told = [2.0, 0.1105, 0.002, 1234.4, 0.0].map(digits);
        assert_eq!(told, ["2.00", "0.111", "0.00200", "1234", "0"]);
        assert_eq!([3.2e-7, -2e6].map(digits), ["3.20e-7", "-2.00e6"]);
    }
}
