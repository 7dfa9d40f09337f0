//! Scene files of `tests/families` as scenes of the library: the keys that they use, and
//! no others.

use std::sync::Arc;

use signorini::scene::{
    Formulation, Material, MaterialModel, Modulus, Obstacle, ObstacleTarget, RubberModel, Shape,
    Support,
};
use signorini::{Mesh, Scene, Step};
use toml::{Table, Value};

use super::meshes::{mesh, parts_of};
use super::scenes::support;

/// The scene `tests/families/NAME.toml`, its steps and its mesh.
pub(crate) fn family(name: &str) -> (Scene, Vec<Step>, Arc<Mesh>) {
    let folder = format!("{}/tests/families", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(format!("{folder}/{name}.toml"));
    let table: Table = text.expect("a scene file").parse().expect("valid TOML");
    let materials = table["material"].as_table().expect("a table");
    let scene = Scene {
        name: name.to_owned(),
        materials: materials.iter().map(material).collect(),
        supports: rows(&table, "support").map(held).collect(),
        obstacles: rows(&table, "obstacle").map(obstacle).collect(),
        ..Scene::default()
    };
    let steps = rows(&table, "step").map(step).collect();
    let mesh = mesh(parts_of(&format!("{folder}/{}", text_of(&table, "mesh"))));
    (scene, steps, mesh)
}

/// The tables of an array of tables.
fn rows<'a>(table: &'a Table, key: &str) -> impl Iterator<Item = &'a Table> {
    let rows = table.get(key).and_then(Value::as_array);
    rows.into_iter()
        .flatten()
        .map(|row| row.as_table().expect("a table"))
}

fn text_of<'a>(table: &'a Table, key: &str) -> &'a str {
    table[key].as_str().expect("a text")
}

fn number(table: &Table, key: &str) -> f64 {
    table[key].as_float().expect("a number")
}

fn vector(value: &Value) -> [f64; 3] {
    let values = value.as_array().expect("an array");
    std::array::from_fn(|i| values[i].as_float().expect("a number"))
}

/// Named components; none where there is no table.
fn components(table: Option<&Value>) -> [Option<f64>; 3] {
    ["x", "y", "z"].map(|axis| table?.get(axis)?.as_float())
}

fn material((group, value): (&String, &Value)) -> Material {
    let table = value.as_table().expect("a table");
    let bulk_modulus = table.get("bulk_modulus").and_then(Value::as_float);
    let rubber = |model| MaterialModel::Rubber {
        model,
        bulk_modulus,
        formulation: Formulation::Auto,
    };
    let model = match text_of(table, "model") {
        "neo-hookean" => rubber(RubberModel::NeoHookean {
            shear_modulus: number(table, "shear_modulus"),
        }),
        "mooney-rivlin" => rubber(RubberModel::MooneyRivlin {
            c10: number(table, "c10"),
            c01: number(table, "c01"),
        }),
        "linear-elastic" => MaterialModel::LinearElastic {
            modulus: Modulus::Shear(number(table, "shear_modulus")),
            poisson_ratio: number(table, "poisson_ratio"),
            formulation: Formulation::Auto,
        },
        other => panic!("no material model `{other}` in the families"),
    };
    Material {
        group: group.clone(),
        model,
    }
}

fn held(table: &Table) -> Support {
    let values = table["displacement"].as_table().expect("a table");
    let value = |axis: &str| values.get(axis).and_then(Value::as_float);
    support(text_of(table, "on"), ["x", "y", "z"].map(value))
}

fn obstacle(table: &Table) -> Obstacle {
    let shape = shape(table["shape"].as_table().expect("a table"));
    super::scenes::obstacle(text_of(table, "name"), text_of(table, "on"), shape)
}

fn shape(table: &Table) -> Shape {
    match text_of(table, "kind") {
        "half-space" => Shape::HalfSpace {
            point: vector(&table["point"]),
            normal: vector(&table["normal"]),
        },
        "sphere" => Shape::Sphere {
            centre: vector(&table["centre"]),
            radius: number(table, "radius"),
        },
        "cylinder" => Shape::Cylinder {
            point: vector(&table["point"]),
            axis: vector(&table["axis"]),
            radius: number(table, "radius"),
        },
        other => panic!("no shape `{other}` in the families"),
    }
}

fn step(table: &Table) -> Step {
    let increments = table["increments"].as_integer().expect("a count");
    let obstacles = table.get("obstacle").and_then(Value::as_table);
    let target = |(name, value): (&String, &Value)| ObstacleTarget {
        name: name.clone(),
        translation: value.get("translation").map(vector),
        force: components(value.get("force")),
        ..ObstacleTarget::default()
    };
    Step {
        increments: u32::try_from(increments).expect("a small count"),
        obstacles: obstacles.into_iter().flatten().map(target).collect(),
        ..Step::default()
    }
}
