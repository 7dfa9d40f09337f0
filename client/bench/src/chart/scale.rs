//! From values to places: linear and logarithmic scales and their ticks.

/// How values spread over an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// From zero.
    Linear,
    /// Equal factors are equally long; values must be above zero.
    Logarithmic,
}

/// A mark on an axis; without a label a minor one.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tick {
    pub(super) value: f64,
    pub(super) label: Option<String>,
}

/// A scale over a range of values.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    kind: Kind,
    low: f64,
    high: f64,
}

/// Free space at both ends of a logarithmic axis, in decades.
const MARGIN: f64 = 0.12;
/// The least that a logarithmic axis shows, in decades.
const DECADES: f64 = 1.2;

impl Scale {
    /// A scale that shows all values.
    pub(super) fn new(kind: Kind, values: impl Iterator<Item = f64>) -> Self {
        let usable = |value: &f64| value.is_finite() && (kind == Kind::Linear || *value > 0.0);
        let (low, high) = values
            .filter(usable)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                (low.min(value), high.max(value))
            });
        let (low, high) = match kind {
            _ if low > high => (0.1, 10.0),
            Kind::Linear => (0.0, (high * 1.15).max(1.0)),
            Kind::Logarithmic => widened(low, high),
        };
        Self { kind, low, high }
    }

    /// Place of a value between 0 and 1.
    pub(super) fn fraction(&self, value: f64) -> f64 {
        match self.kind {
            Kind::Linear => (value - self.low) / (self.high - self.low),
            Kind::Logarithmic => (value / self.low).log10() / (self.high / self.low).log10(),
        }
    }

    /// Marks, ascending.
    pub(super) fn ticks(&self) -> Vec<Tick> {
        match self.kind {
            Kind::Linear => self.linear_ticks(),
            Kind::Logarithmic => self.logarithmic_ticks(),
        }
    }

    /// Numbers from here on are written as powers: five digits beside powers
    /// would look smaller than they are.
    fn plain_below(&self) -> f64 {
        if self.high < 2e5 { 99_999.0 } else { 9_999.0 }
    }

    fn linear_ticks(&self) -> Vec<Tick> {
        let rough = (self.high - self.low) / 5.0;
        let unit = 10_f64.powf(rough.log10().floor());
        let steps = [1.0, 2.0, 5.0, 10.0];
        let step = steps
            .into_iter()
            .find(|step| step * unit >= rough)
            .unwrap_or(10.0)
            * unit;
        let count = (self.high / step).floor() as i32;
        let tick = |index| {
            let value = f64::from(index) * step;
            Tick {
                value,
                label: Some(label(value, self.plain_below())),
            }
        };
        (0..=count).map(tick).collect()
    }

    fn logarithmic_ticks(&self) -> Vec<Tick> {
        let decades = (self.high / self.low).log10();
        let labelled: &[i32] = if decades <= 2.7 { &[1, 2, 5] } else { &[1] };
        let every = if decades > 7.0 { 2 } else { 1 };
        let exponents = self.low.log10().floor() as i32..=self.high.log10().ceil() as i32;
        let digits = exponents.flat_map(|exponent| (1..=9).map(move |digit| (exponent, digit)));
        let ticks = digits.map(|(exponent, digit)| {
            let value = f64::from(digit) * 10_f64.powi(exponent);
            let has_label = labelled.contains(&digit) && exponent % every == 0;
            Tick {
                value,
                label: has_label.then(|| label(value, self.plain_below())),
            }
        });
        ticks
            .filter(|tick| (self.low..=self.high).contains(&tick.value))
            .collect()
    }
}

fn widened(low: f64, high: f64) -> (f64, f64) {
    let missing = (DECADES - (high / low).log10()).max(0.0) / 2.0;
    let factor = 10_f64.powf(MARGIN + missing);
    (low / factor, high * factor)
}

/// A tick's number: plain where short, else a digit and a power of ten.
fn label(value: f64, plain_below: f64) -> String {
    if value.abs() < 1e-12 {
        return "0".to_owned();
    }
    if (0.999e-3..plain_below).contains(&value) {
        let decimals = (-value.log10().floor()).max(0.0) as usize;
        return format!("{value:.decimals$}");
    }
    // The next lower power, with room for rounding.
    let exponent = (value.log10() + 1e-9).floor() as i32;
    let digit = (value / 10_f64.powi(exponent)).round();
    let power = format!("10{}", superscript(exponent));
    if digit > 1.5 {
        format!("{digit:.0}·{power}")
    } else {
        power
    }
}

fn superscript(number: i32) -> String {
    let raised = |character| match character {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '4' => '⁴',
        '5' => '⁵',
        '6' => '⁶',
        '7' => '⁷',
        '8' => '⁸',
        '9' => '⁹',
        _ => '⁰',
    };
    number.to_string().chars().map(raised).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(scale: &Scale) -> Vec<String> {
        scale
            .ticks()
            .into_iter()
            .filter_map(|tick| tick.label)
            .collect()
    }

    #[test]
    fn wide_axes_are_marked_by_decades() {
        let scale = Scale::new(Kind::Logarithmic, [2e-5, 3e-2].into_iter());
        assert_eq!(labels(&scale), ["10⁻⁴", "0.001", "0.01"]);
    }

    #[test]
    fn narrow_axes_still_have_several_labels() {
        let scale = Scale::new(Kind::Logarithmic, [100.0, 101.0].into_iter());
        assert!(labels(&scale).contains(&"100".to_owned()));
        assert!(labels(&scale).len() >= 3, "{:?}", labels(&scale));
    }

    #[test]
    fn every_value_has_its_place_inside() {
        for kind in [Kind::Linear, Kind::Logarithmic] {
            let values = [0.004, 17.0, 2000.0];
            let scale = Scale::new(kind, values.into_iter());
            for value in values {
                assert!((0.0..=1.0).contains(&scale.fraction(value)));
            }
        }
    }

    #[test]
    fn linear_axes_begin_at_zero() {
        let scale = Scale::new(Kind::Linear, [31.0, 26.0].into_iter());
        assert_eq!(labels(&scale), ["0", "10", "20", "30"]);
    }

    #[test]
    fn nothing_to_show_is_a_scale_too() {
        let scale = Scale::new(Kind::Logarithmic, [0.0, f64::NAN].into_iter());
        assert!(!scale.ticks().is_empty());
    }
}
