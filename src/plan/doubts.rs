//! What a mechanic would doubt in a scene before anything is solved, in sentences:
//!
//! | doubt | found by |
//! |---|---|
//! | flat cells | the least mean ratio of a cell |
//! | contrast | the stiffest over the softest shear modulus |
//! | nearly incompressible | the first Lame parameter over the shear modulus |
//! | unstable law | where the energy of a rubber is convex no more |
//! | far away | the largest coordinate over the length of the body |
//! | tool below the mesh | the radius of an obstacle beside the edges that may touch it |
//! | edges below the mesh | the radius of an obstacle's edges or tip beside the same |
//! | on the wrong side | the same of an obstacle without a bound ([`super::behind`]) |
//! | begins inside | distances of the vertices that an obstacle may touch, in its first pose |
//! | facets left out | those of a surface that have no area or are there twice |
//! | long way | the travel of a step over the length of the body |
//!
//! Cost: one pass over materials and facets, one distance a vertex that may be touched
//! ([`super::overlap`]).

use super::Units;
use super::behind::behind;
use super::overlap::{DEEP, overlap};
use super::problem::Problem;
use super::units::ScaledMesh;
use crate::material::stability::unstable;
use crate::mesh::Mesh;
use crate::scene::validate::{Resolved, ResolvedMaterial, ResolvedObstacle};
use crate::scene::{Material, Obstacle, Scene, Shape, Step};

/// Mean ratio below which a cell is flat: sides of about 1 : 12 in the plane, 1 : 20 in space.
const FLAT: f64 = 0.15;
/// Shear moduli side by side beyond which digits of the softer body are at stake.
const CONTRAST: f64 = 1e5;
/// Lame parameter over shear modulus from which on exact incompressibility says the same.
const NEARLY_INCOMPRESSIBLE: f64 = 1e5;

/// Largest coordinate over the length of the body beyond which its shape loses digits that
/// contact needs.
const FAR: f64 = 1e6;
/// Lengths of the body beyond which a travel is more likely in another unit.
const LONG_WAY: f64 = 10.0;

/// All doubts about a problem and its steps on a mesh.
pub(super) fn doubts(problem: &Problem, steps: &[Step], mesh: &Mesh) -> Vec<String> {
    let Problem {
        scene,
        resolved,
        obstacles,
        units,
        ..
    } = problem;
    let body = ScaledMesh { mesh, units };
    let mut all: Vec<String> = Vec::new();
    all.extend(flat_cells(mesh));
    all.extend(far_away(mesh, units));
    all.extend(contrast(scene, resolved));
    all.extend(nearly_incompressible(scene, resolved));
    all.extend(unstable_laws(scene, resolved));
    let sharp = |one| below_the_mesh(one, body).or_else(|| edges(one, body));
    all.extend(obstacles.iter().filter_map(sharp));
    let inside = |one: (&Obstacle, &ResolvedObstacle)| match behind(one, steps, body) {
        Some(found) => Some(found.message),
        None => begins_inside(one.1, body),
    };
    all.extend(scene.obstacles.iter().zip(obstacles).filter_map(inside));
    all.extend(scene.obstacles.iter().filter_map(left_out));
    all.extend(long_way(steps, units));
    all
}

/// Facets of a tool that bound nothing.
fn left_out(obstacle: &Obstacle) -> Option<String> {
    let Shape::Surface(shape) = &obstacle.shape else {
        return None;
    };
    let left_out = shape.surface.left_out()?;
    Some(format!(
        "{} facets of the surface of obstacle `{}` have no area or are there twice, the first is facet {}: they are left out",
        left_out.facets, obstacle.name, left_out.first
    ))
}

/// An obstacle that lies in the body before anything has moved.
fn begins_inside(obstacle: &ResolvedObstacle, body: ScaledMesh<'_>) -> Option<String> {
    overlap(obstacle, DEEP, body)
        .map(|found| format!("{found}: the first increment pushes the body out of it"))
}

/// A step in which an obstacle travels farther than any body is thick.
fn long_way(steps: &[Step], units: &Units) -> Option<String> {
    let targets = steps.iter().flat_map(|step| &step.obstacles);
    let far = targets.filter_map(|target| {
        let way = target
            .translation?
            .iter()
            .map(|x| x * x)
            .sum::<f64>()
            .sqrt()
            / units.length;
        (way > LONG_WAY).then_some((target, way))
    });
    let (target, way) = far.max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(format!(
        "obstacle `{}` travels {way:.0} lengths of the body: is the step in the units of the mesh?",
        target.name
    ))
}

/// Cells that are nearly flat.
fn flat_cells(mesh: &Mesh) -> Option<String> {
    let quality = mesh.quality();
    (quality.minimum < FLAT).then(|| {
        format!(
            "cell {} is nearly flat: mean ratio {:.1e}, one where it is regular; iterations and errors grow",
            quality.worst_cell, quality.minimum
        )
    })
}

/// A body so far from the origin that coordinates round its shape.
fn far_away(mesh: &Mesh, units: &Units) -> Option<String> {
    let coordinates = mesh.coordinates().as_flattened().iter();
    let largest = coordinates.fold(0.0_f64, |most, x| most.max(x.abs()));
    let ratio = largest / units.length;
    (ratio > FAR).then(|| {
        let rounding = f64::EPSILON * ratio;
        format!(
            "the body lies {ratio:.0e} of its lengths away from the origin: rounding of coordinates is {rounding:.0e} of its size; move it and its obstacles to the origin"
        )
    })
}

/// Bodies of very different stiffness.
fn contrast(scene: &Scene, resolved: &Resolved) -> Option<String> {
    let shear = |&index: &usize| resolved.materials[index].law.shear_modulus;
    let by_shear = |a: &usize, b: &usize| shear(a).total_cmp(&shear(b));
    let softest = (0..resolved.materials.len()).min_by(by_shear)?;
    let stiffest = (0..resolved.materials.len()).max_by(by_shear)?;
    let ratio = shear(&stiffest) / shear(&softest);
    (ratio > CONTRAST).then(|| {
        format!(
            "material `{}` is {ratio:.0e} times as stiff as `{}`: an obstacle and supports say the same of a rigid part",
            scene.materials[stiffest].group, scene.materials[softest].group
        )
    })
}

/// Materials whose volume changes by less than anybody asks for.
fn nearly_incompressible(scene: &Scene, resolved: &Resolved) -> Option<String> {
    let is_nearly = |law: &crate::material::LinearElastic| {
        law.lame().is_finite() && law.lame() > NEARLY_INCOMPRESSIBLE * law.shear_modulus
    };
    let mut materials = scene.materials.iter().zip(&resolved.materials);
    let (material, found) = materials
        .find(|(_, resolved)| !resolved.is_incompressible() && is_nearly(&resolved.law))?;
    let ratio = found.law.lame() / found.law.shear_modulus;
    let cure = if found.is_foam() {
        "`ogden` without `bulk_modulus`"
    } else if material.model.is_rubber() {
        "no `bulk_modulus`"
    } else {
        "0.5 as `poisson_ratio`"
    };
    Some(format!(
        "material `{}` resists a change of volume {ratio:.0e} times as much as one of shape: unless it is closed in on all sides, {cure} costs less and differs by as little",
        material.group
    ))
}

/// Laws of rubber that soften somewhere, of materials that are given as rubber.
fn unstable_laws(scene: &Scene, resolved: &Resolved) -> Vec<String> {
    let materials = scene.materials.iter().zip(&resolved.materials);
    let rubbers = materials.filter(|(material, _)| material.model.is_rubber());
    let doubt = |(material, resolved): (&Material, &ResolvedMaterial)| {
        let found = unstable(&resolved.rubber.as_ref()?.isochoric);
        let ways = found
            .iter()
            .map(|one| format!("in {} beyond a stretch of {:.2}", one.way, one.stretch));
        let ways: Vec<String> = ways.collect();
        (!ways.is_empty()).then(|| {
            format!(
                "the law of material `{}` is unstable {}: bodies that reach that soften and may have no equilibrium",
                material.group,
                ways.join(", ")
            )
        })
    };
    rubbers.filter_map(doubt).collect()
}

/// A round obstacle that fits between the vertices of the mesh.
fn below_the_mesh(obstacle: &ResolvedObstacle, body: ScaledMesh<'_>) -> Option<String> {
    let inner = obstacle.shape.inner_ball()?.radius * body.units.length;
    let shortest = finest_face(obstacle, body);
    (inner < shortest && shortest.is_finite()).then(|| {
        format!(
            "obstacle `{}` has a radius of {inner:.3}, all edges that may touch it are longer, from {shortest:.3} on: a finer mesh sees more of its contact",
            obstacle.name
        )
    })
}

/// An obstacle whose edges or tip are sharper than the faces that may touch it resolve.
fn edges(obstacle: &ResolvedObstacle, body: ScaledMesh<'_>) -> Option<String> {
    let inner = (obstacle.shape.inner_ball()).map_or(f64::INFINITY, |ball| ball.radius);
    let sharpest = obstacle
        .shape
        .sharpest_radius()
        .filter(|one| *one < inner)?
        * body.units.length;
    let shortest = finest_face(obstacle, body);
    (sharpest < shortest && shortest.is_finite()).then(|| {
        format!(
            "obstacle `{}` has edges or a tip of radius {sharpest:.3}, below the edges that may touch it, from {shortest:.3} on: where they touch, pressures are those of the mesh",
            obstacle.name
        )
    })
}

/// Longest edge of the finest face that may touch an obstacle, which is where it is meant to, in
/// the caller's lengths.
pub(super) fn finest_face(
    obstacle: &ResolvedObstacle,
    ScaledMesh { mesh, units }: ScaledMesh<'_>,
) -> f64 {
    let longest = |&facet: &u32| longest_edge(mesh, facet as usize);
    let finest = (obstacle.facets.iter().map(longest)).fold(f64::INFINITY, f64::min);
    finest * units.coordinate_scale * units.length
}

/// Length of the longest edge of an uploaded facet.
fn longest_edge(mesh: &Mesh, facet: usize) -> f64 {
    let points = mesh
        .facet(facet)
        .iter()
        .map(|&vertex| mesh.coordinates()[vertex as usize]);
    let points: Vec<[f64; 3]> = points.collect();
    let square = |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>();
    let pairs = points
        .iter()
        .flat_map(|a| points.iter().map(move |b| square(a, b)));
    pairs.fold(0.0, f64::max).sqrt()
}
