//! The compliance of the contact that is near, by a factor of the body:
//!
//! ```text
//! W_ij = C_i K^-1 C_j^T    where i and j are near
//! W_ii = w |C_i|^2         elsewhere, w the largest W_jj / |C_j|^2 of what is near
//! ```
//!
//! Near is what is closed, what no gap opens, and what is nearer to a tool than some faces are
//! long; tractions of friction go with their pressures. What comes from further away in one
//! program is soft there, and near in the next. Shape `[multipliers, multipliers]`, symmetric.
//! Cost: one solution with the factor for each that is near, and the square of their number.

use crate::geometry::vector3::{norm, sub};
use crate::inequality::BodyFactor;
use crate::linalg::vector::dot;
use crate::linalg::{DenseMatrix, LinearOperator, SparseRows, SymmetricMatrix, Workspace};
use crate::model::Model;
use crate::model::evaluate::Evaluation;
use crate::model::interfaces::Interface;
use crate::model::state::State;

constants! {
    /// Distance over the mean length of a face within which contact is near: an X-ring on a rod takes
    /// 868 solutions in all with one face and 646 with two, which no more change.
    const NEAR: f64 = 2.0;
    /// Loads that are solved for together: some 700 on a breast take 0.27 s by 16, 0.22 s by 32, 0.19 s
    /// by 64 and by 128.
    const BATCH: usize = 64;
    /// What keeps the rounding of dependent rows from making W indefinite, over its diagonal.
    const ROUNDING: f64 = 1e-9;
}

/// W.
#[derive(Debug)]
pub(super) struct NearCompliance {
    /// Place among those that are near `[multipliers]`.
    place: Vec<Option<u32>>,
    /// W of those.
    near: DenseMatrix,
    /// Diagonal of the others `[multipliers]`.
    far: Vec<f64>,
}

impl NearCompliance {
    /// Of the contact of `now`, whose rows are C.
    pub(super) fn new(
        factor: &BodyFactor,
        (model, state): (&Model<'_>, &State),
        now: &Evaluation,
        work: &mut Workspace,
    ) -> Self {
        let is_near = near(model, now, state);
        let chosen: Vec<usize> = (0..is_near.len()).filter(|&m| is_near[m]).collect();
        let mut place = vec![None; is_near.len()];
        for (own, &m) in (0..).zip(&chosen) {
            place[m] = Some(own);
        }
        let squares = squares(&now.coupling);
        let mut near = products(factor, &now.coupling, &chosen, work);
        let mut softest = 0.0_f64;
        for (own, &m) in chosen.iter().enumerate() {
            let diagonal = near.at_mut(own, own);
            if squares[m] > 0.0 {
                softest = softest.max(*diagonal / squares[m]);
            } else {
                // What holds nothing is not coupled to anything.
                *diagonal = 1.0;
            }
        }
        let far = squares.iter().map(|square| softest * square);
        Self {
            place,
            near,
            far: far.map(|own| if own > 0.0 { own } else { 1.0 }).collect(),
        }
    }
}

impl NearCompliance {
    /// Bytes held.
    pub(super) fn bytes(&self) -> u64 {
        self.near.bytes() + 16 * self.place.len() as u64
    }
}

impl SymmetricMatrix for NearCompliance {
    fn size(&self) -> usize {
        self.place.len()
    }

    fn entry(&self, row: usize, column: usize) -> f64 {
        match (self.place[row], self.place[column]) {
            (Some(i), Some(j)) => self.near.at(i as usize, j as usize),
            _ if row == column => self.far[row],
            _ => 0.0,
        }
    }

    fn product(&self, x: &[f64], y: &mut [f64]) {
        let mut small = vec![0.0; self.near.rows()];
        let places = x.iter().zip(&self.place);
        for (value, place) in places.filter_map(|(value, place)| Some((value, (*place)?))) {
            small[place as usize] = *value;
        }
        let mut product = vec![0.0; small.len()];
        self.near.multiply(&small, &mut product);
        for (index, place) in self.place.iter().enumerate() {
            y[index] = match place {
                Some(place) => product[*place as usize],
                None => self.far[index] * x[index],
            };
        }
    }

    fn principal_part(&self, selected: &[usize]) -> DenseMatrix {
        let mut part = DenseMatrix::zeros(selected.len(), selected.len());
        for (j, &column) in selected.iter().enumerate() {
            let entries = part.column_mut(j).iter_mut().zip(selected);
            entries.for_each(|(entry, &row)| *entry = self.entry(row, column));
        }
        part
    }
}

/// |C_i|^2 of all rows.
fn squares(rows: &SparseRows) -> Vec<f64> {
    let of_row = |row| {
        let (_, values) = rows.row(row);
        dot(values, values)
    };
    (0..rows.rows()).map(of_row).collect()
}

/// C K^-1 C^T of the `chosen` rows.
fn products(
    factor: &BodyFactor,
    rows: &SparseRows,
    chosen: &[usize],
    work: &mut Workspace,
) -> DenseMatrix {
    let size = factor.size();
    let mut matrix = DenseMatrix::zeros(chosen.len(), chosen.len());
    let mut loads = vec![0.0; BATCH.min(chosen.len()) * size];
    for (first, batch) in chosen.chunks(BATCH).enumerate() {
        let loads = &mut loads[..batch.len() * size];
        loads.fill(0.0);
        for (load, &row) in loads.chunks_exact_mut(size).zip(batch) {
            rows.add_row(row, 1.0, load);
        }
        factor.solve(loads, work);
        for (own, moved) in loads.chunks_exact(size).enumerate() {
            let column = matrix.column_mut(first * BATCH + own);
            let entries = column.iter_mut().zip(chosen);
            entries.for_each(|(entry, &row)| *entry = rows.row_product(row, moved));
        }
    }
    for j in 0..chosen.len() {
        for i in 0..j {
            let mean = 0.5 * (matrix.at(i, j) + matrix.at(j, i));
            (*matrix.at_mut(i, j), *matrix.at_mut(j, i)) = (mean, mean);
        }
        *matrix.at_mut(j, j) *= 1.0 + ROUNDING;
    }
    matrix
}

/// Which multipliers are near `[multipliers]`.
fn near(model: &Model<'_>, now: &Evaluation, state: &State) -> Vec<bool> {
    let mut near = vec![false; now.gap.len()];
    for interface in &model.interfaces.list {
        let reach = NEAR * mean_length(model, interface);
        let weights = interface.surface.weights.iter();
        for (place, weight) in interface.places().zip(weights) {
            near[place] |= !interface.is_contact()
                || state.status[place].is_closed()
                || now.gap[place] < reach * weight;
        }
    }
    if let Some(friction) = &model.interfaces.friction {
        let width = friction.components.count();
        let tractions = near.split_off(friction.first);
        let of_points = (friction.partners.iter())
            .flat_map(|&partner| std::iter::repeat_n(near[partner as usize], width));
        let of_points: Vec<bool> = of_points.collect();
        near.extend(&of_points);
        near.extend(&tractions[of_points.len()..]);
    }
    near
}

/// Mean length of the first edges of the faces of a surface, non-dimensional.
fn mean_length(model: &Model<'_>, interface: &Interface) -> f64 {
    let place = |vertex: u32| model.mesh.coordinates()[vertex as usize];
    let faces = &interface.surface.faces;
    let edges = faces.iter().map(|face| match face.corners[..] {
        [a, b, ..] => norm(sub(place(a), place(b))),
        _ => 0.0,
    });
    model.plan.problem.units.coordinate_scale * edges.sum::<f64>() / faces.len().max(1) as f64
}
