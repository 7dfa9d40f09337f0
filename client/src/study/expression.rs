//! Expressions of columns: `force / {gap of the lid}`, `sqrt(force.x^2 + force.z^2)`.
//!
//! A sum has products, a product has powers with their signs, a power has values: numbers, `pi`,
//! names of columns (in braces where they are no words with dots), functions, sums in parentheses.
//! As people write: -2^2 is -4, 2^3^2 is 512, 1 / 2 is 0.5. Read once into the order in which a
//! stack evaluates them; a value costs as many steps as there are values and operators.

/// Bytes of an expression.
const LONGEST: usize = 1000;
/// Parentheses and signs within each other.
const DEEPEST: usize = 50;

/// One step of an evaluation, on a stack.
#[derive(Clone, Copy, Debug)]
enum Step {
    Number(f64),
    /// By its position among the columns.
    Column(usize),
    One(fn(f64) -> f64),
    Two(fn(f64, f64) -> f64),
}

/// An expression whose columns are known.
#[derive(Clone, Debug)]
pub(crate) struct Expression {
    steps: Vec<Step>,
}

impl Expression {
    /// Reads an expression of the columns of these names.
    ///
    /// # Errors
    /// What is wrong, for people.
    pub(crate) fn read(text: &str, columns: &[&str]) -> Result<Self, String> {
        if text.len() > LONGEST {
            return Err(format!("is longer than {LONGEST} bytes"));
        }
        let mut reader = Reader {
            rest: text,
            columns,
            steps: Vec::new(),
            depth: 0,
        };
        reader.sum()?;
        if reader.skip().is_empty() {
            Ok(Self {
                steps: reader.steps,
            })
        } else {
            Err(reader.unexpected("an operator"))
        }
    }

    /// Positions of the columns that it names.
    pub(crate) fn columns(&self) -> impl Iterator<Item = usize> {
        let column = |step: &Step| match step {
            Step::Column(at) => Some(*at),
            Step::Number(_) | Step::One(_) | Step::Two(_) => None,
        };
        self.steps.iter().filter_map(column)
    }

    /// Its value; none where a column has none, or where it is no finite number.
    pub(crate) fn value(&self, columns: &[Option<f64>]) -> Option<f64> {
        let mut stack = Vec::new();
        for step in &self.steps {
            let value = match step {
                Step::Number(number) => *number,
                Step::Column(at) => columns.get(*at).copied()??,
                Step::One(function) => function(stack.pop()?),
                Step::Two(function) => {
                    let second = stack.pop()?;
                    function(stack.pop()?, second)
                }
            };
            stack.push(value);
        }
        stack.pop().filter(|value| value.is_finite())
    }
}

struct Reader<'a> {
    rest: &'a str,
    columns: &'a [&'a str],
    steps: Vec<Step>,
    depth: usize,
}

impl<'a> Reader<'a> {
    fn skip(&mut self) -> &'a str {
        self.rest = self.rest.trim_start();
        self.rest
    }

    /// Takes a sign if it is the next one.
    fn takes(&mut self, sign: char) -> bool {
        let rest = self.skip().strip_prefix(sign);
        self.rest = rest.unwrap_or(self.rest);
        rest.is_some()
    }

    fn unexpected(&mut self, wanted: &str) -> String {
        match self.skip() {
            "" => format!("{wanted} is expected at the end"),
            rest => {
                let short: String = rest.chars().take(20).collect();
                format!("{wanted} is expected before \"{short}\"")
            }
        }
    }

    fn sum(&mut self) -> Result<(), String> {
        self.product()?;
        loop {
            let function: fn(f64, f64) -> f64 = if self.takes('+') {
                |one, other| one + other
            } else if self.takes('-') {
                |one, other| one - other
            } else {
                return Ok(());
            };
            self.product()?;
            self.steps.push(Step::Two(function));
        }
    }

    fn product(&mut self) -> Result<(), String> {
        self.signed()?;
        loop {
            let function: fn(f64, f64) -> f64 = if self.takes('*') {
                |one, other| one * other
            } else if self.takes('/') {
                |one, other| one / other
            } else {
                return Ok(());
            };
            self.signed()?;
            self.steps.push(Step::Two(function));
        }
    }

    fn signed(&mut self) -> Result<(), String> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(format!("has more than {DEEPEST} levels"));
        }
        if self.takes('-') {
            self.signed()?;
            self.steps.push(Step::One(|value| -value));
        } else {
            self.power()?;
        }
        self.depth -= 1;
        Ok(())
    }

    fn power(&mut self) -> Result<(), String> {
        self.value()?;
        if self.takes('^') {
            self.signed()?;
            self.steps.push(Step::Two(f64::powf));
        }
        Ok(())
    }

    fn value(&mut self) -> Result<(), String> {
        if self.takes('(') {
            self.sum()?;
            return self.close();
        }
        if self.takes('{') {
            let Some((name, rest)) = self.rest.split_once('}') else {
                return Err("\"{\" has no \"}\"".to_owned());
            };
            self.rest = rest;
            return self.column(name.trim());
        }
        let rest = self.skip();
        match rest.chars().next() {
            Some(first) if first.is_ascii_digit() || first == '.' => self.number(),
            Some(first) if first.is_alphabetic() || first == '_' => self.named(),
            Some(_) | None => Err(self.unexpected("a number, a column or a function")),
        }
    }

    fn close(&mut self) -> Result<(), String> {
        if self.takes(')') {
            Ok(())
        } else {
            Err(self.unexpected("\")\""))
        }
    }

    /// The front of the rest that is of such characters, which is taken.
    fn front(&mut self, is_part: impl Fn(char) -> bool) -> &'a str {
        let end = self.rest.find(|one| !is_part(one));
        let (front, rest) = self.rest.split_at(end.unwrap_or(self.rest.len()));
        self.rest = rest;
        front
    }

    fn number(&mut self) -> Result<(), String> {
        let whole = self.rest;
        self.front(|one| one.is_ascii_digit() || one == '.');
        let exponent_part = self.rest.strip_prefix(['e', 'E']);
        if let Some(exponent) = exponent_part {
            self.rest = exponent.strip_prefix(['+', '-']).unwrap_or(exponent);
            self.front(|one| one.is_ascii_digit());
        }
        let text = whole.strip_suffix(self.rest).unwrap_or(whole);
        let number = text
            .parse()
            .map_err(|_| format!("\"{text}\" is no number"))?;
        self.steps.push(Step::Number(number));
        Ok(())
    }

    fn named(&mut self) -> Result<(), String> {
        let name = self.front(|one| one.is_alphanumeric() || one == '_' || one == '.');
        if self.takes('(') {
            return self.call(name);
        }
        match name {
            "pi" if !self.columns.contains(&name) => {
                self.steps.push(Step::Number(std::f64::consts::PI));
                Ok(())
            }
            name => self.column(name),
        }
    }

    fn column(&mut self, name: &str) -> Result<(), String> {
        let at = self.columns.iter().position(|one| *one == name);
        let at = at.ok_or_else(|| {
            let known = self.columns.join(", ");
            format!("there is no column \"{name}\" before it; there are {known}")
        })?;
        self.steps.push(Step::Column(at));
        Ok(())
    }

    fn call(&mut self, name: &str) -> Result<(), String> {
        let step = function(name)?;
        self.sum()?;
        if let Step::Two(_) = step {
            if !self.takes(',') {
                return Err(self.unexpected("\",\""));
            }
            self.sum()?;
        }
        self.steps.push(step);
        self.close()
    }
}

fn function(name: &str) -> Result<Step, String> {
    Ok(match name {
        "abs" => Step::One(f64::abs),
        "sqrt" => Step::One(f64::sqrt),
        "exp" => Step::One(f64::exp),
        "ln" => Step::One(f64::ln),
        "sin" => Step::One(f64::sin),
        "cos" => Step::One(f64::cos),
        "tan" => Step::One(f64::tan),
        "atan2" => Step::Two(f64::atan2),
        "min" => Step::Two(f64::min),
        "max" => Step::Two(f64::max),
        other => {
            return Err(format!(
                "there is no function \"{other}\"; there are abs, sqrt, exp, ln, sin, cos, tan, \
                 atan2, min, max"
            ));
        }
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const COLUMNS: [&str; 3] = ["force.z", "travel", "gap of the lid"];

    fn value(text: &str) -> Result<Option<f64>, String> {
        let expression = Expression::read(text, &COLUMNS)?;
        Ok(expression.value(&[Some(6.0), Some(-2.0), None]))
    }

    #[test]
    fn expressions_are_worth_what_people_mean_by_them() {
        for (text, expected) in [
            ("force.z / travel", -3.0),
            ("{force.z}/{ travel }", -3.0),
            ("-2^2", -4.0),
            ("2^-1", 0.5),
            ("2^3^2", 512.0),
            ("1 - 2 - 3", -4.0),
            ("8 / 2 / 2", 2.0),
            ("1 + 2 * 3", 7.0),
            ("(1 + 2) * 3", 9.0),
            ("1e-3 * 2.5E+2", 0.25),
            ("sqrt(force.z^2 + 8^2)", 10.0),
            ("max(min(1, 2), -travel)", 2.0),
            ("--3", 3.0),
            ("2*-3", -6.0),
            ("cos(2 * pi)", 1.0),
        ] {
            let found = value(text).unwrap().unwrap();
            assert!((found - expected).abs() < 1e-12, "{text}: {found}");
        }
        for without in ["1 / 0", "sqrt(travel)", "1 + {gap of the lid}"] {
            assert_eq!(value(without), Ok(None), "{without}");
        }
    }

    #[test]
    fn what_cannot_be_read_says_why() {
        for (text, said) in [
            ("", "is expected at the end"),
            ("force.z /", "is expected at the end"),
            (
                "force",
                "no column \"force\" before it; there are force.z, travel",
            ),
            (
                "force.z travel",
                "an operator is expected before \"travel\"",
            ),
            ("(1", "\")\" is expected"),
            ("1)", "before \")\""),
            ("max(1)", "\",\" is expected"),
            ("log(1)", "no function \"log\""),
            ("{travel", "no \"}\""),
            ("1.2.3", "is no number"),
            ("2e", "is no number"),
        ] {
            let fault = value(text).unwrap_err();
            assert!(fault.contains(said), "{text}: {fault}");
        }
        assert!(value(&"(".repeat(900)).unwrap_err().contains("levels"));
        assert!(value(&"1+".repeat(900)).unwrap_err().contains("bytes"));
    }

    proptest! {
        #[test]
        fn whatever_is_written_is_read_or_refused(text in "[-+*/^(){},. a-z0-9eE]{0,60}|.{0,40}") {
            let _any = value(&text);
        }
    }
}
