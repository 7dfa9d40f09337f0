//! What points of the carrier are to the other surface: distance along the ray, and its direction.
//!
//! For what is told of a contact, not for its integrals. Found for the places of one state. Cost: one
//! ray a point.

use std::collections::HashMap;

use super::outline::{Polygon, middle, sides, whole};
use super::pair::{Pair, Placed};
use super::patch::{At, Patch};
use super::rays::{Rayed, hit};
use crate::contact::{ContactFace, Counterpart, Places};
use crate::geometry::vector3::{norm, scale};
use crate::obstacle::{Contact, Derivatives};

/// A face of the carrier with its partners.
struct Site {
    face: Rayed,
    is_turned: bool,
    /// Parts of the face, and their partners.
    partners: Vec<(Polygon, Patch)>,
}

/// The faces of the carrier, by the nodes of their edges.
pub struct Probing {
    sites: HashMap<[u32; 3], Site>,
    reach: f64,
}

/// What tells a face from others: its edges, ascending.
fn key(nodes: &[u32]) -> [u32; 3] {
    let mut edges = [3, 4, 5].map(|k: usize| nodes.get(k).copied().unwrap_or(0));
    edges.sort_unstable();
    edges
}

impl Probing {
    pub(super) fn new(pair: &Pair, placed: &Placed<'_>) -> Self {
        let faces = pair.carrier.faces.iter().zip(&placed.own);
        let site = |(face, &own): (&super::skin::SkinFace, &Rayed)| {
            let site = Site {
                face: own,
                is_turned: face.is_turned,
                partners: Vec::new(),
            };
            (key(&face.nodes), site)
        };
        let mut sites: HashMap<[u32; 3], Site> = faces.map(site).collect();
        for meeting in &placed.meetings {
            let key = key(&pair.carrier.faces[meeting.face].nodes);
            let pieces = meeting.pieces.iter();
            let partners = pieces.map(|piece| (piece.polygon.clone(), placed.others[piece.other]));
            if let Some(site) = sites.get_mut(&key) {
                site.partners.extend(partners);
            }
        }
        Self {
            sites,
            reach: placed.reach,
        }
    }
}

/// How far a place is outside of a convex polygon with straight sides, in face coordinates.
fn away(polygon: &Polygon, at: At) -> f64 {
    let sides = sides(polygon).map(|([a, b], _)| {
        let along = [b[0] - a[0], b[1] - a[1]];
        let size = along[0].hypot(along[1]);
        if size == 0.0 {
            return 0.0;
        }
        (along[1] * (at[0] - a[0]) - along[0] * (at[1] - a[1])) / size
    });
    sides.fold(0.0, f64::max)
}

impl Site {
    /// Normal and distance of the other surface at a place.
    fn contact(&self, at: At, reach: f64) -> Contact {
        let ray = self.face.ray(at);
        let size = norm(ray.along);
        let partners = self.partners.iter();
        let far = |polygon: &Polygon| {
            let [s, t] = middle(polygon);
            (s - at[0]).hypot(t - at[1])
        };
        let nearest = partners.min_by(|(a, _), (b, _)| {
            let by_border = away(a, at).total_cmp(&away(b, at));
            by_border.then(far(a).total_cmp(&far(b)))
        });
        let met = nearest.and_then(|(_, other)| hit(other, ray));
        Contact {
            distance: met.map_or(reach, |met| met.gap * size),
            normal: scale(-size.recip(), ray.along),
            ..Contact::default()
        }
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
        let site = self.sites.get(&key(&face.nodes));
        for (l, contact) in points.coordinates.iter().zip(out) {
            *contact = match site {
                Some(site) => {
                    let first = if site.is_turned { l[0] } else { l[1] };
                    site.contact([first, l[2]], self.reach)
                }
                None => Contact {
                    distance: self.reach,
                    ..Contact::default()
                },
            };
        }
    }

    fn share(&self, face: &ContactFace) -> f64 {
        let site = self.sites.get(&key(&face.nodes));
        let partners = site.into_iter().flat_map(|site| &site.partners);
        // A face has an area of 1/2 in its own coordinates.
        let parts = partners.map(|(polygon, _)| 2.0 * whole(polygon));
        parts.sum::<f64>().min(1.0)
    }
}
