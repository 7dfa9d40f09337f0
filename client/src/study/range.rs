//! Numbers of an axis between two ends, evenly or by a constant factor.

use std::str::FromStr;

use toml::Value;

/// How the numbers lie between the ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Spacing {
    /// By a constant difference.
    Linear,
    /// By a constant factor.
    Logarithmic,
}

/// Two ends, and what lies between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Range {
    from: f64,
    to: f64,
    spacing: Spacing,
    /// Both ends are integers of the file.
    whole: bool,
}

impl FromStr for Spacing {
    type Err = String;

    fn from_str(word: &str) -> Result<Self, String> {
        match word {
            "linear" => Ok(Self::Linear),
            "logarithmic" => Ok(Self::Logarithmic),
            other => Err(format!(
                "\"{other}\" is not known; known are linear, logarithmic"
            )),
        }
    }
}

impl Range {
    /// A range between two values of a file.
    ///
    /// # Errors
    /// Which key is wrong, and why.
    pub(crate) fn new(
        from: &Value,
        to: &Value,
        spacing: Spacing,
    ) -> Result<Self, (&'static str, String)> {
        let ends = (number(from, "from")?, number(to, "to")?);
        let whole = from.is_integer() && to.is_integer() && spacing == Spacing::Linear;
        let (from, to) = ends;
        if !(to - from).is_finite() {
            return Err(("to", format!("{from} to {to} is too far")));
        }
        // A factor leads from one end to the other on one side of zero only.
        if spacing == Spacing::Logarithmic && !(to / from).is_normal() || is_split(spacing, ends) {
            let message = format!("logarithmic between {from} and {to}: both must have one sign");
            return Err(("spacing", message));
        }
        Ok(Self {
            from,
            to,
            spacing,
            whole,
        })
    }

    /// The number at a fraction of the way, from 0 to 1.
    pub(crate) fn at(&self, fraction: f64) -> f64 {
        match self.spacing {
            Spacing::Linear => self.from + (self.to - self.from) * fraction,
            Spacing::Logarithmic => self.from * (self.to / self.from).powf(fraction),
        }
    }

    /// The value of one of `count` numbers, ends included; integers stay some.
    pub(crate) fn step(&self, index: u64, count: u64) -> Value {
        let last = count.saturating_sub(1);
        let value = match index {
            0 => self.from,
            index if index >= last => self.to,
            index => self.between(index as f64, last as f64),
        };
        let is_whole = value.fract().abs() <= 0.0 && value.abs() < 9.0e15;
        if self.whole && is_whole {
            Value::Integer(value as i64)
        } else {
            Value::Float(value)
        }
    }

    /// A mean of the ends where that is finite, so that tenths are tenths.
    fn between(&self, index: f64, last: f64) -> f64 {
        let sum = self.from * (last - index) + self.to * index;
        match self.spacing {
            Spacing::Linear if sum.is_finite() => sum / last,
            Spacing::Linear | Spacing::Logarithmic => self.at(index / last),
        }
    }
}

fn is_split(spacing: Spacing, (from, to): (f64, f64)) -> bool {
    spacing == Spacing::Logarithmic && (from > 0.0) != (to > 0.0)
}

fn number(value: &Value, key: &'static str) -> Result<f64, (&'static str, String)> {
    let number = value.as_float();
    let number = number.or_else(|| value.as_integer().map(|integer| integer as f64));
    let finite = number.filter(|number| number.is_finite());
    finite.ok_or_else(|| (key, format!("a finite number is expected, found {value}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steps(from: impl Into<Value>, to: impl Into<Value>, spacing: Spacing) -> Vec<String> {
        let range = Range::new(&from.into(), &to.into(), spacing).unwrap();
        (0..5)
            .map(|index| range.step(index, 5).to_string())
            .collect()
    }

    #[test]
    fn numbers_lie_evenly_or_by_a_factor_with_both_ends() {
        assert_eq!(
            steps(0.1, 0.5, Spacing::Linear),
            ["0.1", "0.2", "0.3", "0.4", "0.5"]
        );
        assert_eq!(steps(0, 8, Spacing::Linear), ["0", "2", "4", "6", "8"]);
        assert_eq!(steps(0, 2, Spacing::Linear), ["0", "0.5", "1", "1.5", "2"]);
        assert_eq!(
            steps(1.0, 1e4, Spacing::Logarithmic),
            ["1.0", "10.0", "100.0", "1000.0", "10000.0"]
        );
    }

    #[test]
    fn ends_that_give_no_numbers_are_refused_by_key() {
        let refused = |from: f64, to: f64, spacing| {
            Range::new(&from.into(), &to.into(), spacing).unwrap_err().0
        };
        assert_eq!(refused(f64::NAN, 1.0, Spacing::Linear), "from");
        assert_eq!(refused(-f64::MAX, f64::MAX, Spacing::Linear), "to");
        for (from, to) in [(-1.0, 1.0), (0.0, 1.0), (1.0, 0.0)] {
            assert_eq!(refused(from, to, Spacing::Logarithmic), "spacing");
        }
    }
}
