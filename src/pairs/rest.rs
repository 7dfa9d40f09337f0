//! Gaps and slips of linear bodies, in the plane and about an axis, by how their surfaces move against
//! each other from where they rest:
//!
//! ```text
//! G_j = int psi_j [ g + M.(v - u) / (M.n) ] n.N da,   R_j . (u, v) = int psi_j t.(u - v) da
//! ```
//!
//! u the displacement of the point x of the carrier, v that of the point y = x + g n of the other surface
//! that the ray from x meets, M the normal of that surface, t across it, N and da the normal and the
//! length of the carrier, or the area of the full turn, all at rest. What stands after g is how it
//! changes along a ray that stays where it is: the condition of Signorini. Where surfaces touch, G and its
//! derivative are those of the volume between them. Where they are apart, those of the volume have parts
//! that grow with the gap, what the surfaces between which it lies stretch and turn by, and a linear
//! body would keep them when the gap has closed. Shapes: of each face the three functions of its ends and
//! its edge, derivatives by the coordinates of the ten nodes of a piece. Cost: 1 us a piece.

use super::number::{First, Number};
use super::pair::{Part, Placed};
use super::piece::{
    Face, INPUTS, NODES, NodePlaces, OTHER, Piece, Sweep, dot, slope, to_the_right,
};
use super::slip::SlipPart;

/// What is known at a point of a piece.
struct Site {
    /// psi da of the functions.
    weighted: [f64; 3],
    /// g, M / (M.n) and n.N.
    gap: f64,
    closing: [f64; 2],
    facing: f64,
    /// t.
    along: [f64; 2],
    /// Factors of the ten nodes in v - u.
    relative: [f64; NODES],
}

/// Values of the two ends and the edge, whose node is its bulge, at `s`.
fn shares(s: f64) -> [f64; 3] {
    [1.0 - s, s, 4.0 * s * (1.0 - s)]
}

impl Site {
    /// `factor` v_i - u_i by the coordinates of the nodes, each component by its own factor.
    fn row(&self, factors: [f64; 2]) -> [f64; INPUTS] {
        std::array::from_fn(|input| factors[input % 2] * self.relative[input / 2])
    }
}

impl Piece {
    fn sites_at_rest(&self, places: &NodePlaces<f64>, sweep: Sweep<'_>) -> Vec<Site> {
        let face = Face::new(places, self.beside);
        let other = [places[OTHER], places[OTHER + 1], places[OTHER + 2]];
        let sites = self.sites(places, sweep.rule).into_iter();
        let site = |own: super::slip::Site| {
            let area = own.weight * face.stretch(own.s, sweep.section);
            let normal = to_the_right(slope(face.nodes, own.s));
            let ray = to_the_right(face.tangent(own.s)[0]);
            let met = slope(other, own.r);
            let across = to_the_right(met);
            let mut relative = [0.0; NODES];
            for (k, (near, far)) in shares(own.s).into_iter().zip(shares(own.r)).enumerate() {
                relative[k] = -near;
                relative[OTHER + k] = far;
            }
            Site {
                weighted: self.values(&face, &own, other).map(|value| value * area),
                gap: face.gap(own.s, other, own.r),
                closing: across.map(|x| x / dot(across, ray)),
                facing: dot(ray, normal) / dot(normal, normal).sqrt(),
                // The other surface runs the other way.
                along: met.map(|x| -x / dot(met, met).sqrt()),
                relative,
            }
        };
        sites.map(site).collect()
    }

    /// G of the three functions with their derivatives.
    fn gaps_at_rest(&self, places: &NodePlaces<f64>, sweep: Sweep<'_>) -> [First<INPUTS>; 3] {
        let mut sums = [First::constant(0.0); 3];
        for site in self.sites_at_rest(places, sweep) {
            let gap = First {
                value: site.gap,
                first: site.row(site.closing),
            };
            for (sum, weight) in sums.iter_mut().zip(site.weighted) {
                *sum = *sum + gap.times(weight * site.facing);
            }
        }
        sums
    }
}

impl Placed<'_> {
    /// What each meeting of linear bodies adds to the gaps.
    pub fn gaps_at_rest(&self) -> Vec<Part<First<INPUTS>>> {
        self.parts(&|meeting| {
            let places = self.places(meeting);
            meeting.piece.gaps_at_rest(&places, self.sweep())
        })
    }

    /// Areas and R of each meeting of linear bodies; nothing has slid.
    pub fn slips_at_rest(&self) -> Vec<SlipPart> {
        let part = |meeting: &super::pair::Meeting| {
            let mut part = SlipPart {
                face: meeting.face,
                nodes: self.nodes(meeting),
                slips: [0.0; 3],
                areas: [0.0; 3],
                tangents: [[0.0; 3]; 2],
                rows: [[0.0; INPUTS]; 3],
            };
            let places = self.places(meeting);
            for site in meeting.piece.sites_at_rest(&places, self.sweep()) {
                part.add(&site);
            }
            part
        };
        self.meetings.iter().map(part).collect()
    }
}

impl SlipPart {
    fn add(&mut self, site: &Site) {
        let [x, y] = site.along;
        let row = site.row([-x, -y]);
        for (j, weight) in site.weighted.into_iter().enumerate() {
            self.areas[j] += weight;
            self.tangents[0][j] += weight * x;
            self.tangents[1][j] += weight * y;
            let entries = self.rows[j].iter_mut().zip(row);
            entries.for_each(|(sum, own)| *sum += weight * own);
        }
    }
}
