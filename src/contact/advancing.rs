//! A tool that has moved on into a body that has not followed it yet.
//!
//! ```text
//! d_0   where d < d_0 and |d_0| < |d|,   else d;   0 where nothing presses yet
//! ```
//!
//! d the distance now, d_0 before the tool moved. The next step closes what the way of the tool
//! has opened between them, so that it has no part in how the change of the area changes the gap
//! and its force. A tool that retreats counts where it is: the body may not follow it. Where
//! nothing presses, the step closes all that presses after it: the sides of a closed box rise to a
//! ball from where its edges are far. Cost: two probes a point.

use super::counterpart::{Counterpart, Places};
use super::face::ContactFace;
use crate::obstacle::{Contact, Derivatives};

/// Points that are probed at once: the rule of degree 8 on a triangle has 16.
const CHUNK: usize = 16;

/// A tool now and before it moved on; without the latter where nothing presses on the body.
#[derive(Clone, Copy, Debug)]
pub struct Advancing<'a, C: ?Sized> {
    /// The tool where it is.
    pub now: &'a C,
    /// The same where the body was in equilibrium with it.
    pub before: Option<&'a C>,
}

impl<C: Counterpart + ?Sized> Counterpart for Advancing<'_, C> {
    fn probe_on(
        &self,
        face: &ContactFace,
        points: Places<'_>,
        what: Derivatives,
        out: &mut [Contact],
    ) {
        self.now.probe_on(face, points, what, out);
        let Some(before) = self.before else {
            out.iter_mut().for_each(|contact| contact.distance = 0.0);
            return;
        };
        let places = points.coordinates.chunks(CHUNK);
        let places = places.zip(points.deformed.chunks(CHUNK));
        for ((coordinates, deformed), out) in places.zip(out.chunks_mut(CHUNK)) {
            let mut earlier = [Contact::default(); CHUNK];
            let points = Places {
                coordinates,
                deformed,
            };
            before.probe_on(face, points, Derivatives::Gap, &mut earlier[..out.len()]);
            for (now, before) in out.iter_mut().zip(&earlier) {
                let (came, went) = (before.distance, now.distance);
                if went < came && came.abs() < went.abs() {
                    now.distance = came;
                }
            }
        }
    }
}
