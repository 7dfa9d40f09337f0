//! Both sides of a contact in space, with the functions of the first one.
//!
//! Shapes: of each face of the carrier the functions of its corners and edges, in the order that turns
//! its normal out of the body. Cost: see [`super::pair`].

use super::fold::SpaceFold;
use super::frames::{Tangents, tangents};
use super::pair::{Pair, Placed};
use super::patch::NODES;
use super::probing::Probing;
use super::skin::Skin;
use super::sums::SpaceGaps;
use crate::contact::{ContactSurface, Deformed};
use crate::pairs::fold::Meets;
use crate::pairs::ground::Ground;

/// Two surfaces and the functions of the first one.
#[derive(Clone, Debug)]
pub struct SpaceSides {
    pub(in crate::pairs) pair: Pair,
    /// Functions of each face of the carrier `[faces]`.
    functions: Vec<[u32; NODES]>,
    /// What tangents of the functions follow `[functions]`.
    tangents: Vec<Tangents>,
}

impl SpaceSides {
    /// Of the facets `carrier`, those of `surface` in their order, and `other`, which it `meets`.
    pub(in crate::pairs) fn new(
        ground: Ground<'_>,
        ([carrier, other], meets): ([&[u32]; 2], Meets),
        surface: &ContactSurface,
    ) -> Self {
        let Ground { mesh, space, .. } = ground;
        let carrier = Skin::new(mesh, space, carrier).between_walls(mesh, ground.is_held);
        let other = Skin::new(mesh, space, other);
        let pair = Pair {
            fold: SpaceFold::new((mesh, space), [&carrier, &other], meets),
            carrier,
            other,
        };
        let faces = pair.carrier.faces.iter().zip(&surface.faces);
        let functions = faces.map(|(face, own)| {
            let function = |k: usize| own.functions.get(k).copied().unwrap_or(0);
            // Corners 0 and 1 change places, and so do the edges (0,2) and (1,2).
            let order = if face.is_turned {
                [1, 0, 2, 3, 5, 4]
            } else {
                [0, 1, 2, 3, 4, 5]
            };
            order.map(function)
        });
        let functions: Vec<[u32; NODES]> = functions.collect();
        let count = surface.carriers.len();
        Self {
            tangents: tangents(ground, [&pair.carrier, &pair.other], (&functions, count)),
            functions,
            pair,
        }
    }

    /// What tangents of a function follow.
    pub(super) fn tangents(&self, function: u32) -> &Tangents {
        &self.tangents[function as usize]
    }

    /// Functions of a face of the carrier.
    pub(super) fn functions_of(&self, face: usize) -> [u32; NODES] {
        self.functions[face]
    }

    /// The surfaces where `body` has them.
    pub(super) fn placed(&self, body: &Deformed<'_>) -> Placed<'_> {
        let place = |node: u32| body.place(node as usize);
        self.pair.placed(&place)
    }

    /// What `task` makes of the gaps of `count` functions where `body` has the surfaces.
    pub(in crate::pairs) fn gaps_of<T>(
        &self,
        body: &Deformed<'_>,
        count: usize,
        task: impl FnOnce(&SpaceGaps<'_>) -> T,
    ) -> T {
        let sizes = [count, body.space.displacement_unknowns()];
        task(&SpaceGaps::new(&self.placed(body), &self.functions, sizes))
    }

    /// What points of the carrier's faces are to the other surface.
    pub(in crate::pairs) fn probing(&self, body: &Deformed<'_>) -> Probing {
        Probing::new(&self.pair, &self.placed(body))
    }
}
