//! Quadrature on the reference segment, triangle and tetrahedron:
//! ∫_K f ≈ |K| Σ_q w_q f(x_q), x_q in barycentric coordinates.
//!
//! Small degrees use symmetric rules; the others collapse products of
//! Gauss-Legendre rules (Stroud's conical product), whose weights are positive
//! and whose points lie inside for every degree. The Jacobian 1 − a of a
//! collapsed direction raises the degree in it by one, so degree d takes about
//! (d/2 + 1)^dimension points. Gauss points come from Newton's method on the
//! Legendre recurrence. Cost: microseconds at degree 20, once per element kind.

/// Largest degree that scenes may ask for.
pub const MAXIMUM_DEGREE: u32 = 20;

/// The reference cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Simplex {
    /// A segment with two vertices.
    Segment,
    /// A triangle with three vertices.
    Triangle,
    /// A tetrahedron with four vertices.
    Tetrahedron,
}

impl Simplex {
    /// Number of vertices, one more than the dimension.
    pub fn vertices(self) -> usize {
        match self {
            Self::Segment => 2,
            Self::Triangle => 3,
            Self::Tetrahedron => 4,
        }
    }
}

/// Points and weights; both arrays have one entry per point.
#[derive(Clone, Debug, PartialEq)]
pub struct Rule {
    /// Barycentric coordinates `[points, 4]`; a simplex of v vertices uses the
    /// first v, the others are zero.
    pub points: Vec<[f64; 4]>,
    /// Positive, with sum 1: the caller multiplies by the measure.
    pub weights: Vec<f64>,
}

impl Rule {
    /// Number of points.
    pub fn len(&self) -> usize {
        self.weights.len()
    }

    /// Whether there are no points; no rule of this module is empty.
    pub fn is_empty(&self) -> bool {
        self.weights.is_empty()
    }

    /// Adds one point, by its barycentric coordinates `[4]`, with its weight.
    fn push(&mut self, point: [f64; 4], weight: f64) {
        self.points.push(point);
        self.weights.push(weight);
    }
}

/// A rule that integrates all polynomials up to `degree` exactly.
pub fn rule(kind: Simplex, degree: u32) -> Rule {
    match (kind, degree) {
        (Simplex::Segment, _) => segment(degree),
        (Simplex::Triangle | Simplex::Tetrahedron, 0 | 1) => centroid(kind),
        (Simplex::Triangle, 2) => orbits(3, &[(2.0 / 3.0, 1.0)]),
        (Simplex::Triangle, 4 | 5) => radon(),
        (Simplex::Triangle, _) => collapsed_triangle(degree),
        (Simplex::Tetrahedron, 2) => orbits(4, &[(0.585_410_196_624_968_5, 1.0)]),
        (Simplex::Tetrahedron, 4 | 5) => walkington(),
        (Simplex::Tetrahedron, _) => collapsed_tetrahedron(degree),
    }
}

/// One point, degree 1.
fn centroid(kind: Simplex) -> Rule {
    let vertices = kind.vertices();
    let mut point = [0.0; 4];
    point[..vertices].fill(1.0 / vertices as f64);
    Rule {
        points: vec![point],
        weights: vec![1.0],
    }
}

/// Points on the medians: each orbit has one point per vertex, with coordinate
/// `near` there and equal ones elsewhere, and shares its total weight.
fn orbits(vertices: usize, near_and_total: &[(f64, f64)]) -> Rule {
    let mut rule = empty();
    for &(near, total) in near_and_total {
        for vertex in 0..vertices {
            let mut point = [0.0; 4];
            point[..vertices].fill((1.0 - near) / (vertices - 1) as f64);
            point[vertex] = near;
            rule.push(point, total / vertices as f64);
        }
    }
    rule
}

/// Seven points on the triangle, degree 5 (Radon 1948).
fn radon() -> Rule {
    let root = 15_f64.sqrt();
    let mut rule = orbits(
        3,
        &[
            ((9.0 + 2.0 * root) / 21.0, (155.0 - root) / 400.0),
            ((9.0 - 2.0 * root) / 21.0, (155.0 + root) / 400.0),
        ],
    );
    let third = 1.0 / 3.0;
    rule.push([third, third, third, 0.0], 9.0 / 40.0);
    rule
}

/// Fourteen points on the tetrahedron, degree 5 (Walkington 2000).
fn walkington() -> Rule {
    let inner = 1.0 - 3.0 * 0.092_735_250_310_891_23;
    let outer = 1.0 - 3.0 * 0.310_885_919_263_300_6;
    let inner_total = 4.0 * 0.073_493_043_116_361_95;
    let outer_total = 4.0 * 0.112_687_925_718_015_85;
    let mut rule = orbits(4, &[(inner, inner_total), (outer, outer_total)]);
    let low = 0.045_503_704_125_649_65;
    let weight = (1.0 - inner_total - outer_total) / 6.0;
    for first in 0..4 {
        for second in first + 1..4 {
            let mut point = [low; 4];
            point[first] = 0.5 - low;
            point[second] = 0.5 - low;
            rule.push(point, weight);
        }
    }
    rule
}

/// Gauss's rule on the segment, exact for polynomials of that degree; its weights add
/// up to one.
fn segment(degree: u32) -> Rule {
    let mut rule = empty();
    for (a, weight) in gauss(degree) {
        rule.push([1.0 - a, a, 0.0, 0.0], weight);
    }
    rule
}

/// (a, b) in the unit square ↦ λ = ((1−a)(1−b), a, b(1−a)), Jacobian 1 − a.
fn collapsed_triangle(degree: u32) -> Rule {
    let mut rule = empty();
    let inner = gauss(degree);
    for (a, first) in gauss(degree + 1) {
        let rest = 1.0 - a;
        for &(b, second) in &inner {
            let point = [rest * (1.0 - b), a, rest * b, 0.0];
            rule.push(point, 2.0 * first * second * rest);
        }
    }
    rule
}

/// The triangle's map over the faces a = const, Jacobian (1 − a)² (1 − b).
fn collapsed_tetrahedron(degree: u32) -> Rule {
    let mut rule = empty();
    let face = collapsed_triangle(degree);
    for (a, first) in gauss(degree + 2) {
        let rest = 1.0 - a;
        for (point, second) in face.points.iter().zip(&face.weights) {
            let [x, y, z, _] = point.map(|coordinate| rest * coordinate);
            rule.push([x, y, z, a], 3.0 * first * second * rest * rest);
        }
    }
    rule
}

/// A rule without points, to be filled.
fn empty() -> Rule {
    Rule {
        points: Vec::new(),
        weights: Vec::new(),
    }
}

/// Gauss-Legendre points and weights on `[0, 1]`, ascending, exact to `degree`.
fn gauss(degree: u32) -> Vec<(f64, f64)> {
    let count = degree / 2 + 1;
    (0..count).map(|index| gauss_point(count, index)).collect()
}

/// Point `index` of the Gauss rule of `count` points: root of P_count.
fn gauss_point(count: u32, index: u32) -> (f64, f64) {
    // Tricomi's estimate is close enough for Newton to stay with its root.
    let estimate = (f64::from(index) + 0.75) / (f64::from(count) + 0.5);
    let mut root = -(std::f64::consts::PI * estimate).cos();
    for _ in 0..8 {
        let (value, derivative) = legendre(count, root);
        root -= value / derivative;
    }
    let (_, derivative) = legendre(count, root);
    let weight = 1.0 / ((1.0 - root * root) * derivative * derivative);
    (0.5 * (1.0 + root), weight)
}

/// P_n(x) and its derivative for n ≥ 1 and |x| < 1, by the three-term recurrence.
fn legendre(order: u32, x: f64) -> (f64, f64) {
    let (mut previous, mut current) = (1.0, x);
    for step in 1..order {
        let step = f64::from(step);
        let next = ((2.0 * step + 1.0) * x * current - step * previous) / (step + 1.0);
        (previous, current) = (current, next);
    }
    let derivative = f64::from(order) * (previous - x * current) / (1.0 - x * x);
    (current, derivative)
}

#[cfg(test)]
mod tests {
    use super::*;

    const KINDS: [Simplex; 3] = [Simplex::Segment, Simplex::Triangle, Simplex::Tetrahedron];

    fn factorial(number: u32) -> f64 {
        (1..=number).map(f64::from).product()
    }

    /// ∫ Π λ_i^{a_i} / |K| = d! Π a_i! / (d + Σ a_i)!.
    fn exact_mean(dimension: u32, exponents: &[u32]) -> f64 {
        let total: u32 = exponents.iter().sum();
        let numerator: f64 = exponents.iter().map(|&power| factorial(power)).product();
        factorial(dimension) * numerator / factorial(dimension + total)
    }

    fn computed_mean(rule: &Rule, exponents: &[u32]) -> f64 {
        let value = |point: &[f64; 4]| -> f64 {
            let factors = point.iter().zip(exponents);
            factors.map(|(x, &power)| x.powi(power as i32)).product()
        };
        let terms = rule.points.iter().zip(&rule.weights);
        terms.map(|(point, weight)| weight * value(point)).sum()
    }

    /// All exponents of the Cartesian monomials up to a degree.
    fn monomials(dimension: u32, degree: u32) -> Vec<Vec<u32>> {
        let mut found = vec![Vec::new()];
        for _ in 0..dimension {
            found = found
                .into_iter()
                .flat_map(|head: Vec<u32>| {
                    let left = degree - head.iter().sum::<u32>();
                    (0..=left).map(move |power| [head.as_slice(), &[power]].concat())
                })
                .collect();
        }
        found
    }

    #[test]
    fn every_monomial_is_exact_to_the_degree() {
        for kind in KINDS {
            let dimension = kind.vertices() as u32 - 1;
            for degree in 1..=MAXIMUM_DEGREE {
                let rule = rule(kind, degree);
                for exponents in monomials(dimension, degree) {
                    let exact = exact_mean(dimension, &exponents);
                    let error = (computed_mean(&rule, &exponents) - exact).abs();
                    assert!(
                        error < 1e-13 * exact,
                        "{kind:?} {degree} {exponents:?} {error:e}"
                    );
                }
            }
        }
    }

    #[test]
    fn points_lie_inside_and_weights_are_positive() {
        for kind in KINDS {
            for degree in 0..=MAXIMUM_DEGREE {
                let rule = rule(kind, degree);
                assert_eq!(rule.points.len(), rule.len());
                assert!(rule.weights.iter().all(|&weight| weight > 0.0));
                for point in &rule.points {
                    assert!(point[..kind.vertices()].iter().all(|&x| x > 0.0));
                    assert!(point[kind.vertices()..].iter().all(|&x| x.abs() < 1e-300));
                    assert!((point.iter().sum::<f64>() - 1.0).abs() < 1e-15);
                }
            }
        }
    }

    #[test]
    fn one_degree_more_is_not_integrated_exactly() {
        let exact = exact_mean(3, &[0, 0, 0, 3]);
        let error = computed_mean(&rule(Simplex::Tetrahedron, 2), &[0, 0, 0, 3]) - exact;
        assert!(error.abs() > 1e-3 * exact);
    }

    #[test]
    fn small_degrees_use_few_points() {
        let count = |kind, degree| rule(kind, degree).len();
        assert_eq!(count(Simplex::Tetrahedron, 1), 1);
        assert_eq!(count(Simplex::Tetrahedron, 2), 4);
        assert_eq!(count(Simplex::Tetrahedron, 5), 14);
        assert_eq!(count(Simplex::Triangle, 2), 3);
        assert_eq!(count(Simplex::Triangle, 5), 7);
        assert_eq!(count(Simplex::Segment, 3), 2);
    }
}
