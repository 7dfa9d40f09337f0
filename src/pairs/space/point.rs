//! The gap on the ray from a point of a face, and its derivatives by the nodes:
//!
//! ```text
//! e = dx + g dn - dy,   nu = y_,1 x y_,2,   c = n.nu,   dg = -nu.e / c,   dl'_k = m_k.e
//! c d2g = -2 dg nu.dn + 2 nu.dy_,k dl'_k + nu.y_,kl dl'_k dl'_l
//! da = a_g dg + what x_,k, n and n_,k do at that g,   a_g = n.(X_1 x X_2)
//! ```
//!
//! dy at that place of the other face; m_1 = y_,2 x n / c, m_2 = n x y_,1 / c. All of it is linear or
//! quadratic in eight vectors, the FORMS e, dx_,1, dx_,2, dn, dn_,1, dn_,2, dy_,1, dy_,2, which are sums
//! over fifteen vectors: six nodes of the face, its three normals, six nodes of the other face. Shapes:
//! gradients `[15][3]`, second derivatives `[15][15][3][3]`. Cost: 1e3 flops a gradient, 2e4 a second
//! derivative.

use super::patch::{self, At, Patch};
use super::rays::{Hit, Rayed, hit};
use crate::geometry::vector3::{add, cross, dot, norm, scale};

/// Vectors that a point depends on: nodes of the face, its normals, nodes of the other face.
pub const VECTORS: usize = 15;
/// First of the nodes of the other face.
pub const OTHER: usize = 9;
/// e, dx_,1, dx_,2, dn, dn_,1, dn_,2, dy_,1, dy_,2.
pub(super) const FORMS: usize = 8;

/// With which forms each has a second derivative of a.
const PARTNERS: [&[usize]; FORMS] = [
    &[0, 1, 2, 3, 4, 5, 6, 7],
    &[0, 2, 3, 5],
    &[0, 1, 3, 4],
    &[0, 1, 2, 4, 5],
    &[0, 2, 3, 5],
    &[0, 1, 3, 4],
    &[0],
    &[0],
];

/// A matrix.
pub(super) type Block = [[f64; 3]; 3];

/// What is known at a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    /// Place on the face.
    pub(super) at: At,
    /// Where its ray meets the other face.
    pub(super) met: Hit,
    x: [[f64; 3]; 2],
    n: [[f64; 3]; 3],
    /// g, g^2 / 2, g^3 / 3.
    powers: [f64; 3],
}

/// A second derivative by all vectors, in pairs.
pub(super) type Bend = [[Block; VECTORS]; VECTORS];

/// v w'.
pub(super) fn outer(v: [f64; 3], w: [f64; 3]) -> Block {
    v.map(|v| w.map(|w| v * w))
}

/// The matrix M of a.(b x v) = a.M b.
fn before(v: [f64; 3]) -> Block {
    // b x v = -[v] b
    [[0.0, v[2], -v[1]], [-v[2], 0.0, v[0]], [v[1], -v[0], 0.0]]
}

fn opposite(block: Block) -> Block {
    block.map(|row| row.map(|x| -x))
}

fn times(factor: f64, block: Block) -> Block {
    block.map(|row| row.map(|x| factor * x))
}

fn sum(a: Block, b: Block) -> Block {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| a[i][j] + b[i][j]))
}

impl Point {
    /// At a place of `face`, whose ray meets `other`; none where it misses.
    pub(super) fn new(face: &Rayed, at: At, other: &Patch) -> Option<Self> {
        let met = hit(other, face.ray(at))?;
        let [first, second] = face.turns();
        let g = met.gap;
        Some(Self {
            at,
            met,
            x: face.patch.tangents(at),
            n: [face.normal(at), first, second],
            powers: [g, 0.5 * g * g, g * g * g / 3.0],
        })
    }

    /// a.
    pub(super) fn swept(&self) -> f64 {
        let ([x1, x2], [n, n1, n2]) = (self.x, self.n);
        let mixed = add(cross(x1, n2), cross(n1, x2));
        let by_power = [cross(x1, x2), mixed, cross(n1, n2)];
        let terms = by_power.into_iter().zip(self.powers);
        terms.map(|(part, power)| power * dot(n, part)).sum()
    }

    /// |x_,1 x x_,2|.
    pub(super) fn area(&self) -> f64 {
        norm(cross(self.x[0], self.x[1]))
    }

    /// x_,1 and x_,2.
    pub(super) fn tangents(&self) -> [[f64; 3]; 2] {
        self.x
    }

    /// n.
    pub(super) fn normal(&self) -> [f64; 3] {
        self.n[0]
    }

    /// |n|.
    pub(super) fn ray_length(&self) -> f64 {
        norm(self.n[0])
    }

    /// X_1 and X_2.
    pub(super) fn carried(&self) -> [[f64; 3]; 2] {
        [0, 1].map(|k| add(self.x[k], scale(self.powers[0], self.n[1 + k])))
    }

    /// int X_k dt and int X_k t dt from 0 to g.
    fn integrals(&self) -> [[[f64; 3]; 2]; 2] {
        let [g, half, third] = self.powers;
        [[g, half], [half, third]].map(|[of_x, of_n]| {
            [0, 1].map(|k| add(scale(of_x, self.x[k]), scale(of_n, self.n[1 + k])))
        })
    }

    /// Factors of the vectors in the forms.
    pub(super) fn factors(&self) -> [[f64; FORMS]; VECTORS] {
        let mut all = [[0.0; FORMS]; VECTORS];
        let values = patch::values(self.at);
        let slopes = patch::slopes(self.at);
        let others = patch::values(self.met.at);
        let other_slopes = patch::slopes(self.met.at);
        for k in 0..6 {
            let own = &mut all[k];
            (own[0], own[1], own[2]) = (values[k], slopes[0][k], slopes[1][k]);
            let own = &mut all[OTHER + k];
            (own[0], own[6], own[7]) = (-others[k], other_slopes[0][k], other_slopes[1][k]);
        }
        let [s, t] = self.at;
        let hats = [1.0 - s - t, s, t];
        let turns = [[-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]];
        for k in 0..3 {
            let own = &mut all[6 + k];
            own[0] = self.powers[0] * hats[k];
            own[3..6].copy_from_slice(&[hats[k], turns[0][k], turns[1][k]]);
        }
        all
    }

    /// -nu / c, and c.
    pub(super) fn across(&self, other: &Patch) -> ([f64; 3], f64) {
        let nu = other.area_vector(self.met.at);
        let c = dot(self.n[0], nu);
        (scale(-c.recip(), nu), c)
    }

    /// a_g.
    pub(super) fn swept_by_gap(&self) -> f64 {
        let [first, second] = self.carried();
        dot(self.n[0], cross(first, second))
    }

    /// Derivative of a by the vectors.
    pub(super) fn gradient(&self, other: &Patch) -> [[f64; 3]; VECTORS] {
        let n = self.n[0];
        let (down, _) = self.across(other);
        let [[u1, u2], [w1, w2]] = self.integrals();
        let [g, half, third] = self.powers;
        let ([x1, x2], [_, n1, n2]) = (self.x, self.n);
        let mixed = add(cross(x1, n2), cross(n1, x2));
        let turned = add(
            scale(g, cross(x1, x2)),
            add(scale(half, mixed), scale(third, cross(n1, n2))),
        );
        let forms = [
            scale(self.swept_by_gap(), down),
            cross(u2, n),
            cross(n, u1),
            turned,
            cross(w2, n),
            cross(n, w1),
        ];
        self.factors().map(|factors| {
            let terms = forms.iter().zip(factors);
            terms.fold([0.0; 3], |sum, (form, factor)| {
                add(sum, scale(factor, *form))
            })
        })
    }

    /// Of linear bodies n.(x_,1 x x_,2) times g, and times its derivatives by the vectors where the ray
    /// stays as it is ([`crate::pairs`]).
    pub(super) fn at_rest(&self, other: &Patch) -> (f64, [[f64; 3]; VECTORS]) {
        let facing = dot(self.n[0], cross(self.x[0], self.x[1]));
        let (down, _) = self.across(other);
        let mut rows = self
            .factors()
            .map(|factors| scale(facing * factors[0], down));
        rows[6..OTHER].fill([0.0; 3]);
        (facing * self.met.gap, rows)
    }

    /// Second derivative of a by the forms, of each pair once or both ways.
    fn form_bend(&self, other: &Patch) -> [[Block; FORMS]; FORMS] {
        let n = self.n[0];
        let (down, c) = self.across(other);
        let nu = scale(-c, down);
        let [y1, y2] = other.tangents(self.met.at);
        let m = [cross(y2, n), cross(n, y1)].map(|v| scale(c.recip(), v));
        let [b11, b12, b22] = other.bends().map(|bend| dot(nu, bend));
        let [p1, p2] = self.carried();
        let [g, half, third] = self.powers;
        let [[u1, u2], [w1, w2]] = self.integrals();
        let by_gap = self.swept_by_gap();
        let again = dot(n, add(cross(self.n[1], p2), cross(p1, self.n[2])));
        let share = by_gap / c;
        let curved = sum(
            sum(outer(scale(b11, m[0]), m[0]), outer(scale(b22, m[1]), m[1])),
            times(b12, sum(outer(m[0], m[1]), outer(m[1], m[0]))),
        );
        let mut bend = [[[[0.0; 3]; 3]; FORMS]; FORMS];
        bend[0][0] = sum(times(share, curved), times(again, outer(down, down)));
        let across_gap = add(scale(-share, nu), cross(p1, p2));
        let with_gap = [
            cross(p2, n),
            cross(n, p1),
            across_gap,
            scale(g, cross(p2, n)),
            scale(g, cross(n, p1)),
        ];
        for (k, form) in with_gap.into_iter().enumerate() {
            bend[0][1 + k] = outer(down, form);
        }
        bend[0][6] = outer(scale(share, m[0]), nu);
        bend[0][7] = outer(scale(share, m[1]), nu);
        // dn.(dx_1 x u_2), dn.(u_1 x dx_2) and so on.
        bend[3][1] = before(u2);
        bend[3][2] = opposite(before(u1));
        bend[3][4] = before(w2);
        bend[3][5] = opposite(before(w1));
        // n.(dx_1 x dx_2) = dx_1.(dx_2 x n).
        let turned = before(n);
        bend[1][2] = times(g, turned);
        bend[1][5] = times(half, turned);
        bend[4][2] = times(half, turned);
        bend[4][5] = times(third, turned);
        bend
    }

    /// Adds `factor` times the second derivative of a by the vectors, of each pair once: the later
    /// vector first.
    pub(super) fn add_bend(&self, other: &Patch, factor: f64, out: &mut Bend) {
        let mut forms = self.form_bend(other);
        for i in 0..FORMS {
            for j in 0..i {
                let both = sum(forms[i][j], transposed(forms[j][i]));
                (forms[i][j], forms[j][i]) = (both, transposed(both));
            }
        }
        let factors = self.factors();
        for (a, own) in factors.iter().enumerate() {
            // Rows of this vector by the forms.
            let mut rows = [[[0.0; 3]; 3]; FORMS];
            for &form in forms_of(a) {
                for &partner in PARTNERS[form] {
                    add_times(
                        &mut rows[partner],
                        factor * own[form],
                        &forms[form][partner],
                    );
                }
            }
            for (b, others) in factors.iter().enumerate().take(a + 1) {
                let block = &mut out[a][b];
                for &form in forms_of(b) {
                    add_times(block, others[form], &rows[form]);
                }
            }
        }
    }
}

/// The forms that a vector is part of.
fn forms_of(vector: usize) -> &'static [usize] {
    match vector {
        0..6 => &[0, 1, 2],
        6..OTHER => &[0, 3, 4, 5],
        _ => &[0, 6, 7],
    }
}

/// The second halves of a second derivative of which only pairs with the later vector first are known.
pub(super) fn completed(bend: &mut Bend) {
    for a in 0..VECTORS {
        for b in 0..a {
            bend[b][a] = transposed(bend[a][b]);
        }
    }
}

fn transposed(block: Block) -> Block {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| block[j][i]))
}

pub(super) fn add_times(sum: &mut Block, factor: f64, block: &Block) {
    for (row, own) in sum.iter_mut().zip(block) {
        for (sum, own) in row.iter_mut().zip(own) {
            *sum += factor * own;
        }
    }
}
