//! Rubber: parameters, and what a scene of rubber can have beside it.
//!
//! The shear modulus at rest is 2 (c10 + c01), of Ogden's law the sum of
//! mu alpha / 2; Poisson's ratio at rest (3 K - 2 mu) / (2 (3 K + mu)). Foams are beside ([`foams`]).

use super::{Faults, Resolved, ResolvedMaterial, foams};
use crate::material::{
    ArrudaBoyce, Gent, InvariantLaw, Isochoric, LinearElastic, Ogden, OgdenTerm, POWERS,
    Polynomial, Potential, Rubber, VanDerWaals, blatz_ko,
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
    let isochoric = match law(model, path, faults) {
        Isochoric::Hyperfoam(law) => return foams::resolve(law, bulk_modulus, path, faults),
        law @ (Isochoric::Invariants(_)
        | Isochoric::Ogden(_)
        | Isochoric::Potential(_)
        | Isochoric::Sheet(_)) => law,
    };
    let inverse_bulk = inverse_bulk(bulk_modulus, path, faults);
    let rubber = Rubber {
        isochoric,
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
    ResolvedMaterial {
        law: LinearElastic {
            shear_modulus,
            inverse_lame: inverse_bulk,
            direct_lame: 0.0,
        },
        rubber: Some(Rubber::neo_hookean(shear_modulus, inverse_bulk)),
        ..material
    }
}

/// Makes `material` that of a sheet of `rubber`, by its moduli in the plane at rest; displacements
/// carry what its pressure does not.
pub(super) fn flatten(rubber: Rubber, material: &mut ResolvedMaterial) {
    let (shear_modulus, ratio) = (material.law.shear_modulus, material.poisson_ratio);
    let in_plane = LinearElastic::from_shear_modulus(shear_modulus, ratio).of_a_sheet();
    let sheet = rubber.of_a_sheet();
    material.law.direct_lame = in_plane.lame() - sheet.inverse_bulk.recip();
    material.law.inverse_lame = sheet.inverse_bulk;
    material.poisson_ratio = in_plane.poisson_ratio();
    material.rubber = Some(sheet);
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

pub(super) fn law(model: &RubberModel, path: &str, faults: &mut Faults) -> Isochoric {
    let first = format!("{path}.c10");
    let [c10, c01, c20, c30] = match model {
        &RubberModel::MooneyRivlin { c10, c01 } => {
            all_finite(&[("c10", c10), ("c01", c01)], path, faults);
            faults.at_rest(2.0 * (c10 + c01), "2 (c10 + c01)", &first);
            [c10, c01, 0.0, 0.0]
        }
        &RubberModel::NeoHookean { shear_modulus } => {
            faults.above_zero(&format!("{path}.shear_modulus"), shear_modulus);
            [0.5 * shear_modulus, 0.0, 0.0, 0.0]
        }
        &RubberModel::Yeoh { c10, c20, c30 } => {
            all_finite(&[("c10", c10), ("c20", c20), ("c30", c30)], path, faults);
            faults.at_rest(2.0 * c10, "2 c10", &first);
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
        &RubberModel::VanDerWaals {
            shear_modulus,
            locking_stretch,
            a,
            beta,
        } => {
            let law = VanDerWaals {
                shear_modulus,
                locking_stretch,
                interaction: a,
                second_share: beta,
            };
            return van_der_waals(law, path, faults);
        }
        RubberModel::Hyperfoam { mu, alpha, nu } => {
            return Isochoric::Hyperfoam(foams::hyperfoam([mu, alpha, nu], path, faults));
        }
        &RubberModel::BlatzKo { shear_modulus } => {
            faults.above_zero(&format!("{path}.shear_modulus"), shear_modulus);
            return Isochoric::Hyperfoam(blatz_ko(shear_modulus));
        }
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
    faults.at_rest(law.shear_modulus(), formula, &format!("{path}.mu"));
    Isochoric::Ogden(law)
}

/// Rivlin's polynomial, its coefficients checked.
fn polynomial(coefficients: [f64; 9], path: &str, faults: &mut Faults) -> Isochoric {
    let names = POWERS.map(|(i, j)| format!("c{i}{j}"));
    let pairs: Vec<(&str, f64)> = names.iter().map(String::as_str).zip(coefficients).collect();
    all_finite(&pairs, path, faults);
    let modulus = 2.0 * (coefficients[0] + coefficients[1]);
    faults.at_rest(modulus, "2 (c10 + c01)", &format!("{path}.c10"));
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

fn van_der_waals(law: VanDerWaals, path: &str, faults: &mut Faults) -> Isochoric {
    faults.above_zero(&format!("{path}.shear_modulus"), law.shear_modulus);
    let limit = law.locking_stretch * law.locking_stretch - 3.0;
    if !(law.locking_stretch > 0.0 && limit >= LEAST_LIMIT && limit.is_finite()) {
        let message = format!(
            "must be above the square root of three, its square at least {LEAST_LIMIT} above three and finite, not {}",
            law.locking_stretch
        );
        faults.add(format!("{path}.locking_stretch"), message);
    }
    if !(law.interaction >= 0.0 && law.interaction.is_finite()) {
        let message = format!("must be at least zero and finite, not {}", law.interaction);
        faults.add(format!("{path}.a"), message);
    }
    if !(0.0..=1.0).contains(&law.second_share) {
        let message = format!("must lie between zero and one, not {}", law.second_share);
        faults.add(format!("{path}.beta"), message);
    }
    Isochoric::Potential(Potential::VanDerWaals(law))
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
    if scene.kind == Some(SceneKind::PlaneStress) && !scene.pressures.is_empty() {
        let message = "a follower pressure on a sheet, whose thickness changes; give a `traction`";
        faults.unsupported("pressure[0]", message);
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
        self.is_rubber() || !self.pressures.is_empty()
    }
}
