//! How a fluid advances over its surface at one equilibrium. Shapes `[nodes of the surface]`;
//! pressures in one unit. Cost: a pass over the surface.

use super::across::{Across, film, follow, settle};
use super::leak_path::Barrier;
use super::surface::FluidSurface;

/// What a fluid meets at an equilibrium.
#[derive(Clone, Copy, Debug)]
pub struct Front<'a> {
    /// The surface, its parts joined by what lies across.
    pub surface: &'a FluidSurface,
    /// What lies across contacts between bodies.
    pub across: &'a [Across],
    /// Nodes that the fluid must not reach.
    pub dry: &'a [bool],
    /// Coefficients of the contact pressure at its nodes, what the fluid bears left out.
    pub contact: &'a [f64],
    /// Pressure of contact and fluid together at its nodes.
    pub total: &'a [f64],
    /// Pressure below which it enters.
    pub threshold: f64,
}

/// How many nodes a fluid has come to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Advance {
    /// Open ones.
    pub flooded: usize,
    /// Pressed ones.
    pub entered: usize,
    /// Pressed ones that lie on wet ones of another body.
    pub followed: usize,
}

impl Front<'_> {
    /// The multipliers of open nodes are zero, not small.
    fn is_open(&self, place: usize) -> bool {
        self.contact[place] <= 0.0
    }

    /// Wets every dry node that nodes with `may` join to a wet one; how many.
    fn spread(&self, wet: &mut [bool], may: impl Fn(usize) -> bool) -> usize {
        let mut edge: Vec<usize> = (0..wet.len()).filter(|&place| wet[place]).collect();
        let before = edge.len();
        let mut at = 0;
        while let Some(&place) = edge.get(at) {
            at += 1;
            for other in self.surface.beside(place) {
                if !wet[other] && may(other) {
                    wet[other] = true;
                    edge.push(other);
                }
            }
        }
        edge.len() - before
    }

    /// Wets what open nodes join to wet ones; where there is nothing, as a flood may press a seal on, what
    /// nodes do that are pressed by less than the threshold: the fluid lifts what it enters, so that
    /// what lies beside that is pressed less, not more.
    pub fn advance(&self, wet: &mut [bool]) -> Advance {
        let followed = follow(self.across, wet);
        let flooded = self.spread(wet, |place| self.is_open(place));
        let is_weak = |place: usize| self.total[place] < self.threshold;
        let entered = match followed + flooded {
            0 => self.spread(wet, is_weak),
            _ => 0,
        };
        Advance {
            flooded,
            entered,
            followed,
        }
    }

    /// Has what lies pressed on another body be wet as far as that is.
    pub fn settle(&self, wet: &mut [bool]) {
        settle(self.across, &self.surface.sources, wet);
    }

    /// Share of its pressure at the nodes where it is `wet`.
    pub fn film(&self, wet: &[bool]) -> Vec<f64> {
        film(self.across, &self.surface.sources, wet)
    }

    /// The pressure that it must exceed to leak, and the place of the node that holds it last; none
    /// where no path leads to what must stay dry.
    pub fn margin(&self, wet: &[bool]) -> Option<(f64, usize)> {
        let barrier = Barrier {
            surface: self.surface,
            dry: self.dry,
            wet,
            pressure: self.total,
        };
        barrier.margin()
    }

    /// Dries wet nodes, but for sources, that are pressed with all nodes beside them; how many.
    pub fn squeeze(&self, wet: &mut [bool]) -> usize {
        let is_closed = |place: usize| !self.is_open(place);
        let squeezed = |&place: &usize| {
            let is_own = wet[place] && !self.surface.sources[place];
            is_own && is_closed(place) && self.surface.beside(place).all(is_closed)
        };
        let leaving: Vec<usize> = (0..wet.len()).filter(squeezed).collect();
        leaving.iter().for_each(|&place| wet[place] = false);
        leaving.len()
    }
}

#[cfg(test)]
mod tests {
    use super::super::surface::Reach;
    use super::*;
    use crate::mesh::{GroupKind, Mesh, samples};
    use crate::space::TaylorHood;

    /// The bottom of a strip, wet at its left end, dry at its right: nine nodes along it.
    fn bottom() -> (FluidSurface, Vec<usize>) {
        let mesh = samples::rectangle(4, 1);
        let space = TaylorHood::new(&mesh);
        let group = |mesh: &Mesh, name: &str| {
            let group = mesh.group(name, GroupKind::Facets).expect("a side");
            group.members.clone()
        };
        let [facets, from, dry] = ["y0", "x0", "x1"].map(|name| group(&mesh, name));
        let reach = Reach {
            facets: &facets,
            from: &from,
            dry: &dry,
        };
        let surface = FluidSurface::new(&mesh, &space, reach);
        let mut along: Vec<usize> = (0..9).collect();
        along.sort_by(|&a, &b| {
            let x = |place: usize| space.node_place(&mesh, surface.nodes[place])[0];
            x(a).total_cmp(&x(b))
        });
        (surface, along)
    }

    fn wet_along(wet: &[bool], along: &[usize]) -> Vec<bool> {
        along.iter().map(|&place| wet[place]).collect()
    }

    fn contact(values: [f64; 9], along: &[usize]) -> Vec<f64> {
        let mut contact = vec![0.0; 9];
        along
            .iter()
            .zip(values)
            .for_each(|(&place, value)| contact[place] = value);
        contact
    }

    /// The front of a fluid of pressure one.
    fn of_unit_pressure<'a>(surface: &'a FluidSurface, contact: &'a [f64]) -> Front<'a> {
        Front {
            surface,
            across: &[],
            dry: &surface.dry,
            contact,
            total: contact,
            threshold: 1.0,
        }
    }

    #[test]
    fn a_flood_stops_at_the_first_pressed_node_and_skips_what_lies_beyond() {
        let (surface, along) = bottom();
        let contact = contact([0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 5.0, 5.0, 5.0], &along);
        let front = of_unit_pressure(&surface, &contact);
        let mut wet = surface.sources.clone();
        assert_eq!(front.advance(&mut wet).flooded, 2);
        let expected = [true, true, true, false, false, false, false, false, false];
        assert_eq!(wet_along(&wet, &along), expected);
        assert_eq!(front.advance(&mut wet), Advance::default());
    }

    #[test]
    fn weak_contact_is_entered_as_far_as_it_is_weak() {
        let (surface, along) = bottom();
        let contact = contact([0.5, 0.5, 0.5, 3.0, 0.1, 0.1, 0.1, 0.1, 0.1], &along);
        let front = of_unit_pressure(&surface, &contact);
        let mut wet = surface.sources.clone();
        let rounds: Vec<usize> = (0..3).map(|_| front.advance(&mut wet).entered).collect();
        assert_eq!(rounds, [2, 0, 0]);
        assert_eq!(FluidSurface::leak(&wet, &surface.dry), None);
        // With a threshold of zero it enters only what is open.
        let never = Front {
            threshold: 0.0,
            ..front
        };
        let mut wet = surface.sources.clone();
        assert_eq!(never.advance(&mut wet), Advance::default());
    }

    #[test]
    fn what_reaches_the_dry_end_leaks() {
        let (surface, along) = bottom();
        let contact = [0.0; 9];
        let front = of_unit_pressure(&surface, &contact);
        let mut wet = surface.sources.clone();
        assert_eq!(front.advance(&mut wet).flooded, 8);
        assert_eq!(FluidSurface::leak(&wet, &surface.dry), Some(along[8]));
    }

    #[test]
    fn a_film_that_is_pressed_on_all_sides_is_squeezed_out() {
        let (surface, along) = bottom();
        let contact = contact([2.0, 2.0, 2.0, 2.0, 0.0, 0.0, 2.0, 2.0, 2.0], &along);
        let front = of_unit_pressure(&surface, &contact);
        let mut wet = vec![true; 9];
        assert_eq!(front.squeeze(&mut wet), 4);
        let expected = [true, false, false, true, true, true, true, false, false];
        assert_eq!(wet_along(&wet, &along), expected);
    }
}
