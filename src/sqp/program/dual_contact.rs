//! Contact in the dual problem: the transposed rows and columns of what holds.
//!
//! ```text
//! slips:  t = a l + b w,   b . s + c w = 0    ([`Slide`]: a with the pressure, b across, c = |s| / |t|)
//! K has   C_l^T + C_t^T a   as the column of l,   C_l    as its row
//! K^T     C_l^T             as the column,        C_l + a . C_t   as the row
//! ```
//!
//! What sticks has a row and a column of its own; across the slip b w stays as it is. Columns are
//! with the turning of tangents, rows without. Without friction rows and columns are those of the
//! program. Shapes `[multipliers, displacement]`, non-dimensional. Cost: one pass over the entries.

use super::QuadraticProgram;
use crate::contact::shares::add_equal_columns;
use crate::inequality::Slide;
use crate::linalg::vector::norm;
use crate::linalg::{LinearOperator, SparseRows, SparseRowsBuilder};
use crate::model::friction::Law;
use crate::model::state::State;
use crate::saddle::{AdmissibleSet, FrictionBound, MultiplierBlock, ProductSet, SetPart, Status};

/// Contact of a dual problem.
pub(super) struct DualContact {
    /// Rows with those of what follows; none without friction.
    rows: Option<SparseRows>,
    /// What each multiplier does `[multipliers]`.
    pub(super) status: Vec<Status>,
    /// Points that slip in space, with what they give way to.
    across: Vec<Slide>,
    /// All points that slip.
    slides: Vec<Slide>,
}

impl DualContact {
    /// At the state of `program`.
    pub(super) fn new(program: &QuadraticProgram<'_>, state: &State) -> Self {
        let now = &program.now;
        let Some(law) = &now.friction else {
            return Self {
                rows: None,
                status: state.status.clone(),
                across: Vec::new(),
                slides: Vec::new(),
            };
        };
        let slides = slides(law, state, &now.gap);
        let across = slides.iter().filter(|slide| slide.width > 1);
        // Where no direction is known nothing acts.
        let mut status = state.status.clone();
        let own = status.iter_mut().enumerate();
        own.filter(|(place, one)| {
            **one == Status::Slip && !slides.iter().any(|s| holds(s, *place))
        })
        .for_each(|(_, one)| *one = Status::Open);
        Self {
            rows: Some(followed(&now.coupling, &slides)),
            status,
            across: across
                .map(|slide| Slide {
                    along: [0.0; 2],
                    ..*slide
                })
                .collect(),
            slides,
        }
    }

    /// The points that the method of faces treats as slipping.
    pub(super) fn across(&self) -> Vec<Slide> {
        self.across.clone()
    }

    /// C of the problem that `program` belongs to.
    pub(super) fn rows<'p>(&'p self, program: &'p QuadraticProgram<'_>) -> &'p SparseRows {
        self.rows.as_ref().unwrap_or(&program.now.coupling)
    }

    /// Gives the program's block of contact these rows and columns.
    pub(super) fn take_part<'p>(
        &'p self,
        program: &'p QuadraticProgram<'_>,
        block: MultiplierBlock<'p>,
    ) -> MultiplierBlock<'p> {
        let Some(rows) = &self.rows else {
            return block;
        };
        MultiplierBlock {
            rows,
            columns: program.contact_rows(),
            set: ProductSet::Uniform(SetPart {
                size: self.status.len(),
                set: AdmissibleSet::Free,
            }),
            ..block
        }
    }

    /// The right sides of the face's unknowns, from those of all multipliers, in place.
    pub(super) fn gather(&self, right: &mut [f64]) {
        for slide in &self.slides {
            let own: f64 = along(slide, right);
            right[slide.leader as usize] += own;
        }
        self.keep_across(right, &vec![0.0; right.len()]);
    }

    /// Leaves of `left` what the face's unknowns `y` answer.
    pub(super) fn keep_across(&self, left: &mut [f64], y: &[f64]) {
        for slide in &self.slides {
            let own = slide.first as usize..slide.first as usize + usize::from(slide.width);
            let across = |all: &[f64]| -> f64 {
                let parts = all[own.clone()].iter().zip(slide.across);
                parts.map(|(value, b)| value * b).sum()
            };
            let value = across(left) + slide.softness * across(y);
            let kept = slide.across.map(|b| b * value);
            left[own.clone()].copy_from_slice(&kept[..own.len()]);
        }
        let open = left.iter_mut().zip(&self.status);
        open.filter(|(_, status)| **status == Status::Open)
            .for_each(|(value, _)| *value = 0.0);
    }

    /// J_t - C_t y_u where points slip, zero elsewhere `[multipliers]`, from J of all multipliers
    /// and y_u: what y is to the law of friction; empty without.
    pub(super) fn of_law(&self, coupling: &SparseRows, (right, y): (&[f64], &[f64])) -> Vec<f64> {
        if self.rows.is_none() {
            return Vec::new();
        }
        let mut own = vec![0.0; self.status.len()];
        for slide in &self.slides {
            for i in 0..usize::from(slide.width) {
                let place = slide.first as usize + i;
                own[place] = right[place] - coupling.row_product(place, y);
            }
        }
        own
    }
}

/// Whether a multiplier is one of the numbers of a point.
fn holds(slide: &Slide, place: usize) -> bool {
    let first = slide.first as usize;
    (first..first + usize::from(slide.width)).contains(&place)
}

/// a . of the numbers of a point.
fn along(slide: &Slide, all: &[f64]) -> f64 {
    let first = slide.first as usize;
    let own = all[first..first + usize::from(slide.width)].iter();
    own.zip(slide.along).map(|(value, a)| value * a).sum()
}

/// The points that slip at a state with these slips among its `gaps`.
fn slides(law: &Law, state: &State, gaps: &[f64]) -> Vec<Slide> {
    let width = law.components.count();
    let radii = law.radii(&state.multiplier);
    let points = law.partners.iter().zip(&law.bounds).zip(radii).enumerate();
    let slide = |(number, ((&leader, bound), radius)): (usize, ((&u32, &FrictionBound), f64))| {
        let first = law.normals + number * width;
        let own = first..first + width;
        let traction = &state.multiplier[own.clone()];
        let size = norm(traction);
        let slips = state.status[first] == Status::Slip && size > 0.0 && radius > 0.0;
        slips.then(|| {
            let slope = bound.slope(state.multiplier[leader as usize]);
            let mut direction = [0.0; 2];
            let parts = direction.iter_mut().zip(traction);
            parts.for_each(|(e, t)| *e = t / size);
            Slide {
                leader,
                first: first as u32,
                width: width as u8,
                along: direction.map(|e| slope * e),
                across: match width {
                    1 => [0.0; 2],
                    _ => [-direction[1], direction[0]],
                },
                softness: norm(&gaps[own]) / radius,
            }
        })
    };
    points.filter_map(slide).collect()
}

/// The coupling with the rows of what follows added to those of what is followed.
fn followed(coupling: &SparseRows, slides: &[Slide]) -> SparseRows {
    let row_of = |place: usize| {
        let (columns, values) = coupling.row(place);
        columns.iter().copied().zip(values.iter().copied())
    };
    let mut rows: Vec<Vec<(u32, f64)>> = (0..coupling.rows())
        .map(|place| row_of(place).collect())
        .collect();
    for slide in slides {
        for i in 0..usize::from(slide.width) {
            let own = row_of(slide.first as usize + i);
            let own = own.map(|(column, value)| (column, slide.along[i] * value));
            let leader = &mut rows[slide.leader as usize];
            leader.extend(own);
            add_equal_columns(leader);
        }
    }
    let mut builder = SparseRowsBuilder::new(coupling.columns());
    rows.iter_mut().for_each(|row| builder.push_row(row));
    builder.finish()
}
