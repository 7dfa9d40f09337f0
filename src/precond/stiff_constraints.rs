//! Constraints that an approximate inverse knows: the body as if springs held them,
//!
//! ```text
//! A_s = A + C^T W C,      w_j = SHARE f(p_j) / (C D^-1 C^T)_jj,   f(p) = p max(1, p / COUPLED)
//! ```
//!
//! C `[constraints, displacement]`: the gaps that are closed; D: node blocks of A. A body
//! that presses with many shear moduli has no stable inverse without what holds it; with
//! springs some ten times as stiff as its nodes it has. Motions along the surface do
//! not feel them. A step with that inverse takes the springs off again
//! (`inequality::one_level::sprung`). Multipliers at the rim of contact that carry little, and
//! may open soon, have none. At P1 the springs of a vertex are lumped. Cost: one sparse product
//! with C and its transpose an application of A_s.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::NodeBlocks;
use crate::linalg::vector::{dot, norm};
use crate::linalg::{LinearOperator, ResidualUpdate, SparseRows, SparseRowsBuilder};
use stiffened::Stiffened;

mod stiffened;

/// Stiffness of a spring over that of the nodes which it holds: between 3 and 100 the
/// counts of a pressed block stay within two.
const SHARE: f64 = 10.0;
/// Pressure in shear moduli from which on springs grow with its square: it couples motions
/// along the surface, as stiff as the body, with those across it, and w mu > p^2 keeps the two
/// together positive.
const COUPLED: f64 = 10.0;
/// Largest factor of pressure: beyond, rounding hides a motion along an oblique surface from
/// any factor.
const HIGHEST: f64 = 1e8;
/// The same of a factor in single precision.
const HIGHEST_IN_SINGLE: f64 = 1e4;
/// Pressure over the mean from which on a constraint at the rim will not open soon.
const RIM: f64 = 0.5;

/// Which constraints press, and how much.
#[derive(Clone, Copy)]
pub struct Pressed<'a> {
    /// Which are closed `[constraints]`.
    pub closed: &'a [bool],
    /// What each carries, in shear moduli `[constraints]`.
    pub own: &'a [f64],
    /// Mean over those that are closed, in shear moduli.
    pub mean: f64,
}

impl Pressed<'_> {
    /// The pressure that the spring of a constraint is made for which is closed all around.
    fn inside(&self, row: usize) -> f64 {
        self.own[row].abs().max(self.mean)
    }

    /// The largest pressure that a spring is made for.
    fn highest(&self) -> f64 {
        let closed = self.own.iter().zip(self.closed);
        let own = closed
            .filter(|(_, closed)| **closed)
            .map(|(own, _)| own.abs());
        own.fold(self.mean, f64::max)
    }

    /// That of one at the rim; none where it carries too little to have a spring.
    fn at_the_rim(&self, row: usize) -> Option<f64> {
        let own = self.own[row].abs();
        (self.closed[row] && own > RIM * self.mean).then_some(own)
    }
}

/// The nodes of a body.
pub struct Nodes<'a> {
    /// Inverted Lagrange node blocks.
    pub blocks: &'a NodeBlocks,
    /// Number of vertices: nodes below are vertices, the others edges.
    pub vertices: usize,
    /// Ends of each edge `[edges]`.
    pub edges: &'a [[u32; 2]],
    /// Which unknowns are prescribed `[displacement]`.
    pub is_held: &'a [bool],
}

/// C and W, in both bases.
pub struct StiffConstraints {
    /// C on hierarchical displacements `[constraints, displacement]`.
    hierarchical: Arc<SparseRows>,
    /// C on Lagrange node values `[constraints, displacement]`.
    lagrange: Arc<SparseRows>,
    /// W, zero for constraints that are not held `[constraints]`.
    weights: Arc<[f64]>,
    /// Components of a node.
    components: usize,
    /// Largest factor of pressure among the springs.
    highest: f64,
}

impl StiffConstraints {
    /// Those of the rows of `coupling` that `pressed` says.
    pub fn new(coupling: &SparseRows, pressed: Pressed<'_>, nodes: &Nodes<'_>) -> Self {
        let lagrange = lagrange(coupling, nodes);
        let c = nodes.blocks.components();
        let is_inside = inside(coupling, pressed.closed);
        let weight = |row: usize| {
            let local: f64 = by_nodes(&lagrange, row, c)
                .iter()
                .map(|(node, a)| work(&nodes.blocks.block(*node as usize), a, c))
                .sum();
            let pressure = match is_inside[row] {
                true => Some(pressed.inside(row)),
                false => pressed.at_the_rim(row),
            };
            match pressure {
                Some(pressure) if local > 0.0 => SHARE * by_pressure(pressure) / local,
                Some(_) | None => 0.0,
            }
        };
        let weights: Vec<f64> = (0..coupling.rows()).map(weight).collect();
        Self {
            hierarchical: Arc::new(kept(coupling, &weights)),
            lagrange: Arc::new(kept(&lagrange, &weights)),
            weights: weights.into(),
            components: c,
            highest: by_pressure(pressed.highest()),
        }
    }

    /// Whether a factor in single precision knows motions along the surface beside the
    /// springs.
    pub fn bear_single_precision(&self) -> bool {
        self.highest <= HIGHEST_IN_SINGLE
    }

    /// W `[constraints]`.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Bytes held.
    pub fn bytes(&self) -> u64 {
        self.hierarchical.bytes() + self.lagrange.bytes() + 8 * self.weights.len() as u64
    }

    /// The springs at the nodes that move alone, in the Lagrange basis.
    pub fn at_nodes(&self, mut visit: impl FnMut(usize, [[f64; 3]; 3])) {
        for (row, weight) in self.present() {
            for (node, a) in by_nodes(&self.lagrange, row, self.components) {
                visit(node as usize, square(weight, &a));
            }
        }
    }

    /// The springs at the first `vertices` nodes as a P1 displacement feels them, lumped:
    /// what moves evenly feels the same.
    pub fn at_vertices(&self, vertices: usize, mut visit: impl FnMut(usize, [[f64; 3]; 3])) {
        for (row, weight) in self.present() {
            let mut own = by_nodes(&self.hierarchical, row, self.components);
            own.retain(|(node, a)| (*node as usize) < vertices && norm(a) > 0.0);
            let sum: f64 = own.iter().map(|(_, a)| norm(a)).sum();
            for (node, a) in own {
                visit(node as usize, square(weight * sum / norm(&a), &a));
            }
        }
    }

    /// Rows with a spring, and its stiffness.
    fn present(&self) -> impl Iterator<Item = (usize, f64)> {
        let weights = self.weights.iter().copied().enumerate();
        weights.filter(|&(_, weight)| weight > 0.0)
    }

    /// `inner` with springs on the rows of C in its basis.
    fn around<A: ?Sized>(&self, inner: Arc<A>, rows: &Arc<SparseRows>) -> Stiffened<A> {
        Stiffened {
            inner,
            rows: rows.clone(),
            weights: self.weights.clone(),
        }
    }

    /// A + C^T W C on Lagrange node values, `inner` being A there.
    pub fn on_lagrange(&self, inner: Arc<dyn LinearOperator>) -> Arc<dyn LinearOperator> {
        Arc::new(self.around(inner, &self.lagrange))
    }

    /// A + C^T W C on Lagrange node values in single precision, `inner` being A there.
    pub fn on_single_lagrange(
        &self,
        inner: Arc<dyn ResidualUpdate<f32>>,
    ) -> Arc<dyn ResidualUpdate<f32>> {
        Arc::new(self.around(inner, &self.lagrange))
    }

    /// A + C^T W C on hierarchical displacements, `inner` being A there.
    pub fn on_hierarchical(&self, inner: Arc<dyn LinearOperator>) -> Arc<dyn LinearOperator> {
        Arc::new(self.around(inner, &self.hierarchical))
    }
}

/// Which rows are closed and share no unknown with one that is not: those at the rim of
/// contact may open soon.
fn inside(coupling: &SparseRows, closed: &[bool]) -> Vec<bool> {
    let mut is_met = vec![false; coupling.columns()];
    for row in (0..coupling.rows()).filter(|&row| !closed[row]) {
        for &unknown in coupling.row(row).0 {
            is_met[unknown as usize] = true;
        }
    }
    let columns = |row: usize| coupling.row(row).0.iter();
    (0..coupling.rows())
        .map(|row| closed[row] && columns(row).all(|&unknown| !is_met[unknown as usize]))
        .collect()
}

/// Factor of the springs' stiffness under a mean pressure in shear moduli.
fn by_pressure(pressure: f64) -> f64 {
    (pressure * (pressure / COUPLED).max(1.0)).clamp(1.0, HIGHEST)
}

/// a.D^-1 a of one node.
fn work(block: &[f64], a: &[f64; 3], c: usize) -> f64 {
    (0..c)
        .map(|i| a[i] * dot(&block[i * c..(i + 1) * c], &a[..c]))
        .sum()
}

/// `weight` a a^T.
fn square(weight: f64, a: &[f64; 3]) -> [[f64; 3]; 3] {
    std::array::from_fn(|i| std::array::from_fn(|j| weight * a[i] * a[j]))
}

/// One row by nodes, ascending.
fn by_nodes(rows: &SparseRows, row: usize, c: usize) -> Vec<(u32, [f64; 3])> {
    let mut found: Vec<(u32, [f64; 3])> = Vec::new();
    let (columns, values) = rows.row(row);
    for (&unknown, &value) in columns.iter().zip(values) {
        let (node, i) = (unknown / c as u32, unknown as usize % c);
        if found.last().is_none_or(|last| last.0 != node) {
            found.push((node, [0.0; 3]));
        }
        if let Some(last) = found.last_mut() {
            last.1[i] += value;
        }
    }
    found
}

/// The rows with a weight; the others are empty.
fn kept(rows: &SparseRows, weights: &[f64]) -> SparseRows {
    let mut builder = SparseRowsBuilder::new(rows.columns());
    for (row, &weight) in weights.iter().enumerate() {
        let (columns, values) = rows.row(row);
        let entries = columns.iter().copied().zip(values.iter().copied());
        let mut entries: Vec<_> = entries.filter(|_| weight > 0.0).collect();
        builder.push_row(&mut entries);
    }
    builder.finish()
}

/// C on Lagrange values: a vertex that moves alone takes half of what its edges do with it.
fn lagrange(coupling: &SparseRows, nodes: &Nodes<'_>) -> SparseRows {
    let c = nodes.blocks.components();
    let mut builder = SparseRowsBuilder::new(coupling.columns());
    for row in 0..coupling.rows() {
        let (columns, values) = coupling.row(row);
        let mut sums: BTreeMap<u32, f64> = BTreeMap::new();
        for (&unknown, &value) in columns.iter().zip(values) {
            *sums.entry(unknown).or_default() += value;
            let (node, i) = (unknown as usize / c, unknown as usize % c);
            let Some(edge) = node.checked_sub(nodes.vertices) else {
                continue;
            };
            for &end in &nodes.edges[edge] {
                let place = end as usize * c + i;
                if !nodes.is_held[place] {
                    *sums.entry(place as u32).or_default() -= 0.5 * value;
                }
            }
        }
        builder.push_row(&mut sums.into_iter().collect::<Vec<_>>());
    }
    builder.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::Workspace;
    use crate::linalg::vector::reproducible_noise;
    use crate::precond::Transfer;

    /// Two triangles on a square: the gaps of four functions on the side y = 0 and of one on
    /// the side above, of which `closed` are closed.
    fn springs(closed: &[bool], held: &[u32]) -> StiffConstraints {
        let mut builder = SparseRowsBuilder::new(18);
        let rows: [&[(u32, f64)]; 4] = [
            &[(1, 0.3), (9, 0.1)],
            &[(1, 0.1), (3, 0.1), (9, 0.4)],
            &[(3, 0.3), (9, 0.1)],
            &[(5, 0.2), (7, 0.2)],
        ];
        for row in rows {
            builder.push_row(&mut row.to_vec());
        }
        let blocks = [2.0, 0.5, 0.5, 1.0].repeat(9);
        let mut is_held = vec![false; 18];
        held.iter()
            .for_each(|&index| is_held[index as usize] = true);
        let nodes = Nodes {
            blocks: &NodeBlocks::invert(2, blocks),
            vertices: 4,
            edges: &EDGES,
            is_held: &is_held,
        };
        let pressed = Pressed {
            closed,
            own: &[0.0; 4],
            mean: 0.0,
        };
        StiffConstraints::new(&builder.finish(), pressed, &nodes)
    }

    #[test]
    #[allow(clippy::float_cmp)] // Copied, not computed.
    fn what_carries_much_at_the_rim_has_a_spring_by_its_own_pressure() {
        let pressed = Pressed {
            closed: &[true, true, false],
            own: &[4.0, 0.5, 0.0],
            mean: 2.0,
        };
        let inside = [0, 1].map(|row| pressed.inside(row));
        assert_eq!(inside, [4.0, 2.0]);
        let at_the_rim = [0, 1, 2].map(|row| pressed.at_the_rim(row));
        assert_eq!(at_the_rim, [Some(4.0), None, None]);
    }

    const EDGES: [[u32; 2]; 5] = [[0, 1], [0, 2], [0, 3], [1, 3], [2, 3]];

    fn nothing() -> Arc<SparseRows> {
        let mut builder = SparseRowsBuilder::new(18);
        (0..18).for_each(|_| builder.push_row(&mut []));
        Arc::new(builder.finish())
    }

    fn energy(operator: &dyn LinearOperator, x: &[f64]) -> f64 {
        let mut product = vec![0.0; x.len()];
        operator.apply(x, &mut product, &mut Workspace::new());
        dot(x, &product)
    }

    #[test]
    fn springs_hold_what_is_closed_all_around() {
        let weights = |closed| springs(closed, &[]).weights().to_vec();
        let all = weights(&[true; 4]);
        assert!(all.iter().all(|&weight| weight > 0.0), "{all:?}");
        // The third is open, and the first and second meet it.
        let some = weights(&[true, true, false, true]);
        assert_eq!(
            some.iter().map(|w| *w > 0.0).collect::<Vec<_>>(),
            [false, false, false, true]
        );
    }

    #[test]
    fn springs_store_the_same_energy_in_both_bases() {
        for held in [&[][..], &[0, 3]] {
            let springs = springs(&[true; 4], held);
            let transfer = Transfer::new(4, 2, EDGES.into(), held.into());
            let mut values = reproducible_noise(18);
            held.iter().for_each(|&index| values[index as usize] = 0.0);
            let mut hierarchical = vec![0.0; 18];
            transfer.values_to_hierarchical(1.0, &values, &mut hierarchical);
            let none = nothing();
            let lagrange = energy(&*springs.on_lagrange(none.clone()), &values);
            let other = energy(&*springs.on_hierarchical(none), &hierarchical);
            assert!(lagrange > 0.0 && (lagrange - other).abs() < 1e-12 * lagrange);
        }
    }

    #[test]
    fn springs_in_single_precision_push_as_those_in_double() {
        struct Nothing;
        impl ResidualUpdate<f32> for Nothing {
            fn take_off(&self, _: &[f32], _: &mut [f32], _: &mut Workspace) {}
        }
        let springs = springs(&[true; 4], &[]);
        let x = reproducible_noise(18);
        let (mut r, mut narrow) = (vec![0.0; 18], vec![0.0_f32; 18]);
        let single: Vec<f32> = x.iter().map(|&x| x as f32).collect();
        let work = &mut Workspace::new();
        springs
            .on_lagrange(nothing())
            .subtract_product(&x, &mut r, work);
        springs
            .on_single_lagrange(Arc::new(Nothing))
            .take_off(&single, &mut narrow, work);
        let size = norm(&r);
        let pairs = r.iter().zip(&narrow);
        assert!(size > 0.1);
        pairs.for_each(|(r, n)| assert!((r - f64::from(*n)).abs() < 1e-6 * size));
    }

    #[test]
    fn a_node_that_moves_alone_and_a_p1_motion_feel_the_springs_that_are_there() {
        let springs = springs(&[true; 4], &[]);
        let operator = springs.on_lagrange(nothing());
        let mut alone = [0.0; 9];
        springs.at_nodes(|node, spring| alone[node] += spring[1][1]);
        for (node, own) in alone.iter().enumerate() {
            let mut x = vec![0.0; 18];
            x[2 * node + 1] = 1.0;
            assert!((energy(&*operator, &x) - own).abs() < 1e-12);
        }
        // An even motion of all vertices.
        let mut even = 0.0;
        springs.at_vertices(4, |_, spring| even += spring[1][1]);
        let x: Vec<f64> = [0.0, 1.0].repeat(9);
        assert!((energy(&*operator, &x) - even).abs() < 1e-12 * even);
    }
}
