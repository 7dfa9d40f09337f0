//! Everything of a scene but obstacles and steps.

use signorini_proto::v1;
use signorini_proto::v1::linear_elastic::Modulus;
use signorini_proto::v1::material::Model;

use super::keys::Keys;

const FORMULATIONS: &[(&str, v1::Formulation)] = &[
    ("auto", v1::Formulation::Unspecified),
    ("mixed", v1::Formulation::Mixed),
    ("displacement", v1::Formulation::Displacement),
];

const PROFILES: &[(&str, v1::SupportProfile)] = &[
    ("constant", v1::SupportProfile::Unspecified),
    ("parabolic", v1::SupportProfile::Parabolic),
];

/// Names of output fields.
pub(crate) const FIELDS: &[(&str, v1::FieldName)] = &[
    ("displacement", v1::FieldName::Displacement),
    ("pressure", v1::FieldName::Pressure),
    ("contact_pressure", v1::FieldName::ContactPressure),
    ("gap", v1::FieldName::Gap),
    ("contact_state", v1::FieldName::ContactState),
    ("stress", v1::FieldName::Stress),
    ("jacobian", v1::FieldName::Jacobian),
    ("error_estimate", v1::FieldName::ErrorEstimate),
    (
        "contact_pressure_deformed",
        v1::FieldName::ContactPressureDeformed,
    ),
    (
        "contact_pressure_undeformed",
        v1::FieldName::ContactPressureUndeformed,
    ),
    ("friction_traction", v1::FieldName::FrictionTraction),
    ("slip", v1::FieldName::Slip),
    ("lowest_mode", v1::FieldName::LowestMode),
    ("nodal_force", v1::FieldName::NodalForce),
];

type ReadModel = fn(&Keys<'_>) -> Option<Model>;

/// Each law: its name, its keys beside `model` and `formulation`, its reader.
const MODELS: &[(&str, &[&str], ReadModel)] = &[
    (
        "linear-elastic",
        &["shear_modulus", "young_modulus", "poisson_ratio"],
        linear_elastic,
    ),
    ("stokes", &["viscosity"], stokes),
    (
        "mooney-rivlin",
        &["c10", "c01", "bulk_modulus"],
        mooney_rivlin,
    ),
    (
        "neo-hookean",
        &["shear_modulus", "bulk_modulus"],
        neo_hookean,
    ),
    ("yeoh", &["c10", "c20", "c30", "bulk_modulus"], yeoh),
    ("ogden", &["mu", "alpha", "bulk_modulus"], ogden),
    (
        "polynomial",
        &[
            "c10",
            "c01",
            "c20",
            "c11",
            "c02",
            "c30",
            "c21",
            "c12",
            "c03",
            "bulk_modulus",
        ],
        polynomial,
    ),
    ("gent", &["shear_modulus", "limit", "bulk_modulus"], gent),
    (
        "arruda-boyce",
        &["mu", "locking_stretch", "bulk_modulus"],
        arruda_boyce,
    ),
];

pub(super) fn materials(scene: &Keys<'_>) -> Vec<v1::Material> {
    let tables = scene.named_tables("material");
    tables
        .into_iter()
        .map(|(group, keys)| v1::Material {
            group,
            formulation: keys
                .choice("formulation", FORMULATIONS)
                .map_or(0, i32::from),
            model: model(&keys),
        })
        .collect()
}

fn model(keys: &Keys<'_>) -> Option<Model> {
    let name = keys.required_text("model");
    let found = MODELS.iter().find(|(known, _, _)| *known == name);
    let Some((_, own, read)) = found else {
        if keys.has("model") {
            keys.unknown_word("model", &name, MODELS.iter().map(|(known, _, _)| *known));
        }
        return None;
    };
    let known: Vec<&str> = ["model", "formulation"]
        .into_iter()
        .chain(own.iter().copied())
        .collect();
    keys.check(&known);
    read(keys)
}

fn linear_elastic(keys: &Keys<'_>) -> Option<Model> {
    let shear = keys.number("shear_modulus").map(Modulus::ShearModulus);
    let young = keys.number("young_modulus").map(Modulus::YoungModulus);
    match (keys.has("shear_modulus"), keys.has("young_modulus")) {
        (true, true) => keys.fault(
            "young_modulus",
            "give either shear_modulus or young_modulus, not both",
        ),
        (false, false) => keys.fault(
            "shear_modulus",
            "required key is missing (or give young_modulus)",
        ),
        _ => {}
    }
    Some(Model::LinearElastic(v1::LinearElastic {
        poisson_ratio: keys.required_number("poisson_ratio"),
        modulus: shear.or(young),
    }))
}

fn stokes(keys: &Keys<'_>) -> Option<Model> {
    let viscosity = keys.required_number("viscosity");
    Some(Model::Stokes(v1::Stokes { viscosity }))
}

fn mooney_rivlin(keys: &Keys<'_>) -> Option<Model> {
    Some(Model::MooneyRivlin(v1::MooneyRivlin {
        c10: keys.required_number("c10"),
        c01: keys.required_number("c01"),
        bulk_modulus: keys.number("bulk_modulus"),
    }))
}

fn neo_hookean(keys: &Keys<'_>) -> Option<Model> {
    Some(Model::NeoHookean(v1::NeoHookean {
        shear_modulus: keys.required_number("shear_modulus"),
        bulk_modulus: keys.number("bulk_modulus"),
    }))
}

fn yeoh(keys: &Keys<'_>) -> Option<Model> {
    Some(Model::Yeoh(v1::Yeoh {
        c10: keys.required_number("c10"),
        c20: keys.required_number("c20"),
        c30: keys.required_number("c30"),
        bulk_modulus: keys.number("bulk_modulus"),
    }))
}

fn ogden(keys: &Keys<'_>) -> Option<Model> {
    Some(Model::Ogden(v1::Ogden {
        mu: keys.numbers("mu"),
        alpha: keys.numbers("alpha"),
        bulk_modulus: keys.number("bulk_modulus"),
    }))
}

fn polynomial(keys: &Keys<'_>) -> Option<Model> {
    let coefficient = |key| keys.number(key).unwrap_or_default();
    Some(Model::Polynomial(v1::Polynomial {
        c10: coefficient("c10"),
        c01: coefficient("c01"),
        c20: coefficient("c20"),
        c11: coefficient("c11"),
        c02: coefficient("c02"),
        c30: coefficient("c30"),
        c21: coefficient("c21"),
        c12: coefficient("c12"),
        c03: coefficient("c03"),
        bulk_modulus: keys.number("bulk_modulus"),
    }))
}

fn gent(keys: &Keys<'_>) -> Option<Model> {
    Some(Model::Gent(v1::Gent {
        shear_modulus: keys.required_number("shear_modulus"),
        limit: keys.required_number("limit"),
        bulk_modulus: keys.number("bulk_modulus"),
    }))
}

fn arruda_boyce(keys: &Keys<'_>) -> Option<Model> {
    Some(Model::ArrudaBoyce(v1::ArrudaBoyce {
        mu: keys.required_number("mu"),
        locking_stretch: keys.required_number("locking_stretch"),
        bulk_modulus: keys.number("bulk_modulus"),
    }))
}

/// The key `name`, or a name made of the kind and the position.
pub(super) fn name_of(keys: &Keys<'_>, kind: &str, index: usize) -> String {
    keys.text("name")
        .unwrap_or_else(|| format!("{kind}-{}", index + 1))
}

const SUPPORT: &[&str] = &[
    "name",
    "on",
    "displacement",
    "normal",
    "profile",
    "values",
    "force",
    "moment",
    "stiffness",
    "rotational_stiffness",
    "about",
];

/// Keys of a support one of which has to be there.
const HOLDING: [&str; 7] = [
    "displacement",
    "normal",
    "values",
    "force",
    "moment",
    "stiffness",
    "rotational_stiffness",
];

pub(super) fn supports(scene: &Keys<'_>) -> Vec<v1::Support> {
    let tables = scene.tables("support", SUPPORT);
    let support = |(index, keys): (usize, &Keys<'_>)| {
        if !HOLDING.iter().any(|key| keys.has(key)) {
            let message = "required key is missing (or give normal, values, force or stiffness)";
            keys.fault("displacement", message);
        }
        v1::Support {
            name: name_of(keys, "support", index),
            on: keys.required_names("on"),
            displacement: components(keys, "displacement"),
            normal: keys.number("normal"),
            profile: keys.choice("profile", PROFILES).map_or(0, i32::from),
            values: values(keys),
            load: support_load(keys),
        }
    };
    tables.iter().enumerate().map(support).collect()
}

/// Forces and springs of a support; none where it has no key of theirs.
fn support_load(keys: &Keys<'_>) -> Option<v1::SupportLoad> {
    let load = v1::SupportLoad {
        force: components(keys, "force"),
        moment: components(keys, "moment"),
        stiffness: components(keys, "stiffness"),
        rotational_stiffness: components(keys, "rotational_stiffness"),
        about: keys.vector("about"),
    };
    (load != v1::SupportLoad::default()).then_some(load)
}

/// Values that a file has, whose rows are read later.
pub(super) fn values(keys: &Keys<'_>) -> Option<v1::Values> {
    keys.text("values").map(|_| v1::Values::default())
}

/// Named components of a vector.
pub(super) fn components(keys: &Keys<'_>, key: &str) -> Option<v1::Components> {
    let keys = keys.table(key, &["x", "y", "z"])?;
    Some(v1::Components {
        x: keys.number("x"),
        y: keys.number("y"),
        z: keys.number("z"),
    })
}

pub(super) fn tractions(scene: &Keys<'_>) -> Vec<v1::Traction> {
    let tables = scene.tables("traction", &["name", "on", "value", "values"]);
    let traction = |keys: &Keys<'_>| v1::Traction {
        name: keys.text("name").unwrap_or_default(),
        on: keys.required_names("on"),
        value: if keys.has("values") {
            keys.vector("value")
        } else {
            keys.required_vector("value")
        },
        values: values(keys),
    };
    tables.iter().map(traction).collect()
}

pub(super) fn pressures(scene: &Keys<'_>) -> Vec<v1::Pressure> {
    let tables = scene.tables("pressure", &["on", "value"]);
    let pressure = |keys: &Keys<'_>| v1::Pressure {
        on: keys.required_names("on"),
        value: keys.required_number("value"),
    };
    tables.iter().map(pressure).collect()
}

/// The constant force, and the one that a file has.
pub(super) fn body_force(scene: &Keys<'_>) -> (Vec<f64>, Option<v1::Values>) {
    let Some(keys) = scene.table("body_force", &["value", "values"]) else {
        return (Vec::new(), None);
    };
    let constant = if keys.has("values") {
        keys.vector("value")
    } else {
        keys.required_vector("value")
    };
    (constant, values(&keys))
}

pub(super) fn manufactured(scene: &Keys<'_>) -> String {
    let keys = scene.table("manufactured", &["field"]);
    keys.map(|keys| keys.required_text("field"))
        .unwrap_or_default()
}

pub(super) fn probes(scene: &Keys<'_>) -> Vec<v1::Probe> {
    let tables = scene.tables("probe", &["name", "point"]);
    let probe = |(index, keys): (usize, &Keys<'_>)| v1::Probe {
        name: name_of(keys, "probe", index),
        point: keys.required_vector("point"),
    };
    tables.iter().enumerate().map(probe).collect()
}

/// Words that may stand in the place of the tolerance.
const TOLERANCE_RULES: &[(&str, v1::ToleranceRule)] =
    &[("discretisation", v1::ToleranceRule::Discretisation)];

const SOLVER: &[&str] = &[
    "tolerance",
    "quadrature_degree",
    "max_wall_time",
    "element",
    "displacement_preconditioner",
    "p1_solver",
    "saddle",
    "contact",
    "contact_metric",
    "contact_space",
    "stability",
    "on_instability",
    "response",
    "report",
    "penalty",
    "error_estimate",
];

pub(super) fn solver(scene: &Keys<'_>) -> Option<v1::SolverOptions> {
    let keys = scene.table("solver", SOLVER)?;
    let quadrature = keys.text_or("quadrature_degree", "auto", Keys::integer);
    let (tolerance, tolerance_rule) = tolerance(&keys);
    let method = |key| keys.text(key).unwrap_or_default();
    Some(v1::SolverOptions {
        tolerance,
        tolerance_rule: tolerance_rule.into(),
        quadrature_degree: quadrature,
        max_wall_time: keys.number("max_wall_time"),
        element: method("element"),
        displacement_preconditioner: method("displacement_preconditioner"),
        p1_solver: method("p1_solver"),
        saddle: method("saddle"),
        contact: method("contact"),
        contact_metric: method("contact_metric"),
        contact_space: method("contact_space"),
        stability: method("stability"),
        on_instability: method("on_instability"),
        response: method("response"),
        report: method("report"),
        penalty: keys.text_or("penalty", "auto", Keys::number),
        verify: false,
        error_estimate: method("error_estimate"),
    })
}

/// The tolerance; a word in its place chooses a rule.
fn tolerance(keys: &Keys<'_>) -> (Option<f64>, v1::ToleranceRule) {
    if keys.has_text("tolerance") {
        let rule = keys.choice("tolerance", TOLERANCE_RULES);
        (None, rule.unwrap_or_default())
    } else {
        (keys.number("tolerance"), v1::ToleranceRule::Unspecified)
    }
}

/// What the units are called; nothing is converted.
pub(super) fn units(scene: &Keys<'_>) -> Option<v1::UnitNames> {
    let keys = scene.table("units", &["length", "force", "stress"])?;
    let name = |key| keys.text(key).unwrap_or_default();
    Some(v1::UnitNames {
        length: name("length"),
        force: name("force"),
        stress: name("stress"),
    })
}

pub(super) fn output(scene: &Keys<'_>) -> Option<v1::Output> {
    let keys = scene.table("output", &["fields", "every"])?;
    let mut fields = Vec::new();
    for name in keys.names("fields") {
        match FIELDS.iter().find(|(known, _)| *known == name) {
            Some((_, field)) => fields.push(i32::from(*field)),
            None => keys.unknown_word("fields", &name, FIELDS.iter().map(|(known, _)| *known)),
        }
    }
    Some(v1::Output {
        fields,
        every: keys.integer("every"),
    })
}
