//! Material messages into the library's laws.

use signorini::scene::{Formulation, Material, MaterialModel, Modulus, RubberModel};
use signorini_proto::v1 as wire;
use signorini_proto::v1::material::Model;

use super::Faults;

const MAXIMUM_TERMS: usize = 3;
const MAXIMUM_FOAM_TERMS: usize = 6;

/// Converts one material.
pub(super) fn material(message: wire::Material, faults: &mut Faults) -> Material {
    let path = format!("material.{}", faults.name(&message.group, "material"));
    let formulation = formulation(message.formulation, &path, faults);
    let model = match message.model {
        Some(law) => model(law, formulation, &path, faults),
        None => {
            faults.add(format!("{path}.model"), "is required");
            placeholder()
        }
    };
    Material {
        group: message.group,
        model,
    }
}

fn model(law: Model, formulation: Formulation, path: &str, faults: &mut Faults) -> MaterialModel {
    let rubber = |model, bulk_modulus| MaterialModel::Rubber {
        model,
        bulk_modulus,
        formulation,
    };
    match law {
        Model::LinearElastic(law) => MaterialModel::LinearElastic {
            modulus: modulus(law.modulus, path, faults),
            poisson_ratio: faults.required(law.poisson_ratio, &format!("{path}.poisson_ratio")),
            formulation,
        },
        Model::Stokes(law) => MaterialModel::Stokes {
            viscosity: faults.required(law.viscosity, &format!("{path}.viscosity")),
            formulation,
        },
        Model::MooneyRivlin(law) => rubber(mooney_rivlin(&law, path, faults), law.bulk_modulus),
        Model::NeoHookean(law) => rubber(neo_hookean(&law, path, faults), law.bulk_modulus),
        Model::Yeoh(law) => rubber(yeoh(&law, path, faults), law.bulk_modulus),
        Model::Ogden(law) => {
            let bulk_modulus = law.bulk_modulus;
            rubber(ogden(law, path, faults), bulk_modulus)
        }
        Model::Polynomial(law) => rubber(polynomial(&law), law.bulk_modulus),
        Model::Gent(law) => rubber(gent(&law, path, faults), law.bulk_modulus),
        Model::ArrudaBoyce(law) => rubber(arruda_boyce(&law, path, faults), law.bulk_modulus),
        Model::VanDerWaals(law) => rubber(van_der_waals(&law, path, faults), law.bulk_modulus),
        Model::Hyperfoam(law) => rubber(hyperfoam(law, path, faults), None),
        Model::BlatzKo(law) => rubber(blatz_ko(&law, path, faults), None),
    }
}

fn mooney_rivlin(law: &wire::MooneyRivlin, path: &str, faults: &mut Faults) -> RubberModel {
    RubberModel::MooneyRivlin {
        c10: faults.required(law.c10, &format!("{path}.c10")),
        c01: faults.required(law.c01, &format!("{path}.c01")),
    }
}

fn neo_hookean(law: &wire::NeoHookean, path: &str, faults: &mut Faults) -> RubberModel {
    RubberModel::NeoHookean {
        shear_modulus: faults.required(law.shear_modulus, &format!("{path}.shear_modulus")),
    }
}

fn yeoh(law: &wire::Yeoh, path: &str, faults: &mut Faults) -> RubberModel {
    RubberModel::Yeoh {
        c10: faults.required(law.c10, &format!("{path}.c10")),
        c20: faults.required(law.c20, &format!("{path}.c20")),
        c30: faults.required(law.c30, &format!("{path}.c30")),
    }
}

fn ogden(law: wire::Ogden, path: &str, faults: &mut Faults) -> RubberModel {
    faults.at_most(&law.mu, MAXIMUM_TERMS, &format!("{path}.mu"));
    faults.at_most(&law.alpha, MAXIMUM_TERMS, &format!("{path}.alpha"));
    RubberModel::Ogden {
        mu: law.mu,
        alpha: law.alpha,
    }
}

fn polynomial(law: &wire::Polynomial) -> RubberModel {
    RubberModel::Polynomial {
        coefficients: [
            law.c10, law.c01, law.c20, law.c11, law.c02, law.c30, law.c21, law.c12, law.c03,
        ],
    }
}

fn gent(law: &wire::Gent, path: &str, faults: &mut Faults) -> RubberModel {
    RubberModel::Gent {
        shear_modulus: faults.required(law.shear_modulus, &format!("{path}.shear_modulus")),
        limit: faults.required(law.limit, &format!("{path}.limit")),
    }
}

fn arruda_boyce(law: &wire::ArrudaBoyce, path: &str, faults: &mut Faults) -> RubberModel {
    RubberModel::ArrudaBoyce {
        mu: faults.required(law.mu, &format!("{path}.mu")),
        locking_stretch: faults.required(law.locking_stretch, &format!("{path}.locking_stretch")),
    }
}

fn van_der_waals(law: &wire::VanDerWaals, path: &str, faults: &mut Faults) -> RubberModel {
    RubberModel::VanDerWaals {
        shear_modulus: faults.required(law.shear_modulus, &format!("{path}.shear_modulus")),
        locking_stretch: faults.required(law.locking_stretch, &format!("{path}.locking_stretch")),
        a: law.a,
        beta: law.beta,
    }
}

fn hyperfoam(law: wire::Hyperfoam, path: &str, faults: &mut Faults) -> RubberModel {
    let lists = [("mu", &law.mu), ("alpha", &law.alpha), ("nu", &law.nu)];
    for (key, list) in lists {
        faults.at_most(list, MAXIMUM_FOAM_TERMS, &format!("{path}.{key}"));
    }
    RubberModel::Hyperfoam {
        mu: law.mu,
        alpha: law.alpha,
        nu: law.nu,
    }
}

fn blatz_ko(law: &wire::BlatzKo, path: &str, faults: &mut Faults) -> RubberModel {
    RubberModel::BlatzKo {
        shear_modulus: faults.required(law.shear_modulus, &format!("{path}.shear_modulus")),
    }
}

/// Stands for a law whose fault is noted already.
fn placeholder() -> MaterialModel {
    MaterialModel::LinearElastic {
        modulus: Modulus::Shear(1.0),
        poisson_ratio: 0.0,
        formulation: Formulation::Auto,
    }
}

fn modulus(
    value: Option<wire::linear_elastic::Modulus>,
    path: &str,
    faults: &mut Faults,
) -> Modulus {
    match value {
        Some(wire::linear_elastic::Modulus::ShearModulus(value)) => Modulus::Shear(value),
        Some(wire::linear_elastic::Modulus::YoungModulus(value)) => Modulus::Young(value),
        None => {
            faults.add(path, "needs `shear_modulus` or `young_modulus`");
            Modulus::Shear(1.0)
        }
    }
}

fn formulation(number: i32, path: &str, faults: &mut Faults) -> Formulation {
    match wire::Formulation::try_from(number) {
        Ok(wire::Formulation::Unspecified) => Formulation::Auto,
        Ok(wire::Formulation::Mixed) => Formulation::Mixed,
        Ok(wire::Formulation::Displacement) => Formulation::Displacement,
        Err(_) => {
            faults.later(
                format!("{path}.formulation"),
                format!("number {number} is not known here"),
            );
            Formulation::Auto
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn convert(model: Model) -> (MaterialModel, Faults) {
        let message = wire::Material {
            group: "body".into(),
            model: Some(model),
            ..Default::default()
        };
        let mut faults = Faults::default();
        (material(message, &mut faults).model, faults)
    }

    #[test]
    fn every_rubber_reaches_the_library_with_its_coefficients() {
        let bulk_modulus = Some(9.0);
        let cases = [
            (
                Model::MooneyRivlin(wire::MooneyRivlin {
                    c10: Some(0.4),
                    c01: Some(-0.1),
                    bulk_modulus,
                }),
                RubberModel::MooneyRivlin {
                    c10: 0.4,
                    c01: -0.1,
                },
            ),
            (
                Model::NeoHookean(wire::NeoHookean {
                    shear_modulus: Some(0.8),
                    bulk_modulus,
                }),
                RubberModel::NeoHookean { shear_modulus: 0.8 },
            ),
            (
                Model::Yeoh(wire::Yeoh {
                    c10: Some(0.4),
                    c20: Some(0.2),
                    c30: Some(0.1),
                    bulk_modulus,
                }),
                RubberModel::Yeoh {
                    c10: 0.4,
                    c20: 0.2,
                    c30: 0.1,
                },
            ),
            (
                Model::Ogden(wire::Ogden {
                    mu: vec![1.0, 0.5],
                    alpha: vec![2.0, -2.0],
                    bulk_modulus,
                }),
                RubberModel::Ogden {
                    mu: vec![1.0, 0.5],
                    alpha: vec![2.0, -2.0],
                },
            ),
        ];
        let others = [
            (
                Model::Polynomial(wire::Polynomial {
                    c10: 1.0,
                    c01: 2.0,
                    c20: 3.0,
                    c11: 4.0,
                    c02: 5.0,
                    c30: 6.0,
                    c21: 7.0,
                    c12: 8.0,
                    c03: 9.0,
                    bulk_modulus,
                }),
                RubberModel::Polynomial {
                    coefficients: [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0],
                },
            ),
            (
                Model::Gent(wire::Gent {
                    shear_modulus: Some(0.8),
                    limit: Some(30.0),
                    bulk_modulus,
                }),
                RubberModel::Gent {
                    shear_modulus: 0.8,
                    limit: 30.0,
                },
            ),
            (
                Model::ArrudaBoyce(wire::ArrudaBoyce {
                    mu: Some(0.8),
                    locking_stretch: Some(3.0),
                    bulk_modulus,
                }),
                RubberModel::ArrudaBoyce {
                    mu: 0.8,
                    locking_stretch: 3.0,
                },
            ),
            (
                Model::VanDerWaals(wire::VanDerWaals {
                    shear_modulus: Some(0.8),
                    locking_stretch: Some(5.0),
                    a: 0.2,
                    beta: 0.1,
                    bulk_modulus,
                }),
                RubberModel::VanDerWaals {
                    shear_modulus: 0.8,
                    locking_stretch: 5.0,
                    a: 0.2,
                    beta: 0.1,
                },
            ),
        ];
        for (message, model) in cases.into_iter().chain(others) {
            let (found, faults) = convert(message);
            let formulation = Formulation::Auto;
            let expected = MaterialModel::Rubber {
                model,
                bulk_modulus,
                formulation,
            };
            assert_eq!(found, expected);
            assert_eq!(faults.outcome(), Ok(()));
        }
    }

    #[test]
    fn foams_reach_the_library_with_their_terms() {
        let cases = [
            (
                Model::Hyperfoam(wire::Hyperfoam {
                    mu: vec![1.0, 0.5],
                    alpha: vec![8.0, -2.0],
                    nu: vec![0.1, 0.0],
                }),
                RubberModel::Hyperfoam {
                    mu: vec![1.0, 0.5],
                    alpha: vec![8.0, -2.0],
                    nu: vec![0.1, 0.0],
                },
            ),
            (
                Model::BlatzKo(wire::BlatzKo {
                    shear_modulus: Some(0.8),
                }),
                RubberModel::BlatzKo { shear_modulus: 0.8 },
            ),
        ];
        for (message, model) in cases {
            let (found, faults) = convert(message);
            let expected = MaterialModel::Rubber {
                model,
                bulk_modulus: None,
                formulation: Formulation::Auto,
            };
            assert_eq!(found, expected);
            assert_eq!(faults.outcome(), Ok(()));
        }
    }

    #[test]
    fn coefficients_are_required_and_a_bulk_modulus_is_not() {
        let (found, faults) = convert(Model::Yeoh(wire::Yeoh::default()));
        assert!(matches!(
            found,
            MaterialModel::Rubber {
                bulk_modulus: None,
                ..
            }
        ));
        let Err(crate::fault::Fault::SceneInvalid(all)) = faults.outcome() else {
            panic!("three coefficients are missing");
        };
        let paths: Vec<&str> = all.iter().map(|one| one.path.as_str()).collect();
        let expected = ["c10", "c20", "c30"].map(|key| format!("material.body.{key}"));
        assert_eq!(paths, expected);
    }
}
