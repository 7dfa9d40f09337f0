//! Conjugate gradients on A11 to a fixed relative tolerance, preconditioned by
//! block incomplete Cholesky of level 0: the seed's P1 solver.
//!
//! J. Meijerink and H. van der Vorst, Math. Comp. 31, 1977. The iterations grow
//! like 1/h, and with them the cost; a fixed number of them instead would make
//! the outer counts grow. The map is not linear: the outer method must be
//! flexible.

use std::sync::Arc;

use crate::precond::symmetric_blocks::SymmetricBlocks;
use crate::precond::triangular_sweep::TriangularSweep;
use signorini::linalg::vector::{add_scaled, dot, norm, scale_and_add};
use signorini::linalg::{LinearOperator, Preconditioner, Workspace};
use signorini::precond::node_pairs::NodePairs;
use signorini::precond::p1::VertexBlocks;

/// Reduction of the residual: at 1e-2 the outer counts are those of a factor.
const REDUCTION: f64 = 1e-2;
/// More iterations than any sound matrix takes.
const MOST_ITERATIONS: usize = 1000;

/// A11 with its incomplete factor.
#[derive(Clone, Debug)]
pub(crate) struct IncompleteCholeskyCg<const C: usize> {
    /// A11 by nodes, which the conjugate gradients multiply with.
    matrix: SymmetricBlocks<C>,
    /// The incomplete factor without fill: a triangular sweep with a corrected
    /// diagonal.
    factor: TriangularSweep<C>,
}

/// The solver of `blocks`, and its bytes.
pub(crate) fn incomplete_cholesky_cg(blocks: &VertexBlocks<'_>) -> (Arc<dyn Preconditioner>, u64) {
    match blocks.components {
        2 => shared(IncompleteCholeskyCg::<2>::new(blocks)),
        _ => shared(IncompleteCholeskyCg::<3>::new(blocks)),
    }
}

/// The solver behind the trait, with the bytes that it holds.
fn shared<const C: usize>(solver: IncompleteCholeskyCg<C>) -> (Arc<dyn Preconditioner>, u64) {
    let bytes = solver.matrix.bytes() + solver.factor.bytes();
    (Arc::new(solver), bytes)
}

impl<const C: usize> IncompleteCholeskyCg<C> {
    /// Factorises `blocks` incompletely.
    pub(crate) fn new(blocks: &VertexBlocks<'_>) -> Self {
        let pairs = NodePairs {
            diagonal: blocks.diagonal,
            pairs: blocks.edges,
            off: blocks.off,
        };
        let matrix = SymmetricBlocks::new(&pairs, blocks.held.entries.iter().copied());
        Self {
            factor: TriangularSweep::incomplete(&matrix),
            matrix,
        }
    }

    /// Solves to the fixed reduction; returns the iterations.
    pub(crate) fn solve(&self, r: &[f64], x: &mut [f64], work: &mut Workspace) -> usize {
        x.fill(0.0);
        let mut residual = work.copy(r);
        let mut z = work.zeros(r.len());
        let mut product = work.zeros(r.len());
        let mut direction = work.zeros(r.len());
        let (bound, mut rz) = (REDUCTION * norm(r), 1.0);
        let mut iterations = 0;
        while iterations < MOST_ITERATIONS && norm(&residual) > bound {
            self.factor.apply(&residual, &mut z, work);
            let next = dot(&residual, &z);
            scale_and_add(&mut direction, next / rz, &z);
            rz = next;
            self.matrix.apply(&direction, &mut product, work);
            let step = rz / dot(&direction, &product);
            if !step.is_finite() {
                break;
            }
            add_scaled(x, step, &direction);
            add_scaled(&mut residual, -step, &product);
            iterations += 1;
        }
        for vector in [residual, z, product, direction] {
            work.give(vector);
        }
        iterations
    }
}

impl<const C: usize> Preconditioner for IncompleteCholeskyCg<C> {
    fn apply(&self, r: &[f64], z: &mut [f64], work: &mut Workspace) {
        self.solve(r, z, work);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use signorini::linalg::Held;
    use signorini::linalg::vector::{reproducible_noise, subtract_from};

    /// A bar of `vertices` in two dimensions, held at its first vertex.
    fn solver(vertices: usize) -> IncompleteCholeskyCg<2> {
        let node = [[2.0, 0.3, 0.0], [0.3, 1.0, 0.0], [0.0; 3]];
        let link = [[-1.0, 0.1, 0.0], [-0.1, -0.5, 0.0], [0.0; 3]];
        let edges: Vec<[u32; 2]> = (1..vertices as u32).map(|v| [v - 1, v]).collect();
        let blocks = VertexBlocks {
            components: 2,
            coordinates: &vec![[0.0; 3]; vertices],
            edges: &edges,
            diagonal: &vec![node; vertices],
            off: &vec![link; vertices - 1],
            held: &Held::of_entries(2, [0, 1]),
        };
        IncompleteCholeskyCg::new(&blocks)
    }

    #[test]
    fn the_residual_falls_by_the_promised_factor() {
        let solver = solver(200);
        let mut r = reproducible_noise(400);
        (r[0], r[1]) = (0.0, 0.0);
        let (mut z, mut product) = (vec![f64::NAN; 400], vec![0.0; 400]);
        let work = &mut Workspace::new();
        let iterations = solver.solve(&r, &mut z, work);
        solver.matrix.apply(&z, &mut product, work);
        subtract_from(&mut product, &r);
        assert!(norm(&product) <= REDUCTION * norm(&r));
        // A chain has no fill: the factor is exact, shifted only if it must be.
        let is_shifted = TriangularSweep::needs_shift(&solver.matrix);
        assert!(is_shifted || iterations == 1, "{iterations}");
    }

    #[test]
    fn no_load_gives_no_displacement() {
        let mut z = vec![f64::NAN; 8];
        solver(4).apply(&[0.0; 8], &mut z, &mut Workspace::new());
        assert!(z.iter().all(|&value| value == 0.0));
    }
}
