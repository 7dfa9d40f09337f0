//! Materials of a scene: the laws by name, each with its keys.

use signorini_proto::v1;
use signorini_proto::v1::linear_elastic::Modulus;
use signorini_proto::v1::material::Model;

use super::keys::Keys;

const FORMULATIONS: &[(&str, v1::Formulation)] = &[
    ("auto", v1::Formulation::Unspecified),
    ("mixed", v1::Formulation::Mixed),
    ("displacement", v1::Formulation::Displacement),
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
    (
        "van-der-waals",
        &[
            "shear_modulus",
            "locking_stretch",
            "a",
            "beta",
            "bulk_modulus",
        ],
        van_der_waals,
    ),
    ("hyperfoam", &["mu", "alpha", "nu"], hyperfoam),
    ("blatz-ko", &["shear_modulus"], blatz_ko),
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

fn van_der_waals(keys: &Keys<'_>) -> Option<Model> {
    Some(Model::VanDerWaals(v1::VanDerWaals {
        shear_modulus: keys.required_number("shear_modulus"),
        locking_stretch: keys.required_number("locking_stretch"),
        a: keys.number("a").unwrap_or_default(),
        beta: keys.number("beta").unwrap_or_default(),
        bulk_modulus: keys.number("bulk_modulus"),
    }))
}

fn hyperfoam(keys: &Keys<'_>) -> Option<Model> {
    Some(Model::Hyperfoam(v1::Hyperfoam {
        mu: keys.numbers("mu"),
        alpha: keys.numbers("alpha"),
        nu: keys.numbers("nu"),
    }))
}

fn blatz_ko(keys: &Keys<'_>) -> Option<Model> {
    Some(Model::BlatzKo(v1::BlatzKo {
        shear_modulus: keys.required_number("shear_modulus"),
    }))
}
