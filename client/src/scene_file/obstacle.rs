//! Obstacles: what they stand on and what shape they have. Contacts and ties between bodies.

use signorini_proto::v1;

use super::body::name_of;
use super::keys::Keys;
use super::shape::shape;

/// Words for the surface of the body.
const SURFACES: &[(&str, v1::SurfaceGeometry)] = &[
    ("as-meshed", v1::SurfaceGeometry::AsMeshed),
    ("smooth", v1::SurfaceGeometry::Smooth),
];

/// Words for what follows where a tool begins inside the body.
const PENETRATIONS: &[(&str, v1::InitialPenetration)] = &[
    ("resolve", v1::InitialPenetration::Resolve),
    ("reject", v1::InitialPenetration::Reject),
];

/// Contacts between bodies.
pub(super) fn contacts(scene: &Keys<'_>) -> Vec<v1::BodyContact> {
    let tables = scene.tables(
        "contact",
        &["name", "between", "self", "carries", "friction", "tresca"],
    );
    let contact = |(index, keys): (usize, &Keys<'_>)| v1::BodyContact {
        name: name_of(keys, "contact", index),
        between: keys.required_names("between"),
        carries: keys.text("carries").unwrap_or_default(),
        friction: keys.number("friction"),
        tresca: keys.number("tresca"),
        itself: keys.boolean("self").unwrap_or_default(),
    };
    tables.iter().enumerate().map(contact).collect()
}

/// Ties between bodies.
pub(super) fn ties(scene: &Keys<'_>) -> Vec<v1::Tie> {
    let tables = scene.tables("tie", &["name", "between", "carries"]);
    let tie = |(index, keys): (usize, &Keys<'_>)| v1::Tie {
        name: name_of(keys, "tie", index),
        between: keys.required_names("between"),
        carries: keys.text("carries").unwrap_or_default(),
    };
    tables.iter().enumerate().map(tie).collect()
}

pub(super) fn obstacles(scene: &Keys<'_>) -> Vec<v1::Obstacle> {
    let tables = scene.tables(
        "obstacle",
        &[
            "name",
            "on",
            "shape",
            "friction",
            "tresca",
            "surface",
            "initial_penetration",
        ],
    );
    let obstacle = |(index, keys): (usize, &Keys<'_>)| v1::Obstacle {
        name: name_of(keys, "obstacle", index),
        on: keys.required_names("on"),
        shape: keys.required_open_table("shape").map(|keys| shape(&keys)),
        friction: keys.number("friction"),
        tresca: keys.number("tresca"),
        surface: keys.choice("surface", SURFACES).unwrap_or_default().into(),
        initial_penetration: keys
            .choice("initial_penetration", PENETRATIONS)
            .unwrap_or_default()
            .into(),
    };
    tables.iter().enumerate().map(obstacle).collect()
}
