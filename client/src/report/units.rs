//! What the quantities of a scene are measured in, as the scene calls it. Nothing is
//! converted: the names stand beside the numbers.

use std::collections::BTreeMap;

use signorini_proto::v1;

const LENGTHS: [&str; 4] = ["Points", "displacement", "gap", "slip"];
const STRESSES: [&str; 8] = [
    "pressure",
    "contact_pressure",
    "contact_pressure_deformed",
    "contact_pressure_undeformed",
    "friction_traction",
    "stress",
    "von_mises",
    "principal_stresses",
];
const FORCES: [&str; 1] = ["nodal_force"];

/// Names of units by the arrays of the files for ParaView; only those that are named. What is
/// called displacement is the velocity of a flow, whose unit no scene names.
pub(crate) fn of_arrays(scene: &v1::Scene) -> BTreeMap<String, String> {
    let Some(units) = &scene.units else {
        return BTreeMap::new();
    };
    let all = [
        (&LENGTHS[..], &units.length),
        (&STRESSES, &units.stress),
        (&FORCES, &units.force),
    ];
    let pairs = all.into_iter().flat_map(|(arrays, unit)| {
        let named = arrays.iter().filter(|_| !unit.is_empty());
        named.map(move |array| ((*array).to_owned(), unit.clone()))
    });
    let mut pairs: BTreeMap<String, String> = pairs.collect();
    if scene.materials.iter().any(is_flow) {
        pairs.remove("displacement");
    }
    pairs
}

fn is_flow(material: &v1::Material) -> bool {
    matches!(material.model, Some(v1::material::Model::Stokes(_)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(model: v1::material::Model) -> v1::Scene {
        let material = v1::Material {
            model: Some(model),
            ..Default::default()
        };
        v1::Scene {
            materials: vec![material],
            units: Some(v1::UnitNames {
                length: "mm".to_owned(),
                force: String::new(),
                stress: "MPa".to_owned(),
            }),
            ..Default::default()
        }
    }

    #[test]
    fn arrays_have_the_units_that_the_scene_names() {
        let solid = scene(v1::material::Model::LinearElastic(Default::default()));
        let units = of_arrays(&solid);
        assert_eq!(units["displacement"], "mm");
        assert_eq!(units["von_mises"], "MPa");
        for none in ["nodal_force", "jacobian", "contact_state", "lowest_mode"] {
            assert!(!units.contains_key(none), "{none}");
        }
        assert!(of_arrays(&v1::Scene::default()).is_empty());
    }

    #[test]
    fn the_velocity_of_a_flow_is_no_length() {
        let flow = scene(v1::material::Model::Stokes(Default::default()));
        let units = of_arrays(&flow);
        assert!(!units.contains_key("displacement"));
        assert_eq!(units["Points"], "mm");
    }
}
