//! The laws of the cells in batches, and what a state leaves for products.

use std::sync::Arc;

use super::bend::Curve;
use super::by_point::{LaneLaw, TANGENT};
use super::kernel::BatchCells;
use super::laws::VolumeTerm;
use crate::assembly::grid::{CellGrid, Grid};
use crate::assembly::kernel::Batch;
use crate::assembly::lanes::{Lanes, Pack, WIDTH};
use crate::assembly::partition::blocks_of_cells;
use crate::element::quadrature::Rule;
use crate::material::{InvariantLaw, Isochoric, Rubber};
use crate::mesh::Mesh;

/// Laws, non-dimensional, and the law of each cell.
#[derive(Clone, Copy, Debug)]
pub struct CellLaws<'a> {
    /// By number.
    pub laws: &'a [Rubber],
    /// Number of the law `[cells]`.
    pub of_cell: &'a [u16],
}

/// A law as kernels take it: one of the parts is zero.
struct Split {
    invariants: InvariantLaw<f64>,
    by_point: LaneLaw,
    modulus: f64,
    compliance: f64,
}

impl Split {
    fn new(rubber: &Rubber) -> Self {
        let none = InvariantLaw {
            c10: 0.0,
            c01: 0.0,
            c20: 0.0,
            c30: 0.0,
        };
        let (invariants, by_point) = match &rubber.isochoric {
            Isochoric::Invariants(law) => (*law, None),
            law @ (Isochoric::Ogden(_)
            | Isochoric::Potential(_)
            | Isochoric::Hyperfoam(_)
            | Isochoric::Sheet(_)) => (none, Some(Arc::new(law.clone()))),
        };
        Self {
            invariants,
            by_point,
            modulus: rubber.shear_modulus(),
            compliance: rubber.inverse_bulk,
        }
    }
}

/// Coefficients of a batch.
#[derive(Clone, Debug)]
pub(super) struct BatchLaw {
    invariants: InvariantLaw<Lanes>,
    /// Absent where every lane has a law in invariants.
    by_point: Option<Box<[LaneLaw; WIDTH]>>,
    modulus: Lanes,
    /// 1 / K.
    compliance: Lanes,
}

impl BatchLaw {
    /// Missing lanes repeat the last cell.
    fn new(cells: &[u32], laws: &[Split], of_cell: &[u16]) -> Self {
        let law = |lane: usize| {
            let cell = cells[lane.min(cells.len() - 1)] as usize;
            &laws[usize::from(of_cell[cell])]
        };
        let lanes = |part: fn(&Split) -> f64| Lanes(std::array::from_fn(|lane| part(law(lane))));
        let by_point: [LaneLaw; WIDTH] = std::array::from_fn(|lane| law(lane).by_point.clone());
        Self {
            invariants: InvariantLaw {
                c10: lanes(|law| law.invariants.c10),
                c01: lanes(|law| law.invariants.c01),
                c20: lanes(|law| law.invariants.c20),
                c30: lanes(|law| law.invariants.c30),
            },
            by_point: (by_point.iter().any(Option::is_some)).then(|| Box::new(by_point)),
            modulus: lanes(|law| law.modulus),
            compliance: lanes(|law| law.compliance),
        }
    }

    /// Laws by point of one part's lanes; none where there are none at all.
    #[inline(always)]
    pub(super) fn by_point<S: pulp::Simd>(&self, part: usize) -> &[LaneLaw] {
        let lanes = part * S::F64_LANES..(part + 1) * S::F64_LANES;
        match &self.by_point {
            Some(by_point) => &by_point[lanes],
            None => &[],
        }
    }

    /// Shear modulus at rest.
    #[inline(always)]
    pub(super) fn modulus<S: pulp::Simd>(&self, simd: S, part: usize) -> Pack<S> {
        Pack::load(simd, &self.modulus, part)
    }

    /// The volume term of one part's lanes.
    #[inline(always)]
    pub(super) fn volume<S: pulp::Simd>(
        &self,
        simd: S,
        part: usize,
        stiffness: f64,
    ) -> VolumeTerm<S> {
        VolumeTerm {
            stiffness: self.modulus(simd, part) * stiffness,
            compliance: Pack::load(simd, &self.compliance, part),
        }
    }

    #[inline(always)]
    pub(super) fn load<S: pulp::Simd>(&self, simd: S, part: usize) -> InvariantLaw<Pack<S>> {
        let law = &self.invariants;
        InvariantLaw {
            c10: Pack::load(simd, &law.c10, part),
            c01: Pack::load(simd, &law.c01, part),
            c20: Pack::load(simd, &law.c20, part),
            c30: Pack::load(simd, &law.c30, part),
        }
    }
}

/// Cells of finite strain: the blocks of a grid with their laws and a rule.
#[derive(Clone, Debug)]
pub struct StrainGrid {
    pub(super) grid: Arc<Grid>,
    pub(super) rule: Rule,
    /// Of each block, by batches.
    pub(super) laws: Arc<Vec<Vec<BatchLaw>>>,
    /// Numbers of the tangent kept at each point; none for laws in invariants,
    /// which make it anew.
    tangents: usize,
    /// s.
    pub(super) penalty: f64,
}

impl StrainGrid {
    /// The cells of `grid`, made from the same `mesh`.
    pub fn new(mesh: &Mesh, grid: Arc<Grid>, laws: CellLaws<'_>, rule: Rule) -> Self {
        let blocks = blocks_of_cells(mesh);
        let split: Vec<Split> = laws.laws.iter().map(Split::new).collect();
        let of_block = |cells: &Vec<u32>| {
            let batches = cells.chunks(WIDTH);
            let laws = batches.map(|cells| BatchLaw::new(cells, &split, laws.of_cell));
            laws.collect()
        };
        let keeps_tangents = split.iter().any(|law| law.by_point.is_some());
        Self {
            tangents: if keeps_tangents { TANGENT } else { 0 },
            laws: Arc::new(blocks.iter().map(of_block).collect()),
            grid,
            rule,
            penalty: 0.0,
        }
    }

    /// The same cells with another s; laws are shared.
    #[must_use]
    pub fn penalised(&self, penalty: f64) -> Self {
        Self {
            penalty,
            ..self.clone()
        }
    }

    /// The same cells on another copy of their grid, to compare kernels.
    #[must_use]
    pub fn on(self, grid: Arc<Grid>) -> Self {
        Self { grid, ..self }
    }

    /// s.
    pub fn penalty(&self) -> f64 {
        self.penalty
    }

    /// The rule.
    pub fn rule(&self) -> &Rule {
        &self.rule
    }

    /// Points of the rule.
    pub fn points(&self) -> usize {
        self.rule.len()
    }

    /// Bytes held beside the grid.
    pub fn bytes(&self) -> u64 {
        let batches: usize = self.laws.iter().map(Vec::len).sum();
        (batches * size_of::<BatchLaw>()) as u64
    }

    /// Points that a stretch around the axis is kept at.
    pub(super) fn hoops(&self) -> usize {
        if self.grid.is_about_axis() {
            self.points()
        } else {
            0
        }
    }

    /// Lanes that a state leaves for one batch.
    pub(super) fn stride(&self) -> usize {
        let (vertices, components) = match &*self.grid {
            Grid::Triangles(_) => (3, 2),
            Grid::Tetrahedra(_) => (4, 3),
        };
        vertices * components * components
            + vertices
            + self.hoops()
            + (1 + self.tangents) * self.points()
    }
}

/// What a state leaves for products: vertex gradients, pressures, J^(-1/3) at the
/// points and, about an axis, the stretch around it, for laws by point the
/// tangent.
#[derive(Clone, Debug, Default)]
pub struct Linearised {
    /// Of each block, batch by batch.
    pub(super) blocks: Vec<Vec<Lanes>>,
}

impl Linearised {
    /// Bytes held.
    pub fn bytes(&self) -> u64 {
        let lanes: usize = self.blocks.iter().map(Vec::len).sum();
        (lanes * size_of::<Lanes>()) as u64
    }
}

/// Lanes of one batch.
pub(super) struct BatchState<'a, const V: usize, const D: usize>(pub(super) &'a [Lanes]);

impl<'a, const V: usize, const D: usize> BatchState<'a, V, D> {
    /// J^(-1/3) at the points.
    #[inline(always)]
    pub(super) fn roots(&self, points: usize) -> &'a [Lanes] {
        &self.0[V * D * D + V..][..points]
    }

    /// Stretches around the axis less one at the points, if any.
    #[inline(always)]
    pub(super) fn hoops(&self, points: usize, hoops: usize) -> &'a [Lanes] {
        &self.0[V * D * D + V + points..][..hoops]
    }

    /// Tangents at the points, if any.
    #[inline(always)]
    pub(super) fn tangents(&self, points: usize, hoops: usize) -> &'a [Lanes] {
        &self.0[V * D * D + V + points + hoops..]
    }

    #[inline(always)]
    pub(super) fn gradients<S: pulp::Simd>(
        &self,
        simd: S,
        part: usize,
    ) -> super::points::VertexGradients<S, V, D> {
        let mut out = [[[Pack::splat(simd, 0.0); D]; D]; V];
        for (j, gradient) in out.iter_mut().enumerate() {
            for i in 0..D {
                for k in 0..D {
                    gradient[i][k] = Pack::load(simd, &self.0[(j * D + i) * D + k], part);
                }
            }
        }
        out
    }

    #[inline(always)]
    pub(super) fn pressures<S: pulp::Simd>(&self, simd: S, part: usize) -> [Pack<S>; V] {
        let mut out = [Pack::splat(simd, 0.0); V];
        for (value, lanes) in out.iter_mut().zip(&self.0[V * D * D..]) {
            *value = Pack::load(simd, lanes, part);
        }
        out
    }
}

/// Batches of a block with their laws.
#[derive(Clone, Copy)]
pub(super) struct Batches<'a, const V: usize, const D: usize, const E: usize> {
    pub(super) batches: &'a [Batch<V, D, E>],
    pub(super) laws: &'a [BatchLaw],
    pub(super) rule: &'a Rule,
    /// Lanes that a state leaves for one batch.
    pub(super) stride: usize,
    /// Of the vertices, batch by batch, or empty.
    radii: &'a [Lanes],
    /// Of the last batches.
    curves: &'a [Curve<V, D, E>],
    /// Points that a stretch around the axis is kept at.
    pub(super) hoops: usize,
    /// s.
    pub(super) penalty: f64,
}

impl<'a, const V: usize, const D: usize, const E: usize> Batches<'a, V, D, E> {
    /// The block of `cells` that has `batches`.
    pub(super) fn new(cells: &'a StrainGrid, grid: &'a CellGrid<V, D, E>, block: usize) -> Self {
        Self {
            batches: grid.batches(block),
            curves: grid.curves(block),
            laws: &cells.laws[block],
            rule: &cells.rule,
            stride: cells.stride(),
            radii: grid.radii(block),
            hoops: cells.hoops(),
            penalty: cells.penalty,
        }
    }

    /// A batch with what its cells have beside it.
    #[inline(always)]
    pub(super) fn at(&self, index: usize) -> BatchCells<'a, V, D, E> {
        let straight = self.batches.len() - self.curves.len();
        BatchCells {
            batch: &self.batches[index],
            rule: self.rule,
            radii: (self.radii.get(V * index..V * (index + 1))).unwrap_or_default(),
            curve: index.checked_sub(straight).map(|place| &self.curves[place]),
        }
    }
}
