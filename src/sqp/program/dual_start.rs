//! Where a dual problem begins: at the best combination of solutions of earlier increments,
//!
//! ```text
//! min over c   | J_x - K^T sum of c_k y_k |,   gaps weighed as on faces
//! ```
//!
//! What opens since has no part in y. Non-dimensional. Cost: one product with K for each solution.

use std::sync::Arc;

use super::QuadraticProgram;
use super::dual::DualProblem;
use crate::linalg::Workspace;
use crate::linalg::vector::dot;
use crate::saddle::Status;
use crate::sqp::fields::Fields;

constants! {
    /// Squared weight of gaps beside forces, as on the faces of the method.
    const GAPS: f64 = 100.0;
    /// A product this much shorter than it was, squared, is that of others.
    const DEPENDENT: f64 = 1e-12;
}

/// A direction with its product, which is orthogonal to those before it.
struct Pair {
    y: Fields,
    product: Fields,
    square: f64,
}

impl QuadraticProgram<'_> {
    /// Makes `solution`, which is zero, the best of `known` ones; whether there are any.
    pub(super) fn begin(
        &self,
        problem: &DualProblem<'_>,
        known: &[Arc<Fields>],
        solution: &mut Fields,
        work: &mut Workspace,
    ) -> bool {
        let mut pairs: Vec<Pair> = Vec::with_capacity(known.len());
        for y in known.iter().filter(|y| y.is_like(problem.right)) {
            let mut pair = self.pair(problem, y, work);
            let before = pair.square;
            for other in &pairs {
                let share = weighed(&pair.product, &other.product) / other.square;
                pair.y.add_multiple(-share, &other.y);
                pair.product.add_multiple(-share, &other.product);
            }
            pair.square = weighed(&pair.product, &pair.product);
            if pair.square > DEPENDENT * before {
                let step = weighed(problem.right, &pair.product) / pair.square;
                solution.add_multiple(step, &pair.y);
                pairs.push(pair);
            }
        }
        !pairs.is_empty()
    }

    fn pair(&self, problem: &DualProblem<'_>, y: &Fields, work: &mut Workspace) -> Pair {
        let nothing = Fields::zeros_like(problem.right);
        let mut y = y.clone();
        let own = y.multiplier.iter_mut().zip(&problem.contact.status);
        own.filter(|(_, status)| **status == Status::Open)
            .for_each(|(value, _)| *value = 0.0);
        let of_zero = DualProblem {
            right: &nothing,
            ..*problem
        };
        let left = self.residual(&of_zero, &y, work);
        let mut product = nothing.clone();
        product.add_multiple(-1.0, &left);
        Pair {
            square: weighed(&product, &product),
            y,
            product,
        }
    }
}

fn weighed(a: &Fields, b: &Fields) -> f64 {
    dot(&a.displacement, &b.displacement)
        + dot(&a.pressure, &b.pressure)
        + GAPS * dot(&a.multiplier, &b.multiplier)
}
