//! The metric of a block step on one face: the compliance on what is unknown there,
//!
//! ```text
//! K_ss            its Cholesky factor, where nothing slips
//! R K P + c       its LU factor, R the constraints and P the forces of what slips (`Slide`)
//! ```
//!
//! Cost: a third, or two thirds, of the cube of the number of unknowns.

use std::cell::RefCell;
use std::sync::Arc;

use super::GAP_WEIGHT;
use super::slides::{Shape, gather};
use crate::inequality::Slide;
use crate::inequality::blocks::ContactBlock;
use crate::linalg::vector::{add_scaled, norm};
use crate::linalg::{
    DenseLu, DenseMatrix, FactoriseError, PartFactor, Preconditioner, SymmetricMatrix, Workspace,
};

/// Least cosine between directions of slip for which the factor of an earlier face serves:
/// they turn much on the way from face to face only where sides change, too.
const ALIKE: f64 = 0.9;

/// The factor of the last face where points slip, which serves as long as they only turn.
pub(super) type LastFactor = RefCell<Option<Known>>;

/// A factor with the face that it belongs to.
pub(super) struct Known {
    /// Unknowns of the face, ascending.
    selected: Vec<usize>,
    /// Its points that slip.
    slides: Vec<Slide>,
    /// The factor on them.
    factor: Arc<FaceFactor>,
}

impl Known {
    /// Whether a face has the same unknowns, and its points slip in about the same directions.
    fn serves(&self, selected: &[usize], slides: &[Slide]) -> bool {
        let is_alike = |(a, b): (&Slide, &Slide)| {
            let along: f64 = a.along.iter().zip(b.along).map(|(a, b)| a * b).sum();
            let sizes = norm(&a.along) * norm(&b.along);
            a.first == b.first && along >= ALIKE * sizes
        };
        self.selected == selected
            && self.slides.len() == slides.len()
            && self.slides.iter().zip(slides).all(is_alike)
    }
}

/// The weighted compliance's inverse on the face.
pub(super) struct FaceMetric<'a> {
    /// Indices of the multipliers that stick, ascending.
    selected: Vec<usize>,
    /// Moduli by which their residuals are weighted besides; empty where all are one.
    moduli: &'a [f64],
    /// Factor of the compliance's principal part on them.
    factor: Arc<FaceFactor>,
}

/// A factor of the compliance on a face.
pub(super) enum FaceFactor {
    /// Where nothing follows: symmetric.
    Cholesky(Arc<dyn PartFactor>),
    /// With the columns of what follows added to those of what is followed.
    Lu(DenseLu),
}

impl FaceFactor {
    /// Of `matrix` on `selected` with points that slip.
    fn new(
        matrix: &dyn SymmetricMatrix,
        selected: &[usize],
        slides: &[Slide],
    ) -> Result<Self, FactoriseError> {
        if slides.is_empty() {
            return Ok(Self::Cholesky(matrix.factor_of_part(selected)?));
        }
        let own =
            |slide: &Slide| slide.first as usize..(slide.first as usize + usize::from(slide.width));
        let mut all: Vec<usize> = selected.to_vec();
        all.extend(slides.iter().flat_map(own));
        all.sort_unstable();
        all.dedup();
        let place = |index: u32| all.partition_point(|&other| other < index as usize) as u32;
        let within: Vec<Slide> = slides
            .iter()
            .map(|slide| Slide {
                leader: place(slide.leader),
                first: place(slide.first),
                ..*slide
            })
            .collect();
        let mut whole = matrix.part_again(&all);
        combine(&mut whole, &within);
        let own: Vec<usize> = selected
            .iter()
            .map(|&index| place(index as u32) as usize)
            .collect();
        match DenseLu::new(&whole.principal(&own)) {
            Ok(factor) => Ok(Self::Lu(factor)),
            // At the edge of what friction holds; without what slips it is regular.
            Err(_) => Ok(Self::Cholesky(matrix.factor_of_part(selected)?)),
        }
    }

    fn solve(&self, x: &mut [f64], work: &mut Workspace) {
        match self {
            Self::Cholesky(factor) => factor.solve_part(x, work),
            Self::Lu(factor) => factor.solve(x),
        }
    }
}

/// Columns of forces, then rows of constraints, of the points that slip, with their softness.
fn combine(matrix: &mut DenseMatrix, slides: &[Slide]) {
    for slide in slides {
        let own = slide.first as usize;
        let columns: Vec<Vec<f64>> = (own..own + usize::from(slide.width))
            .map(|column| matrix.column(column).to_vec())
            .collect();
        let mut across = vec![0.0; matrix.rows()];
        for (i, column) in columns.iter().enumerate() {
            add_scaled(
                matrix.column_mut(slide.leader as usize),
                slide.along[i],
                column,
            );
            add_scaled(&mut across, slide.across[i], column);
        }
        matrix.column_mut(own).copy_from_slice(&across);
    }
    for column in 0..matrix.columns() {
        gather(slides, matrix.column_mut(column));
    }
    for slide in slides.iter().filter(|slide| slide.width > 1) {
        *matrix.at_mut(slide.first as usize, slide.first as usize) += slide.softness;
    }
}

impl<'a> FaceMetric<'a> {
    /// Factorises the compliance on the multipliers that stick. Cost: a third of the
    /// cube of their number.
    pub(super) fn new(
        contact: &ContactBlock<'a>,
        face: &Shape<'_>,
        last: &LastFactor,
    ) -> Result<Self, FactoriseError> {
        let is_unknown = |&i: &usize| face.unknowns[i];
        let selected: Vec<usize> = (0..face.unknowns.len()).filter(is_unknown).collect();
        let mut last = last.borrow_mut();
        let known = last
            .as_ref()
            .filter(|known| !face.slides.is_empty() && known.serves(&selected, face.slides));
        let factor = match known {
            Some(known) => known.factor.clone(),
            None => {
                let matrix = contact.matrix;
                let factor = Arc::new(FaceFactor::new(matrix, &selected, face.slides)?);
                *last = Some(Known {
                    selected: selected.clone(),
                    slides: face.slides.to_vec(),
                    factor: factor.clone(),
                });
                factor
            }
        };
        Ok(Self {
            factor,
            moduli: contact.moduli,
            selected,
        })
    }
}

impl Preconditioner for FaceMetric<'_> {
    fn apply(&self, r: &[f64], z: &mut [f64], work: &mut Workspace) {
        let mut small = work.scratch(self.selected.len());
        let modulus = |index: usize| self.moduli.get(index).copied().unwrap_or(1.0);
        for (value, &index) in small.iter_mut().zip(&self.selected) {
            *value = r[index] / modulus(index);
        }
        self.factor.solve(&mut small, work);
        z.fill(0.0);
        for (value, &index) in small.iter().zip(&self.selected) {
            z[index] = *value / (GAP_WEIGHT * GAP_WEIGHT) / modulus(index);
        }
        work.give(small);
    }
}
