//! Forces of a contact on both of its surfaces, derivatives of its gaps and slips by the places of
//! nodes:
//!
//! ```text
//! f = sum_j Lam_j dG_j/dx + t_j R_j,   over the nodes of either side
//! ```
//!
//! Where both sides are of one body, pieces know the side of their nodes, even where a node is of
//! both. Shapes: pressures and tractions `[multipliers]`; non-dimensional. Cost: that of first
//! derivatives.

use super::pair::Placed;
use super::piece::{INPUTS, NODES, OTHER, Section};
use super::plane::PlaneSides;
use super::slip::Sliding;
use super::space::SpaceSides;
use super::surface::{PairForce, PairSurface, Sides};
use crate::contact::{ContactSurface, Deformed};
use crate::geometry::vector3::add;

/// What functions of a face move of the nodes of a piece.
struct SidedPart<'a> {
    face: usize,
    nodes: &'a [u32; NODES],
    rows: [[f64; INPUTS]; 3],
}

impl PairSurface {
    /// Forces of `pressures` `[multipliers]` on both bodies: derivatives of the gaps.
    pub fn forces(
        &self,
        body: &Deformed<'_>,
        (surface, pressures): (&ContactSurface, &[f64]),
    ) -> PairForce {
        if let Some(sides) = self.folded_in_space() {
            let pressures = surface.shares.spread(pressures);
            return match self.at_rest {
                None => sides.forces(body, &pressures),
                Some(_) => {
                    let still = vec![0.0; body.displacement.len()];
                    sides.forces_at_rest([body, &body.displaced(&still)], &pressures)
                }
            };
        }
        let Some(sides) = self.folded() else {
            let free = vec![false; body.space.displacement_unknowns()];
            let rows = self.linearise(body, surface, &free).rows;
            let pushing: Vec<f64> = pressures.iter().map(|pressure| -pressure).collect();
            return self.forces_of(body, &rows, &pushing);
        };
        let coefficients = surface.shares.spread(pressures);
        let parts = self.where_taken(sides, (body, surface), |placed| match &self.at_rest {
            Some(_) => placed.gaps_at_rest(),
            None => placed.first(),
        });
        let parts = parts.iter().map(|part| SidedPart {
            face: part.face,
            nodes: &part.nodes,
            rows: [0, 1, 2].map(|k: usize| part.gaps[k].first),
        });
        forces_of_parts(sides, (body, parts), &sides.of_faces(&coefficients))
    }

    /// Force on each face of the carrier in the plane or about an axis `[faces][3]`; none in space.
    pub fn face_forces(
        &self,
        body: &Deformed<'_>,
        (surface, pressures): (&ContactSurface, &[f64]),
    ) -> Option<Vec<[f64; 3]>> {
        let sides = self.plane()?;
        let coefficients = surface.shares.spread(pressures);
        let parts = self.where_taken(sides, (body, surface), |placed| match &self.at_rest {
            Some(_) => placed.gaps_at_rest(),
            None => placed.first(),
        });
        let factors = sides.of_faces(&coefficients);
        let mut forces = vec![[0.0; 3]; surface.faces.len()];
        for part in &parts {
            let one = SidedPart {
                face: part.face,
                nodes: &part.nodes,
                rows: [0, 1, 2].map(|k: usize| part.gaps[k].first),
            };
            let own = forces_of_parts(sides, (body, std::iter::once(one)), &factors);
            forces[part.face] = add(forces[part.face], own.on_carrier);
        }
        Some(forces)
    }

    /// Forces of `tractions` `[multipliers]` on both bodies along the rows of `sliding`.
    pub fn forces_of_tractions(
        &self,
        body: &Deformed<'_>,
        (surface, sliding): (&ContactSurface, &Sliding),
        tractions: &[f64],
    ) -> PairForce {
        let Some(sides) = self.folded() else {
            return self.forces_of(body, &sliding.rows, tractions);
        };
        let coefficients = surface.shares.spread(tractions);
        let start = |node: u32| {
            let [x, y, _] = body.place(node as usize);
            [x, y]
        };
        let parts = self.where_taken(sides, (body, surface), |placed| match &self.at_rest {
            Some(_) => placed.slips_at_rest(),
            None => placed.slid(&start),
        });
        let parts = parts.iter().map(|part| SidedPart {
            face: part.face,
            nodes: &part.nodes,
            rows: part.rows,
        });
        forces_of_parts(sides, (body, parts), &sides.of_faces(&coefficients))
    }

    /// Both sides in the plane or about an axis where they are of one body.
    fn folded(&self) -> Option<&PlaneSides> {
        self.plane().filter(|sides| sides.pair.fold.is_some())
    }

    /// The same in space.
    fn folded_in_space(&self) -> Option<&SpaceSides> {
        match &self.sides {
            Sides::Space(sides) if sides.pair.fold.is_some() => Some(sides),
            Sides::Space(_) | Sides::Plane(_) => None,
        }
    }

    /// What `task` makes of the surfaces where their gaps are taken: of a linear body at rest.
    fn where_taken<T>(
        &self,
        sides: &PlaneSides,
        (body, surface): (&Deformed<'_>, &ContactSurface),
        task: impl FnOnce(&Placed<'_>) -> T,
    ) -> T {
        if self.at_rest.is_none() {
            return sides.placed((body, surface), task);
        }
        let rest = vec![0.0; body.displacement.len()];
        let rest = Deformed {
            displacement: &rest,
            ..*body
        };
        let moved = self.touching(&rest, surface);
        let touching = Deformed {
            displacement: &moved,
            ..rest
        };
        sides.placed((&touching, surface), task)
    }
}

/// Forces of functions with `factors` `[faces]` along the rows of `parts`.
fn forces_of_parts<'p>(
    sides: &PlaneSides,
    (body, parts): (&Deformed<'_>, impl Iterator<Item = SidedPart<'p>>),
    factors: &[[f64; 3]],
) -> PairForce {
    let mut sum = PairForce::default();
    for part in parts {
        for (place, &node) in part.nodes.iter().enumerate() {
            let along = |i: usize| -> f64 {
                let pairs = part.rows.iter().zip(factors[part.face]);
                pairs.map(|(row, factor)| factor * row[2 * place + i]).sum()
            };
            sum.add(body, (node, [along(0), along(1), 0.0]), place >= OTHER);
        }
    }
    match sides.pair.section {
        Section::Plane => sum,
        Section::AboutAxis => sum.about_axis(),
    }
}
