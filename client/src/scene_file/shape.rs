//! Shapes of obstacles: their keys in scene files. What they look like is beside it.

use signorini_proto::v1;
use signorini_proto::v1::shape::Kind;

use super::keys::Keys;
use super::suggest::nearest;
use crate::formats::stl::MOST_WELD;

type ReadShape = fn(&Keys<'_>) -> Kind;

/// Each shape: its name, its keys beside `kind` and `inside`, its reader.
const SHAPES: &[(&str, &[&str], ReadShape)] = &[
    ("half-space", &["point", "normal"], half_space),
    ("sphere", &["centre", "radius"], sphere),
    ("cylinder", &["point", "axis", "radius"], cylinder),
    (
        "capped-cylinder",
        &["from", "to", "radius", "rounding"],
        capped_cylinder,
    ),
    ("box", &["centre", "half_sizes", "rounding"], cuboid),
    ("torus", &["centre", "axis", "radius", "tube_radius"], torus),
    ("cone", &["apex", "axis", "angle", "rounding"], cone),
    (
        "surface",
        &["file", "scale", "facets", "feature_angle", "weld"],
        surface,
    ),
    ("height-field", &["file"], height_field),
    ("distance-grid", &["file"], distance_grid),
];

fn unknown_kind(keys: &Keys<'_>, name: &str) {
    let all = SHAPES.iter().map(|(known, _, _)| *known);
    if nearest(name, all.clone()).is_some() {
        return keys.unknown_word("kind", name, all);
    }
    let known: Vec<&str> = all.collect();
    let known = known.join(", ");
    keys.fault(
        "kind",
        format!("\"{name}\" is not known; known are {known}"),
    );
}

/// The shape that `keys` describe.
pub(super) fn shape(keys: &Keys<'_>) -> v1::Shape {
    let name = keys.required_text("kind");
    let found = SHAPES.iter().find(|(known, _, _)| *known == name);
    let Some((_, own, read)) = found else {
        if keys.has("kind") {
            unknown_kind(keys, &name);
        }
        return v1::Shape::default();
    };
    let known: Vec<&str> = ["kind", "inside"]
        .into_iter()
        .chain(own.iter().copied())
        .collect();
    keys.check(&known);
    v1::Shape {
        inside: keys.boolean("inside").unwrap_or_default(),
        kind: Some(read(keys)),
    }
}

fn half_space(keys: &Keys<'_>) -> Kind {
    Kind::HalfSpace(v1::HalfSpace {
        point: keys.required_vector("point"),
        normal: keys.required_vector("normal"),
    })
}

fn sphere(keys: &Keys<'_>) -> Kind {
    Kind::Sphere(v1::Sphere {
        centre: keys.required_vector("centre"),
        radius: keys.required_number("radius"),
    })
}

fn cylinder(keys: &Keys<'_>) -> Kind {
    Kind::Cylinder(v1::Cylinder {
        point: keys.required_vector("point"),
        axis: keys.required_vector("axis"),
        radius: keys.required_number("radius"),
    })
}

fn capped_cylinder(keys: &Keys<'_>) -> Kind {
    Kind::CappedCylinder(v1::CappedCylinder {
        from: keys.required_vector("from"),
        to: keys.required_vector("to"),
        radius: keys.required_number("radius"),
        rounding: keys.number("rounding"),
    })
}

fn cuboid(keys: &Keys<'_>) -> Kind {
    Kind::Box(v1::BoxShape {
        centre: keys.required_vector("centre"),
        half_sizes: keys.required_vector("half_sizes"),
        rounding: keys.number("rounding"),
    })
}

fn torus(keys: &Keys<'_>) -> Kind {
    Kind::Torus(v1::Torus {
        centre: keys.required_vector("centre"),
        axis: keys.required_vector("axis"),
        radius: keys.required_number("radius"),
        tube_radius: keys.required_number("tube_radius"),
    })
}

fn cone(keys: &Keys<'_>) -> Kind {
    Kind::Cone(v1::Cone {
        apex: keys.required_vector("apex"),
        axis: keys.required_vector("axis"),
        angle: keys.required_number("angle"),
        rounding: keys.number("rounding"),
    })
}

fn surface(keys: &Keys<'_>) -> Kind {
    let weld = keys.number("weld");
    if weld.is_some_and(|weld| !(0.0..=MOST_WELD).contains(&weld)) {
        let what = "of the diagonal of the surface's box";
        keys.fault("weld", format!("must lie from 0 to {MOST_WELD} {what}"));
    }
    Kind::Surface(v1::SurfaceShape {
        surface: keys.required_text("file"),
        scale: keys.number("scale"),
        facets: keys.boolean("facets").unwrap_or_default(),
        feature_angle: keys.number("feature_angle"),
        weld,
    })
}

fn height_field(keys: &Keys<'_>) -> Kind {
    let grid = keys.required_text("file");
    Kind::HeightField(v1::HeightField { grid })
}

fn distance_grid(keys: &Keys<'_>) -> Kind {
    let grid = keys.required_text("file");
    Kind::DistanceGrid(v1::DistanceGrid { grid })
}
