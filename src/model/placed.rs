//! What a surface with multipliers meets, where a drive has it, and what it is to the surface: gaps and
//! coupling. Obstacles and guides are asked point by point, another body that the surface meets or is
//! tied to as a whole.

use std::sync::Arc;

use crate::contact::gap::{Deformed, evaluate_gaps};
use crate::contact::{
    AdmittedDepth, Advancing, ContactFace, ContactSurface, Counterpart, Guide, Linearisation,
    Places, linearise, linearise_advanced,
};
use crate::element::quadrature::Rule;
use crate::obstacle::{Contact, Derivatives, Moving};
use crate::pairs::PairSurface;
use crate::ties::Tied;

/// What a surface meets, where a drive has it.
#[derive(Clone, Debug)]
pub(crate) enum Placed {
    /// An obstacle in its pose, non-dimensional.
    Obstacle(Moving),
    /// An obstacle that lets the body in by some depth.
    Admitting(Moving, AdmittedDepth),
    /// The planes of the faces, moved with their support.
    Guide(Guide),
    /// A surface of another body, which lets the surface in by some depths `[multipliers]`.
    Pair(Arc<PairSurface>, Option<Arc<[f64]>>),
    /// A surface of another body that moves along in one component.
    Tie(Arc<Tied>),
}

impl Placed {
    /// The same, letting the body of `surface` in by `depths` `[multipliers]`.
    pub(crate) fn admitting(self, surface: &ContactSurface, rule: &Rule, depths: &[f64]) -> Self {
        match self {
            Self::Obstacle(obstacle) => {
                Self::Admitting(obstacle, AdmittedDepth::new(surface, rule, depths))
            }
            Self::Pair(pair, None) => Self::Pair(pair, Some(depths.into())),
            Self::Admitting(..) | Self::Guide(_) | Self::Pair(..) | Self::Tie(_) => self,
        }
    }

    /// The obstacle; none where a support holds the surface, or another body meets it.
    pub(crate) fn obstacle(&self) -> Option<&Moving> {
        match self {
            Self::Obstacle(obstacle) | Self::Admitting(obstacle, _) => Some(obstacle),
            Self::Guide(_) | Self::Pair(..) | Self::Tie(_) => None,
        }
    }

    /// Whether it is asked point by point, not as a whole.
    pub(crate) fn is_by_points(&self) -> bool {
        match self {
            Self::Obstacle(_) | Self::Admitting(..) | Self::Guide(_) => true,
            Self::Pair(..) | Self::Tie(_) => false,
        }
    }

    /// Weighted gaps `[multipliers]`, and the deepest penetration.
    pub(crate) fn gaps(&self, body: &Deformed<'_>, surface: &ContactSurface) -> (Vec<f64>, f64) {
        let (pair, depths) = match self {
            Self::Pair(pair, depths) => (pair, depths),
            Self::Tie(tie) => return (tie.gaps(body.displacement), 0.0),
            Self::Obstacle(_) | Self::Admitting(..) | Self::Guide(_) => {
                return evaluate_gaps(body, surface, self);
            }
        };
        let (mut gaps, deepest) = pair.gaps(body, surface);
        admit(surface, depths.as_deref(), &mut gaps);
        (gaps, deepest)
    }

    /// Gaps and coupling; `held[k]` says that unknown k is prescribed.
    pub(crate) fn linearise(
        &self,
        body: &Deformed<'_>,
        surface: &ContactSurface,
        held: &[bool],
    ) -> Linearisation {
        let (pair, depths) = match self {
            Self::Pair(pair, depths) => (pair, depths),
            Self::Tie(tie) => return tie.linearise(body.displacement, held),
            Self::Obstacle(_) | Self::Admitting(..) | Self::Guide(_) => {
                return linearise(body, surface, self, held);
            }
        };
        let mut part = pair.linearise(body, surface, held);
        admit(surface, depths.as_deref(), &mut part.gap);
        part
    }

    /// The same where it has moved on from `before` ([`linearise_advanced`]).
    pub(crate) fn linearise_from(
        &self,
        before: Option<&Self>,
        (body, surface): (&Deformed<'_>, &ContactSurface),
        held: &[bool],
    ) -> Linearisation {
        if !self.is_by_points() {
            return self.linearise(body, surface, held);
        }
        let tool = Advancing { now: self, before };
        linearise_advanced(body, surface, tool, held)
    }
}

/// Adds what surfaces are let in by to their gaps.
fn admit(surface: &ContactSurface, depths: Option<&[f64]>, gaps: &mut [f64]) {
    let depths = depths.unwrap_or_default();
    for ((gap, depth), weight) in gaps.iter_mut().zip(depths).zip(&surface.weights) {
        *gap += depth * weight;
    }
}

impl Counterpart for Placed {
    fn probe_on(
        &self,
        face: &ContactFace,
        points: Places<'_>,
        what: Derivatives,
        out: &mut [Contact],
    ) {
        match self {
            Self::Obstacle(obstacle) => obstacle.probe_on(face, points, what, out),
            Self::Admitting(obstacle, depth) => depth.probe(obstacle, (face, points), what, out),
            Self::Guide(guide) => guide.probe_on(face, points, what, out),
            // Another body is not met point by point.
            Self::Pair(..) | Self::Tie(_) => out.fill(Contact::default()),
        }
    }
}
