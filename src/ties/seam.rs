//! The rows of a tie:
//!
//! ```text
//! sum over the parts of int psi_j (N_a(x) u_a - N_b(x) u_b) dS
//! ```
//!
//! a the nodes of the carrier's facet, b those of the cell behind its partner, x the point of the
//! carrier. Shapes: rows `[functions]` of values at nodes, the same for every component; areas of the
//! scaled body, about an axis of the full turn. Facets run in parallel, sums in their order. Cost:
//! some ten parts a facet, five or seven points each, 100 flops a point and node.

use super::cell::{self, Value};
use super::overlap::{self, Part};
use crate::contact::shares::add_equal_columns;
use crate::contact::{ContactFace, ContactSurface};
use crate::element::quadrature::{Rule, Simplex, rule};
use crate::geometry::vector3::{add, norm, scale, sub};
use crate::mesh::{CurvedFacet, Mesh};
use crate::pairs::tree::{Bounds, BoxTree};
use crate::parallel;
use crate::space::TaylorHood;

/// Degrees of the rules on segments and on triangles: products of quadratics and the radius.
const DEGREE: [u32; 2] = [9, 5];
/// How far surfaces may be apart, or inside each other, over the longest edge of the two facets.
const REACH: f64 = 0.25;
/// Fewer facets are not worth a second thread.
const FEW: usize = 8;

/// The two surfaces of a tie.
#[derive(Clone, Copy, Debug)]
pub struct Sides<'a> {
    /// Faces and functions of the carrier, one multiplier a function.
    pub surface: &'a ContactSurface,
    /// Facets of the other one.
    pub other: &'a [u32],
}

/// How far surfaces are apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Distance of a point of the carrier from the facet that it is tied to, length of the mesh.
    pub width: f64,
    /// The point, undeformed.
    pub place: [f64; 3],
}

/// What one part of a facet adds.
#[derive(Clone, Debug, Default)]
struct Own {
    /// Values at nodes of the carrier and of the other body `[functions of the face][2]`.
    rows: Vec<[Vec<Value>; 2]>,
    /// int psi_j dS `[functions of the face]`.
    covered: Vec<f64>,
    gap: Option<Gap>,
}

/// Both surfaces compared, function by function.
#[derive(Clone, Debug)]
pub struct Seam {
    /// Values at nodes of the carrier `[functions]`, nodes ascending.
    pub own: Vec<Vec<Value>>,
    /// Values at nodes of the other body.
    pub other: Vec<Vec<Value>>,
    /// int psi_j dS where there is a partner `[functions]`.
    pub covered: Vec<f64>,
    /// The largest gap.
    pub gap: Option<Gap>,
}

impl Seam {
    /// Of the surfaces at rest.
    pub fn new((mesh, space): (&Mesh, &TaylorHood), sides: Sides<'_>) -> Self {
        let finder = Finder::new((mesh, space), sides.other);
        let faces = &sides.surface.faces;
        let all = parallel::map(faces.len(), FEW, &|face| finder.face(&faces[face]));
        let size = sides.surface.carriers.len();
        let mut seam = Self {
            own: vec![Vec::new(); size],
            other: vec![Vec::new(); size],
            covered: vec![0.0; size],
            gap: None,
        };
        for (face, own) in faces.iter().zip(all) {
            seam.add(face, own);
        }
        let rows = seam.own.iter_mut().chain(&mut seam.other);
        rows.for_each(add_equal_columns);
        seam
    }

    fn add(&mut self, face: &ContactFace, added: Own) {
        let each = added.rows.into_iter().zip(added.covered);
        for (&function, ([own, other], covered)) in face.functions.iter().zip(each) {
            let k = function as usize;
            self.own[k].extend(own);
            self.other[k].extend(other);
            self.covered[k] += covered;
        }
        self.gap = wider(self.gap, added.gap);
    }

    /// The part of `surface` that has a partner, none above one.
    pub fn share(&self, surface: &ContactSurface) -> f64 {
        let [covered, whole] = [&self.covered, &surface.weights].map(|all| all.iter().sum::<f64>());
        (covered / whole).min(1.0)
    }
}

/// The wider one, the first of equal ones.
fn wider(first: Option<Gap>, second: Option<Gap>) -> Option<Gap> {
    match (first, second) {
        (Some(a), Some(b)) if b.width > a.width => Some(b),
        (None, b) => b,
        (a, _) => a,
    }
}

/// Facets of the other surface, and where they are.
struct Finder<'a> {
    mesh: &'a Mesh,
    space: &'a TaylorHood,
    other: &'a [u32],
    tree: BoxTree,
    rule: Rule,
}

impl<'a> Finder<'a> {
    fn new((mesh, space): (&'a Mesh, &'a TaylorHood), other: &'a [u32]) -> Self {
        let boxes = other.iter().map(|&facet| {
            let corners = corners(mesh, mesh.facet(facet as usize));
            grown(&corners, REACH * longest(&corners))
        });
        let (simplex, degree) = match mesh.cell_kind().facet_vertices() {
            2 => (Simplex::Segment, DEGREE[0]),
            _ => (Simplex::Triangle, DEGREE[1]),
        };
        Self {
            mesh,
            space,
            other,
            tree: BoxTree::new(boxes.collect()),
            rule: rule(simplex, degree),
        }
    }

    /// What a face adds, partner by partner.
    fn face(&self, face: &ContactFace) -> Own {
        let own = corners(self.mesh, &face.corners);
        let mut sum = Own {
            rows: vec![Default::default(); face.functions.len()],
            covered: vec![0.0; face.functions.len()],
            gap: None,
        };
        for place in self.tree.meeting(&grown(&own, REACH * longest(&own))) {
            let facet = self.other[place as usize];
            let partner = corners(self.mesh, self.mesh.facet(facet as usize));
            let reach = REACH * longest(&own).max(longest(&partner));
            for part in overlap::parts(&own, &partner) {
                self.part((face, facet), (&part, reach), &mut sum);
            }
        }
        for [own, other] in &mut sum.rows {
            add_equal_columns(own);
            add_equal_columns(other);
        }
        sum
    }

    /// Adds a part, where its partner is within reach of all its points.
    fn part(&self, (face, facet): (&ContactFace, u32), (part, reach): (&Part, f64), sum: &mut Own) {
        let points = self.rule.points.iter().zip(&self.rule.weights);
        let points = points.map(|(point, weight)| {
            let count = face.corners.len();
            let corners = part.corners.iter().zip(point).take(count);
            let place = corners.fold([0.0; 3], |sum, (corner, l)| add(sum, scale(*l, *corner)));
            self.point((face, facet), &place[..count], weight * part.share)
        });
        let Some(points) = points.collect::<Option<Vec<Point>>>() else {
            return;
        };
        if points.iter().any(|point| point.gap.width > reach) {
            return;
        }
        for point in points {
            point.add(sum);
        }
    }

    /// A point of a face at `l`; none where it is not found beside its partner.
    fn point(&self, (face, facet): (&ContactFace, u32), l: &[f64], weight: f64) -> Option<Point> {
        let place = position(self.mesh, &face.corners, l);
        let (cell, opposite) = self.mesh.facet_cell(facet as usize);
        let inside = cell::coordinates(self.mesh, cell, place)?;
        let own = face.nodes.iter().copied().zip(quadratics(l, 4.0, |l| l));
        Some(Point {
            functions: quadratics(l, 2.0, |l| l * l),
            weight: weight * face.area_at(l),
            own: own.collect(),
            other: cell::values(self.mesh, self.space, (cell, inside)),
            gap: Gap {
                width: cell::beyond(self.mesh, (cell, opposite), inside[opposite]),
                place,
            },
        })
    }
}

/// A point of the rule.
struct Point {
    /// Functions of the traction `[functions of the face]`.
    functions: Vec<f64>,
    /// Weight times the area.
    weight: f64,
    own: Vec<Value>,
    other: Vec<Value>,
    gap: Gap,
}

impl Point {
    fn add(self, sum: &mut Own) {
        let each = sum.rows.iter_mut().zip(&mut sum.covered);
        for (([own, other], covered), function) in each.zip(&self.functions) {
            let weight = self.weight * function;
            let times = |&(node, value): &Value| (node, weight * value);
            own.extend(self.own.iter().map(times));
            other.extend(self.other.iter().map(times));
            *covered += weight;
        }
        sum.gap = wider(sum.gap, Some(self.gap));
    }
}

/// A function of each corner, then `factor` L_a L_b of the edges (0,1), (0,2), (1,2).
fn quadratics(l: &[f64], factor: f64, corner: impl Fn(f64) -> f64) -> Vec<f64> {
    let mut values: Vec<f64> = l.iter().map(|&l| corner(l)).collect();
    for (i, a) in l.iter().enumerate() {
        values.extend(l[i + 1..].iter().map(|b| factor * a * b));
    }
    values
}

/// The undeformed point of a face at `l`, length of the mesh.
fn position(mesh: &Mesh, corners: &[u32], l: &[f64]) -> [f64; 3] {
    if let Some(curve) = CurvedFacet::of(mesh, 1.0, corners) {
        return curve.position(l);
    }
    let places = corners.iter().zip(l);
    places.fold([0.0; 3], |sum, (&vertex, l)| {
        add(sum, scale(*l, mesh.coordinates()[vertex as usize]))
    })
}

fn corners(mesh: &Mesh, vertices: &[u32]) -> Vec<[f64; 3]> {
    let places = vertices.iter();
    places
        .map(|&vertex| mesh.coordinates()[vertex as usize])
        .collect()
}

/// Length of the longest edge.
fn longest(corners: &[[f64; 3]]) -> f64 {
    let after = corners.iter().cycle().skip(1);
    let edges = corners.iter().zip(after).map(|(a, b)| norm(sub(*b, *a)));
    edges.fold(0.0, f64::max)
}

fn grown(corners: &[[f64; 3]], by: f64) -> Bounds {
    let mut bounds = Bounds::of(corners.iter().copied());
    bounds.low.iter_mut().for_each(|x| *x -= by);
    bounds.high.iter_mut().for_each(|x| *x += by);
    bounds
}
