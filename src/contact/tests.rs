//! Gaps, their derivatives and resultants on a deformed irregular face.

mod held;
mod round;

use std::sync::Arc;

use super::basis::Bernstein;
use super::gap::{Deformed, Measure};
use super::{
    Acting, Advancing, ContactFace, ContactSurface, Counterpart, Places, curvature, evaluate_gaps,
    linearise, linearise_advanced, resultant,
};
use crate::assembly::load::shape_values;
use crate::element::quadrature::{Rule, Simplex, rule};
use crate::linalg::vector::{dot, largest, norm, reproducible_noise};
use crate::linalg::{LinearOperator, SparseRows, SparseRowsBuilder, Workspace};
use crate::mesh::{EdgeOffset, GroupKind, Mesh, MeshParts, samples};
use crate::obstacle::{Contact, Cylinder, Derivatives, HalfSpace, Moving, Obstacle, Sphere};
use crate::space::TaylorHood;

const SCALE: f64 = 0.8;
/// Step of central differences: their error is some 1e-10.
const STEP: f64 = 1e-5;

/// A deformed body and the candidate face at its top.
struct Sample {
    mesh: Mesh,
    space: TaylorHood,
    surface: ContactSurface,
    rule: Rule,
    displacement: Vec<f64>,
    side: &'static str,
    measure: Measure,
}

impl Sample {
    fn new(parts: MeshParts, side: &'static str) -> Self {
        Self::on(Mesh::new(parts).expect("a valid sample"), side)
    }

    fn on(mesh: Mesh, side: &'static str) -> Self {
        let space = TaylorHood::new(&mesh);
        let group = mesh.group(side, GroupKind::Facets).expect("a side");
        let facets: Vec<Vec<u32>> = group
            .members
            .iter()
            .map(|&f| mesh.facet(f as usize).to_vec())
            .collect();
        let surface = ContactSurface::new(&mesh, &space, SCALE, &facets);
        let simplex = if space.components == 2 {
            Simplex::Segment
        } else {
            Simplex::Triangle
        };
        let noise = reproducible_noise(space.displacement_unknowns());
        Self {
            displacement: noise.into_iter().map(|x| 0.03 * x).collect(),
            rule: rule(simplex, 8),
            mesh,
            space,
            surface,
            side,
            measure: Measure::Undeformed,
        }
    }

    /// With the middles of its edges off the lines by up to a tenth of their length.
    fn curved(self) -> Self {
        let noise = reproducible_noise(3 * self.space.edges.len());
        let edges = self.space.edges.iter().zip(noise.chunks(3));
        let offset = |(ends, noise): (&[u32; 2], &[f64])| EdgeOffset {
            ends: *ends,
            offset: std::array::from_fn(|i| {
                if i < self.space.components {
                    0.02 * noise[i]
                } else {
                    0.0
                }
            }),
        };
        let mesh = self.mesh.with_offsets(edges.map(offset).collect());
        let is_ring = self.surface.faces.iter().any(|face| face.radii.is_some());
        let bent = Self::on(mesh, self.side);
        if is_ring { bent.turned() } else { bent }
    }

    /// As a section of a body of revolution.
    fn turned(self) -> Self {
        let faces = self.surface.faces.iter();
        let facets: Vec<Vec<u32>> = faces.map(|face| face.corners.clone()).collect();
        Self {
            surface: ContactSurface::about_axis(&self.mesh, &self.space, SCALE, &facets),
            ..self
        }
    }

    /// With quadratic multipliers.
    fn quadratic(self) -> Self {
        Self {
            surface: self.surface.with_basis(&Bernstein),
            ..self
        }
    }

    fn body<'a>(&'a self, displacement: &'a [f64]) -> Deformed<'a> {
        Deformed {
            mesh: &self.mesh,
            scale: SCALE,
            space: &self.space,
            displacement,
            rule: &self.rule,
            measure: self.measure,
        }
    }

    /// With integrals over the deformed surface.
    fn finite(self) -> Self {
        Self {
            measure: Measure::Deformed,
            ..self
        }
    }

    /// The displacement moved by `factor` times a fixed direction.
    fn moved(&self, factor: f64) -> (Vec<f64>, Vec<f64>) {
        let direction: Vec<f64> = self.displacement.iter().rev().map(|x| x / 0.03).collect();
        let moved = self.displacement.iter().zip(&direction);
        (moved.map(|(u, d)| u + factor * d).collect(), direction)
    }

    fn gaps(&self, displacement: &[f64], obstacle: &dyn Obstacle) -> Vec<f64> {
        evaluate_gaps(&self.body(displacement), &self.surface, obstacle).0
    }

    fn coupling(&self, displacement: &[f64], obstacle: &dyn Obstacle) -> SparseRows {
        let held = vec![false; displacement.len()];
        let mut part = linearise(&self.body(displacement), &self.surface, obstacle, &held);
        let mut builder = SparseRowsBuilder::new(displacement.len());
        part.rows.iter_mut().for_each(|row| builder.push_row(row));
        builder.finish()
    }

    /// -C^T l: the force of the obstacle on each unknown.
    fn contact_force(
        &self,
        displacement: &[f64],
        obstacle: &dyn Obstacle,
        pressure: &[f64],
    ) -> Vec<f64> {
        let mut force = vec![0.0; displacement.len()];
        let coupling = self.coupling(displacement, obstacle);
        coupling.apply_transposed(pressure, &mut force, &mut Workspace::new());
        force.into_iter().map(|x| -x).collect()
    }

    fn pressure(&self) -> Vec<f64> {
        let noise = reproducible_noise(self.surface.multipliers());
        noise.into_iter().map(|x| 1.0 + x).collect()
    }
}

fn solid() -> Sample {
    Sample::new(samples::cube_parts(2), "z1")
}

fn plane() -> Sample {
    Sample::new(samples::rectangle_parts(3, 2), "y1")
}

/// A ring about the axis.
fn ring() -> Sample {
    plane().turned()
}

/// Obstacles over the top of the scaled unit cube.
fn obstacles() -> Vec<Arc<dyn Obstacle>> {
    let sphere = Sphere::new([0.3, 0.4, 1.5], 0.75).expect("a sphere");
    let roll = Cylinder::new([0.3, 0.4, 1.5], [1.0, 0.3, 0.1], 0.7).expect("a cylinder");
    let floor = HalfSpace::new([0.3, 0.4, 0.8], [0.1, -0.2, -1.0]).expect("a half-space");
    let shapes: [Arc<dyn Obstacle>; 3] = [Arc::new(sphere), Arc::new(roll), Arc::new(floor)];
    let moved = |shape: &Arc<dyn Obstacle>| -> Arc<dyn Obstacle> {
        Arc::new(Moving::new(
            shape.clone(),
            [0.05, -0.02, -0.04],
            [0.2, -0.1, 0.3],
        ))
    };
    let carried: Vec<_> = shapes.iter().map(moved).collect();
    shapes.into_iter().chain(carried).collect()
}

fn plane_obstacles() -> Vec<Arc<dyn Obstacle>> {
    let roll = Cylinder::new([0.4, 1.5, 0.0], [0.0, 0.0, 1.0], 0.75).expect("a cylinder");
    let disc = Sphere::new([0.4, 1.5, 0.0], 0.75).expect("a sphere");
    vec![Arc::new(roll), Arc::new(disc)]
}

/// A sample on an obstacle.
type Case = (Sample, Arc<dyn Obstacle>);

/// Solid and plane samples on every obstacle, with hats and with quadratic
/// multipliers, on flat and on curved faces.
fn cases() -> Vec<Case> {
    let on = |sample: fn() -> Sample, obstacles: Vec<Arc<dyn Obstacle>>| -> Vec<Case> {
        let both = |obstacle: Arc<dyn Obstacle>| {
            let bent = || sample().curved().quadratic();
            [
                (sample(), obstacle.clone()),
                (sample().quadratic(), obstacle.clone()),
                (sample().finite(), obstacle.clone()),
                (sample().quadratic().finite(), obstacle.clone()),
                (sample().curved().finite(), obstacle.clone()),
                (bent().finite(), obstacle.clone()),
                (bent(), obstacle.clone()),
            ]
        };
        obstacles.into_iter().flat_map(both).collect()
    };
    let mut cases = on(solid, obstacles());
    cases.extend(on(plane, plane_obstacles()));
    cases
}

/// The same, and rings, which no motion along their radius leaves as they are.
fn cases_and_rings() -> Vec<Case> {
    let mut cases = cases();
    for obstacle in plane_obstacles() {
        cases.push((ring().finite(), obstacle.clone()));
        cases.push((ring().curved().quadratic().finite(), obstacle));
    }
    cases
}

#[test]
fn the_coupling_is_minus_the_derivative_of_the_gaps() {
    for (sample, obstacle) in cases_and_rings() {
        let (up, direction) = sample.moved(STEP);
        let (down, _) = sample.moved(-STEP);
        let (up, down) = (sample.gaps(&up, &*obstacle), sample.gaps(&down, &*obstacle));
        let mut closing = vec![0.0; up.len()];
        let coupling = sample.coupling(&sample.displacement, &*obstacle);
        coupling.apply(&direction, &mut closing, &mut Workspace::new());
        assert!(largest(&closing) > 1e-3);
        for ((up, down), closing) in up.iter().zip(&down).zip(&closing) {
            let slope = (up - down) / (2.0 * STEP);
            assert!(
                (slope + closing).abs() < 1e-9,
                "{obstacle:?} {slope} {closing}"
            );
        }
    }
}

#[test]
fn the_curvature_is_the_derivative_of_the_contact_force() {
    for (sample, obstacle) in cases_and_rings() {
        let pressure = sample.pressure();
        let (up, direction) = sample.moved(STEP);
        let (down, _) = sample.moved(-STEP);
        let up = sample.contact_force(&up, &*obstacle, &pressure);
        let down = sample.contact_force(&down, &*obstacle, &pressure);
        let held = vec![false; up.len()];
        let surfaces = [(&sample.surface, &*obstacle, &pressure[..])];
        let matrix = curvature(&sample.body(&sample.displacement), &surfaces, &held);
        let mut product = vec![0.0; up.len()];
        matrix.apply(&direction, &mut product, &mut Workspace::new());
        for ((up, down), product) in up.iter().zip(&down).zip(&product) {
            let slope = (up - down) / (2.0 * STEP);
            assert!(
                (slope - product).abs() < 1e-7,
                "{obstacle:?} {slope} {product}"
            );
        }
    }
}

#[test]
fn held_unknowns_have_neither_coupling_nor_curvature() {
    let (sample, obstacle) = (solid(), &obstacles()[0]);
    let held: Vec<bool> = (0..sample.displacement.len()).map(|k| k % 2 == 0).collect();
    let body = sample.body(&sample.displacement);
    let part = linearise(&body, &sample.surface, &**obstacle, &held);
    assert!(
        part.rows
            .iter()
            .flatten()
            .all(|&(unknown, _)| !held[unknown as usize])
    );
    let pressure = sample.pressure();
    let matrix = curvature(&body, &[(&sample.surface, &**obstacle, &pressure)], &held);
    for (row, &is_held) in held.iter().enumerate() {
        let (columns, _) = matrix.row(row);
        assert!(
            columns
                .iter()
                .all(|&column| !is_held && !held[column as usize])
        );
    }
}

#[test]
fn linearising_gives_the_gaps_and_the_penetration_of_evaluating() {
    for (sample, obstacle) in cases() {
        let held = vec![false; sample.displacement.len()];
        let body = sample.body(&sample.displacement);
        let part = linearise(&body, &sample.surface, &*obstacle, &held);
        let (gap, deepest) = evaluate_gaps(&body, &sample.surface, &*obstacle);
        assert_eq!(part.gap, gap);
        assert_eq!(part.max_penetration.to_bits(), deepest.to_bits());
        assert!(deepest > 0.0);
    }
}

#[test]
fn weights_sum_to_the_area_and_weigh_a_uniform_gap() {
    for mut sample in [solid(), solid().quadratic()] {
        let area: f64 = sample.surface.weights.iter().sum();
        assert!((area - SCALE * SCALE).abs() < 1e-14);
        sample.displacement.fill(0.0);
        let floor = HalfSpace::new([0.0, 0.0, 0.8 - 0.25], [0.0, 0.0, 1.0]).expect("a half-space");
        let gap = sample.gaps(&sample.displacement, &floor);
        for (gap, weight) in gap.iter().zip(&sample.surface.weights) {
            assert!((gap - 0.25 * weight).abs() < 1e-15);
        }
    }
}

#[test]
fn quadratic_multipliers_stand_on_every_node_of_the_surface() {
    let (hats, quadratic) = (solid(), solid().quadratic());
    // 2 x 2 squares of two triangles: 9 vertices and 16 edges.
    assert_eq!(hats.surface.multipliers(), 9);
    assert_eq!(quadratic.surface.multipliers(), 9 + 16);
    assert_eq!(quadratic.surface.carriers[..9], hats.surface.carriers[..]);
    for face in &quadratic.surface.faces {
        let at = face.functions.iter();
        let carriers: Vec<u32> = at
            .map(|&m| quadratic.surface.carriers[m as usize])
            .collect();
        assert_eq!(carriers, face.nodes);
    }
}

/// A larger surface, worth more than one thread.
fn wide() -> Sample {
    Sample::new(samples::cube_parts(9), "z1")
}

fn in_threads<T: Send>(threads: usize, task: impl FnOnce() -> T + Send) -> T {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.expect("a pool").install(task)
}

#[test]
fn contact_integrals_have_the_same_bits_on_one_and_on_two_threads() {
    for sample in [wide(), wide().quadratic()] {
        let (obstacle, pressure) = (&obstacles()[3], sample.pressure());
        let held = vec![false; sample.displacement.len()];
        let integrals = || {
            let body = sample.body(&sample.displacement);
            let part = linearise(&body, &sample.surface, &**obstacle, &held);
            let surfaces = [(&sample.surface, &**obstacle, &pressure[..])];
            let active = vec![true; pressure.len()];
            let origin = [0.0; 3];
            let found = resultant(
                &body,
                &sample.surface,
                &**obstacle,
                Acting {
                    reference: origin,
                    pressure: &pressure,
                    active: &active,
                },
            );
            (
                part.gap,
                part.rows,
                curvature(&body, &surfaces, &held),
                found,
                sample.surface.areas(&body),
            )
        };
        // Equal numbers are equal bits here: none is a negative zero or NaN.
        assert_eq!(in_threads(1, integrals), in_threads(2, integrals));
    }
}

/// The gap face by face and point by point, as the formula stands.
fn plain_gaps(sample: &Sample, obstacle: &dyn Obstacle) -> Vec<f64> {
    let mut gap = vec![0.0; sample.surface.multipliers()];
    let coordinates = sample.mesh.coordinates();
    for face in &sample.surface.faces {
        for (l, weight) in sample.rule.points.iter().zip(&sample.rule.weights) {
            let l = &l[..face.corners.len()];
            let mut position = [0.0; 3];
            for (&corner, l) in face.corners.iter().zip(l) {
                (0..3).for_each(|i| position[i] += l * SCALE * coordinates[corner as usize][i]);
            }
            for (&node, shape) in face.nodes.iter().zip(shape_values(l)) {
                let c = sample.space.components;
                (0..c).for_each(|i| {
                    position[i] += shape * sample.displacement[node as usize * c + i];
                });
            }
            let distance = obstacle.distance(position).distance;
            for (&multiplier, hat) in face.functions.iter().zip(l) {
                gap[multiplier as usize] += weight * face.area_at(l) * hat * distance;
            }
        }
    }
    gap
}

#[test]
fn gaps_have_the_bits_of_the_plain_sum_over_faces_and_points() {
    let hats = |obstacle: Arc<dyn Obstacle>| [(wide(), obstacle.clone()), (solid(), obstacle)];
    let solids = obstacles().into_iter().flat_map(hats);
    let planes = plane_obstacles()
        .into_iter()
        .map(|obstacle| (plane(), obstacle));
    for (sample, obstacle) in solids.chain(planes) {
        let gaps = sample.gaps(&sample.displacement, &*obstacle);
        let bits = |gaps: &[f64]| gaps.iter().map(|gap| gap.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&gaps), bits(&plain_gaps(&sample, &*obstacle)));
    }
}

#[test]
fn the_resultant_is_the_work_of_the_contact_force_on_rigid_motions() {
    for (sample, obstacle) in cases() {
        let pressure = sample.pressure();
        let force = sample.contact_force(&sample.displacement, &*obstacle, &pressure);
        let (reference, active) = ([0.1, -0.2, 0.3], vec![true; pressure.len()]);
        let body = sample.body(&sample.displacement);
        let found = resultant(
            &body,
            &sample.surface,
            &*obstacle,
            Acting {
                reference,
                pressure: &pressure,
                active: &active,
            },
        );
        let c = sample.space.components;
        for axis in 0..c {
            // The vertex functions sum to one.
            let sum: f64 = (0..sample.space.vertices)
                .map(|v| force[v * c + axis])
                .sum();
            assert!((found.force[axis] - sum).abs() < 1e-12, "{obstacle:?}");
        }
        let spin = spin_about_z(&sample, reference);
        assert!(
            (found.moment[2] - dot(&force, &spin)).abs() < 1e-12,
            "{obstacle:?}"
        );
        // A gap of one everywhere weighs the area.
        let area: f64 = evaluate_gaps(&body, &sample.surface, &Away(1.0))
            .0
            .iter()
            .sum();
        assert!((found.area - area).abs() < 1e-14);
        // Quadratic functions stay within the hull of their coefficients.
        assert!(found.max_pressure <= largest(&pressure) + 1e-15);
    }
}

/// e_z x (x + u - reference) as a hierarchical vector.
fn spin_about_z(sample: &Sample, reference: [f64; 3]) -> Vec<f64> {
    let c = sample.space.components;
    let u = &sample.displacement;
    let mut spin = vec![0.0; u.len()];
    for node in 0..sample.space.nodes() {
        let vertices = sample.mesh.coordinates();
        let x = match vertices.get(node) {
            Some(point) => [
                SCALE * point[0] - reference[0],
                SCALE * point[1] - reference[1],
            ],
            None => {
                let offset = sample.mesh.offset_of(node - vertices.len());
                [SCALE * offset[0], SCALE * offset[1]]
            }
        };
        spin[node * c] = -(x[1] + u[node * c + 1]);
        spin[node * c + 1] = x[0] + u[node * c];
    }
    spin
}

#[test]
fn the_centre_of_a_uniform_pressure_is_the_centre_of_the_face() {
    let mut sample = solid();
    sample.displacement.fill(0.0);
    let floor = HalfSpace::new([0.0, 0.0, 0.8], [0.0, 0.0, -1.0]).expect("a half-space");
    let pressure = vec![2.0; sample.surface.multipliers()];
    let active = vec![false; pressure.len()];
    let body = sample.body(&sample.displacement);
    let found = resultant(
        &body,
        &sample.surface,
        &floor,
        Acting {
            reference: [0.0; 3],
            pressure: &pressure,
            active: &active,
        },
    );
    let error: Vec<f64> = found
        .centre
        .iter()
        .zip([0.4, 0.4, 0.8])
        .map(|(a, b)| a - b)
        .collect();
    assert!(norm(&error) < 1e-14 && found.area.abs() < 1e-15);
    assert!((found.force[2] + 2.0 * SCALE * SCALE).abs() < 1e-14);
}

#[test]
fn the_way_that_a_tool_has_gone_pulls_at_no_area() {
    for sample in [solid().finite(), plane().finite(), ring().finite()] {
        let up = sample.space.components - 1;
        let lid = |height: f64| {
            let (mut point, mut normal) = ([0.0; 3], [0.0; 3]);
            (point[up], normal[up]) = (height, -1.0);
            HalfSpace::new(point, normal).expect("a half-space")
        };
        let body = sample.body(&sample.displacement);
        let held = vec![false; sample.displacement.len()];
        let [before, after] = [0.8, 0.3].map(lid);
        let exact = |lid| linearise(&body, &sample.surface, lid, &held);
        let advanced =
            linearise_advanced(&body, &sample.surface, advancing(&after, &before), &held);
        assert_eq!(advanced.gap, exact(&after).gap);
        assert_eq!(advanced.rows, exact(&before).rows);
        assert_ne!(advanced.rows, exact(&after).rows);
        // A tool that retreats counts where it is.
        let back = linearise_advanced(&body, &sample.surface, advancing(&before, &after), &held);
        assert_eq!(back.rows, exact(&before).rows);
    }
}

#[test]
fn a_body_that_follows_its_tool_is_pressed_as_before() {
    for sample in [solid().finite(), solid().quadratic().finite()] {
        let ball = |way: f64| {
            let centre = [0.3 + 0.2 * way, 0.4, SCALE + 0.6 - way];
            Sphere::new(centre, 0.6).expect("a ball")
        };
        let way = 1e-4;
        let [before, after] = [0.02, 0.02 + way].map(ball);
        let pressure = sample.pressure();
        let at = |tool| sample.contact_force(&sample.displacement, tool, &pressure);
        // The whole body goes with the tool.
        let moved = sample.displacement.chunks_exact(3).enumerate();
        let moved = moved.flat_map(|(node, _)| {
            if node < sample.space.vertices {
                [0.2 * way, 0.0, -way]
            } else {
                [0.0; 3]
            }
        });
        let moved: Vec<f64> = moved.collect();
        let held = vec![false; moved.len()];
        let tool = advancing(&after, &before);
        let surfaces = [(&sample.surface, &tool, &pressure[..])];
        let matrix = curvature(&sample.body(&sample.displacement), &surfaces, &held);
        let mut product = vec![0.0; moved.len()];
        matrix.apply(&moved, &mut product, &mut Workspace::new());
        let (old, new) = (at(&before), at(&after));
        let change: Vec<f64> = old.iter().zip(&new).map(|(old, new)| old - new).collect();
        let error: Vec<f64> = change.iter().zip(&product).map(|(x, y)| x - y).collect();
        assert!(
            norm(&error) < 1e-3 * norm(&change),
            "{} {}",
            norm(&error),
            norm(&change)
        );
    }
}

/// A tool that was at `before` and is at `now`.
fn advancing<'a, T: Obstacle>(now: &'a T, before: &'a T) -> Advancing<'a, T> {
    Advancing {
        now,
        before: Some(before),
    }
}

/// Adds int N_k a dS of the deformed top, a the area vector: the force of a unit pressure on the
/// body from outside is its negative.
fn area_vectors(sample: &Sample) -> Vec<f64> {
    let body = sample.body(&sample.displacement);
    let along = Away(0.0);
    let held = vec![false; sample.displacement.len()];
    let rows = linearise(&body, &sample.surface, &along, &held).rows;
    let mut sums = vec![0.0; held.len()];
    for (unknown, value) in rows.into_iter().flatten() {
        sums[unknown as usize] -= value;
    }
    sums
}

/// The upward normal and that distance.
struct Away(f64);

impl Counterpart for Away {
    fn probe_on(&self, _: &ContactFace, _: Places<'_>, _: Derivatives, out: &mut [Contact]) {
        for contact in out {
            (contact.distance, contact.normal) = (self.0, [0.0, 0.0, 1.0]);
        }
    }
}

#[test]
fn an_even_pressure_on_a_closed_flat_gap_works_on_the_volume_only() {
    // The top stays in its plane and is stretched and sheared in it; the rim does not move.
    for mut sample in [solid().finite(), solid().quadratic().finite()] {
        let rim = |place: [f64; 3]| place[0] * (1.0 - place[0]) * place[1] * (1.0 - place[1]);
        for node in 0..sample.space.nodes() {
            let place = sample.space.node_place(&sample.mesh, node as u32);
            let is_inside = rim(place).abs() > 1e-9;
            let own = &mut sample.displacement[3 * node..3 * node + 3];
            own[2] = 0.0;
            if !is_inside {
                own.fill(0.0);
            }
        }
        let lid = HalfSpace::new([0.0, 0.0, SCALE], [0.0, 0.0, -1.0]).expect("a half-space");
        let ones = vec![1.0; sample.surface.multipliers()];
        let force = sample.contact_force(&sample.displacement, &lid, &ones);
        let volume = area_vectors(&sample);
        for (force, volume) in force.iter().zip(&volume) {
            assert!((force + volume).abs() < 1e-10, "{force} {volume}");
        }
        // The tangent of both cancels: the gap is closed to second order.
        let held = vec![false; ones.len().max(sample.displacement.len())];
        let surfaces = [(&sample.surface, &lid, &ones[..])];
        let matrix = curvature(&sample.body(&sample.displacement), &surfaces, &held);
        let (up, direction) = sample.moved(STEP);
        let (down, _) = sample.moved(-STEP);
        let at = |displacement: &[f64]| sample.contact_force(displacement, &lid, &ones);
        let (up, down) = (at(&up), at(&down));
        let mut product = vec![0.0; up.len()];
        matrix.apply(&direction, &mut product, &mut Workspace::new());
        for ((up, down), product) in up.iter().zip(&down).zip(&product) {
            assert!(((up - down) / (2.0 * STEP) - product).abs() < 1e-8);
        }
    }
}
