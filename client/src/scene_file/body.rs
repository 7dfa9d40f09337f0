//! Everything of a scene but materials, obstacles and steps.

use signorini_proto::v1;

use super::keys::Keys;

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
    ("contact_path", v1::FieldName::ContactPath),
    ("error_density", v1::FieldName::ErrorDensity),
    ("mesh_gradient", v1::FieldName::MeshGradient),
];

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
