//! Numbers of a scene by the keys of parameters.

use std::sync::Arc;

use crate::obstacle::Shape;
use crate::scene::{MaterialModel, Modulus, RubberModel};

/// Keys of Rivlin's polynomial, in the order of its coefficients.
const POLYNOMIAL: [&str; 9] = [
    "c10", "c01", "c20", "c11", "c02", "c30", "c21", "c12", "c03",
];

/// A constant of a law; none that it does not have.
pub(crate) fn constant<'a>(model: &'a mut MaterialModel, key: &str) -> Option<&'a mut f64> {
    match model {
        MaterialModel::LinearElastic {
            modulus,
            poisson_ratio,
            ..
        } => match (key, modulus) {
            ("poisson_ratio", _) => Some(poisson_ratio),
            ("shear_modulus", Modulus::Shear(value)) => Some(value),
            ("young_modulus", Modulus::Young(value)) => Some(value),
            _ => None,
        },
        MaterialModel::Stokes { viscosity, .. } => (key == "viscosity").then_some(viscosity),
        MaterialModel::Rubber {
            model,
            bulk_modulus,
            ..
        } => match key {
            "bulk_modulus" => bulk_modulus.as_mut().filter(|value| value.is_finite()),
            _ => of_rubber(model, key),
        },
    }
}

/// Whether stresses and volumes at given strains and pressures are linear in a constant, of rubber
/// that is not a sheet: all but exponents, limits and moduli that the volume feels.
pub(crate) fn is_linear(model: &MaterialModel, key: &str) -> bool {
    let name = key.split('.').next().unwrap_or(key);
    match model {
        MaterialModel::LinearElastic { poisson_ratio, .. } => {
            *poisson_ratio >= 0.5 && name != "poisson_ratio"
        }
        MaterialModel::Stokes { .. } => true,
        MaterialModel::Rubber { model, .. } => {
            let is_foam = matches!(
                model,
                RubberModel::Hyperfoam { .. } | RubberModel::BlatzKo { .. }
            );
            let is_factor = matches!(name, "mu" | "shear_modulus") || POLYNOMIAL.contains(&name);
            is_factor && !is_foam
        }
    }
}

fn of_rubber<'a>(model: &'a mut RubberModel, key: &str) -> Option<&'a mut f64> {
    let (name, place) = match key.split_once('.') {
        Some((name, place)) => (name, place.parse::<usize>().ok()),
        None => (key, None),
    };
    match (model, name, place) {
        (RubberModel::MooneyRivlin { c10, .. }, "c10", None) => Some(c10),
        (RubberModel::MooneyRivlin { c01, .. }, "c01", None) => Some(c01),
        (RubberModel::NeoHookean { shear_modulus }, "shear_modulus", None) => Some(shear_modulus),
        (RubberModel::Yeoh { c10, .. }, "c10", None) => Some(c10),
        (RubberModel::Yeoh { c20, .. }, "c20", None) => Some(c20),
        (RubberModel::Yeoh { c30, .. }, "c30", None) => Some(c30),
        (RubberModel::Ogden { mu, .. }, "mu", Some(place)) => mu.get_mut(place),
        (RubberModel::Ogden { alpha, .. }, "alpha", Some(place)) => alpha.get_mut(place),
        (RubberModel::Polynomial { coefficients }, _, None) => {
            let place = POLYNOMIAL.iter().position(|one| *one == name)?;
            coefficients.get_mut(place)
        }
        (RubberModel::Gent { shear_modulus, .. }, "shear_modulus", None) => Some(shear_modulus),
        (RubberModel::Gent { limit, .. }, "limit", None) => Some(limit),
        (RubberModel::ArrudaBoyce { mu, .. }, "mu", None) => Some(mu),
        (
            RubberModel::ArrudaBoyce {
                locking_stretch, ..
            }
            | RubberModel::VanDerWaals {
                locking_stretch, ..
            },
            "locking_stretch",
            None,
        ) => Some(locking_stretch),
        (RubberModel::VanDerWaals { shear_modulus, .. }, "shear_modulus", None) => {
            Some(shear_modulus)
        }
        (RubberModel::VanDerWaals { a, .. }, "a", None) => Some(a),
        (RubberModel::VanDerWaals { beta, .. }, "beta", None) => Some(beta),
        (RubberModel::Hyperfoam { mu, .. }, "mu", Some(place)) => mu.get_mut(place),
        (RubberModel::Hyperfoam { alpha, .. }, "alpha", Some(place)) => alpha.get_mut(place),
        (RubberModel::Hyperfoam { nu, .. }, "nu", Some(place)) => nu.get_mut(place),
        (RubberModel::BlatzKo { shear_modulus }, "shear_modulus", None) => Some(shear_modulus),
        _ => None,
    }
}

/// A number of a shape; none that it does not have.
pub(crate) fn number<'a>(shape: &'a mut Shape, key: &str) -> Option<&'a mut f64> {
    if let Shape::Cavity(inner) = shape {
        return number(Arc::make_mut(inner), key);
    }
    if let Some((point, axis)) = key.split_once('.') {
        let axis = ["x", "y", "z"].iter().position(|name| *name == axis)?;
        return point_of(shape, point).map(|point| &mut point[axis]);
    }
    match (shape, key) {
        (
            Shape::Sphere { radius, .. }
            | Shape::Cylinder { radius, .. }
            | Shape::CappedCylinder { radius, .. }
            | Shape::Torus { radius, .. },
            "radius",
        ) => Some(radius),
        (Shape::Torus { tube_radius, .. }, "tube_radius") => Some(tube_radius),
        (
            Shape::CappedCylinder { rounding, .. }
            | Shape::Box { rounding, .. }
            | Shape::Cone { rounding, .. },
            "rounding",
        ) => Some(rounding),
        (Shape::Cone { angle, .. }, "angle") => Some(angle),
        _ => None,
    }
}

fn point_of<'a>(shape: &'a mut Shape, key: &str) -> Option<&'a mut [f64; 3]> {
    match (shape, key) {
        (Shape::HalfSpace { point, .. } | Shape::Cylinder { point, .. }, "point") => Some(point),
        (Shape::HalfSpace { normal, .. }, "normal") => Some(normal),
        (
            Shape::Sphere { centre, .. } | Shape::Box { centre, .. } | Shape::Torus { centre, .. },
            "centre",
        ) => Some(centre),
        (
            Shape::Cylinder { axis, .. } | Shape::Torus { axis, .. } | Shape::Cone { axis, .. },
            "axis",
        ) => Some(axis),
        (Shape::CappedCylinder { from, .. }, "from") => Some(from),
        (Shape::CappedCylinder { to, .. }, "to") => Some(to),
        (Shape::Box { half_sizes, .. }, "half_sizes") => Some(half_sizes),
        (Shape::Cone { apex, .. }, "apex") => Some(apex),
        _ => None,
    }
}
