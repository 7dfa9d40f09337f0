//! Laws of materials by the numbers of their data lines.
//!
//! ```text
//! U = sum C_ij (I1 - 3)^i (I2 - 3)^j + (J - 1)^2 / D1     K = 2 / D1, D1 = 0 incompressible
//! OGDEN: 2 mu_i / alpha_i^2 (..)  =  m_i / alpha_i (..)   m_i = 2 mu_i / alpha_i of the scene
//! HYPERFOAM: mu_1, alpha_1, mu_2, alpha_2, .., nu_1, nu_2, ..: the numbers of the scene
//! ```
//!
//! Arruda-Boyce and van der Waals have 1 / D ((J^2 - 1) / 2 - ln J) for the volume, which is K / 2 (J - 1)^2 at small
//! changes of it, K = 2 / D.

use super::super::cards::Keyword;
use super::Law;

/// Forms with one order only: words and coefficients before D1.
const FORMS: [(&str, &str, &[&str]); 4] = [
    ("MOONEY-RIVLIN", "mooney-rivlin", &["c10", "c01"]),
    ("YEOH", "yeoh", &["c10", "c20", "c30"]),
    ("ARRUDA-BOYCE", "arruda-boyce", &["mu", "locking_stretch"]),
    (
        "VAN DER WAALS",
        "van-der-waals",
        &["shear_modulus", "locking_stretch", "a", "beta"],
    ),
];
/// What is told of a law that comes with test data.
const WITH_TESTS: &str = "test data are not taken over: write them into a table, any constants \
    into the scene, and let `signorini fit SCENE DATA.csv` find them";
/// Coefficients of polynomials, each order those before it and its own.
const POLYNOMIAL: [&str; 9] = [
    "c10", "c01", "c20", "c11", "c02", "c30", "c21", "c12", "c03",
];
const REDUCED: [&str; 3] = ["c10", "c20", "c30"];

/// The law of a keyword with these numbers; why there is none.
pub(super) fn law(keyword: &Keyword, numbers: &[f64]) -> Result<Law, String> {
    if keyword.has("DEPENDENCIES") {
        return Err("dependencies are not taken over".to_owned());
    }
    if keyword.has("TEST DATA INPUT") {
        return Err(WITH_TESTS.to_owned());
    }
    if keyword.name == "ELASTIC" {
        return elastic(keyword, numbers);
    }
    if keyword.name == "HYPERFOAM" {
        return hyperfoam(order(keyword, 6)?, numbers);
    }
    let order = order(keyword, 3)?;
    if keyword.has("NEO HOOKE") {
        let (own, rest) = parted(numbers, 1)?;
        let shear = own.iter().map(|c10| 2.0 * c10).collect();
        return with_volume("neo-hookean", vec![("shear_modulus", shear)], rest);
    }
    if keyword.has("OGDEN") {
        return ogden(order, numbers);
    }
    let named = FORMS.iter().find(|(word, _, _)| keyword.has(word));
    let (model, keys): (&'static str, &[&'static str]) = match named {
        Some(&(_, model, keys)) => (model, keys),
        None if keyword.has("REDUCED POLYNOMIAL") => ("polynomial", &REDUCED),
        None if keyword.has("POLYNOMIAL") => ("polynomial", &POLYNOMIAL),
        None => return Err("a form that the scene does not have".to_owned()),
    };
    let count = match (named, keyword.has("REDUCED POLYNOMIAL")) {
        (Some(_), _) => keys.len(),
        (None, true) => order,
        (None, false) => order * (order + 3) / 2,
    };
    let (own, rest) = parted(numbers, count)?;
    let own = keys.iter().copied().zip(own.iter().map(|one| vec![*one]));
    with_volume(model, own.collect(), rest)
}

/// The order of a law, one unless it is told.
fn order(keyword: &Keyword, most: usize) -> Result<usize, String> {
    let order = keyword.value("N").map_or(Ok(1), str::parse::<usize>);
    let order = order.ok().filter(|order| (1..=most).contains(order));
    order.ok_or_else(|| format!("orders are 1 to {most}"))
}

fn elastic(keyword: &Keyword, numbers: &[f64]) -> Result<Law, String> {
    let kind = keyword.value("TYPE").unwrap_or("ISOTROPIC");
    if !(kind.eq_ignore_ascii_case("ISOTROPIC") || kind.eq_ignore_ascii_case("ISO")) {
        return Err("only isotropic elasticity is taken over".to_owned());
    }
    match *numbers {
        [young] => Ok(linear(young, 0.0)),
        [young, poisson] => Ok(linear(young, poisson)),
        _ => Err("it depends on something, or has no number".to_owned()),
    }
}

fn linear(young: f64, poisson: f64) -> Law {
    Law {
        model: "linear-elastic",
        numbers: vec![
            ("young_modulus", vec![young]),
            ("poisson_ratio", vec![poisson]),
        ],
    }
}

fn ogden(order: usize, numbers: &[f64]) -> Result<Law, String> {
    let (own, rest) = parted(numbers, 2 * order)?;
    let (pairs, _) = own.as_chunks::<2>();
    let mu = pairs.iter().map(|[mu, alpha]| 2.0 * mu / alpha);
    let alpha = pairs.iter().map(|[_, alpha]| *alpha);
    let own = vec![("mu", mu.collect()), ("alpha", alpha.collect())];
    with_volume("ogden", own, rest)
}

fn hyperfoam(order: usize, numbers: &[f64]) -> Result<Law, String> {
    let (own, rest) = parted(numbers, 2 * order)?;
    let (pairs, _) = own.as_chunks::<2>();
    let mu = pairs.iter().map(|[mu, _]| *mu);
    let alpha = pairs.iter().map(|[_, alpha]| *alpha);
    // What a deck leaves out is zero.
    let count = rest.len().min(order);
    let (ratios, further) = parted(rest, count)?;
    if further.iter().any(|one| *one != 0.0) {
        return Err("a dependence on temperature is not taken over".to_owned());
    }
    let mut nu = ratios.to_vec();
    nu.resize(order, 0.0);
    Ok(Law {
        model: "hyperfoam",
        numbers: vec![("mu", mu.collect()), ("alpha", alpha.collect()), ("nu", nu)],
    })
}

/// The first numbers, and what is left.
fn parted(numbers: &[f64], count: usize) -> Result<(&[f64], &[f64]), String> {
    let parted = numbers.split_at_checked(count);
    parted.ok_or_else(|| format!("{count} numbers are expected"))
}

/// Adds the bulk modulus of D1, the first of what is left.
fn with_volume(
    model: &'static str,
    mut numbers: Vec<(&'static str, Vec<f64>)>,
    rest: &[f64],
) -> Result<Law, String> {
    let (d1, further) = rest.split_first().unwrap_or((&0.0, &[]));
    if further.iter().any(|one| *one != 0.0) {
        return Err("D2, D3 or a dependence on temperature is not taken over".to_owned());
    }
    if *d1 < 0.0 {
        return Err("D1 is below zero".to_owned());
    }
    if *d1 > 0.0 {
        numbers.push(("bulk_modulus", vec![2.0 / d1]));
    }
    Ok(Law { model, numbers })
}
