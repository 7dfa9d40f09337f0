//! Weighted gaps and their first derivative, the coupling:
//!
//! ```text
//! g_i = int psi_i d(x + u) dS,   C_ik = -dg_i/du_k = -int psi_i N_k n dS
//! ```
//!
//! by one rule on the faces. Faces run in parallel, then rows; each row
//! adds up its faces and their points in their order. Cost: (rule points) * (faces)
//! distance evaluations.

use super::advancing::Advancing;
use super::counterpart::Counterpart;
pub use super::deformed::{Deformed, Measure};
use super::deformed::{FacePoints, Table};
use super::face::ContactFace;
use super::surface::ContactSurface;
use crate::geometry::vector3::{add, scale};
use crate::obstacle::Derivatives;
use crate::parallel;

/// Fewer rows are not worth a second thread.
const PARALLEL_ROWS: usize = 64;

/// Asks what the points of a face meet and fills its gaps.
type Probe<'a> = dyn Fn(&mut FacePoints<'_>, &ContactFace, &mut [f64]) + Sync + 'a;

/// Gap and coupling of one surface.
#[derive(Clone, Debug, Default)]
pub struct Linearisation {
    /// Integral of each multiplier function times the distance `[multipliers]`,
    /// length^dimension; negative in penetration.
    pub gap: Vec<f64>,
    /// Rows of C = -dg/du, held columns left out `[multipliers]`, columns ascending.
    pub rows: Vec<Vec<(u32, f64)>>,
    /// Deepest penetration at a point of the rule, in units of the scaled body; zero
    /// where there is none.
    pub max_penetration: f64,
}

/// Weighted gaps only; also the deepest penetration.
pub fn evaluate_gaps<C: Counterpart + ?Sized>(
    body: &Deformed<'_>,
    surface: &ContactSurface,
    counterpart: &C,
) -> (Vec<f64>, f64) {
    let table = Table::new(body, surface.basis);
    let size = 1 + table.functions * table.points();
    let numbers = body.on_faces(&table, &surface.faces, size, |points, face, numbers| {
        points.probe(counterpart, face, Derivatives::Gap);
        fill_gaps(points, numbers);
    });
    let numbers = FaceNumbers { numbers, size };
    let gaps = surface.shares.gather(surface.summed(&table, &numbers));
    (gaps, numbers.deepest())
}

/// Integral of each multiplier function times the normal `[multipliers][3]`.
pub fn mean_normals<C: Counterpart + ?Sized>(
    body: &Deformed<'_>,
    surface: &ContactSurface,
    counterpart: &C,
) -> Vec<[f64; 3]> {
    let table = Table::new(body, surface.basis);
    let count = table.points();
    let size = 1 + table.functions * count;
    let faces = &surface.faces;
    let numbers = body.on_faces(&table, faces, 3 * size, |points, face, numbers| {
        points.probe(counterpart, face, Derivatives::Normal);
        for (axis, numbers) in numbers.chunks_exact_mut(size).enumerate() {
            for (point, contact) in points.contacts.iter().enumerate() {
                for (k, value) in points.table.values(point).iter().enumerate() {
                    numbers[1 + k * count + point] =
                        points.weights[point] * value * contact.normal[axis];
                }
            }
        }
    });
    let mut normals = vec![[0.0; 3]; surface.multipliers()];
    for axis in 0..3 {
        let of_axis = numbers.chunks_exact(size).skip(axis).step_by(3);
        let numbers = of_axis.flatten().copied().collect();
        let numbers = FaceNumbers { numbers, size };
        let sums = surface.shares.gather(surface.summed(&table, &numbers));
        for (normal, sum) in normals.iter_mut().zip(sums) {
            normal[axis] = sum;
        }
    }
    normals
}

/// Gaps and coupling; `held[k]` says that unknown k is prescribed.
pub fn linearise<C: Counterpart + ?Sized>(
    body: &Deformed<'_>,
    surface: &ContactSurface,
    counterpart: &C,
    held: &[bool],
) -> Linearisation {
    let probe = |points: &mut FacePoints<'_>, face: &ContactFace, out: &mut [f64]| {
        points.probe(counterpart, face, Derivatives::Normal);
        fill_gaps(points, out);
    };
    integrate(body, surface, &probe, held)
}

/// The same with gaps from where a tool is now, and the coupling without what its way makes of the
/// change of the area.
pub fn linearise_advanced<C: Counterpart + ?Sized>(
    body: &Deformed<'_>,
    surface: &ContactSurface,
    tool: Advancing<'_, C>,
    held: &[bool],
) -> Linearisation {
    let probe = |points: &mut FacePoints<'_>, face: &ContactFace, out: &mut [f64]| {
        points.probe(tool.now, face, Derivatives::Gap);
        fill_gaps(points, out);
        points.probe(&tool, face, Derivatives::Normal);
    };
    integrate(body, surface, &probe, held)
}

/// Gaps, which `probe` fills, and the coupling of what it leaves at the points of a face.
fn integrate(
    body: &Deformed<'_>,
    surface: &ContactSurface,
    probe: &Probe<'_>,
    held: &[bool],
) -> Linearisation {
    let table = Table::new(body, surface.basis);
    let gaps = 1 + table.functions * table.points();
    let size = gaps + table.functions * 3 * table.nodes;
    let numbers = body.on_faces(&table, &surface.faces, size, |points, face, numbers| {
        let (first, couplings) = numbers.split_at_mut(gaps);
        probe(points, face, first);
        match (body.measure, table.corners) {
            (Measure::Deformed, _) => add_deformed_couplings(points, couplings),
            (Measure::Undeformed, 2) => add_couplings::<3>(points, couplings),
            (Measure::Undeformed, _) => add_couplings::<6>(points, couplings),
        }
    });
    let numbers = FaceNumbers { numbers, size };
    Linearisation {
        gap: surface.shares.gather(surface.summed(&table, &numbers)),
        rows: surface.rows(&table, &numbers, held),
        max_penetration: numbers.deepest(),
    }
}

/// How the change of the deformed area changes the integral of a field: rows of
/// -int psi_i f (da/du) `[multipliers]`, f the component `axis` of `field`
/// `[displacement unknowns]`.
pub fn area_rows(
    body: &Deformed<'_>,
    surface: &ContactSurface,
    (field, axis): (&[f64], usize),
    held: &[bool],
) -> Vec<Vec<(u32, f64)>> {
    let table = Table::new(body, surface.basis);
    let gaps = 1 + table.functions * table.points();
    let size = gaps + table.functions * 3 * table.nodes;
    let c = body.space.components;
    let numbers = body.on_faces(&table, &surface.faces, size, |points, face, numbers| {
        for (point, contact) in points.contacts.iter_mut().enumerate() {
            let nodes = face.nodes.iter().zip(table.shapes(point));
            let values = nodes.map(|(&node, shape)| shape * field[node as usize * c + axis]);
            (contact.distance, contact.normal) = (values.sum(), [0.0; 3]);
        }
        add_deformed_couplings(points, &mut numbers[gaps..]);
    });
    surface.rows(&table, &FaceNumbers { numbers, size }, held)
}

/// Numbers of all faces `[faces, size]`: the deepest penetration, what each function
/// gains at each point `[functions, points]`, the couplings `[functions, 3, nodes]`.
struct FaceNumbers {
    /// The numbers of all faces side by side, row-major `[faces, size]`.
    numbers: Vec<f64>,
    /// Numbers of one face.
    size: usize,
}

impl FaceNumbers {
    /// The numbers of one face `[size]`.
    fn of(&self, face: u32) -> &[f64] {
        &self.numbers[face as usize * self.size..(face as usize + 1) * self.size]
    }

    /// Deepest penetration over all faces, at least zero, in units of the scaled body.
    fn deepest(&self) -> f64 {
        let faces = self.numbers.chunks_exact(self.size);
        faces.map(|numbers| numbers[0]).fold(0.0, f64::max)
    }
}

/// The deepest penetration, then weight * psi * d of each function at each point.
fn fill_gaps(points: &FacePoints<'_>, numbers: &mut [f64]) {
    numbers[0] = points.deepest();
    let count = points.table.points();
    for (point, contact) in points.contacts.iter().enumerate() {
        for (k, value) in points.table.values(point).iter().enumerate() {
            numbers[1 + k * count + point] = points.weights[point] * value * contact.distance;
        }
    }
}

/// -int psi N n of every function, direction and node; `N` nodes a face.
fn add_couplings<const N: usize>(points: &FacePoints<'_>, couplings: &mut [f64]) {
    for (point, contact) in points.contacts.iter().enumerate() {
        let Some(shapes) = points.table.shapes(point).first_chunk::<N>() else {
            return;
        };
        let values = points.table.values(point);
        for (value, block) in values.iter().zip(couplings.chunks_exact_mut(3 * N)) {
            let weight = points.weights[point] * value;
            let weighted = shapes.map(|shape| weight * shape);
            for (normal, entries) in contact.normal.iter().zip(block.as_chunks_mut::<N>().0) {
                for (entry, part) in entries.iter_mut().zip(weighted) {
                    *entry -= part * normal;
                }
            }
        }
    }
}

/// -int psi (N n da + d da/dX) of every function, direction and node.
fn add_deformed_couplings(points: &FacePoints<'_>, couplings: &mut [f64]) {
    let (table, nodes) = (points.table, points.table.nodes);
    let elements = points.contacts.iter().zip(&points.areas).enumerate();
    for (point, (contact, area)) in elements {
        let weight = table.rule.weights[point];
        for (node, &shape) in table.shapes(point).iter().enumerate() {
            let pulled = scale(shape * area.size(), contact.normal);
            let change = scale(contact.distance, area.gradient(node, shape));
            let along = scale(weight, add(pulled, change));
            let values = table.values(point).iter();
            for (value, block) in values.zip(couplings.chunks_exact_mut(3 * nodes)) {
                (0..3).for_each(|i| block[i * nodes + node] -= value * along[i]);
            }
        }
    }
}

impl ContactSurface {
    /// Per function, the sum of what it gains on its faces `[functions]`.
    fn summed(&self, table: &Table<'_>, numbers: &FaceNumbers) -> Vec<f64> {
        let count = table.points();
        let gain = |index: usize| {
            let places = self.at_functions.of(index).iter();
            places.fold(0.0, |sum, place| {
                let first = 1 + place.slot as usize * count;
                let own = &numbers.of(place.face)[first..first + count];
                own.iter().fold(sum, |sum, part| sum + part)
            })
        };
        parallel::map(self.carriers.len(), PARALLEL_ROWS, &gain)
    }

    /// The rows of all multipliers, without what is `held`.
    fn rows(
        &self,
        table: &Table<'_>,
        numbers: &FaceNumbers,
        held: &[bool],
    ) -> Vec<Vec<(u32, f64)>> {
        let row = |index: usize| self.row(index, table, numbers, (table.corners, held));
        let rows = parallel::map(self.carriers.len(), PARALLEL_ROWS, &row);
        self.shares.gather_rows(rows)
    }

    /// One row of C for `components` of the displacement, without what is `held`.
    fn row(
        &self,
        index: usize,
        table: &Table<'_>,
        numbers: &FaceNumbers,
        (components, held): (usize, &[bool]),
    ) -> Vec<(u32, f64)> {
        let nodes = self.couplings.nodes(index);
        let mut row = Vec::with_capacity(nodes.len() * components);
        for &node in nodes {
            let first = node * components as u32;
            row.extend((first..first + components as u32).map(|unknown| (unknown, 0.0)));
        }
        let places = self.at_functions.of(index).iter();
        let positions = self.couplings.positions(index).chunks_exact(table.nodes);
        for (place, positions) in places.zip(positions) {
            let first = numbers.size - (table.functions - place.slot as usize) * 3 * table.nodes;
            let block = &numbers.of(place.face)[first..first + 3 * table.nodes];
            for (slot, &position) in positions.iter().enumerate() {
                for i in 0..components {
                    row[position as usize * components + i].1 += block[i * table.nodes + slot];
                }
            }
        }
        row.retain(|&(unknown, _)| !held[unknown as usize]);
        row
    }
}
