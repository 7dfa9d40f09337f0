//! Points that slip, on one face: from the unknowns of a face to all multipliers, and from
//! all constraints to those of the face ([`Slide`]).

use std::borrow::Cow;

use crate::inequality::Slide;
use crate::saddle::Status;

/// What is unknown on a face, and how what slips depends on it.
pub(super) struct Shape<'a> {
    /// Which multipliers are unknowns, or hold one of a point that slips `[multipliers]`.
    pub(super) unknowns: Vec<bool>,
    /// Points that slip.
    pub(super) slides: &'a [Slide],
}

impl<'a> Shape<'a> {
    /// The points that slip, as forces or, without what follows, as constraints.
    pub(super) fn following(&self, follows: bool) -> Cow<'a, [Slide]> {
        if follows {
            Cow::Borrowed(self.slides)
        } else {
            self.slides
                .iter()
                .map(|slide| Slide {
                    along: [0.0; 2],
                    ..*slide
                })
                .collect()
        }
    }
}

/// Tractions of the points from what they follow and give way to, in place; their own places
/// hold w.
pub(super) fn expand(slides: &[Slide], multipliers: &mut [f64]) {
    for slide in slides {
        let (first, pressure) = (slide.first as usize, multipliers[slide.leader as usize]);
        let across = match slide.width {
            1 => 0.0,
            _ => multipliers[first],
        };
        for i in 0..usize::from(slide.width) {
            multipliers[first + i] = slide.along[i] * pressure + slide.across[i] * across;
        }
    }
}

/// The constraints of the points from those of all multipliers, in place: across the slip.
pub(super) fn gather(slides: &[Slide], constraints: &mut [f64]) {
    for slide in slides {
        let first = slide.first as usize;
        let own = &mut constraints[first..first + usize::from(slide.width)];
        let parts = own.iter().zip(slide.across);
        let across = parts.map(|(value, across)| value * across).sum();
        own.fill(0.0);
        own[0] = across;
    }
}

/// What `gather` does, transposed: adds to the constraints of pressures what their tractions
/// make of them besides.
pub(super) fn add_along(slides: &[Slide], all: &[f64], constraints: &mut [f64]) {
    for slide in slides {
        let first = slide.first as usize;
        let own = &all[first..first + usize::from(slide.width)];
        let parts = own.iter().zip(slide.along);
        constraints[slide.leader as usize] +=
            parts.map(|(value, along)| value * along).sum::<f64>();
    }
}

/// Which multipliers are unknowns on the face of `status`: those that stick, and one for
/// each point that slips in space.
pub(super) fn unknowns(status: &[Status], slides: &[Slide]) -> Vec<bool> {
    let mut unknowns: Vec<bool> = status.iter().map(|&s| s == Status::Stick).collect();
    for slide in slides.iter().filter(|slide| slide.width > 1) {
        unknowns[slide.first as usize] = true;
    }
    unknowns
}
