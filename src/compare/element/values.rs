//! Values at points, error norms and fields of a comparison element.

use rayon::prelude::*;

use crate::assembly::load::position;
use crate::compare::element::body::EnrichedBody;
use crate::compare::space::enriched::{Enrichment, Function};
use crate::element::manufactured::Manufactured;
use crate::element::quadrature::{Rule, rule};
use crate::geometry::Matrix3;
use crate::linalg::vector::ratio;
use crate::model::loads::{MANUFACTURED_DEGREE, simplices};
use crate::model::state::State;
use crate::report::{FieldData, FieldName, ManufacturedErrors};
use crate::results::errors::energy;

impl EnrichedBody {
    /// Displacement at barycentric coordinates of a cell, non-dimensional.
    pub(crate) fn displacement_at(&self, state: &State, cell: usize, l: &[f64]) -> [f64; 3] {
        let functions = self.data.space.functions(&self.mesh, cell);
        self.displacement_of(&functions, state, l)
    }

    /// Displacement of the given functions of a cell.
    fn displacement_of(&self, functions: &[Function], state: &State, l: &[f64]) -> [f64; 3] {
        let shapes = &self.data.space.shapes;
        let mut value = [0.0; 3];
        for function in functions {
            let unknown = state.displacement[function.unknown as usize];
            let factor = unknown * shapes[function.shape].value(l);
            (0..3).for_each(|i| value[i] += factor * function.direction[i]);
        }
        value
    }

    /// Displacement gradient du_i/dx_j at barycentric coordinates of a cell.
    fn gradient_at(&self, state: &State, cell: usize, l: &[f64]) -> Matrix3 {
        let functions = self.data.space.functions(&self.mesh, cell);
        let g = self.data.geometry.gradients_of(cell);
        self.gradient_of(&functions, g, state, l)
    }

    /// Displacement gradient of the given functions of a cell.
    fn gradient_of(
        &self,
        functions: &[Function],
        g: &[[f64; 3]],
        state: &State,
        l: &[f64],
    ) -> Matrix3 {
        let shapes = self.data.space.shapes.iter();
        let slopes: Vec<[f64; 3]> = shapes.map(|shape| shape.gradient(l, g)).collect();
        let mut gradient = [[0.0; 3]; 3];
        for function in functions {
            let value = state.displacement[function.unknown as usize];
            let slope = &slopes[function.shape];
            for i in 0..3 {
                for j in 0..3 {
                    gradient[i][j] += value * function.direction[i] * slope[j];
                }
            }
        }
        gradient
    }

    /// Pressure at barycentric coordinates of a cell, non-dimensional.
    pub(crate) fn pressure_at(&self, state: &State, cell: usize, l: &[f64]) -> f64 {
        let pressures = self.data.space.pressures(&self.mesh, cell);
        pressures.at(l, &state.pressure)
    }

    /// Error norms against a manufactured field.
    pub(crate) fn errors(&self, state: &State, field: &Manufactured) -> ManufacturedErrors {
        let degree = self.plan.settings.quadrature_degree;
        let (simplex, _) = simplices(self.plan.units.dimension);
        let rule = rule(simplex, degree.unwrap_or(MANUFACTURED_DEGREE));
        let cells: Vec<[f64; 5]> = (0..self.data.space.cells)
            .into_par_iter()
            .map(|cell| self.cell_squares(state, field, &rule, cell))
            .collect();
        let sum = |k: usize| cells.iter().map(|squares| squares[k]).sum::<f64>().sqrt();
        ManufacturedErrors {
            displacement_l2: sum(0),
            displacement_h1: sum(1),
            pressure_l2: Some(sum(2)),
            relative_energy: ratio(sum(3), sum(4)),
        }
    }

    /// Squares of the errors in u, grad u, p and energy and of the energy itself,
    /// over one cell, caller's units.
    fn cell_squares(
        &self,
        state: &State,
        field: &Manufactured,
        rule: &Rule,
        cell: usize,
    ) -> [f64; 5] {
        let units = &self.plan.units;
        let scale = units.coordinate_scale * units.length;
        let corners = self.mesh.cell(cell);
        let load = state.drive.load;
        let functions = self.data.space.functions(&self.mesh, cell);
        let g = self.data.geometry.gradients_of(cell);
        let material = usize::from(self.plan.resolved.cell_material[cell]);
        let shear = self.plan.resolved.materials[material].law.shear_modulus;
        let mut squares = [0.0; 5];
        for (point, weight) in rule.points.iter().zip(&rule.weights) {
            let l = &point[..corners.len()];
            let x = position(&self.mesh, scale, corners, l);
            let weight = weight * self.data.geometry.volumes[cell] * units.volume();
            let u = self.displacement_of(&functions, state, l);
            let gradient = self.gradient_of(&functions, g, state, l);
            let (exact, slope) = (field.displacement(x), field.gradient(x));
            for i in 0..units.dimension {
                squares[0] += weight * (u[i] * units.length - load * exact[i]).powi(2);
                for j in 0..units.dimension {
                    squares[1] += weight * (gradient[i][j] - load * slope[i][j]).powi(2);
                }
            }
            let exact = slope.map(|row| row.map(|slope| load * slope));
            let error: Matrix3 =
                std::array::from_fn(|i| std::array::from_fn(|j| gradient[i][j] - exact[i][j]));
            // Mixed forms: the volume is the constraint's, as in the estimate.
            squares[3] += weight * energy(&error, shear, 0.0);
            squares[4] += weight * energy(&exact, shear, 0.0);
            let p = self.pressure_at(state, cell, l) * units.stress;
            squares[2] += weight * (p - load * field.pressure(x)).powi(2);
        }
        squares
    }

    /// The field `name`; none if the scene has no such field.
    pub(crate) fn field_of(&self, state: &State, name: FieldName) -> Option<FieldData> {
        let (components, values) = match name {
            FieldName::Displacement => (3, self.nodal_displacement(state)),
            FieldName::Pressure => (1, self.vertex_pressure(state)),
            FieldName::Stress => (
                6,
                self.per_cell(|cell, l| self.stress(state, cell, l).to_vec()),
            ),
            FieldName::Jacobian => {
                let volume = |cell: usize, l: &[f64]| {
                    let g = self.gradient_at(state, cell, l);
                    vec![1.0 + g[0][0] + g[1][1] + g[2][2]]
                };
                (1, self.per_cell(volume))
            }
            // The recovery knows the shape functions of Taylor-Hood only.
            FieldName::ErrorEstimate => return None,
            FieldName::ContactPressureDeformed
            | FieldName::ContactPressureUndeformed
            | FieldName::FrictionTraction
            | FieldName::Slip
            | FieldName::LowestMode
            | FieldName::NodalForce => return None,
            FieldName::ContactPressure | FieldName::Gap | FieldName::ContactState => {
                (1, self.contact_field(state, name)?)
            }
        };
        Some(FieldData {
            name,
            components,
            values,
        })
    }

    /// Values at the centre of each cell.
    fn per_cell(&self, values: impl Fn(usize, &[f64]) -> Vec<f64>) -> Vec<f64> {
        let corners = self.data.space.components + 1;
        let centre = vec![1.0 / corners as f64; corners];
        let cells = 0..self.data.space.cells;
        cells.flat_map(|cell| values(cell, &centre)).collect()
    }

    /// On uploaded vertices, then at midpoints of edges.
    fn nodal_displacement(&self, state: &State) -> Vec<f64> {
        let c = self.data.space.components;
        let (uploaded, edges) = (self.mesh.vertex_count(), self.mesh.edges());
        let mut out = vec![0.0; 3 * (uploaded + edges.len())];
        let mut put = |row: usize, value: [f64; 3]| {
            let value = value.map(|x| x * self.plan.units.length);
            out[3 * row..3 * row + 3].copy_from_slice(&value);
        };
        let vertex = |v: usize| -> [f64; 3] {
            std::array::from_fn(|i| {
                if i < c {
                    state.displacement[v * c + i]
                } else {
                    0.0
                }
            })
        };
        for (used, &row) in self.mesh.used_vertices().iter().enumerate() {
            put(row as usize, vertex(used));
        }
        for (edge, &[a, b]) in edges.iter().enumerate() {
            let (a, b) = (vertex(a as usize), vertex(b as usize));
            let bubble = self.edge_bubble(state, edges[edge]);
            let middle = |i: usize| 0.5 * (a[i] + b[i]) + bubble[i];
            put(uploaded + edge, std::array::from_fn(middle));
        }
        out
    }

    /// What bubbles add at the midpoint of an edge: nothing but where edges are facets.
    fn edge_bubble(&self, state: &State, edge: [u32; 2]) -> [f64; 3] {
        let space = &self.data.space;
        match (space.enrichment, space.components) {
            (Enrichment::FacetBubbles, 2) => {
                let facet = space.facet(&edge);
                let value = state.displacement[space.facet_unknown(facet)];
                space.normal(facet).map(|n| n * value)
            }
            (Enrichment::FacetBubbles | Enrichment::CellBubbles, _) => [0.0; 3],
        }
    }

    /// Vertex values; constant pressures are averaged by volume.
    fn vertex_pressure(&self, state: &State) -> Vec<f64> {
        let corners = self.data.space.components + 1;
        let mut sums = vec![[0.0; 2]; self.data.space.vertices];
        for cell in 0..self.data.space.cells {
            let volume = self.data.geometry.volumes[cell];
            for (local, &vertex) in self.mesh.cell(cell).iter().enumerate() {
                let mut l = vec![0.0; corners];
                l[local] = 1.0;
                let [sum, weight] = &mut sums[vertex as usize];
                *sum += volume * self.pressure_at(state, cell, &l);
                *weight += volume;
            }
        }
        let mut out = vec![0.0; self.mesh.vertex_count()];
        for (&uploaded, [sum, weight]) in self.mesh.used_vertices().iter().zip(sums) {
            out[uploaded as usize] = sum / weight * self.plan.units.stress;
        }
        out
    }

    /// Stress at a point of a cell: xx yy zz xy yz zx.
    fn stress(&self, state: &State, cell: usize, l: &[f64]) -> [f64; 6] {
        let index = usize::from(self.plan.resolved.cell_material[cell]);
        let law = self.plan.resolved.materials[index].law;
        let pressure = self.pressure_at(state, cell, l) * self.plan.units.stress;
        let s = law.stress(&self.gradient_at(state, cell, l), pressure);
        [s[0][0], s[1][1], s[2][2], s[0][1], s[1][2], s[2][0]]
    }
}
