//! Shapes of obstacles.

use std::sync::Arc;

use signorini::obstacle::surface::{Interpolation, SurfaceShape};
use signorini::scene::{Shape, SurfaceGeometry};
use signorini_proto::v1 as wire;

use super::Faults;
use super::uploaded::{Surface, SurfacesByName};

/// Angle between facets beyond which their edge is a feature, degrees.
const FEATURE_ANGLE: f64 = 30.0;
/// Largest distance of corners that a client takes as one, over the diagonal of their box.
const MOST_WELD: f64 = 0.01;

/// Converts a shape; `path` is its key, such as `obstacle.ball.shape`.
pub(crate) fn shape(
    message: Option<wire::Shape>,
    path: &str,
    (surfaces, faults): (&SurfacesByName, &mut Faults),
) -> Shape {
    let message = message.unwrap_or_default();
    let of = solid(message.kind, path, (surfaces, faults));
    if message.inside {
        Shape::Cavity(of.into())
    } else {
        of
    }
}

/// Converts a shape seen from outside.
fn solid(
    kind: Option<wire::shape::Kind>,
    path: &str,
    (surfaces, faults): (&SurfacesByName, &mut Faults),
) -> Shape {
    use wire::shape::Kind;
    let rounding = |rounding: Option<f64>| rounding.unwrap_or_default();
    match kind {
        Some(Kind::HalfSpace(shape)) => Shape::HalfSpace {
            point: faults.vector(&shape.point, &format!("{path}.point")),
            normal: faults.vector(&shape.normal, &format!("{path}.normal")),
        },
        Some(Kind::Sphere(shape)) => Shape::Sphere {
            centre: faults.vector(&shape.centre, &format!("{path}.centre")),
            radius: faults.required(shape.radius, &format!("{path}.radius")),
        },
        Some(Kind::Cylinder(shape)) => Shape::Cylinder {
            point: faults.vector(&shape.point, &format!("{path}.point")),
            axis: faults.vector(&shape.axis, &format!("{path}.axis")),
            radius: faults.required(shape.radius, &format!("{path}.radius")),
        },
        Some(Kind::CappedCylinder(shape)) => Shape::CappedCylinder {
            from: faults.vector(&shape.from, &format!("{path}.from")),
            to: faults.vector(&shape.to, &format!("{path}.to")),
            radius: faults.required(shape.radius, &format!("{path}.radius")),
            rounding: rounding(shape.rounding),
        },
        Some(Kind::Box(shape)) => Shape::Box {
            centre: faults.vector(&shape.centre, &format!("{path}.centre")),
            half_sizes: faults.vector(&shape.half_sizes, &format!("{path}.half_sizes")),
            rounding: rounding(shape.rounding),
        },
        Some(Kind::Torus(shape)) => Shape::Torus {
            centre: faults.vector(&shape.centre, &format!("{path}.centre")),
            axis: faults.vector(&shape.axis, &format!("{path}.axis")),
            radius: faults.required(shape.radius, &format!("{path}.radius")),
            tube_radius: faults.required(shape.tube_radius, &format!("{path}.tube_radius")),
        },
        Some(Kind::Cone(shape)) => Shape::Cone {
            apex: faults.vector(&shape.apex, &format!("{path}.apex")),
            axis: faults.vector(&shape.axis, &format!("{path}.axis")),
            angle: faults.required(shape.angle, &format!("{path}.angle")),
            rounding: rounding(shape.rounding),
        },
        Some(Kind::Surface(shape)) => {
            let between = match (shape.facets, shape.feature_angle) {
                (true, _) => Interpolation::Facets,
                (false, angle) => {
                    Interpolation::Patches(angle.unwrap_or(FEATURE_ANGLE).to_radians())
                }
            };
            if shape
                .weld
                .is_some_and(|weld| !(0.0..=MOST_WELD).contains(&weld))
            {
                faults.add(
                    format!("{path}.weld"),
                    format!("must lie from 0 to {MOST_WELD}"),
                );
            }
            match surfaces.get(&shape.surface) {
                Some(Surface::Triangulated(surface)) => Shape::Surface(SurfaceShape {
                    surface: Arc::clone(surface),
                    scale: shape.scale.unwrap_or(1.0),
                    between,
                }),
                other => missing(other, "triangulated surface", (path, faults)),
            }
        }
        Some(Kind::HeightField(shape)) => match surfaces.get(&shape.grid) {
            Some(Surface::Heights(grid)) => Shape::HeightField(Arc::clone(grid)),
            other => missing(other, "grid of heights, with two axes", (path, faults)),
        },
        Some(Kind::DistanceGrid(shape)) => match surfaces.get(&shape.grid) {
            Some(Surface::Distances(grid)) => Shape::DistanceGrid(Arc::clone(grid)),
            other => missing(other, "grid of distances, with three axes", (path, faults)),
        },
        None => {
            faults.add(format!("{path}.kind"), "is required");
            placeholder()
        }
    }
}

/// Stands for a shape whose fault is noted already.
fn placeholder() -> Shape {
    Shape::Sphere {
        centre: [0.0; 3],
        radius: 1.0,
    }
}

/// Notes that an uploaded surface is not there, or not what a shape needs.
fn missing(found: Option<&Surface>, needed: &str, (path, faults): (&str, &mut Faults)) -> Shape {
    let text = match found {
        Some(_) => format!("names no {needed}, but another kind of surface"),
        None => "names no uploaded surface".to_owned(),
    };
    faults.add(format!("{path}.file"), text);
    placeholder()
}

/// Which surface of the body meets an obstacle.
pub(super) fn surface(number: i32, path: &str, faults: &mut Faults) -> SurfaceGeometry {
    match wire::SurfaceGeometry::try_from(number) {
        Ok(wire::SurfaceGeometry::Unspecified | wire::SurfaceGeometry::AsMeshed) => {
            SurfaceGeometry::AsMeshed
        }
        Ok(wire::SurfaceGeometry::Smooth) => SurfaceGeometry::Smooth,
        Err(_) => {
            faults.later(
                format!("{path}.surface"),
                format!("number {number} is not known here"),
            );
            SurfaceGeometry::AsMeshed
        }
    }
}
