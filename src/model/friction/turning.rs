//! How tangents turn as the body moves along a curved obstacle:
//!
//! ```text
//! n_i = m_i / |m_i|,   m_i = int phi_i n(x) dS,   dm_i = int phi_i H du dS
//! d(t_a . S_i) = t_a . dS_i + S_i . dt_a,   d(l_a t_a) = l_a dt_a,   dt_a = (dt_a/dn) (I - n n^T) dm_i / |m_i|
//! ```
//!
//! H the curvature of the obstacle: without these terms programs converge linearly, by what a
//! point travels over the obstacle's radius. The derivative of a tangent by its normal is a
//! central difference of the frame. Cost: three linearisations of a curved frictional obstacle.

use super::frame::{Frame, frame};
use super::points::Point;
use super::traces::Traces;
use super::{Friction, area};
use crate::contact::gap::{linearise, mean_normals};
use crate::contact::shares::add_equal_columns;
use crate::contact::{ContactFace, Counterpart, Places};
use crate::geometry::Matrix3;
use crate::geometry::vector3::{add, dot, norm, normalised, scale, sub};
use crate::linalg::{SparseRows, SparseRowsBuilder};
use crate::model::Model;
use crate::model::state::State;
use crate::obstacle::{Contact, Derivatives, Moving, Obstacle};

/// Step of the difference: tangents are of order one in a unit normal.
const STEP: f64 = 1e-6;
/// Derivative of a tangent beyond which the frame is another one there.
const STEEPEST: f64 = 1e2;

/// Entries by unknown.
type Row = Vec<(u32, f64)>;

/// What the turning of tangents adds to a program.
pub(crate) struct Turning {
    /// To the rows of -ds/du `[multipliers, displacement]`.
    pub(crate) rows: SparseRows,
    /// What tractions take off the stiffness `[displacement, displacement]`.
    pub(crate) geometric: SparseRows,
}

/// An obstacle whose normal's component stands for the distance, and a row of its curvature for
/// the normal.
struct CurvatureRow<'a> {
    obstacle: &'a Moving,
    axis: usize,
}

impl Counterpart for CurvatureRow<'_> {
    fn probe_on(&self, _: &ContactFace, points: Places<'_>, _: Derivatives, out: &mut [Contact]) {
        self.obstacle
            .probe(points.deformed, Derivatives::Curvature, out);
        for contact in out {
            contact.distance = contact.normal[self.axis];
            contact.normal = contact.curvature[self.axis];
        }
    }
}

/// A point's normal and how it turns.
struct Turn<'r> {
    /// Unit normal.
    normal: [f64; 3],
    /// |m_i|.
    length: f64,
    /// Rows of -dm_i/du, axis by axis.
    rows: [&'r Row; 3],
}

impl Friction {
    /// What the turning of tangents and the change of the area add at `state`; none where all
    /// frictional obstacles are flat and the area is the undeformed one.
    pub(crate) fn turning(&self, model: &Model<'_>, state: &State) -> Option<Turning> {
        self.turning_of((model, state), &model.prepared.is_held)
    }

    /// The same without rows and columns of `held` unknowns.
    pub(crate) fn turning_of(
        &self,
        (model, state): (&Model<'_>, &State),
        held: &[bool],
    ) -> Option<Turning> {
        if model.is_rubber() {
            let turning = self.turning_of_tangents((model, state), held);
            let [rows, geometric] = area::change_of_area(self, (model, state), held);
            let own = Turning {
                rows: turning.rows.plus(&rows),
                geometric: turning.geometric.plus(&geometric),
            };
            return Some(match self.change_between((model, state), held) {
                Some([rows, geometric]) => Turning {
                    rows: own.rows.plus(&rows),
                    geometric: own.geometric.plus(&geometric),
                },
                None => own,
            });
        }
        let is_flat = self.is_on_flats(model, state);
        (!is_flat).then(|| self.turning_of_tangents((model, state), held))
    }

    /// What the turning of tangents adds at `state`.
    fn turning_of_tangents(&self, (model, state): (&Model<'_>, &State), held: &[bool]) -> Turning {
        let traces = self.traces(model, state);
        let travels = match &model.conditions.slip_start {
            Some(start) => self.travels(&traces, (model, state), start),
            None => vec![[0.0; 3]; self.on_obstacles],
        };
        let mut turning = Parts {
            friction: self,
            traces: &traces,
            components: model.prepared.space.components,
            held,
            rows: vec![Vec::new(); state.multiplier.len()],
            geometric: vec![Vec::new(); state.displacement.len()],
        };
        let body = model.deformed(&state.displacement);
        let mut first = 0;
        for (index, (interface, met)) in model.placed(&state.drive).enumerate() {
            let Some(obstacle) = met.obstacle() else {
                continue;
            };
            if !model.plan.problem.obstacles[index].is_frictional {
                continue;
            }
            let own = first..first + interface.multipliers.len();
            first = own.end;
            if obstacle.is_flat() {
                continue;
            }
            let sums = mean_normals(&body, &interface.surface, obstacle);
            let along = [0, 1, 2].map(|axis| {
                let row = CurvatureRow { obstacle, axis };
                linearise(&body, &interface.surface, &row, turning.held).rows
            });
            for (point, (local, &sum)) in own.zip(sums.iter().enumerate()) {
                if let Some(normal) = normalised(sum) {
                    let turn = Turn {
                        normal,
                        length: norm(sum),
                        rows: [0, 1, 2].map(|axis| &along[axis][local]),
                    };
                    turning.add(point, &turn, (travels[point], &state.multiplier));
                }
            }
        }
        turning.finish()
    }

    /// Whether no frictional obstacle is curved.
    fn is_on_flats(&self, model: &Model<'_>, state: &State) -> bool {
        let mut placed = model.placed(&state.drive).enumerate();
        placed.all(|(index, (_, met))| {
            met.obstacle().is_none_or(|obstacle| {
                obstacle.is_flat() || !model.plan.problem.obstacles[index].is_frictional
            })
        })
    }
}

/// What is added, under construction.
struct Parts<'a> {
    friction: &'a Friction,
    traces: &'a Traces,
    /// Components of the displacement.
    components: usize,
    /// Whether a displacement unknown is held `[unknowns]`.
    held: &'a [bool],
    rows: Vec<Row>,
    geometric: Vec<Row>,
}

impl Parts<'_> {
    /// Adds a point that has travelled by `travel`, weighted.
    fn add(&mut self, number: usize, turn: &Turn<'_>, (travel, multipliers): ([f64; 3], &[f64])) {
        let friction = self.friction;
        let point = &friction.points[number];
        let width = friction.components.count();
        let slopes = tangent_slopes(point, turn.normal, self.components);
        let mut pulled: Matrix3 = [[0.0; 3]; 3];
        for (a, slope) in slopes.iter().take(width).enumerate() {
            let slope = along_sum(slope, turn);
            let row = friction.first + number * width + a;
            self.rows[row] = combined(transposed_product(&slope, travel), turn.rows);
            let traction = multipliers[row];
            for (sum, own) in pulled.iter_mut().zip(slope) {
                *sum = add(*sum, scale(traction, own));
            }
        }
        if pulled.as_flattened().iter().all(|&value| value == 0.0) {
            return;
        }
        let (nodes, values) = self.traces.rows.row(number);
        for (i, pulled) in pulled.iter().take(self.components).enumerate() {
            let change = combined(scale(-1.0, *pulled), turn.rows);
            for (&node, value) in nodes.iter().zip(values) {
                let unknown = node as usize * self.components + i;
                if !self.held[unknown] {
                    let own = change
                        .iter()
                        .map(|&(column, entry)| (column, value * entry));
                    self.geometric[unknown].extend(own);
                }
            }
        }
    }

    fn finish(self) -> Turning {
        let unknowns = self.geometric.len();
        let [rows, geometric] = [self.rows, self.geometric].map(|rows| {
            let mut builder = SparseRowsBuilder::new(unknowns);
            rows.into_iter()
                .for_each(|mut row| builder.push_row(&mut row));
            builder.finish()
        });
        Turning { rows, geometric }
    }
}

/// dt_a/dn of both tangents `[2][component][axis]`; zero where the frame changes its kind.
fn tangent_slopes(point: &Point, n: [f64; 3], dimension: usize) -> [Matrix3; 2] {
    let at = |axis: usize, step: f64| -> Frame {
        let mut moved = n;
        moved[axis] += step;
        frame(point, normalised(moved).unwrap_or(n), dimension)
    };
    let mut slopes = [[[0.0; 3]; 3]; 2];
    for axis in 0..dimension {
        let (ahead, behind) = (at(axis, STEP), at(axis, -STEP));
        for a in 0..2 {
            let change = scale(0.5 / STEP, sub(ahead[a], behind[a]));
            if norm(change) < STEEPEST {
                (0..3).for_each(|i| slopes[a][i][axis] = change[i]);
            }
        }
    }
    slopes
}

/// dt/dm = (dt/dn) (I - n n^T) / |m|.
fn along_sum(slope: &Matrix3, turn: &Turn<'_>) -> Matrix3 {
    slope.map(|row| {
        let across = sub(row, scale(dot(row, turn.normal), turn.normal));
        scale(turn.length.recip(), across)
    })
}

/// M^T v.
fn transposed_product(matrix: &Matrix3, v: [f64; 3]) -> [f64; 3] {
    let rows = matrix.iter().zip(v);
    rows.fold([0.0; 3], |sum, (row, v)| add(sum, scale(v, *row)))
}

/// Sum of the rows times factors; their columns are the same.
fn combined(factors: [f64; 3], rows: [&Row; 3]) -> Row {
    let terms = factors.iter().zip(rows);
    let terms = terms.filter(|(factor, _)| **factor != 0.0);
    let mut sum: Row = terms
        .flat_map(|(factor, row)| {
            row.iter()
                .map(move |&(column, value)| (column, factor * value))
        })
        .collect();
    add_equal_columns(&mut sum);
    sum
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::linalg::vector::{add_scaled, norm as size, reproducible_noise};
    use crate::linalg::{LinearOperator, Workspace};
    use crate::mesh::{Group, GroupKind, Mesh, samples};
    use crate::model::conditions::Conditions;
    use crate::model::evaluate::{Evaluation, evaluate};
    use crate::model::friction::SlipStart;
    use crate::model::interfaces::Interfaces;
    use crate::plan::Plan;
    use crate::prepare::TaylorHoodData;
    use crate::report::{CancelToken, Seconds};
    use crate::scene::{
        Formulation, Material, MaterialModel, Modulus, Profile, RubberModel, Scene, Shape, Support,
    };

    const STEP: f64 = 1e-5;

    /// A linear body, held below, under a rough curved tool.
    fn scene(on: [&str; 2], shape: Shape) -> Scene {
        Scene {
            materials: vec![Material {
                group: "body".to_owned(),
                model: MaterialModel::LinearElastic {
                    modulus: Modulus::Shear(1.0),
                    poisson_ratio: 0.3,
                    formulation: Formulation::Auto,
                },
            }],
            supports: vec![Support {
                name: "base".to_owned(),
                on: vec![on[0].to_owned()],
                normal: None,
                displacement: [Some(0.0), Some(0.0), (on[0] == "z0").then_some(0.0)],
                profile: Profile::Constant,
                values: None,
                load: Default::default(),
            }],
            obstacles: vec![crate::scene::Obstacle {
                name: "tool".to_owned(),
                on: vec![on[1].to_owned()],
                shape,
                surface: crate::scene::SurfaceGeometry::default(),
                friction: 0.5,
                tresca: None,
                initial_penetration: crate::scene::PenetrationPolicy::default(),
            }],
            ..Scene::default()
        }
    }

    fn error(found: &[f64], exact: &[f64]) -> f64 {
        let mut error = found.to_vec();
        add_scaled(&mut error, -1.0, exact);
        size(&error)
    }

    /// Compares the terms of `scene` with differences along a random direction.
    fn check(scene: &Scene, mesh: Mesh) {
        check_within(scene, mesh, [1e-7, 1e-6]);
    }

    /// The same, slips and forces within shares of what they are.
    fn check_within(scene: &Scene, mesh: Mesh, within: [f64; 2]) {
        let mesh = Arc::new(mesh);
        let plan = Plan::new(scene, &[], &mesh).expect("a valid scene");
        let prepared =
            TaylorHoodData::build(&plan, &mesh, &CancelToken::new()).expect("a solvable body");
        let interfaces = Interfaces::new(&plan, &mesh, &prepared.space);
        let load = vec![0.0; prepared.space.displacement_unknowns()];
        let mut state = State::undeformed(&plan);
        let start = Arc::new(SlipStart::at(&state));
        let model = Model {
            plan: &plan,
            mesh: &mesh,
            prepared: &prepared,
            interfaces: &interfaces,
            load: &load,
            conditions: Conditions {
                slip_start: Some(start),
                ..Conditions::to(1e-8)
            },
        };
        let noise = reproducible_noise(3 * load.len() + state.multiplier.len());
        let (motion, rest) = noise.split_at(load.len());
        let along: Vec<f64> = (rest[..load.len()].iter().zip(&prepared.is_held))
            .map(|(x, held)| if *held { 0.0 } else { *x })
            .collect();
        state.displacement = motion.iter().map(|x| 0.02 * x).collect();
        let friction = interfaces.friction.as_ref().expect("a frictional tool");
        let own = friction.first..friction.first + friction.size();
        state.multiplier[own.clone()].copy_from_slice(&rest[load.len()..][..own.len()]);

        let turning = friction.turning(&model, &state).expect("a curved tool");
        let at = |length: f64| -> Evaluation {
            let mut moved = state.clone();
            let pairs = moved.displacement.iter_mut().zip(&along);
            pairs.for_each(|(u, v)| *u += length * v);
            evaluate(
                &model,
                &moved,
                &mut Seconds::default(),
                &mut Workspace::new(),
            )
        };
        let work = &mut Workspace::new();
        let (ahead, behind, now) = (at(STEP), at(-STEP), at(0.0));
        let pushed = |there: &Evaluation| {
            let mut force = vec![0.0; load.len()];
            let coupling = &there.coupling;
            coupling.apply_transposed(&state.multiplier, &mut force, &mut Workspace::new());
            force
        };
        let slope = |a: &[f64], b: &[f64]| -> Vec<f64> {
            a.iter()
                .zip(b)
                .map(|(a, b)| (a - b) / (2.0 * STEP))
                .collect()
        };
        let mut slips = vec![0.0; state.multiplier.len()];
        let rows = now.coupling.plus(&turning.rows);
        rows.apply(&along, &mut slips, work);
        let exact = slope(&behind.gap[own.clone()], &ahead.gap[own.clone()]);
        assert!(error(&slips[own], &exact) < within[0] * size(&exact));
        let mut taken = vec![0.0; load.len()];
        turning.geometric.apply(&along, &mut taken, work);
        let exact = slope(&pushed(&behind), &pushed(&ahead));
        assert!(size(&exact) > 0.0);
        assert!(error(&taken, &exact) < within[1] * size(&exact));
    }

    #[test]
    fn slips_and_tractions_turn_with_the_tangents_of_a_ball() {
        let ball = Shape::Sphere {
            centre: [0.4, 0.6, 1.8],
            radius: 0.8,
        };
        check(&scene(["z0", "z1"], ball), samples::cube(2));
    }

    #[test]
    fn slips_and_tractions_of_rubber_change_with_the_deformed_area() {
        let ball = Shape::Sphere {
            centre: [0.4, 0.6, 1.8],
            radius: 0.8,
        };
        let lid = Shape::HalfSpace {
            point: [0.0, 0.0, 1.0],
            normal: [0.0, 0.0, -1.0],
        };
        for shape in [ball, lid] {
            let mut scene = scene(["z0", "z1"], shape);
            scene.materials[0].model = MaterialModel::Rubber {
                model: RubberModel::NeoHookean { shear_modulus: 1.0 },
                bulk_modulus: Some(10.0),
                formulation: Formulation::Auto,
            };
            check(&scene, samples::cube(2));
        }
    }

    /// A cube of 2^3 cells on one of 3^3, groups `low_` and `up_`.
    fn two_cubes() -> Mesh {
        let (mut low, up) = (samples::cube_parts(3), samples::cube_parts(2));
        let [first, cells, facets] = [
            low.coordinates.len() as u32,
            low.cells.len() as u32 / 4,
            low.facets.len() as u32 / 3,
        ];
        let lowered = low.coordinates.iter_mut();
        lowered.for_each(|x| *x = [1.2 * x[0] - 0.1, 1.2 * x[1] - 0.1, x[2] - 1.0]);
        low.coordinates.extend(up.coordinates);
        low.cells.extend(up.cells.iter().map(|k| first + k));
        low.facets.extend(up.facets.iter().map(|k| first + k));
        let named = |group: &mut Group, body: &str| group.name = format!("{body}_{}", group.name);
        low.groups.iter_mut().for_each(|group| named(group, "low"));
        for mut group in up.groups {
            let shift = match group.kind {
                GroupKind::Cells => cells,
                GroupKind::Facets => facets,
            };
            group.members.iter_mut().for_each(|k| *k += shift);
            named(&mut group, "up");
            low.groups.push(group);
        }
        Mesh::new(low).expect("two cubes")
    }

    /// But for what parabolas are off the borders of pieces, 1e-5 of a face.
    #[test]
    fn slips_and_tractions_between_bodies_in_space_turn_with_their_faces() {
        let none = Shape::HalfSpace {
            point: [0.0; 3],
            normal: [0.0, 0.0, 1.0],
        };
        let mut scene = scene(["low_z0", "up_z1"], none);
        scene.obstacles.clear();
        scene.supports[0].displacement[2] = Some(0.0);
        let law = MaterialModel::Rubber {
            model: RubberModel::NeoHookean { shear_modulus: 1.0 },
            bulk_modulus: Some(10.0),
            formulation: Formulation::Auto,
        };
        scene.materials = ["low_body", "up_body"]
            .map(|group| Material {
                group: group.to_owned(),
                model: law.clone(),
            })
            .into();
        scene.contacts = vec![crate::scene::ContactPair {
            name: "pair".to_owned(),
            between: ["up_z0".to_owned(), "low_z1".to_owned()],
            carries: Some("up_z0".to_owned()),
            friction: 0.5,
            ..Default::default()
        }];
        check_within(&scene, two_cubes(), [1e-3, 1e-3]);
    }

    #[test]
    fn slips_and_tractions_turn_with_the_tangents_of_a_cylinder_in_the_plane() {
        let roller = Shape::Cylinder {
            point: [0.4, 1.5, 0.0],
            axis: [0.0, 0.0, 1.0],
            radius: 0.5,
        };
        check(&scene(["y0", "y1"], roller), samples::rectangle(3, 3));
    }
}
