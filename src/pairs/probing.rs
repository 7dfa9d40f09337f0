//! What points of the carrier are to the other surface: distance along the ray, and its direction.
//!
//! For what is told of a contact, not for its integrals. Found for the places of one state. Cost: one
//! ray a point.

use std::collections::HashMap;

use super::choice::{cubic, roots};
use super::pair::{Pair, Placed};
use super::piece::{Face, dot, meeting, point, to_the_right};
use crate::contact::{ContactFace, Counterpart, Places};
use crate::obstacle::{Contact, Derivatives};

/// A face of the carrier with its partners.
struct Site {
    face: Face<f64>,
    is_turned: bool,
    /// Ends on the face, and the nodes of the partner.
    partners: Vec<([f64; 2], [[f64; 2]; 3])>,
    /// Part of the face that has a partner, without what goes on beyond the ends of these.
    covered: [f64; 2],
}

/// The faces of the carrier, by the node of their edge.
pub struct Probing {
    sites: HashMap<u32, Site>,
    reach: f64,
}

impl Probing {
    pub(super) fn new(pair: &Pair, placed: &Placed<'_>) -> Self {
        let faces = pair.carrier.faces.iter().enumerate();
        let site = |(index, face): (usize, &super::ChainFace)| {
            let of_face = placed.meetings.iter().filter(|one| one.face == index);
            let partners = of_face.map(|one| {
                let ends = one.piece.ends.map(|end| end.place());
                (ends, placed.other_places(one))
            });
            let partners: Vec<([f64; 2], [[f64; 2]; 3])> = partners.collect();
            let at = placed.face(index);
            let parts = partners.iter().filter_map(|one| within(&at, *one));
            let covered = parts.reduce(|all, one| [all[0].min(one[0]), all[1].max(one[1])]);
            let site = Site {
                covered: covered.unwrap_or_default(),
                face: at,
                is_turned: face.is_turned,
                partners,
            };
            (face.nodes[2], site)
        };
        Self {
            sites: faces.map(site).collect(),
            reach: placed.reach,
        }
    }
}

/// The part of a piece between `ends` whose rays meet the `other` face itself, not what goes on beyond
/// its ends.
fn within(face: &Face<f64>, (ends, other): ([f64; 2], [[f64; 2]; 3])) -> Option<[f64; 2]> {
    let place = |s: f64| {
        let [tangent, _] = face.tangent(s);
        meeting(point(face.nodes, s), tangent, other)
    };
    let mut marks: Vec<f64> = ends.into();
    for vertex in &other[..2] {
        let passed = roots(cubic(face, *vertex)).into_iter();
        marks.extend(passed.filter(|s| *s > ends[0] && *s < ends[1]));
    }
    marks.sort_by(f64::total_cmp);
    let is_met = |s: f64| place(s).is_some_and(|r| (0.0..=1.0).contains(&r));
    let parts = marks
        .windows(2)
        .filter(|part| is_met(0.5 * (part[0] + part[1])));
    parts
        .map(|part| [part[0], part[1]])
        .reduce(|all, one| [all[0], one[1]])
}

impl Site {
    /// Distance and normal of the other surface at `s`.
    fn contact(&self, s: f64, reach: f64) -> ([f64; 2], f64) {
        let [tangent, _] = self.face.tangent(s);
        let normal = to_the_right(tangent);
        let size = dot(normal, normal).sqrt();
        let away = |ends: &[f64; 2]| (ends[0] - s).max(s - ends[1]).max(0.0);
        let nearest = self
            .partners
            .iter()
            .min_by(|a, b| away(&a.0).total_cmp(&away(&b.0)));
        let distance = nearest.and_then(|(_, other)| {
            let r = meeting(point(self.face.nodes, s), tangent, *other)?;
            Some(self.face.gap(s, *other, r) * size)
        });
        (normal.map(|x| -x / size), distance.unwrap_or(reach))
    }
}

impl Counterpart for Probing {
    fn probe_on(
        &self,
        face: &ContactFace,
        points: Places<'_>,
        _: Derivatives,
        out: &mut [Contact],
    ) {
        let site = face.nodes.get(2).and_then(|edge| self.sites.get(edge));
        for (coordinates, contact) in points.coordinates.iter().zip(out) {
            *contact = Contact::default();
            let Some(site) = site else {
                contact.distance = self.reach;
                continue;
            };
            let s = coordinates[usize::from(!site.is_turned)];
            let (normal, distance) = site.contact(s, self.reach);
            contact.distance = distance;
            contact.normal = [normal[0], normal[1], 0.0];
        }
    }

    fn covered(&self, face: &ContactFace) -> [f64; 2] {
        let site = face.nodes.get(2).and_then(|edge| self.sites.get(edge));
        site.map_or([0.0; 2], |site| {
            let [from, to] = site.covered;
            if site.is_turned {
                [1.0 - to, 1.0 - from]
            } else {
                [from, to]
            }
        })
    }
}
