//! Where a foam is stable, its volume free to change:
//!
//! ```text
//! d tau : d eps > 0   where   D = d tau_k / d eps_m = diag(p) + q 1 1^T   is positive definite
//! ```
//!
//! along ways whose free directions bear no stress. Their strain is the first one from zero on, by
//! steps and bisection: up to where the law is stable the stress grows with it.

use super::Unstable;
use super::search::first_unstable;
use crate::material::Hyperfoam;

/// A way of deformation: its name, the strains over that along it, none where a direction is free,
/// and its sign.
type Way = (&'static str, [Option<f64>; 3], f64);

const WAYS: [Way; 6] = [
    ("uniaxial tension", [Some(1.0), None, None], 1.0),
    ("uniaxial compression", [Some(1.0), None, None], -1.0),
    ("equibiaxial tension", [Some(1.0), Some(1.0), None], 1.0),
    ("planar tension", [Some(1.0), Some(0.0), None], 1.0),
    ("volumetric tension", [Some(1.0); 3], 1.0),
    ("volumetric compression", [Some(1.0); 3], -1.0),
];

/// Steps in which a free strain is looked for.
const STEPS: u32 = 32;
/// Halvings of the step in which it lies, to 1e-10.
const HALVINGS: usize = 30;
/// Strains of free directions over that along the way are at most 2 of either sign where each Poisson
/// ratio lies between -1 and 1/2.
const FREE: f64 = 2.1;

/// The ways on which `law` is not stable to the end, with the first stretch of each.
pub(super) fn unstable(law: &Hyperfoam) -> Vec<Unstable> {
    let of_way = |(way, shape, sign): Way| {
        let is_stable = |size: f64| {
            let strains = shape.map(|share| share.map(|share| share * sign * size));
            is_stable(law, &with_free(law, strains, FREE * size))
        };
        let size = first_unstable(is_stable)?;
        let stretch = (sign * size).exp();
        Some(Unstable { way, stretch })
    };
    WAYS.into_iter().filter_map(of_way).collect()
}

/// All strains, the free ones without stress: those nearest to zero, no farther than `range`.
fn with_free(law: &Hyperfoam, strains: [Option<f64>; 3], range: f64) -> [f64; 3] {
    let filled = |free: f64| strains.map(|strain| strain.unwrap_or(free));
    let Some(axis) = strains.iter().position(Option::is_none) else {
        return filled(0.0);
    };
    let pull = |free: f64| law.kirchhoff(&filled(free))[axis];
    // Free directions give way to their stress.
    let step = -pull(0.0).signum() * range / f64::from(STEPS);
    let reached = |place: u32| f64::from(place) * step;
    let last = (1..STEPS).find(|&place| pull(reached(place)) * step >= 0.0);
    let last = last.unwrap_or(STEPS);
    let [mut near, mut far] = [last - 1, last].map(reached);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (near + far);
        if pull(middle) * step >= 0.0 {
            far = middle;
        } else {
            near = middle;
        }
    }
    filled(0.5 * (near + far))
}

/// Whether D is positive definite: where p is, by 1 + q sum 1/p; else by its leading minors.
fn is_stable(law: &Hyperfoam, strains: &[f64; 3]) -> bool {
    let (own, all) = law.kirchhoff_slopes(strains);
    if own.iter().all(|p| *p > 0.0) {
        return 1.0 + own.iter().map(|p| all / p).sum::<f64>() > 0.0;
    }
    let size = own.iter().fold(all.abs(), |most, p| most.max(p.abs()));
    let ([a, b, c], q) = (own.map(|p| p / size), all / size);
    let pairs = a * b + q * (a + b);
    a + q > 0.0 && pairs > 0.0 && pairs * c + q * a * b > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::{FoamTerm, blatz_ko};

    fn foam(terms: &[(f64, f64, f64)]) -> Hyperfoam {
        let term = |&(modulus, exponent, beta): &(f64, f64, f64)| FoamTerm {
            modulus,
            exponent,
            beta,
        };
        Hyperfoam::new(terms.iter().map(term).collect())
    }

    #[test]
    fn foams_of_positive_terms_are_stable() {
        assert!(unstable(&blatz_ko(1.0)).is_empty());
        for exponent in [-5.0, 2.0, 20.0] {
            for beta in [0.0, 0.3, 5.0] {
                let law = foam(&[(1.0, exponent, beta), (0.2, -exponent, 0.0)]);
                let found = unstable(&law);
                assert!(found.is_empty(), "{exponent} {beta}: {found:?}");
            }
        }
    }

    #[test]
    fn a_negative_term_is_unstable_where_its_slope_is_zero() {
        // p = 2 (2 l^2 - l^8) and no lateral strain: zero at l^6 = 2 along the way.
        let law = foam(&[(2.0, 2.0, 0.0), (-1.0, 8.0, 0.0)]);
        let found = unstable(&law);
        let ways =
            ["uniaxial", "equibiaxial", "planar", "volumetric"].map(|way| format!("{way} tension"));
        for way in ways {
            let own = found.iter().find(|one| one.way == way).expect("unstable");
            assert!(
                (own.stretch - 2.0_f64.powf(1.0 / 6.0)).abs() < 1e-6,
                "{own:?}"
            );
        }
        assert!(
            found.iter().all(|one| one.way.ends_with("tension")),
            "{found:?}"
        );
    }

    #[test]
    fn a_foam_that_widens_is_unstable_where_it_gives_way_in_volume() {
        // (l^2 - J^(2/3)) 3 ..: with beta = -1/4 and alpha = 8, D along 1 is
        // 2 (l^8 - 3/4 l^6) in a change of volume, zero at l^2 = 3/4.
        let law = foam(&[(1.0, 8.0, -0.25)]);
        let found = unstable(&law);
        let way = "volumetric compression";
        let own = found.iter().find(|one| one.way == way).expect("unstable");
        assert!((own.stretch - 0.75_f64.sqrt()).abs() < 1e-6, "{own:?}");
    }
}
