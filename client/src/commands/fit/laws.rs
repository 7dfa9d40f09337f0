//! Laws of rubber between messages, names and keys of scenes.

use signorini::scene::RubberModel;
use signorini_proto::v1;
use signorini_proto::v1::material::Model;

/// The law of a message, none of those that are not fitted, and its bulk modulus.
pub(super) fn of_message(material: &v1::Material) -> (Option<RubberModel>, Option<f64>) {
    let value = |value: Option<f64>| value.unwrap_or_default();
    let Some(model) = &material.model else {
        return (None, None);
    };
    let (model, bulk_modulus) = match model {
        Model::MooneyRivlin(law) => (
            RubberModel::MooneyRivlin {
                c10: value(law.c10),
                c01: value(law.c01),
            },
            law.bulk_modulus,
        ),
        Model::NeoHookean(law) => (
            RubberModel::NeoHookean {
                shear_modulus: value(law.shear_modulus),
            },
            law.bulk_modulus,
        ),
        Model::Yeoh(law) => (
            RubberModel::Yeoh {
                c10: value(law.c10),
                c20: value(law.c20),
                c30: value(law.c30),
            },
            law.bulk_modulus,
        ),
        Model::Ogden(law) => (
            RubberModel::Ogden {
                mu: law.mu.clone(),
                alpha: law.alpha.clone(),
            },
            law.bulk_modulus,
        ),
        Model::Polynomial(law) => (
            RubberModel::Polynomial {
                coefficients: [
                    law.c10, law.c01, law.c20, law.c11, law.c02, law.c30, law.c21, law.c12, law.c03,
                ],
            },
            law.bulk_modulus,
        ),
        Model::Gent(law) => (
            RubberModel::Gent {
                shear_modulus: value(law.shear_modulus),
                limit: value(law.limit),
            },
            law.bulk_modulus,
        ),
        Model::ArrudaBoyce(law) => (
            RubberModel::ArrudaBoyce {
                mu: value(law.mu),
                locking_stretch: value(law.locking_stretch),
            },
            law.bulk_modulus,
        ),
        Model::VanDerWaals(law) => (
            RubberModel::VanDerWaals {
                shear_modulus: value(law.shear_modulus),
                locking_stretch: value(law.locking_stretch),
                a: law.a,
                beta: law.beta,
            },
            law.bulk_modulus,
        ),
        Model::LinearElastic(_) | Model::Stokes(_) | Model::Hyperfoam(_) | Model::BlatzKo(_) => {
            return (None, None);
        }
    };
    (Some(model), bulk_modulus)
}

/// A law by its name in scenes, with constants to begin from.
pub(super) fn by_name(name: &str, terms: usize) -> Option<RubberModel> {
    let one = 1.0;
    Some(match name {
        "neo-hookean" => RubberModel::NeoHookean { shear_modulus: one },
        "mooney-rivlin" => RubberModel::MooneyRivlin { c10: one, c01: 0.0 },
        "yeoh" => RubberModel::Yeoh {
            c10: one,
            c20: 0.0,
            c30: 0.0,
        },
        "ogden" => RubberModel::Ogden {
            mu: vec![one; terms],
            alpha: (1..=terms).map(|term| term as f64 + 0.5).collect(),
        },
        "polynomial" => RubberModel::Polynomial {
            coefficients: [0.0; 9],
        },
        "gent" => RubberModel::Gent {
            shear_modulus: one,
            limit: 100.0,
        },
        "arruda-boyce" => RubberModel::ArrudaBoyce {
            mu: one,
            locking_stretch: 5.0,
        },
        "van-der-waals" => RubberModel::VanDerWaals {
            shear_modulus: one,
            locking_stretch: 10.0,
            a: 0.1,
            beta: 0.0,
        },
        _ => return None,
    })
}

/// Constants of a law by key.
pub(super) fn keys(model: &RubberModel) -> Vec<(&'static str, Vec<f64>)> {
    const COEFFICIENTS: [&str; 9] = [
        "c10", "c01", "c20", "c11", "c02", "c30", "c21", "c12", "c03",
    ];
    match model {
        RubberModel::MooneyRivlin { c10, c01 } => vec![("c10", vec![*c10]), ("c01", vec![*c01])],
        RubberModel::NeoHookean { shear_modulus } | RubberModel::BlatzKo { shear_modulus } => {
            vec![("shear_modulus", vec![*shear_modulus])]
        }
        RubberModel::Yeoh { c10, c20, c30 } => vec![
            ("c10", vec![*c10]),
            ("c20", vec![*c20]),
            ("c30", vec![*c30]),
        ],
        RubberModel::Ogden { mu, alpha } => vec![("mu", mu.clone()), ("alpha", alpha.clone())],
        RubberModel::Polynomial { coefficients } => {
            let named = COEFFICIENTS.into_iter().zip(coefficients);
            let named = named.filter(|(_, value)| **value != 0.0);
            named.map(|(key, value)| (key, vec![*value])).collect()
        }
        RubberModel::Gent {
            shear_modulus,
            limit,
        } => vec![
            ("shear_modulus", vec![*shear_modulus]),
            ("limit", vec![*limit]),
        ],
        RubberModel::ArrudaBoyce {
            mu,
            locking_stretch,
        } => vec![
            ("mu", vec![*mu]),
            ("locking_stretch", vec![*locking_stretch]),
        ],
        RubberModel::VanDerWaals {
            shear_modulus,
            locking_stretch,
            a,
            beta,
        } => vec![
            ("shear_modulus", vec![*shear_modulus]),
            ("locking_stretch", vec![*locking_stretch]),
            ("a", vec![*a]),
            ("beta", vec![*beta]),
        ],
        RubberModel::Hyperfoam { mu, alpha, nu } => vec![
            ("mu", mu.clone()),
            ("alpha", alpha.clone()),
            ("nu", nu.clone()),
        ],
    }
}

/// Whether the constants of a law are lists.
pub(super) fn is_list(model: &RubberModel) -> bool {
    matches!(
        model,
        RubberModel::Ogden { .. } | RubberModel::Hyperfoam { .. }
    )
}
