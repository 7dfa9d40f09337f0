//! What is asked of goals: derivatives and errors.

use signorini_proto::v1;

use super::keys::Keys;

pub(super) fn gradients(scene: &Keys<'_>) -> Vec<v1::Gradient> {
    let tables = scene.tables("gradient", &["of", "to", "at"]);
    let gradient = |keys: &Keys<'_>| v1::Gradient {
        of: keys.required_names("of"),
        to: keys.required_names("to"),
        at: at(keys),
    };
    tables.iter().map(gradient).collect()
}

/// Of which increments of a step something is asked.
const ASKED_AT: &[(&str, v1::AskedAt)] = &[
    ("steps", v1::AskedAt::Steps),
    ("increments", v1::AskedAt::Increments),
];

fn at(keys: &Keys<'_>) -> i32 {
    keys.choice("at", ASKED_AT).unwrap_or_default().into()
}

const ACCURACY: &[&str] = &[
    "bound",
    "at",
    "force",
    "moment",
    "reaction",
    "displacement",
    "strain_energy",
    "max_unknowns",
    "max_memory",
    "max_time",
    "max_rounds",
];

/// What a goal may be of, and whether its axis may be left out.
const KINDS: [(&str, bool); 4] = [
    ("force", true),
    ("moment", false),
    ("reaction", false),
    ("displacement", false),
];

const AXES: &[&str] = &["x", "y", "z"];

pub(super) fn accuracy(scene: &Keys<'_>) -> Option<v1::Accuracy> {
    let keys = scene.table("accuracy", ACCURACY)?;
    let energy = target(&keys, "strain_energy", "strain_energy".to_owned());
    let targets = KINDS.iter().flat_map(|kind| targets(&keys, *kind));
    Some(v1::Accuracy {
        targets: targets.chain(energy).collect(),
        bound: keys.names("bound"),
        at: at(&keys),
        max_unknowns: count(&keys, "max_unknowns"),
        max_memory: count(&keys, "max_memory"),
        max_time: keys.number("max_time"),
        max_rounds: keys.integer("max_rounds"),
    })
}

/// Tolerances of goals of a kind: `force.lid.y = 0.01`, or `force.lid = 0.01` along its motion.
fn targets(keys: &Keys<'_>, (kind, may_lack_axis): (&str, bool)) -> Vec<v1::AccuracyTarget> {
    let Some(outer) = keys.open_table(kind) else {
        return Vec::new();
    };
    let mut all = Vec::new();
    for name in outer.names_of_keys() {
        let own = format!("{kind}.{name}");
        if may_lack_axis && outer.has_number(&name) {
            all.extend(target(&outer, &name, own));
        } else if let Some(axes) = outer.table(&name, AXES) {
            let of_axis = |axis: &&str| target(&axes, axis, format!("{own}.{axis}"));
            all.extend(AXES.iter().filter_map(of_axis));
        }
    }
    all
}

fn target(keys: &Keys<'_>, key: &str, goal: String) -> Option<v1::AccuracyTarget> {
    let tolerance = keys.has(key).then(|| keys.number(key))??;
    if !(tolerance > 0.0 && tolerance.is_finite()) {
        let message = format!("must be above zero, the error over the value, not {tolerance:e}");
        keys.fault(key, message);
    }
    Some(v1::AccuracyTarget { goal, tolerance })
}

/// A number of things that may be written as 2e6.
fn count(keys: &Keys<'_>, key: &str) -> Option<i64> {
    /// Doubles up to this one are exact.
    const MOST: f64 = 9e15;
    let number = keys.number(key)?;
    if !(1.0..=MOST).contains(&number) {
        keys.fault(
            key,
            format!("must lie between 1 and {MOST:e}, not {number:e}"),
        );
        return None;
    }
    Some(number as i64)
}
