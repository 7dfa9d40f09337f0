//! Load steps.

use signorini_proto::v1;

use super::body::{components, values};
use super::fluid;
use super::keys::Keys;

pub(super) fn steps(scene: &Keys<'_>) -> Vec<v1::LoadStep> {
    let tables = scene.tables(
        "step",
        &[
            "increments",
            "load",
            "obstacle",
            "support",
            "traction",
            "fluid",
            "body_force",
        ],
    );
    let step = |keys: &Keys<'_>| v1::LoadStep {
        increments: keys.integer("increments"),
        load: keys.number("load"),
        obstacles: obstacles(keys),
        supports: supports(keys),
        tractions: tractions(keys),
        fluids: fluid::targets(keys),
        body_force: keys
            .table("body_force", &["values"])
            .and_then(|keys| required_values(&keys)),
    };
    tables.iter().map(step).collect()
}

fn obstacles(step: &Keys<'_>) -> Vec<v1::ObstacleTarget> {
    let tables = step.named_tables("obstacle");
    let target = |(name, keys): (String, Keys<'_>)| {
        keys.check(&["translation", "rotation", "force", "moment", "friction"]);
        v1::ObstacleTarget {
            name,
            translation: keys.vector("translation"),
            rotation: keys.vector("rotation"),
            force: components(&keys, "force"),
            moment: components(&keys, "moment"),
            friction: keys.number("friction"),
        }
    };
    tables.into_iter().map(target).collect()
}

fn supports(step: &Keys<'_>) -> Vec<v1::SupportTarget> {
    let tables = step.named_tables("support");
    let target = |(name, keys): (String, Keys<'_>)| {
        keys.check(&[
            "displacement",
            "translation",
            "rotation",
            "about",
            "values",
            "force",
            "moment",
        ]);
        if keys.has("displacement") && (keys.has("translation") || keys.has("rotation")) {
            keys.fault_here("give either displacement, or translation and rotation, not both");
        }
        v1::SupportTarget {
            name,
            displacement: components(&keys, "displacement"),
            translation: keys.vector("translation"),
            rotation: keys.vector("rotation"),
            about: keys.vector("about"),
            values: values(&keys),
            force: components(&keys, "force"),
            moment: components(&keys, "moment"),
        }
    };
    tables.into_iter().map(target).collect()
}

fn tractions(step: &Keys<'_>) -> Vec<v1::TractionTarget> {
    let tables = step.named_tables("traction");
    let target = |(name, keys): (String, Keys<'_>)| {
        keys.check(&["values"]);
        let values = required_values(&keys);
        v1::TractionTarget { name, values }
    };
    tables.into_iter().map(target).collect()
}

fn required_values(keys: &Keys<'_>) -> Option<v1::Values> {
    keys.required_text("values");
    values(keys)
}
