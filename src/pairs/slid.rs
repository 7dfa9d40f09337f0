//! How far surfaces of a linear body have slid along each other from where they rest:
//!
//! ```text
//! w_j = | (1 - n n^T) (mean v - mean u) |,   means over the vertices of row j, by their share in it
//! ```
//!
//! v and u the displacements of the other surface and of the carrier, n the direction of the force of j
//! on the other one, all of the row at rest (`rest`): where they pressed then they press ever after.
//! Lengths, non-dimensional. Cost: one pass over the rows.

use super::surface::PairSurface;
use crate::contact::Deformed;
use crate::geometry::vector3::{add, dot, norm, scale, sub};

/// Displacements of one side of a row.
#[derive(Clone, Copy, Default)]
struct Side {
    weight: f64,
    moved: [f64; 3],
    force: [f64; 3],
}

impl PairSurface {
    /// The farthest that functions with `pressures` above zero `[multipliers]` have slid; none at finite
    /// strain, where they meet what is there.
    pub fn slid(&self, body: &Deformed<'_>, pressures: &[f64]) -> Option<f64> {
        let rest = self.at_rest.as_ref()?;
        let others = self.other_nodes();
        let pressed = rest.rows.iter().zip(pressures);
        let ways = pressed.filter(|(_, pressure)| **pressure > 0.0);
        let ways = ways.map(|(row, _)| {
            let mut sides = [Side::default(); 2];
            for &(unknown, value) in row {
                let unknown = unknown as usize;
                let node = unknown / body.space.components;
                if node < body.space.vertices {
                    let is_other = others.contains(&(node as u32));
                    let axis = unknown % body.space.components;
                    sides[usize::from(is_other)].take(body, (node, axis), value);
                }
            }
            along(sides)
        });
        Some(ways.fold(0.0, f64::max))
    }
}

impl Side {
    fn take(&mut self, body: &Deformed<'_>, (node, axis): (usize, usize), value: f64) {
        let first = node * body.space.components;
        let mut moved = [0.0; 3];
        for (own, of_node) in moved
            .iter_mut()
            .take(body.space.components)
            .zip(&body.displacement[first..])
        {
            *own = *of_node;
        }
        self.weight += value.abs();
        self.moved = add(self.moved, scale(value.abs(), moved));
        self.force[axis] += value;
    }

    fn mean(&self) -> [f64; 3] {
        scale(self.weight.recip(), self.moved)
    }
}

/// How far one side has moved against the other across the force.
fn along([carrier, other]: [Side; 2]) -> f64 {
    let size = norm(other.force);
    if size == 0.0 || carrier.weight == 0.0 {
        return 0.0;
    }
    let normal = scale(size.recip(), other.force);
    let moved = sub(other.mean(), carrier.mean());
    norm(sub(moved, scale(dot(moved, normal), normal)))
}
