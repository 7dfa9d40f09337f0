//! The discrete body: loads and prescribed values of a comparison element.

use std::sync::Arc;

use crate::assembly::load::{facet_measure, position};
use crate::compare::element::prepared::ComparisonData;
use crate::compare::space::enriched::{Enrichment, Shape};
use crate::element::manufactured::Manufactured;
use crate::element::quadrature::{Rule, rule};
use crate::mesh::Mesh;
use crate::model::drive::Drive;
use crate::model::interfaces::Interfaces;
use crate::model::loads::{MANUFACTURED_DEGREE, simplices};
use crate::model::prescribed::prescribed_value;
use crate::plan::Plan;

/// Constant loads times bubbles of up to four factors.
const CONSTANT_DEGREE: u32 = 4;
/// Prescribed values times a facet bubble.
const VALUE_DEGREE: u32 = 8;

/// A scene on a comparison element.
#[derive(Debug)]
pub(crate) struct EnrichedBody {
    /// Decisions, resolved names and units of the scene.
    pub(crate) plan: Arc<Plan>,
    /// The checked mesh of the plan, undeformed, in the caller's lengths.
    pub(crate) mesh: Arc<Mesh>,
    /// Assembled matrices and the preconditioners made from them, shared by all
    /// sessions.
    pub(crate) data: Arc<ComparisonData>,
    /// Candidate surfaces with the obstacles that they may touch.
    pub(crate) interfaces: Interfaces,
    /// Dead load at load factor one, non-dimensional `[displacement unknowns]`.
    pub(crate) load: Vec<f64>,
}

impl EnrichedBody {
    /// The body of `plan` with its surfaces and loads.
    pub(crate) fn new(plan: Arc<Plan>, mesh: Arc<Mesh>, data: Arc<ComparisonData>) -> Self {
        let mut body = Self {
            interfaces: Interfaces::new(&plan, &mesh, &data.trace),
            load: Vec::new(),
            plan,
            mesh,
            data,
        };
        body.load = body.reference_load();
        body
    }

    /// All loads at factor one, non-dimensional.
    fn reference_load(&self) -> Vec<f64> {
        let mut load = vec![0.0; self.data.space.displacement_unknowns()];
        match &self.plan.resolved.manufactured {
            Some(field) => self.add_manufactured(field, &mut load),
            None => self.add_constant(&mut load),
        }
        load
    }

    /// Adds constant tractions and body forces, integrated exactly, to the load
    /// `[unknowns]`, non-dimensional.
    fn add_constant(&self, load: &mut [f64]) {
        let units = &self.plan.units;
        let (cell, facet) = simplices(units.dimension);
        let surface_rule = rule(facet, CONSTANT_DEGREE);
        for traction in &self.plan.resolved.tractions {
            let value = traction.value.map(|t| t / units.stress);
            for &index in &traction.facets {
                let vertices = self.mesh.facet(index as usize);
                self.add_traction(vertices, &surface_rule, &|_, _| value, load);
            }
        }
        if self.plan.resolved.has_body_force() {
            let value = self
                .plan
                .resolved
                .body_force
                .map(|f| f / units.body_force());
            self.add_body_force(&rule(cell, CONSTANT_DEGREE), &|_, _| value, load);
        }
    }

    /// Adds body force and boundary tractions of an analytic field to the load
    /// `[unknowns]`, by the rule that the scene asks for.
    fn add_manufactured(&self, field: &Manufactured, load: &mut [f64]) {
        let units = self.plan.units;
        let (cell, facet) = simplices(units.dimension);
        let degree = self.plan.settings.quadrature_degree;
        let degree = degree.unwrap_or(MANUFACTURED_DEGREE);
        let shear = |cell: usize| {
            let index = usize::from(self.plan.resolved.cell_material[cell]);
            self.plan.resolved.materials[index].law.shear_modulus
        };
        let force = |cell: usize, x: [f64; 3]| {
            let force = field.body_force(x.map(|x| x * units.length), shear(cell));
            force.map(|f| f / units.body_force())
        };
        self.add_body_force(&rule(cell, degree), &force, load);
        let surface_rule = rule(facet, degree);
        for boundary in self.mesh.boundary_facets() {
            let traction = |x: [f64; 3], normal: [f64; 3]| {
                let x = x.map(|x| x * units.length);
                let traction = field.traction(x, normal, shear(boundary.cell as usize));
                traction.map(|t| t / units.stress)
            };
            // Held entries of the load belong to reactions and are never read.
            let vertices = &boundary.vertices[..units.dimension];
            self.add_traction(vertices, &surface_rule, &traction, load);
        }
    }

    /// Adds int f . phi dx over all cells; `force` is asked by cell and position, both
    /// non-dimensional.
    fn add_body_force(
        &self,
        rule: &Rule,
        force: &dyn Fn(usize, [f64; 3]) -> [f64; 3],
        load: &mut [f64],
    ) {
        let space = &self.data.space;
        let scale = self.plan.units.coordinate_scale;
        for cell in 0..space.cells {
            let corners = self.mesh.cell(cell);
            let functions = space.functions(&self.mesh, cell);
            for (point, weight) in rule.points.iter().zip(&rule.weights) {
                let l = &point[..corners.len()];
                let density = force(cell, position(&self.mesh, scale, corners, l));
                let weight = weight * self.data.geometry.volumes[cell];
                let values: Vec<f64> = space.shapes.iter().map(|shape| shape.value(l)).collect();
                for function in &functions {
                    let along = inner(&density, &function.direction);
                    load[function.unknown as usize] += weight * values[function.shape] * along;
                }
            }
        }
    }

    /// Adds int t . phi dS over one facet; `traction` is asked by position and outward
    /// normal, non-dimensional.
    fn add_traction(
        &self,
        vertices: &[u32],
        rule: &Rule,
        traction: &dyn Fn([f64; 3], [f64; 3]) -> [f64; 3],
        load: &mut [f64],
    ) {
        let space = &self.data.space;
        let scale = self.plan.units.coordinate_scale;
        let (area, normal) = facet_measure(&self.mesh, vertices, scale);
        let bubble = self.facet_bubble();
        for (point, weight) in rule.points.iter().zip(&rule.weights) {
            let l = &point[..vertices.len()];
            let value = traction(position(&self.mesh, scale, vertices, l), normal);
            for (&vertex, l) in vertices.iter().zip(l) {
                for i in 0..space.components {
                    load[vertex as usize * space.components + i] += weight * area * l * value[i];
                }
            }
            if let Some(bubble) = &bubble {
                let facet = space.facet(vertices);
                let along = inner(&value, &space.normal(facet));
                load[space.facet_unknown(facet)] += weight * area * bubble.value(l) * along;
            }
        }
    }

    /// The bubble of a facet on that facet; none for elements without.
    fn facet_bubble(&self) -> Option<Shape> {
        let count = self.data.space.components;
        match self.data.space.enrichment {
            Enrichment::CellBubbles => None,
            Enrichment::FacetBubbles => Some(Shape::bubble((0..count).collect())),
        }
    }

    /// Sets held vertices to their values, and bubbles of held facets so that the
    /// flux through each is that of the values.
    pub(crate) fn prescribe(&self, drive: &Drive, displacement: &mut [f64]) {
        let space = &self.data.space;
        let c = space.components;
        let on_vertices = self.plan.held.iter();
        for &(unknown, support) in
            on_vertices.filter(|held| (held.0 as usize) < space.p1_unknowns())
        {
            let (vertex, i) = (unknown as usize / c, unknown as usize % c);
            let at = || self.mesh.coordinates()[vertex];
            displacement[unknown as usize] =
                prescribed_value(&self.plan, drive, (usize::from(support), i), &at);
        }
        let (Some(bubble), (_, facet)) = (self.facet_bubble(), simplices(c)) else {
            return;
        };
        let rule = rule(facet, VALUE_DEGREE);
        for held in &self.data.held_facets {
            let normal = space.normal(held.facet);
            let (mut flux, mut own) = (0.0, 0.0);
            for (point, weight) in rule.points.iter().zip(&rule.weights) {
                let l = &point[..c];
                own += weight * bubble.value(l);
                let at = || position(&self.mesh, 1.0, &held.vertices, l);
                let held_along = held.supports.iter().enumerate().take(c);
                for (i, support) in held_along.filter_map(|(i, s)| Some((i, (*s)?))) {
                    let value = prescribed_value(&self.plan, drive, (usize::from(support), i), &at);
                    let on_vertices = held.vertices.iter().zip(l);
                    let linear: f64 = on_vertices
                        .map(|(&v, l)| l * displacement[v as usize * c + i])
                        .sum();
                    flux += weight * normal[i] * (value - linear);
                }
            }
            displacement[space.facet_unknown(held.facet)] = flux / own;
        }
    }
}

/// The scalar product of two vectors `[3]`.
fn inner(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
