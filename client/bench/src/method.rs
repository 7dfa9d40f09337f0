//! The axis of methods: keys of `[solver]`, or of the whole scene.

use std::fmt;
use std::str::FromStr;

/// Settings under comparison: keys of `[solver]` such as `p1_solver=cholesky`,
/// or with a dot of the scene, such as `material.body.poisson_ratio=0.3`; none of
/// them is `auto`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Method {
    keys: Vec<(String, String)>,
}

impl Method {
    /// Changes of the scene, as `--set` takes them.
    pub(crate) fn overrides(&self) -> impl Iterator<Item = String> {
        self.keys.iter().map(|(key, value)| {
            if key.contains('.') {
                format!("{key}={value}")
            } else {
                format!("solver.{key}={value}")
            }
        })
    }
}

impl fmt::Display for Method {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.keys.is_empty() {
            return out.write_str("auto");
        }
        let keys: Vec<_> = self
            .keys
            .iter()
            .map(|(key, value)| format!("{key}={value}"))
            .collect();
        out.write_str(&keys.join(" "))
    }
}

impl FromStr for Method {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "auto" {
            return Ok(Self { keys: Vec::new() });
        }
        let keys = text.split(',').map(|part| match part.split_once('=') {
            Some((key, value)) if !key.is_empty() && !value.is_empty() => {
                Ok((key.to_owned(), value.to_owned()))
            }
            _ => Err("auto, or KEY=VALUE of [solver] (of the scene where KEY has a dot), several with commas".to_owned()),
        });
        let keys = keys.collect::<Result<_, String>>()?;
        Ok(Self { keys })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn methods_become_changes_of_the_scene() {
        let method: Method = "p1_solver=amg,saddle=minres".parse().unwrap();
        assert_eq!(method.to_string(), "p1_solver=amg saddle=minres");
        let overrides: Vec<_> = method.overrides().collect();
        assert_eq!(overrides, ["solver.p1_solver=amg", "solver.saddle=minres"]);
        let poisson: Method = "material.body.poisson_ratio=0.3".parse().unwrap();
        let overrides: Vec<_> = poisson.overrides().collect();
        assert_eq!(overrides, ["material.body.poisson_ratio=0.3"]);
        let auto: Method = "auto".parse().unwrap();
        assert_eq!(
            (auto.to_string().as_str(), auto.overrides().count()),
            ("auto", 0)
        );
        assert!("p1_solver".parse::<Method>().is_err());
    }
}
