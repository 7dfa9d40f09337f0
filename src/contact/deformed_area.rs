//! Deformed areas of the contact surface: int psi_i da with x = X + u on quadratic
//! faces, da = |x_s x x_t| ds dt (|x_s| ds in the plane, times 2 pi (x + u_x) about an axis), by the rule of the gap.
//!
//! A contact pressure l per undeformed area is l_i int psi_i dS / int psi_i da per
//! deformed area. Shapes: `[multipliers]`. Cost: some 100 flops a point.

use std::f64::consts::TAU;

use super::deformed::{Deformed, FacePoints, Table};
use super::face::ContactFace;
use super::surface::ContactSurface;
use crate::assembly::follower::shape_slopes;
use crate::geometry::vector3::{add, cross, norm, scale};

impl ContactSurface {
    /// int psi_k da over the deformed surface `[functions]`.
    pub(super) fn deformed_weights(&self, body: &Deformed<'_>) -> Vec<f64> {
        let table = Table::new(body, self.basis);
        let slopes: Vec<Vec<[f64; 2]>> = (0..table.points())
            .map(|point| shape_slopes(table.coordinates(point)))
            .collect();
        let size = table.points();
        let areas = body.on_faces(&table, &self.faces, size, |points, face, areas| {
            let nodes = node_positions(body, points, face);
            let rule = points.table;
            for (point, area) in areas.iter_mut().enumerate() {
                let (values, slopes) = (rule.shapes(point), slopes[point].iter());
                let functions = values.iter().zip(slopes);
                *area = rule.rule.weights[point] * area_element(face, &nodes, functions);
            }
        });
        let mut weights = vec![0.0; self.carriers.len()];
        for (face, areas) in self.faces.iter().zip(areas.chunks_exact(size)) {
            for (point, area) in areas.iter().enumerate() {
                for (&function, value) in face.functions.iter().zip(table.values(point)) {
                    weights[function as usize] += value * area;
                }
            }
        }
        weights
    }

    /// Coefficients of the contact pressure per deformed area `[functions]`, from those
    /// per undeformed area `[multipliers]`.
    pub fn deformed_pressure(&self, body: &Deformed<'_>, pressure: &[f64]) -> Vec<f64> {
        let deformed = self.deformed_weights(body);
        let weights = self.own_weights().into_iter().zip(deformed);
        let ratios = weights.map(|(undeformed, deformed)| undeformed / deformed);
        let pressure = self.shares.spread(pressure);
        pressure.iter().zip(ratios).map(|(p, r)| p * r).collect()
    }

    /// int phi_k dS over the undeformed surface `[functions]`.
    fn own_weights(&self) -> Vec<f64> {
        let mut weights = vec![0.0; self.carriers.len()];
        for face in &self.faces {
            for (k, &function) in face.functions.iter().enumerate() {
                weights[function as usize] += self.basis.weight(face, k);
            }
        }
        weights
    }

    /// Nodes with the values there of the pressure with these `coefficients`
    /// `[functions]`, face by face, so that a node comes once for each of its faces.
    pub fn at_nodes(&self, coefficients: &[f64]) -> impl Iterator<Item = (u32, f64)> {
        self.faces.iter().flat_map(|face| {
            let own = face.functions.iter().map(|&k| coefficients[k as usize]);
            let own: Vec<f64> = own.collect();
            let values = self.basis.at_nodes(face.corners.len(), &own);
            let nodes = face.functions.iter().map(|&k| self.carriers[k as usize]);
            nodes.zip(values).collect::<Vec<_>>()
        })
    }

    /// Largest value at the nodes of all faces, at least zero, of the pressure with
    /// these `coefficients` `[functions]`.
    pub fn largest(&self, coefficients: &[f64]) -> f64 {
        let values = self.at_nodes(coefficients).map(|(_, value)| value);
        values.fold(0.0, f64::max)
    }
}

/// Coefficients of x + u at the nodes of a face: positions of the corners, those of
/// the edges in the hierarchical basis; zero beyond the face's nodes.
pub(super) fn node_positions(
    body: &Deformed<'_>,
    points: &FacePoints<'_>,
    face: &ContactFace,
) -> [[f64; 3]; 6] {
    let c = body.space.components;
    let mut values = [[0.0; 3]; 6];
    for (shape, (&node, value)) in face.nodes.iter().zip(&mut values).enumerate() {
        if let Some(&corner) = face.corners.get(shape) {
            *value = body.mesh.coordinates()[corner as usize].map(|x| body.scale * x);
        }
        for (i, x) in value.iter_mut().enumerate().take(c) {
            *x += body.displacement[node as usize * c + i];
        }
    }
    if let Some(standing) = &points.standing {
        let edges = values.iter_mut().skip(face.corners.len());
        for (value, offset) in edges.zip(standing.offsets) {
            *value = add(*value, offset);
        }
    }
    values
}

/// Area of the deformed face were it everywhere as at a point, given the value and
/// the slopes there of the function of each node.
fn area_element<'a>(
    face: &ContactFace,
    nodes: &[[f64; 3]],
    functions: impl Iterator<Item = (&'a f64, &'a [f64; 2])>,
) -> f64 {
    let mut along = [[0.0; 3]; 2];
    let mut radius = 0.0;
    for (position, (value, slopes)) in nodes.iter().zip(functions) {
        radius += value * position[0];
        for (tangent, &slope) in along.iter_mut().zip(slopes) {
            *tangent = add(*tangent, scale(slope, *position));
        }
    }
    match (face.corners.len(), face.radii) {
        (2, None) => norm(along[0]),
        (2, Some(_)) => norm(along[0]) * TAU * radius,
        _ => 0.5 * norm(cross(along[0], along[1])),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::basis::Bernstein;
    use crate::element::quadrature::{Simplex, rule};
    use crate::mesh::{GroupKind, samples};
    use crate::space::TaylorHood;

    #[test]
    fn a_stretched_face_has_its_stretched_area_and_less_pressure() {
        let mesh = samples::cube(2);
        let space = TaylorHood::new(&mesh);
        let group = mesh.group("z1", GroupKind::Facets).expect("a side");
        let facets = group.members.iter();
        let facets: Vec<Vec<u32>> = facets.map(|&f| mesh.facet(f as usize).to_vec()).collect();
        let surface = ContactSurface::new(&mesh, &space, 1.0, &facets);
        let mut displacement = vec![0.0; space.displacement_unknowns()];
        for (u, x) in displacement.chunks_exact_mut(3).zip(mesh.coordinates()) {
            (u[0], u[1], u[2]) = (0.5 * x[0] + 0.25 * x[1], 0.2 * x[1], 0.3 * x[0]);
        }
        let body = Deformed {
            mesh: &mesh,
            scale: 1.0,
            space: &space,
            displacement: &displacement,
            rule: &rule(Simplex::Triangle, 2),
        };
        // (1.5, 0, 0.3) x (0.25, 1.2, 0)
        let area = norm(cross([1.5, 0.0, 0.3], [0.25, 1.2, 0.0]));
        let pairs = surface.weights.iter().zip(surface.deformed_weights(&body));
        for (undeformed, deformed) in pairs {
            assert!((deformed - area * undeformed).abs() < 1e-15);
        }
        for surface in [surface.clone(), surface.with_basis(&Bernstein)] {
            let ones = vec![1.0; surface.multipliers()];
            for pressure in surface.deformed_pressure(&body, &ones) {
                assert!((pressure * area - 1.0).abs() < 1e-13);
            }
        }
    }

    #[test]
    fn a_face_bent_by_its_middle_node_has_the_length_of_a_parabola() {
        let mesh = samples::rectangle(1, 1);
        let space = TaylorHood::new(&mesh);
        let group = mesh.group("y1", GroupKind::Facets).expect("a side");
        let facet = mesh.facet(group.members[0] as usize).to_vec();
        let nodes = space.facet_nodes(&facet);
        let surface = ContactSurface::new(&mesh, &space, 1.0, &[facet]);
        let mut displacement = vec![0.0; space.displacement_unknowns()];
        displacement[nodes[2] as usize * 2 + 1] = 0.25;
        let body = Deformed {
            mesh: &mesh,
            scale: 1.0,
            space: &space,
            displacement: &displacement,
            rule: &rule(Simplex::Segment, 20),
        };
        // y = x (1 - x): int sqrt(1 + (1 - 2 x)^2) dx over 0 .. 1.
        let length = 0.5 * (2.0_f64.sqrt() + 1.0_f64.asinh());
        let found: f64 = surface.deformed_weights(&body).iter().sum();
        assert!((found - length).abs() < 1e-9, "{found} {length}");
    }
}
