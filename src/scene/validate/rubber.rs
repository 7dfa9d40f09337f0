//! Rubber: parameters, and what a scene of rubber can have beside it.
//!
//! The shear modulus at rest is 2 (c10 + c01), of Ogden's law the sum of
//! mu alpha / 2; Poisson's ratio at rest (3 K - 2 mu) / (2 (3 K + mu)).

use super::{Faults, Resolved, ResolvedMaterial};
use crate::material::{
    ArrudaBoyce, Gent, InvariantLaw, Isochoric, LinearElastic, Ogden, OgdenTerm, POWERS,
    Polynomial, Potential, Rubber,
};
use crate::scene::{
    Choice, ContactMethod, DisplacementMethod, Named, RubberModel, SaddleMethod, Scene, SceneKind,
    SolverOptions, ToleranceRule,
};

/// Terms of Ogden's law.
const MOST_TERMS: usize = 3;
/// Least limit of Gent's law, without unit: i1 - 3 is 1e-3 at a stretch of 2 %; chosen, no scene
/// measures it.
const LEAST_LIMIT: f64 = 1e-3;
/// Degrees of the volume rule that stress is integrated with.
const DEGREES: std::ops::RangeInclusive<u32> = 2..=12;

/// The material of a rubber.
pub(super) fn resolve(
    model: &RubberModel,
    bulk_modulus: Option<f64>,
    path: &str,
    faults: &mut Faults,
) -> ResolvedMaterial {
    let inverse_bulk = inverse_bulk(bulk_modulus, path, faults);
    let rubber = Rubber {
        isochoric: isochoric(model, path, faults),
        inverse_bulk,
    };
    let shear_modulus = rubber.shear_modulus();
    ResolvedMaterial {
        law: LinearElastic {
            shear_modulus,
            inverse_lame: inverse_bulk,
            direct_lame: 0.0,
        },
        poisson_ratio: poisson_ratio(shear_modulus * inverse_bulk),
        is_flow: false,
        rubber: Some(rubber),
    }
}

/// A material that shares a scene with rubber: a linear solid takes the neo-Hookean law that
/// has its moduli at rest, mu and K = lambda + 2 mu / 3, so that it may turn with the body.
pub(super) fn beside_rubber(material: ResolvedMaterial) -> ResolvedMaterial {
    if material.is_flow || material.rubber.is_some() {
        return material;
    }
    let (shear_modulus, nu) = (material.law.shear_modulus, material.poisson_ratio);
    let inverse_bulk = 1.5 * (1.0 - 2.0 * nu) / (shear_modulus * (1.0 + nu));
    let isochoric = Isochoric::Invariants(InvariantLaw {
        c10: 0.5 * shear_modulus,
        c01: 0.0,
        c20: 0.0,
        c30: 0.0,
    });
    ResolvedMaterial {
        law: LinearElastic {
            shear_modulus,
            inverse_lame: inverse_bulk,
            direct_lame: 0.0,
        },
        rubber: Some(Rubber {
            isochoric,
            inverse_bulk,
        }),
        ..material
    }
}

/// At rest, from mu / K.
fn poisson_ratio(shear_over_bulk: f64) -> f64 {
    (3.0 - 2.0 * shear_over_bulk) / (6.0 + 2.0 * shear_over_bulk)
}

fn inverse_bulk(bulk_modulus: Option<f64>, path: &str, faults: &mut Faults) -> f64 {
    let Some(bulk_modulus) = bulk_modulus else {
        return 0.0;
    };
    let inverse = bulk_modulus.recip();
    if !(bulk_modulus > 0.0 && inverse.is_finite()) {
        let message = format!("must be above zero, or left out for infinite, not {bulk_modulus}");
        faults.add(format!("{path}.bulk_modulus"), message);
    }
    inverse
}

fn isochoric(model: &RubberModel, path: &str, faults: &mut Faults) -> Isochoric {
    let first = format!("{path}.c10");
    let [c10, c01, c20, c30] = match model {
        &RubberModel::MooneyRivlin { c10, c01 } => {
            all_finite(&[("c10", c10), ("c01", c01)], path, faults);
            at_rest(2.0 * (c10 + c01), "2 (c10 + c01)", &first, faults);
            [c10, c01, 0.0, 0.0]
        }
        &RubberModel::NeoHookean { shear_modulus } => {
            faults.above_zero(&format!("{path}.shear_modulus"), shear_modulus);
            [0.5 * shear_modulus, 0.0, 0.0, 0.0]
        }
        &RubberModel::Yeoh { c10, c20, c30 } => {
            all_finite(&[("c10", c10), ("c20", c20), ("c30", c30)], path, faults);
            at_rest(2.0 * c10, "2 c10", &first, faults);
            [c10, 0.0, c20, c30]
        }
        RubberModel::Ogden { mu, alpha } => return ogden(mu, alpha, path, faults),
        RubberModel::Polynomial { coefficients } => return polynomial(*coefficients, path, faults),
        &RubberModel::Gent {
            shear_modulus,
            limit,
        } => return gent(shear_modulus, limit, path, faults),
        &RubberModel::ArrudaBoyce {
            mu,
            locking_stretch,
        } => return arruda_boyce(mu, locking_stretch, path, faults),
    };
    Isochoric::Invariants(InvariantLaw { c10, c01, c20, c30 })
}

fn all_finite(values: &[(&str, f64)], path: &str, faults: &mut Faults) {
    for (key, value) in values {
        if !value.is_finite() {
            faults.add(
                format!("{path}.{key}"),
                format!("must be finite, not {value}"),
            );
        }
    }
}

/// A body without shear stiffness at rest has no equilibrium to find; what is
/// not finite has its own message.
fn at_rest(shear_modulus: f64, formula: &str, path: &str, faults: &mut Faults) {
    let is_usable = shear_modulus > 0.0 && shear_modulus.is_finite();
    if !is_usable && !shear_modulus.is_nan() {
        let message = format!(
            "the shear modulus at rest, {formula}, must be above zero and finite, not {shear_modulus}"
        );
        faults.add(path, message);
    }
}

/// Ogden's law, its terms checked.
fn ogden(mu: &[f64], alpha: &[f64], path: &str, faults: &mut Faults) -> Isochoric {
    let count = mu.len();
    if !(1..=MOST_TERMS).contains(&count) {
        let message = format!("must have 1 to {MOST_TERMS} terms, not {count}");
        faults.add(format!("{path}.mu"), message);
    }
    if alpha.len() != count {
        let message = format!(
            "must have {count} exponents as `mu` has, not {}",
            alpha.len()
        );
        faults.add(format!("{path}.alpha"), message);
    }
    faults.finite(&format!("{path}.mu"), mu);
    faults.finite(&format!("{path}.alpha"), alpha);
    if alpha.contains(&0.0) {
        faults.add(format!("{path}.alpha"), "an exponent must not be zero");
    }
    let terms = mu.iter().zip(alpha);
    let terms = terms.map(|(&modulus, &exponent)| OgdenTerm { modulus, exponent });
    let law = Ogden {
        terms: terms.collect(),
    };
    let formula = "the sum of mu alpha / 2";
    at_rest(law.shear_modulus(), formula, &format!("{path}.mu"), faults);
    Isochoric::Ogden(law)
}

/// Rivlin's polynomial, its coefficients checked.
fn polynomial(coefficients: [f64; 9], path: &str, faults: &mut Faults) -> Isochoric {
    let names = POWERS.map(|(i, j)| format!("c{i}{j}"));
    let pairs: Vec<(&str, f64)> = names.iter().map(String::as_str).zip(coefficients).collect();
    all_finite(&pairs, path, faults);
    let modulus = 2.0 * (coefficients[0] + coefficients[1]);
    at_rest(modulus, "2 (c10 + c01)", &format!("{path}.c10"), faults);
    Isochoric::Potential(Potential::Polynomial(Polynomial { coefficients }))
}

fn gent(shear_modulus: f64, limit: f64, path: &str, faults: &mut Faults) -> Isochoric {
    faults.above_zero(&format!("{path}.shear_modulus"), shear_modulus);
    if !(limit >= LEAST_LIMIT && limit.is_finite()) {
        let message = format!("must be at least {LEAST_LIMIT} and finite, not {limit}");
        faults.add(format!("{path}.limit"), message);
    }
    Isochoric::Potential(Potential::Gent(Gent {
        shear_modulus,
        limit,
    }))
}

fn arruda_boyce(mu: f64, locking_stretch: f64, path: &str, faults: &mut Faults) -> Isochoric {
    faults.above_zero(&format!("{path}.mu"), mu);
    if !(locking_stretch > 1.0 && locking_stretch.is_finite()) {
        let message = format!("must be above one and finite, not {locking_stretch}");
        faults.add(format!("{path}.locking_stretch"), message);
    }
    Isochoric::Potential(Potential::ArrudaBoyce(ArrudaBoyce {
        modulus: mu,
        locking_stretch,
    }))
}

/// Refuses what rubber is not solved with, and what only rubber has.
pub(super) fn check(scene: &Scene, materials: &[ResolvedMaterial], faults: &mut Faults) {
    let is_rubber = |material: &ResolvedMaterial| material.rubber.is_some();
    if !materials.iter().any(is_rubber) {
        return needs_rubber(scene, faults);
    }
    if scene.manufactured.is_some() {
        let message = "the fields are of linear elasticity, not of rubber";
        faults.unsupported("manufactured.field", message);
    }
    methods(&scene.solver, faults);
}

/// Refuses a method that is asked for and does not serve rubber.
fn serves<T: Named>(key: &str, asked: Choice<T>, serving: T, faults: &mut Faults) {
    if let Some(method) = asked.named().filter(|method| *method != serving) {
        let (asked, serving) = (method.name(), serving.name());
        let message = format!("`{asked}` with rubber; `{serving}` serves it");
        faults.unsupported(format!("solver.{key}"), message);
    }
}

fn methods(solver: &SolverOptions, faults: &mut Faults) {
    serves("saddle", solver.saddle, SaddleMethod::Gcr, faults);
    serves("contact", solver.contact, ContactMethod::OneLevel, faults);
    let preconditioner = solver.displacement_preconditioner;
    let (key, serving) = (
        "displacement_preconditioner",
        DisplacementMethod::PMultigrid,
    );
    serves(key, preconditioner, serving, faults);
    if solver.tolerance_rule == ToleranceRule::Discretisation {
        let message = "`discretisation` with rubber, which has no error estimate";
        faults.unsupported("solver.tolerance", message);
    }
    if let Some(degree) = solver.quadrature_degree
        && !DEGREES.contains(&degree)
    {
        let (least, most) = (DEGREES.start(), DEGREES.end());
        let message = format!("must lie between {least} and {most} for rubber, not {degree}");
        faults.add("solver.quadrature_degree", message);
    }
}

fn needs_rubber(scene: &Scene, faults: &mut Faults) {
    if !scene.pressures.is_empty() {
        let message = "a follower pressure without rubber; `traction` is a dead load";
        faults.unsupported("pressure[0]", message);
    }
    if scene.kind == Some(SceneKind::Axisymmetric) {
        faults.unsupported("kind", "`axisymmetric` without rubber");
    }
}

impl Resolved {
    /// Whether the body is rubber.
    pub(crate) fn is_rubber(&self) -> bool {
        self.materials
            .iter()
            .any(|material| material.rubber.is_some())
    }

    /// Whether the equations are not linear in the displacement even without
    /// contact.
    pub(crate) fn is_nonlinear(&self) -> bool {
        let is_axisymmetric = self.kind == SceneKind::Axisymmetric;
        self.is_rubber() || is_axisymmetric || !self.pressures.is_empty()
    }
}
