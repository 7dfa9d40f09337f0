//! Deformed areas of the contact surface: int psi_i da by the rule of the gap.
//!
//! A contact pressure l per deformed area is l_i int psi_i da / int psi_i dS per
//! undeformed area. Shapes: `[multipliers]`. Cost: some 100 flops a point.

use std::borrow::Cow;

use super::deformed::{Deformed, Measure, Table};
use super::face::ContactFace;
use super::surface::ContactSurface;

impl ContactSurface {
    /// int psi_k dS over the undeformed or da over the deformed surface, as `body` measures
    /// `[functions]`.
    pub(super) fn areas(&self, body: &Deformed<'_>) -> Vec<f64> {
        let table = Table::new(body, self.basis);
        let size = table.points();
        let areas = body.on_faces(&table, &self.faces, size, |points, _, areas| {
            areas.copy_from_slice(&points.weights);
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

    /// The weights of the multipliers over the surface that `body` measures `[multipliers]`.
    pub(super) fn present_weights(&self, body: &Deformed<'_>) -> Cow<'_, [f64]> {
        match body.measure {
            Measure::Undeformed => Cow::Borrowed(&self.weights),
            Measure::Deformed => Cow::Owned(self.shares.gather(self.areas(body))),
        }
    }

    /// Coefficients of the contact pressure per undeformed area `[functions]`, from those
    /// per deformed area `[multipliers]`.
    pub fn undeformed_pressure(&self, body: &Deformed<'_>, pressure: &[f64]) -> Vec<f64> {
        let by = |measure| self.areas(&Deformed { measure, ..*body });
        let deformed = by(Measure::Deformed).into_iter();
        let ratios = deformed
            .zip(by(Measure::Undeformed))
            .map(|(now, rest)| now / rest);
        let pressure = self.shares.spread(pressure);
        pressure.iter().zip(ratios).map(|(p, r)| p * r).collect()
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

    /// The largest value at a node of the pressure with these `coefficients` `[functions]`, as the
    /// sum that it is of them: functions with their weights; empty where no value is above zero.
    pub fn largest_as_sum(&self, coefficients: &[f64]) -> Vec<(u32, f64)> {
        let mut known = (0.0, Vec::new());
        for face in &self.faces {
            let own = face.functions.iter().map(|&k| coefficients[k as usize]);
            let own: Vec<f64> = own.collect();
            let values = self.basis.at_nodes(face.corners.len(), &own);
            for (node, value) in values.into_iter().enumerate() {
                if value > known.0 {
                    known = (value, self.weights_at_node(face, node));
                }
            }
        }
        known.1
    }

    /// Weights of a face's functions in the value at one of its nodes.
    fn weights_at_node(&self, face: &ContactFace, node: usize) -> Vec<(u32, f64)> {
        let unit = |k: usize| {
            let mut own = vec![0.0; face.functions.len()];
            own[k] = 1.0;
            self.basis.at_nodes(face.corners.len(), &own)[node]
        };
        let all = face.functions.iter().enumerate();
        let all = all.map(|(k, &function)| (function, unit(k)));
        all.filter(|(_, weight)| *weight != 0.0).collect()
    }

    /// Largest value at the nodes of all faces, at least zero, of the pressure with
    /// these `coefficients` `[functions]`.
    pub fn largest(&self, coefficients: &[f64]) -> f64 {
        let values = self.at_nodes(coefficients).map(|(_, value)| value);
        values.fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::basis::Bernstein;
    use crate::element::quadrature::{Simplex, rule};
    use crate::geometry::vector3::{cross, norm};
    use crate::mesh::{GroupKind, samples};
    use crate::space::TaylorHood;

    #[test]
    fn a_stretched_face_has_its_stretched_area_and_more_undeformed_pressure() {
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
            measure: Measure::Deformed,
        };
        // (1.5, 0, 0.3) x (0.25, 1.2, 0)
        let area = norm(cross([1.5, 0.0, 0.3], [0.25, 1.2, 0.0]));
        let pairs = surface.weights.iter().zip(surface.areas(&body));
        for (undeformed, deformed) in pairs {
            assert!((deformed - area * undeformed).abs() < 1e-15);
        }
        for surface in [surface.clone(), surface.with_basis(&Bernstein)] {
            let ones = vec![1.0; surface.multipliers()];
            for pressure in surface.undeformed_pressure(&body, &ones) {
                assert!((pressure / area - 1.0).abs() < 1e-13);
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
            measure: Measure::Deformed,
        };
        // y = x (1 - x): int sqrt(1 + (1 - 2 x)^2) dx over 0 .. 1.
        let length = 0.5 * (2.0_f64.sqrt() + 1.0_f64.asinh());
        let found: f64 = surface.areas(&body).iter().sum();
        assert!((found - length).abs() < 1e-9, "{found} {length}");
    }
}
