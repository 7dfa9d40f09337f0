//! From the P1 blocks to a hierarchy: assembled in `f64`, each level stored in
//! the hierarchy's own number type as soon as the next one is made.

use super::AmgError;
use super::VertexBlocks;
use super::aggregate::{Aggregates, aggregate};
use super::block_rows::{Block, BlockRows, Pattern};
use super::coarsest::Coarsest;
use super::cycle::{Hierarchy, Level};
use super::galerkin::galerkin;
use super::modes::{Modes, rigid_modes};
use super::prolongate::{smoothed, tentative};
use super::smoother::{Smoother, inverse_diagonal, largest_eigenvalue};
use super::strength::{COARSE_THRESHOLD, THRESHOLD, couplings};
use crate::linalg::Scalar;
use crate::linalg::Workspace;

/// Nodes that are few enough for a dense inverse.
const COARSEST: usize = 128;
/// Damping of the prolongator's smoothing, over the bound of the largest
/// eigenvalue. The classical 4/3 leaves a condition of 2.0 on cubes of 5 k to
/// 43 k vertices, 1.8 leaves 1.7 at the same cost; 2 is no better.
const DAMPING: f64 = 1.8;

/// The hierarchy of `blocks`.
pub(super) fn hierarchy<S: Scalar, const N: usize, const K: usize>(
    blocks: &VertexBlocks<'_>,
) -> Result<Hierarchy<S, N, K>, AmgError> {
    let modes = rigid_modes(blocks.coordinates, blocks.held);
    let (finest, mut matrix, mut modes) =
        coarsen::<S, N, K>(&fine_matrix(blocks), &modes, THRESHOLD)?;
    let mut coarser = Vec::new();
    while matrix.rows() > COARSEST {
        let (level, next, next_modes) = coarsen::<S, K, K>(&matrix, &modes, COARSE_THRESHOLD)?;
        coarser.push(level);
        (matrix, modes) = (next, next_modes);
    }
    Ok(Hierarchy {
        finest,
        coarser,
        coarsest: Coarsest::new(&matrix)?,
    })
}

/// A level with the matrix of the next coarser one.
type Coarsened<S, const N: usize, const K: usize> =
    (Level<S, N, K>, BlockRows<f64, K, K>, Modes<K, K>);

/// A level of `matrix`, and matrix and modes of the next one.
pub(super) fn coarsen<S: Scalar, const N: usize, const K: usize>(
    matrix: &BlockRows<f64, N, N>,
    modes: &Modes<N, K>,
    threshold: f32,
) -> Result<Coarsened<S, N, K>, AmgError> {
    let inverse = inverse_diagonal(matrix)?;
    let largest = largest_eigenvalue(matrix, &inverse, &mut Workspace::new());
    let takes_part: Vec<bool> = modes
        .iter()
        .map(|node| node.iter().flatten().any(|&entry| entry != 0.0))
        .collect();
    let groups = groups_of(matrix, threshold, &takes_part)?;
    // The modes of a group are reproduced exactly; smoothing by one damped Jacobi step
    // then lowers the energy of the prolonged functions.
    let (plain, coarse_modes) = tentative(&groups, modes);
    let prolongation = smoothed(matrix, &inverse, &plain, DAMPING / largest);
    let restriction = prolongation.transposed();
    let coarse = galerkin(matrix, &prolongation, &restriction);
    let level = Level {
        matrix: matrix.converted(),
        smoother: Smoother::new(&inverse, largest),
        prolongation: prolongation.converted(),
        restriction: restriction.converted(),
    };
    Ok((level, coarse, coarse_modes))
}

/// Groups of strongly coupled nodes; of coupled ones where that would stall, as
/// it does on small levels of graded meshes.
fn groups_of<const N: usize>(
    matrix: &BlockRows<f64, N, N>,
    threshold: f32,
    takes_part: &[bool],
) -> Result<Aggregates, AmgError> {
    let mut count = 0;
    // A level that is not half as large as this one is not worth its cost.
    for threshold in [threshold, 0.0] {
        let couplings = couplings(matrix, threshold);
        let groups = aggregate(&matrix.pattern, &couplings, takes_part);
        if 2 * groups.count <= matrix.rows().max(2) {
            return Ok(groups);
        }
        count = groups.count;
    }
    Err(AmgError::Stalled {
        nodes: matrix.rows(),
        groups: count,
    })
}

/// A11 by block rows; held components are the identity, blocks that are held
/// throughout are left out.
pub(super) fn fine_matrix<const N: usize>(blocks: &VertexBlocks<'_>) -> BlockRows<f64, N, N> {
    let vertices = blocks.coordinates.len();
    let mut is_held = vec![[false; N]; vertices];
    for &unknown in blocks.held.entries.iter() {
        if let Some(vertex) = is_held.get_mut(unknown as usize / N) {
            vertex[unknown as usize % N] = true;
        }
    }
    let is_free = |vertex: u32| is_held[vertex as usize].iter().any(|held| !held);
    let couples = |ends: &[u32; 2]| is_free(ends[0]) && is_free(ends[1]);
    // Row lengths: one for the diagonal, one for each coupling with a free vertex.
    let mut offsets = vec![0_u32; vertices + 1];
    for ends in blocks.edges.iter().filter(|ends| couples(ends)) {
        offsets[ends[0] as usize + 1] += 1;
        offsets[ends[1] as usize + 1] += 1;
    }
    for vertex in 0..vertices {
        offsets[vertex + 1] += offsets[vertex] + 1;
    }
    let mut filler = Filler {
        next: offsets.clone(),
        indices: vec![0; offsets[vertices] as usize],
        blocks: vec![[[0.0; N]; N]; offsets[vertices] as usize],
        is_held: &is_held,
    };
    // Edges ascend by their lower, then their upper end: so do the columns.
    let edges = || blocks.edges.iter().zip(blocks.off);
    for (ends, block) in edges().filter(|(ends, _)| couples(ends)) {
        filler.push(ends[1], ends[0], |i, j| block[j][i]);
    }
    for (vertex, block) in blocks.diagonal.iter().enumerate() {
        filler.push(vertex as u32, vertex as u32, |i, j| block[i][j]);
    }
    for (ends, block) in edges().filter(|(ends, _)| couples(ends)) {
        filler.push(ends[0], ends[1], |i, j| block[i][j]);
    }
    BlockRows {
        columns: vertices,
        pattern: Pattern {
            offsets,
            indices: filler.indices,
        },
        blocks: filler.blocks,
    }
}

/// Fills the finest matrix from diagonal blocks and couplings, rows and columns of held
/// components those of the identity.
struct Filler<'a, const N: usize> {
    /// Next free place in each row.
    next: Vec<u32>,
    /// Column of each block.
    indices: Vec<u32>,
    /// The blocks, in the order of `indices`.
    blocks: Vec<Block<f64, N, N>>,
    /// Whether supports hold a component of a vertex `[vertices][N]`.
    is_held: &'a [[bool; N]],
}

impl<const N: usize> Filler<'_, N> {
    /// Stores one block at the next place of its row; held rows and columns are those
    /// of the identity.
    fn push(&mut self, row: u32, column: u32, entry: impl Fn(usize, usize) -> f64) {
        let slot = self.next[row as usize] as usize;
        self.next[row as usize] += 1;
        self.indices[slot] = column;
        let (held, other) = (&self.is_held[row as usize], &self.is_held[column as usize]);
        for i in 0..N {
            for j in 0..N {
                self.blocks[slot][i][j] = if held[i] || other[j] {
                    f64::from(u8::from(row == column && i == j))
                } else {
                    entry(i, j)
                };
            }
        }
    }
}
