//! Nodes of a fluid's surface that lie on another part of it, across a contact between bodies.
//!
//! ```text
//! share(i) = sum over k on the carrier of s_ik [k is wet]
//! ```
//!
//! An open node is beside those that it lies on, so that a fluid gets from one body to the other. What
//! contact presses on bears that share of the pressure, and is wet where what it lies on is, by half at least: there is one film between two bodies,
//! which is known by the nodes of the one that carries the pressure. So no way leads along the other one
//! through closed contact. Shapes `[nodes of the surface]`. Cost: a sort of the pairs of neighbours.

use std::borrow::Cow;

use super::surface::FluidSurface;

/// Share of a place that has to be wet, without unit; chosen.
const HALF: f64 = 0.5;

/// A node that lies on another part of the surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Across {
    /// The node, by its place.
    pub place: usize,
    /// Nodes that it lies on, by their places, with their shares.
    pub on: Vec<(usize, f64)>,
    /// Whether contact presses on it from there.
    pub is_pressed: bool,
}

impl Across {
    /// Which share of what it lies on is wet.
    fn share(&self, wet: &[bool]) -> f64 {
        self.on.iter().filter(|on| wet[on.0]).map(|on| on.1).sum()
    }

    /// Whether what it lies on is wet.
    fn is_on_wet(&self, wet: &[bool]) -> bool {
        self.share(wet) >= HALF
    }
}

/// The surface with its parts joined by what lies across.
pub fn joined<'a>(surface: &'a FluidSurface, across: &[Across]) -> Cow<'a, FluidSurface> {
    if across.is_empty() {
        return Cow::Borrowed(surface);
    }
    let mut is_pressed = vec![false; surface.nodes.len()];
    for one in across.iter().filter(|one| one.is_pressed) {
        is_pressed[one.place] = true;
    }
    let links = across.iter().flat_map(|one| {
        let on = one.on.iter();
        on.flat_map(|&(other, _)| [[one.place, other], [other, one.place]])
    });
    let is_open = |&[a, b]: &[usize; 2]| !(is_pressed[a] && is_pressed[b]);
    let along = (0..surface.nodes.len())
        .flat_map(|place| surface.beside(place).map(move |other| [place, other]))
        .filter(is_open);
    Cow::Owned(surface.with_neighbours(along.chain(links)))
}

/// Wets the pressed nodes that lie on what is wet; how many.
pub fn follow(across: &[Across], wet: &mut [bool]) -> usize {
    let dry = across.iter().filter(|one| one.is_pressed);
    let coming = dry.filter(|one| !wet[one.place] && one.is_on_wet(wet));
    let coming: Vec<usize> = coming.map(|one| one.place).collect();
    coming.iter().for_each(|&place| wet[place] = true);
    coming.len()
}

/// Has all pressed nodes but `sources` be as what they lie on.
pub fn settle(across: &[Across], sources: &[bool], wet: &mut [bool]) {
    let pressed = across.iter().filter(|one| one.is_pressed);
    let now = pressed.map(|one| (one.place, sources[one.place] || one.is_on_wet(wet)));
    let now: Vec<(usize, bool)> = now.collect();
    now.iter().for_each(|&(place, is_wet)| wet[place] = is_wet);
}

/// Share of the fluid's pressure at the nodes: what is pressed has that of the place that it lies on.
pub fn film(across: &[Across], sources: &[bool], wet: &[bool]) -> Vec<f64> {
    let mut film: Vec<f64> = wet.iter().copied().map(f64::from).collect();
    let pressed = across.iter().filter(|one| one.is_pressed);
    for one in pressed.filter(|one| !sources[one.place]) {
        film[one.place] = one.share(wet);
    }
    film
}

#[cfg(test)]
mod tests {
    use super::super::front::{Advance, Front};
    use super::super::surface::Reach;
    use super::*;
    use crate::mesh::{GroupKind, samples};
    use crate::space::TaylorHood;

    /// Bottom and top of a strip, five nodes each from left to right, as if they touched: the bottom
    /// carries. Wet is the left end of the bottom, dry the right end of the top.
    struct Touching {
        surface: FluidSurface,
        carrier: Vec<usize>,
        other: Vec<usize>,
    }

    impl Touching {
        fn new() -> Self {
            let mesh = samples::rectangle(2, 1);
            let space = TaylorHood::new(&mesh);
            let group = |name: &str| {
                let group = mesh.group(name, GroupKind::Facets).expect("a side");
                group.members.clone()
            };
            let [bottom, top, left, right] = ["y0", "y1", "x0", "x1"].map(group);
            let reach = Reach {
                facets: &[bottom, top].concat(),
                from: &left,
                dry: &right,
            };
            let mut surface = FluidSurface::new(&mesh, &space, reach);
            let place = |k: usize| space.node_place(&mesh, surface.nodes[k]);
            let along = |y: f64| {
                let own = (0..surface.nodes.len()).filter(|&k| (place(k)[1] - y).abs() < 1e-9);
                let mut own: Vec<usize> = own.collect();
                own.sort_by(|&a, &b| place(a)[0].total_cmp(&place(b)[0]));
                own
            };
            let [carrier, other] = [along(0.0), along(1.0)];
            surface.sources[other[0]] = false;
            surface.dry[carrier[4]] = false;
            Self {
                surface,
                carrier,
                other,
            }
        }

        /// Every node of the top opposite to that of the bottom, `pressed` where that is.
        fn across(&self, pressed: [bool; 5]) -> Vec<Across> {
            let pairs = self.carrier.iter().zip(&self.other).zip(pressed);
            let all = pairs.map(|((&carrier, &place), is_pressed)| Across {
                place,
                on: vec![(carrier, 1.0)],
                is_pressed,
            });
            all.collect()
        }

        fn pressures(&self, of_pairs: [f64; 5]) -> Vec<f64> {
            let mut all = vec![0.0; 10];
            for ((&a, &b), value) in self.carrier.iter().zip(&self.other).zip(of_pairs) {
                all[a] = value;
                all[b] = value;
            }
            all
        }
    }

    #[test]
    fn a_fluid_gets_from_one_body_to_the_other_where_they_are_open() {
        let touching = Touching::new();
        let pressures = touching.pressures([0.0, 0.0, 3.0, 0.0, 0.0]);
        let across = touching.across([false, false, true, false, false]);
        let surface = joined(&touching.surface, &across);
        let front = Front {
            surface: &surface,
            across: &across,
            dry: &surface.dry,
            contact: &pressures,
            total: &pressures,
            threshold: 1.0,
        };
        let mut wet = surface.sources.clone();
        // One more below, two above.
        assert_eq!(front.advance(&mut wet).flooded, 3);
        assert_eq!(front.advance(&mut wet), Advance::default());
        // Through the contact, not along the other body, and up to its dry end.
        assert_eq!(front.margin(&wet), Some((3.0, touching.carrier[2])));
    }

    #[test]
    fn no_way_leads_past_a_peak_of_the_carrier_along_the_other_body() {
        let touching = Touching::new();
        let mut pressures = touching.pressures([0.0, 2.0, 3.0, 2.0, 0.0]);
        // As a coarser body sees it.
        pressures[touching.other[2]] = 0.5;
        let across = touching.across([false, true, true, true, false]);
        let surface = joined(&touching.surface, &across);
        let front = Front {
            surface: &surface,
            across: &across,
            dry: &surface.dry,
            contact: &pressures,
            total: &pressures,
            threshold: 1.0,
        };
        assert_eq!(
            front.margin(&surface.sources),
            Some((3.0, touching.carrier[2]))
        );
    }

    #[test]
    fn the_film_between_bodies_is_that_of_the_carrier() {
        let touching = Touching::new();
        let across = touching.across([true; 5]);
        let mut wet = vec![false; 10];
        wet[touching.carrier[0]] = true;
        wet[touching.carrier[1]] = true;
        wet[touching.other[4]] = true;
        assert_eq!(follow(&across, &mut wet), 2);
        let of = |wet: &[bool]| -> Vec<bool> { touching.other.iter().map(|&k| wet[k]).collect() };
        assert_eq!(of(&wet), [true, true, false, false, true]);
        settle(&across, &touching.surface.sources, &mut wet);
        assert_eq!(of(&wet), [true, true, false, false, false]);
        let mut across = across;
        across[2].on = vec![(touching.carrier[1], 0.25), (touching.carrier[2], 0.75)];
        let shares = film(&across, &touching.surface.sources, &wet);
        let of_other: Vec<f64> = touching.other.iter().map(|&k| shares[k]).collect();
        assert_eq!(of_other, [1.0, 1.0, 0.25, 0.0, 0.0]);
    }
}
