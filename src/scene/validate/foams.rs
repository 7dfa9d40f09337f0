//! Foams: parameters, and the moduli at rest that the solver is told.
//!
//! The shear modulus at rest is sum mu, the bulk modulus sum 2 mu (1/3 + beta) with
//! beta = nu / (1 - 2 nu). The pressure carries a part of the latter, displacements the rest, as
//! those of a linear body beside a mixed one do.

use super::{Faults, ResolvedMaterial};
use crate::material::{FoamTerm, Hyperfoam, LinearElastic, Rubber};

/// Terms of a hyperfoam.
const MOST_TERMS: usize = 6;

/// The material of a foam.
pub(super) fn resolve(
    law: Hyperfoam,
    bulk_modulus: Option<f64>,
    path: &str,
    faults: &mut Faults,
) -> ResolvedMaterial {
    if bulk_modulus.is_some() {
        let message = "a foam resists changes of volume by its own law: leave it out";
        faults.add(format!("{path}.bulk_modulus"), message);
    }
    let (shear_modulus, bulk) = (law.shear_modulus(), law.bulk_modulus());
    let carried = law.carried();
    ResolvedMaterial {
        law: LinearElastic {
            shear_modulus,
            inverse_lame: carried.recip(),
            direct_lame: bulk - carried,
        },
        poisson_ratio: law.poisson_ratio(),
        is_flow: false,
        rubber: Some(Rubber::of_foam(law)),
    }
}

/// The law of mu, alpha and nu of each term, checked.
pub(super) fn hyperfoam(
    [mu, alpha, nu]: [&[f64]; 3],
    path: &str,
    faults: &mut Faults,
) -> Hyperfoam {
    let count = mu.len();
    if !(1..=MOST_TERMS).contains(&count) {
        let message = format!("must have 1 to {MOST_TERMS} terms, not {count}");
        faults.add(format!("{path}.mu"), message);
    }
    faults.finite(&format!("{path}.mu"), mu);
    exponents(alpha, count, path, faults);
    let is_possible = ratios(nu, count, path, faults);
    let ratio = |place: usize| nu.get(place).or(nu.first());
    let terms = mu.iter().zip(alpha).zip((0..).map(ratio));
    let terms = terms.map(|((&modulus, &exponent), ratio)| FoamTerm {
        modulus,
        exponent,
        beta: ratio.map_or(0.0, |nu| nu / (1.0 - 2.0 * nu)),
    });
    let law = Hyperfoam::new(terms.collect());
    faults.at_rest(law.shear_modulus(), "the sum of mu", &format!("{path}.mu"));
    let bulk = law.bulk_modulus();
    if is_possible && law.shear_modulus() > 0.0 && bulk <= 0.0 {
        let message = format!(
            "the bulk modulus at rest, the sum of 2 mu (1/3 + nu / (1 - 2 nu)), must be above zero, not {bulk}"
        );
        faults.add(format!("{path}.nu"), message);
    }
    law
}

fn exponents(alpha: &[f64], count: usize, path: &str, faults: &mut Faults) {
    let path = format!("{path}.alpha");
    if alpha.len() != count {
        let message = format!(
            "must have {count} exponents as `mu` has, not {}",
            alpha.len()
        );
        faults.add(&path, message);
    }
    faults.finite(&path, alpha);
    if alpha.contains(&0.0) {
        faults.add(path, "an exponent must not be zero");
    }
}

/// Whether all are such as bodies may have.
fn ratios(nu: &[f64], count: usize, path: &str, faults: &mut Faults) -> bool {
    let path = format!("{path}.nu");
    if nu.len() != 1 && nu.len() != count {
        let message = format!(
            "must have one Poisson ratio for all terms, or {count} as `mu` has, not {}",
            nu.len()
        );
        faults.add(&path, message);
    }
    let outside = nu.iter().find(|nu| !(**nu > -1.0 && **nu < 0.5));
    if let Some(one) = outside {
        let message = format!("must lie above -1 and below 0.5, not {one}");
        faults.add(path, message);
    }
    outside.is_none()
}
