//! One component of a tie: gaps and coupling, as the contact integrals of obstacles give them.
//!
//! ```text
//! gap_j = -sum over nodes of rows_j u,   C = -dgap/du = rows   (carrier less other)
//! ```
//!
//! A multiplier is the traction of the carrier on the other body, per undeformed area. Shapes:
//! `[multipliers]`, non-dimensional. Cost: one product with the rows.

use super::cell::Value;
use super::seam::Seam;
use crate::contact::layout::Layout;
use crate::contact::shares::add_equal_columns;
use crate::contact::{Deformed, Linearisation};
use crate::geometry::vector3::{add, cross};

/// Rows of one component.
#[derive(Clone, Debug)]
pub struct Tied {
    /// Component of the displacement.
    pub component: usize,
    /// Values at unknowns of the carrier, and of the other body with the other sign `[multipliers]`.
    own: Vec<Vec<Value>>,
    other: Vec<Vec<Value>>,
    /// Both.
    rows: Vec<Vec<Value>>,
}

/// Force and moment about the origin on the body of the carrier, and on the other one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TieForce {
    /// On the carrier: force, moment.
    pub on_carrier: [[f64; 3]; 2],
    /// On the other body.
    pub on_other: [[f64; 3]; 2],
}

impl Tied {
    /// Component `component` of `components` of a seam whose functions have the multipliers of
    /// `layout`.
    pub fn new(seam: &Seam, layout: &Layout, [component, components]: [usize; 2]) -> Self {
        let unknown = |node: u32| node * components as u32 + component as u32;
        let gathered = |rows: &[Vec<Value>], sign: f64| {
            let row = |row: &Vec<Value>| {
                let entries = row.iter();
                let entries = entries.map(|&(node, value)| (unknown(node), sign * value));
                entries.collect::<Vec<Value>>()
            };
            layout.shares.gather_rows(rows.iter().map(row).collect())
        };
        let [own, other] = [gathered(&seam.own, 1.0), gathered(&seam.other, -1.0)];
        let rows = own.iter().zip(&other).map(|(own, other)| {
            let mut row = [&own[..], other].concat();
            add_equal_columns(&mut row);
            row
        });
        Self {
            component,
            rows: rows.collect(),
            own,
            other,
        }
    }

    /// Gaps of a body displaced by that.
    pub fn gaps(&self, displacement: &[f64]) -> Vec<f64> {
        let gap = |row: &Vec<Value>| {
            let terms = row
                .iter()
                .map(|&(k, value)| value * displacement[k as usize]);
            -terms.sum::<f64>()
        };
        self.rows.iter().map(gap).collect()
    }

    /// Gaps, and the coupling without `held` columns.
    pub fn linearise(&self, displacement: &[f64], held: &[bool]) -> Linearisation {
        let mut rows = self.rows.clone();
        rows.iter_mut()
            .for_each(|row| row.retain(|&(k, _)| !held[k as usize]));
        Linearisation {
            gap: self.gaps(displacement),
            rows,
            max_penetration: 0.0,
        }
    }

    /// Forces of `tractions` `[multipliers]` where the bodies are.
    pub fn forces(&self, body: &Deformed<'_>, tractions: &[f64]) -> TieForce {
        let sum = |rows: &[Vec<Value>]| {
            let mut sum = [[0.0; 3]; 2];
            for (row, traction) in rows.iter().zip(tractions) {
                for &(unknown, value) in row {
                    self.add(body, (unknown, -value * traction), &mut sum);
                }
            }
            sum
        };
        TieForce {
            on_carrier: sum(&self.own),
            on_other: sum(&self.other),
        }
    }

    /// Adds the force on an unknown.
    fn add(&self, body: &Deformed<'_>, (unknown, value): (u32, f64), sum: &mut [[f64; 3]; 2]) {
        let node = unknown as usize / body.space.components;
        let mut force = [0.0; 3];
        force[self.component] = value;
        let [total, moment] = sum;
        *moment = add(*moment, cross(body.place(node), force));
        // An even motion moves vertices alone: edges have what they are off the mean of these.
        if node < body.space.vertices {
            *total = add(*total, force);
        }
    }
}
