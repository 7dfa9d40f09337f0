//! What points of the carrier are to the other surface: distance along the ray, and its direction.
//!
//! For what is told of a contact, not for its integrals. Found for the places of one state. Cost: one
//! ray a point.

use std::collections::HashMap;

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
            let site = Site {
                face: placed.face(index),
                is_turned: face.is_turned,
                partners: partners.collect(),
            };
            (face.nodes[2], site)
        };
        Self {
            sites: faces.map(site).collect(),
            reach: placed.reach,
        }
    }
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
}
