//! Areas of circles and spheres, and surfaces that turn.

use std::f64::consts::TAU;
use std::sync::Arc;

use crate::contact::basis::Bernstein;
use crate::contact::gap::{Deformed, Measure};
use crate::contact::surface::{FACE_DEGREE, face_rule};
use crate::contact::{ContactSurface, linearise};
use crate::geometry::rigid_motion::{multiply, rotation_matrix};
use crate::geometry::vector3::{add, norm, scale, sub};
use crate::mesh::{EdgeOffset, GroupKind, Mesh, MeshParts, samples};
use crate::obstacle::{HalfSpace, Moving, Obstacle, Sphere};
use crate::space::TaylorHood;

const RADIUS: f64 = 2.0;

/// A body whose side lies on the circle or the sphere of [`RADIUS`], with the middles of
/// its edges there.
struct Round {
    mesh: Mesh,
    side: &'static str,
}

impl Round {
    fn new(mut parts: MeshParts, side: &'static str, place: impl Fn([f64; 3]) -> [f64; 3]) -> Self {
        parts.coordinates.iter_mut().for_each(|x| *x = place(*x));
        let straight = Mesh::new(parts.clone()).expect("a valid mesh");
        let on = |x: [f64; 3]| (norm(x) - RADIUS).abs() < 1e-12;
        let edges = straight.edges().iter().filter_map(|&ends| {
            let [a, b] = ends.map(|end| straight.coordinates()[end as usize]);
            let mean = scale(0.5, add(a, b));
            let offset = sub(scale(RADIUS / norm(mean), mean), mean);
            (on(a) && on(b)).then_some(EdgeOffset { ends, offset })
        });
        let mesh = Mesh::second_order(parts, edges.collect()).expect("a valid mesh");
        Self { mesh, side }
    }

    /// Over an eighth of the turn, unequal segments.
    fn arc(count: usize) -> Self {
        Self::new(samples::rectangle_parts(count, 1), "y0", |[x, y, _]| {
            let angle = 0.25 * std::f64::consts::PI * (1.0 - x * (0.8 + 0.2 * x));
            let radius = RADIUS - y;
            [radius * angle.sin(), radius * angle.cos(), 0.0]
        })
    }

    /// The directions (x, y, 1) of the unit square.
    fn patch(count: usize) -> Self {
        Self::new(samples::cube_parts(count), "z1", |[x, y, z]| {
            let direction = [x, y, 1.0];
            scale((1.0 + z) / norm(direction), direction)
        })
    }

    fn facets(&self) -> Vec<Vec<u32>> {
        let group = self.mesh.group(self.side, GroupKind::Facets);
        let members = group.expect("a side").members.iter();
        members
            .map(|&f| self.mesh.facet(f as usize).to_vec())
            .collect()
    }

    /// Error of the sum of all weights.
    fn error(&self, bare: ContactSurface, exact: f64) -> f64 {
        let weights = bare.with_basis(&Bernstein).weights;
        (weights.iter().sum::<f64>() / exact - 1.0).abs()
    }

    /// Not turned about an axis.
    fn flat(&self) -> ContactSurface {
        let space = TaylorHood::new(&self.mesh);
        ContactSurface::new(&self.mesh, &space, 1.0, &self.facets())
    }

    fn turned(&self) -> ContactSurface {
        let space = TaylorHood::new(&self.mesh);
        ContactSurface::about_axis(&self.mesh, &space, 1.0, &self.facets())
    }
}

#[test]
fn areas_of_round_surfaces_converge_with_order_four() {
    let eighth = 0.25 * std::f64::consts::PI * RADIUS;
    // The solid angle of the square, atan(x y / sqrt(1 + x^2 + y^2)) at its corner.
    let square = RADIUS * RADIUS * std::f64::consts::FRAC_PI_6;
    let cap = TAU * RADIUS * RADIUS * (1.0 - 0.5_f64.sqrt());
    let errors = |count: usize| {
        let (arc, patch) = (Round::arc(count), Round::patch(count));
        [
            arc.error(arc.flat(), eighth),
            patch.error(patch.flat(), square),
            arc.error(arc.turned(), cap),
        ]
    };
    let [coarse, fine] = [2, 4].map(errors);
    for (coarse, fine) in coarse.iter().zip(fine) {
        assert!(fine < 1e-3 && coarse / fine > 12.0, "{coarse:e} {fine:e}");
    }
}

/// Gap and coupling of a turned body on a turned obstacle, coupling turned back.
fn linearised(
    round: &Round,
    shape: &Arc<dyn Obstacle>,
    rotation: [f64; 3],
) -> (Vec<f64>, Vec<[f64; 3]>) {
    let (space, turn) = (TaylorHood::new(&round.mesh), rotation_matrix(rotation));
    let c = space.components;
    // Strained and shifted first, then turned.
    let mut displacement = vec![0.0; space.displacement_unknowns()];
    for (node, u) in displacement.chunks_exact_mut(c).enumerate() {
        let vertices = round.mesh.coordinates();
        let (x, bent) = match vertices.get(node) {
            Some(x) => (*x, [0.0; 3]),
            None => (
                round.mesh.offset_of(node - vertices.len()),
                [0.01, -0.02, 0.0],
            ),
        };
        let strained = [
            1.1 * x[0] + 0.1 * x[1],
            0.9 * x[1] - 0.05 * x[0],
            1.05 * x[2],
        ];
        let moved = sub(multiply(&turn, add(strained, bent)), x);
        u.copy_from_slice(&moved[..c]);
    }
    let body = Deformed {
        mesh: &round.mesh,
        scale: 1.0,
        space: &space,
        displacement: &displacement,
        rule: &face_rule(c, FACE_DEGREE),
        measure: Measure::Deformed,
    };
    let surface = round.flat().with_basis(&Bernstein);
    let obstacle = Moving::new(shape.clone(), [0.0; 3], rotation);
    let part = linearise(&body, &surface, &obstacle, &vec![false; displacement.len()]);
    let entries = part.rows.iter().flat_map(|row| row.chunks_exact(c));
    let back = entries.map(|entries| {
        let mut vector = [0.0; 3];
        for (x, &(_, value)) in vector.iter_mut().zip(entries) {
            *x = value;
        }
        crate::geometry::rigid_motion::multiply_transposed(&turn, vector)
    });
    (part.gap, back.collect())
}

#[test]
fn gap_and_coupling_turn_with_body_and_obstacle() {
    // Moving turns a sphere about its centre and a half-space about its point.
    let sphere = Sphere::new([0.0; 3], 1.9).expect("a sphere");
    let plane = HalfSpace::new([0.0; 3], [0.2, -1.0, 0.1]).expect("a half-space");
    let upright = HalfSpace::new([0.0; 3], [0.2, -1.0, 0.0]).expect("a half-space");
    let (solid, flat) = (Round::patch(2), Round::arc(3));
    let cases: [(&Round, Arc<dyn Obstacle>, [f64; 3]); 4] = [
        (&solid, Arc::new(sphere), [0.7, -2.0, 1.1]),
        (&solid, Arc::new(plane), [0.7, -2.0, 1.1]),
        (&flat, Arc::new(sphere), [0.0, 0.0, 2.5]),
        (&flat, Arc::new(upright), [0.0, 0.0, 2.5]),
    ];
    for (round, shape, rotation) in cases {
        let (gap, coupling) = linearised(round, &shape, [0.0; 3]);
        let (turned_gap, turned_coupling) = linearised(round, &shape, rotation);
        for (a, b) in gap.iter().zip(&turned_gap) {
            assert!((a - b).abs() < 1e-13, "{shape:?}: {a} {b}");
        }
        for (a, b) in coupling.iter().zip(&turned_coupling) {
            assert!(norm(sub(*a, *b)) < 1e-13, "{shape:?}: {a:?} {b:?}");
        }
    }
}
