//! Flow through what is open between a body and what it touches, by Reynolds' equation of a thin
//! film at rest,
//!
//! ```text
//! div(g^3 / (12 eta) grad p) = 0,   p = q where the fluid is from, p = 0 where it must not be
//! Q = C q,                          C the conductance: Q over the pressure difference
//! ```
//!
//! g the gap of the deformed body at the nodes; where a node is closed nothing passes the parts of
//! facets around it. On lines g is linear between nodes and a part's resistance is exact, int ds/g^3; on
//! faces p is linear on the parts into which the midpoints divide a facet and g^3 is integrated
//! exactly. Assumptions: the gap is small beside its length, the fluid Newtonian and without
//! inertia, walls smooth and at rest.
//!
//! Shapes `[nodes of the surface]`, lengths in any one unit; C is for viscosity one, in length^3,
//! in the plane length^2. Reference: B. Hamrock, *Fundamentals of Fluid Film Lubrication* (2004),
//! chapter 7. Cost: one sparse factor of the open nodes.

use super::surface::FluidSurface;
use crate::geometry::vector3::{cross, dot, norm, sub};
use crate::linalg::cholesky::{LowerColumns, Precision, SparseCholesky};
use crate::linalg::{FactoriseError, Workspace};

/// Parts of a segment's nodes: corners, then the middle.
const SEGMENT: &[&[usize]] = &[&[0, 2], &[2, 1]];
/// Parts of a triangle's: corners, then the middles of (0, 1), (0, 2), (1, 2).
const TRIANGLE: &[&[usize]] = &[&[0, 3, 4], &[3, 1, 5], &[4, 5, 2], &[3, 5, 4]];

/// How much flows beside a line of the plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Breadth {
    /// A unit of thickness.
    One,
    /// The circle about the axis, 2 pi r.
    Circumference,
}

/// What a fluid may flow through.
#[derive(Clone, Copy, Debug)]
pub struct OpenGap<'a> {
    /// The surface of the body.
    pub surface: &'a FluidSurface,
    /// Its nodes in the deformed body.
    pub places: &'a [[f64; 3]],
    /// How far each is from what it may touch; zero where it is closed.
    pub gaps: &'a [f64],
    /// Beside a line.
    pub breadth: Breadth,
}

/// An open part of a facet.
struct Part {
    /// Places of its nodes on the surface.
    nodes: Vec<u32>,
    /// Flow out of node i for a unit of pressure at node j `[nodes, nodes]`.
    matrix: Vec<f64>,
}

impl OpenGap<'_> {
    /// Flow from sources to what must stay dry for a unit of pressure and of viscosity.
    ///
    /// # Errors
    /// [`FactoriseError`] where memory is short or numbers are not finite.
    pub fn conductance(&self) -> Result<f64, FactoriseError> {
        let parts = self.parts();
        let is_reached = self.reached(&parts);
        let surface = self.surface;
        let ends = surface.dry.iter().zip(&is_reached);
        if !ends.into_iter().any(|(&dry, &reached)| dry && reached) {
            return Ok(0.0);
        }
        let pressure = self.pressures(&parts, &is_reached)?;
        let flows = parts.iter().map(|part| {
            let count = part.nodes.len();
            let rows = part.nodes.iter().zip(part.matrix.chunks_exact(count));
            let sources = rows.filter(|(node, _)| surface.sources[**node as usize]);
            let flow = |row: &[f64]| -> f64 {
                let pairs = row.iter().zip(&part.nodes);
                pairs.map(|(k, &node)| k * pressure[node as usize]).sum()
            };
            sources.map(|(_, row)| flow(row)).sum::<f64>()
        });
        Ok(flows.sum())
    }

    /// Parts of facets that are open.
    fn parts(&self) -> Vec<Part> {
        let facets = self.surface.facets.iter();
        let all = facets.flat_map(|nodes| {
            let parts = if nodes.len() == 3 { SEGMENT } else { TRIANGLE };
            let parts = parts.iter().copied();
            parts.map(|own| own.iter().map(|&k| nodes[k]).collect::<Vec<u32>>())
        });
        all.filter_map(|nodes| self.part(nodes)).collect()
    }

    /// The part of these nodes; none where one of them is closed, or it has no extent.
    fn part(&self, nodes: Vec<u32>) -> Option<Part> {
        let gaps: Vec<f64> = nodes.iter().map(|&node| self.gaps[node as usize]).collect();
        let is_open = gaps.iter().all(|gap| *gap > 0.0 && gap.is_finite());
        let places: Vec<[f64; 3]> = nodes
            .iter()
            .map(|&node| self.places[node as usize])
            .collect();
        let matrix = match (&places[..], &gaps[..]) {
            (&[a, b], &[g, h]) => self.line([a, b], [g, h]),
            (&[a, b, c], &[f, g, h]) => face([a, b, c], [f, g, h]),
            _ => return None,
        };
        let is_sound = is_open && matrix.iter().all(|entry| entry.is_finite());
        is_sound.then_some(Part { nodes, matrix })
    }

    /// 1 / int 12 ds / (b g^3) of a straight line, b the breadth in its middle.
    fn line(&self, [a, b]: [[f64; 3]; 2], [g, h]: [f64; 2]) -> Vec<f64> {
        let breadth = match self.breadth {
            Breadth::One => 1.0,
            Breadth::Circumference => std::f64::consts::PI * (a[0] + b[0]),
        };
        let of_gaps = 2.0 * (g * h).powi(2) / (g + h);
        let own = breadth * of_gaps / (12.0 * norm(sub(b, a)));
        vec![own, -own, -own, own]
    }

    /// Nodes that open parts join to a source.
    fn reached(&self, parts: &[Part]) -> Vec<bool> {
        let mut at_node: Vec<Vec<u32>> = vec![Vec::new(); self.gaps.len()];
        for (part, number) in parts.iter().zip(0..) {
            let nodes = part.nodes.iter();
            nodes.for_each(|&node| at_node[node as usize].push(number));
        }
        let mut is_reached = self.surface.sources.clone();
        let mut ahead: Vec<usize> = (0..is_reached.len()).filter(|&k| is_reached[k]).collect();
        while let Some(node) = ahead.pop() {
            for &part in &at_node[node] {
                for &other in &parts[part as usize].nodes {
                    let known = &mut is_reached[other as usize];
                    if !std::mem::replace(known, true) {
                        ahead.push(other as usize);
                    }
                }
            }
        }
        is_reached
    }

    /// Pressures over that of the source: one there, zero where it must stay dry and where nothing
    /// flows to.
    fn pressures(&self, parts: &[Part], is_reached: &[bool]) -> Result<Vec<f64>, FactoriseError> {
        let surface = self.surface;
        let mut pressure: Vec<f64> = surface.sources.iter().map(|&is| f64::from(is)).collect();
        let is_sought = |node: usize| {
            let is_given = surface.sources[node] || surface.dry[node];
            is_reached[node] && !is_given
        };
        let sought: Vec<usize> = (0..pressure.len()).filter(|&k| is_sought(k)).collect();
        let (matrix, mut right) = system(parts, &sought, &pressure);
        if !sought.is_empty() {
            let factor = SparseCholesky::by_least_degree(&matrix, Precision::Double)?;
            factor.solve(&mut right, 1, &mut Workspace::default());
        }
        for (&node, value) in sought.iter().zip(right) {
            pressure[node] = value;
        }
        Ok(pressure)
    }
}

/// Stiffness of linear pressure on a triangle, times the mean of g^3 / 12.
fn face(places: [[f64; 3]; 3], gaps: [f64; 3]) -> Vec<f64> {
    let [a, b, c] = places;
    let opposite = [sub(c, b), sub(a, c), sub(b, a)];
    let doubled = norm(cross(opposite[2], opposite[1]));
    let conductivity = mean_cube(gaps) / 12.0;
    let pairs = (0..3).flat_map(|i| (0..3).map(move |j| (i, j)));
    let entry = |(i, j): (usize, usize)| dot(opposite[i], opposite[j]) / (2.0 * doubled);
    pairs.map(|pair| conductivity * entry(pair)).collect()
}

/// Mean over a triangle of the cube of what is linear there: a tenth of all products of three.
fn mean_cube([f, g, h]: [f64; 3]) -> f64 {
    let of_two = g * g + g * h + h * h;
    let of_three = (g + h) * (g * g + h * h);
    (f.powi(3) + f * f * (g + h) + f * of_two + of_three) / 10.0
}

/// Matrix of the `sought` nodes and what the given pressures make of the right-hand side.
fn system(parts: &[Part], sought: &[usize], pressure: &[f64]) -> (LowerColumns, Vec<f64>) {
    let mut place = vec![None; pressure.len()];
    for (&node, number) in sought.iter().zip(0_u32..) {
        place[node] = Some(number);
    }
    let mut right = vec![0.0; sought.len()];
    let mut entries: Vec<([u32; 2], f64)> = Vec::new();
    for part in parts {
        let rows = part.matrix.chunks_exact(part.nodes.len());
        for (i, row) in part.nodes.iter().zip(rows) {
            let Some(i) = place[*i as usize] else {
                continue;
            };
            for (&j, &value) in part.nodes.iter().zip(row) {
                match place[j as usize] {
                    None => right[i as usize] -= value * pressure[j as usize],
                    Some(j) if i >= j => entries.push(([j, i], value)),
                    Some(_) => {}
                }
            }
        }
    }
    entries.sort_by_key(|(at, _)| *at);
    let mut matrix = LowerColumns::default();
    for own in entries.chunk_by(|a, b| a.0 == b.0) {
        let [column, row] = own[0].0;
        while matrix.offsets.len() <= column as usize {
            matrix.offsets.push(matrix.rows.len() as u32);
        }
        matrix.rows.push(row);
        matrix.values.push(own.iter().map(|(_, value)| value).sum());
    }
    matrix.offsets.push(matrix.rows.len() as u32);
    (matrix, right)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fluid::surface::Reach;
    use crate::mesh::{GroupKind, Mesh, samples};
    use crate::space::TaylorHood;

    fn group(mesh: &Mesh, name: &str) -> Vec<u32> {
        let group = mesh.group(name, GroupKind::Facets).expect("a side");
        group.members.clone()
    }

    /// Of the side `on` of a sample, from the side `x0` to `x1`, under a gap.
    fn conductance(mesh: &Mesh, on: &str, gap: impl Fn([f64; 3]) -> f64, breadth: Breadth) -> f64 {
        let space = TaylorHood::new(mesh);
        let [on, from, dry] = [on, "x0", "x1"].map(|name| group(mesh, name));
        let reach = Reach {
            facets: &on,
            from: &from,
            dry: &dry,
        };
        let surface = FluidSurface::new(mesh, &space, reach);
        let nodes = surface.nodes.iter();
        let places: Vec<[f64; 3]> = nodes.map(|&node| space.node_place(mesh, node)).collect();
        let gaps: Vec<f64> = places.iter().map(|&place| gap(place)).collect();
        let open = OpenGap {
            surface: &surface,
            places: &places,
            gaps: &gaps,
            breadth,
        };
        open.conductance().expect("a factor")
    }

    #[test]
    fn a_wedge_lets_through_what_its_closed_form_says() {
        // int dx / (12 (.1 + .1 x)^3) over one: 12 * (g + h) / (2 g^2 h^2), g = .1, h = .2.
        let exact = 2.0 * (0.1_f64 * 0.2).powi(2) / (12.0 * 0.3);
        let mesh = samples::rectangle(3, 2);
        let found = conductance(&mesh, "y0", |x| 0.1 + 0.1 * x[0], Breadth::One);
        assert!((found / exact - 1.0).abs() < 1e-12, "{found} {exact}");
    }

    #[test]
    fn an_even_gap_lets_through_its_cube() {
        let mesh = samples::cube(3);
        let found = conductance(&mesh, "z1", |_| 0.2, Breadth::One);
        let exact = 0.2_f64.powi(3) / 12.0;
        assert!((found / exact - 1.0).abs() < 1e-12, "{found} {exact}");
    }

    #[test]
    fn faces_come_to_the_wedge_of_the_plane_by_the_square_of_their_size() {
        let exact = 2.0 * (0.1_f64 * 0.2).powi(2) / (12.0 * 0.3);
        let error = |n| {
            let mesh = samples::cube(n);
            let found = conductance(&mesh, "z1", |x| 0.1 + 0.1 * x[0], Breadth::One);
            (found / exact - 1.0).abs()
        };
        let errors = [error(2), error(4)];
        assert!(errors[0] < 0.03, "{errors:?}");
        let rate = errors[0] / errors[1];
        assert!((3.5..4.5).contains(&rate), "{errors:?}");
    }

    #[test]
    fn a_closed_node_in_the_way_stops_the_flow_of_a_line() {
        let mesh = samples::rectangle(4, 1);
        let gap = |x: [f64; 3]| if (x[0] - 0.5).abs() < 1e-9 { 0.0 } else { 0.1 };
        assert!(conductance(&mesh, "y0", gap, Breadth::One) == 0.0);
    }

    #[test]
    fn what_is_dammed_up_lets_through_what_the_rest_does() {
        // A strip that is closed over half of its breadth, along the flow: half of the rest.
        let mesh = samples::cube(4);
        let gap = |x: [f64; 3]| if x[1] > 0.51 { 0.0 } else { 0.2 };
        let found = conductance(&mesh, "z1", gap, Breadth::One);
        let exact = 0.5 * 0.2_f64.powi(3) / 12.0;
        assert!((found / exact - 1.0).abs() < 1e-12, "{found} {exact}");
    }

    #[test]
    fn a_ring_lets_through_the_logarithm_of_its_radii() {
        // From r = 1 to 2: 2 pi g^3 / (12 ln 2).
        let mesh = samples::rectangle(16, 1);
        let space = TaylorHood::new(&mesh);
        let [on, from, dry] = ["y0", "x0", "x1"].map(|name| group(&mesh, name));
        let reach = Reach {
            facets: &on,
            from: &from,
            dry: &dry,
        };
        let surface = FluidSurface::new(&mesh, &space, reach);
        let nodes = surface.nodes.iter();
        let places = nodes.map(|&node| {
            let [x, y, z] = space.node_place(&mesh, node);
            [1.0 + x, y, z]
        });
        let open = OpenGap {
            surface: &surface,
            places: &places.collect::<Vec<_>>(),
            gaps: &vec![0.1; surface.nodes.len()],
            breadth: Breadth::Circumference,
        };
        let found = open.conductance().expect("a factor");
        let exact = std::f64::consts::TAU * 1e-3 / (12.0 * 2.0_f64.ln());
        assert!((found / exact - 1.0).abs() < 2e-4, "{found} {exact}");
    }
}
