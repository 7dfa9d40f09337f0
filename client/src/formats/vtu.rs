//! Writes a body and its fields as VTU with quadratic cells.
//!
//! Points are the P2 nodes: the vertices, then the midpoint of every unique
//! edge of the cells as (low, high) vertex pairs in lexicographic order, the
//! order in which the service sends displacement; edges of a second-order mesh may have
//! their midpoint off the line. Fields of the vertices only
//! are linear: their midpoint values are the means of the two ends (of the
//! contact state: the smaller). Cells are `VTK_QUADRATIC_TRIANGLE` or
//! `VTK_QUADRATIC_TETRA`; points stay undeformed (ParaView's Warp By Vector shows
//! the deformed body).
//!
//! Cost: the edges are sorted once a mesh; a file is one copy of its arrays.

use super::vtk_xml::{Notes, Writer};

const VTK_QUADRATIC_TRIANGLE: u8 = 22;
const VTK_QUADRATIC_TETRA: u8 = 24;

/// Fields that have one row a cell.
const CELL_FIELDS: [&str; 7] = [
    "error_density",
    "error_estimate",
    "jacobian",
    "principal_stresses",
    "principal_stretches",
    "stress",
    "von_mises",
];

/// Edges of a cell by local vertices, in VTK's order.
const TRIANGLE_EDGES: &[(usize, usize)] = &[(0, 1), (1, 2), (0, 2)];
const TETRAHEDRON_EDGES: &[(usize, usize)] = &[(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)];

/// A mesh with its P2 nodes.
#[derive(Clone, Debug)]
pub struct Grid {
    points: Vec<f64>,
    vertex_count: usize,
    edges: Vec<(u32, u32)>,
    connectivity: Vec<i64>,
    nodes_per_cell: usize,
}

/// A field on the P2 nodes, the vertices or the cells: which follows from the
/// number of values.
#[derive(Clone, Copy, Debug)]
pub struct GridField<'a> {
    /// Name of the array.
    pub name: &'a str,
    /// Values per row.
    pub components: usize,
    /// Flat, `[rows, components]`.
    pub values: &'a [f64],
}

/// Why a grid or field cannot be written.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum GridError {
    /// Cells that are neither triangles nor tetrahedra.
    #[error("cells of {0} vertices: 3 or 4 are expected")]
    CellKind(usize),
    /// A cell refers to a vertex that does not exist.
    #[error("a cell refers to vertex {vertex} of {count}")]
    Vertex {
        /// Index found.
        vertex: u32,
        /// Vertices of the mesh.
        count: usize,
    },
    /// A field that fits neither nodes nor vertices nor cells.
    #[error("field {name} has {rows} rows, which fits neither nodes, vertices nor cells")]
    Rows {
        /// Field.
        name: String,
        /// Rows found.
        rows: usize,
    },
}

impl Grid {
    /// The P2 nodes and quadratic cells of a mesh.
    ///
    /// # Errors
    /// [`GridError::CellKind`], [`GridError::Vertex`].
    pub fn new(
        vertices_per_cell: usize,
        coordinates: &[[f64; 3]],
        cells: &[u32],
    ) -> Result<Self, GridError> {
        let local = local_edges(vertices_per_cell)?;
        let count = coordinates.len();
        if let Some(&vertex) = cells.iter().find(|vertex| **vertex as usize >= count) {
            return Err(GridError::Vertex { vertex, count });
        }
        let edges = unique_edges(vertices_per_cell, cells);
        let mut grid = Self {
            points: coordinates.iter().flatten().copied().collect(),
            vertex_count: count,
            connectivity: Vec::new(),
            nodes_per_cell: vertices_per_cell + local.len(),
            edges,
        };
        grid.points = grid.on_nodes(3, &grid.points, mean);
        grid.connect(vertices_per_cell, local, cells);
        Ok(grid)
    }

    /// Moves the middles of edges by their offsets, given with their vertices, the lower
    /// one first; unknown edges are left out.
    pub fn bend(&mut self, offsets: impl Iterator<Item = ([u32; 2], [f64; 3])>) {
        for ([low, high], offset) in offsets {
            let Ok(edge) = self.edges.binary_search(&(low, high)) else {
                continue;
            };
            let first = 3 * (self.vertex_count + edge);
            let place = self.points.iter_mut().skip(first);
            place.zip(offset).for_each(|(x, by)| *x += by);
        }
    }

    /// P2 nodes.
    pub fn node_count(&self) -> usize {
        self.vertex_count + self.edges.len()
    }

    /// The node in the middle of an edge between two vertices; none where no cell has it.
    pub fn edge_node(&self, a: u32, b: u32) -> Option<usize> {
        let edge = self.edges.binary_search(&(a.min(b), a.max(b))).ok()?;
        Some(self.vertex_count + edge)
    }

    /// Vertices.
    pub fn vertex_count(&self) -> usize {
        self.vertex_count
    }

    /// Cells.
    pub fn cell_count(&self) -> usize {
        self.connectivity.len() / self.nodes_per_cell
    }

    /// Coordinates of the P2 nodes, flat `[nodes, 3]`.
    pub fn points(&self) -> &[f64] {
        &self.points
    }

    /// Nodes of the cells, in VTK's order, as many a row as [`Grid::nodes_per_cell`].
    pub(super) fn connectivity(&self) -> &[i64] {
        &self.connectivity
    }

    /// 6 for triangles, 10 for tetrahedra.
    pub(super) fn nodes_per_cell(&self) -> usize {
        self.nodes_per_cell
    }

    fn connect(&mut self, vertices_per_cell: usize, local: &[(usize, usize)], cells: &[u32]) {
        self.connectivity
            .reserve(cells.len() / vertices_per_cell * self.nodes_per_cell);
        for cell in cells.chunks_exact(vertices_per_cell) {
            self.connectivity
                .extend(cell.iter().map(|vertex| i64::from(*vertex)));
            for &(a, b) in local {
                let Some(edge) = edge_of(cell, a, b) else {
                    continue;
                };
                let index = self.edges.binary_search(&edge).unwrap_or_default();
                self.connectivity.push((self.vertex_count + index) as i64);
            }
        }
    }

    /// Vertex values continued to the nodes, each edge by what `middle` makes of
    /// its two ends.
    fn on_nodes(
        &self,
        components: usize,
        values: &[f64],
        middle: impl Fn(f64, f64) -> f64,
    ) -> Vec<f64> {
        let mut nodes = values.to_vec();
        nodes.reserve(self.edges.len() * components);
        for &(low, high) in &self.edges {
            let row = |vertex: u32| values.iter().skip(vertex as usize * components);
            let ends = row(low).zip(row(high)).take(components);
            nodes.extend(ends.map(|(a, b)| middle(*a, *b)));
        }
        nodes
    }

    /// The bytes of a VTU file with these fields.
    ///
    /// # Errors
    /// [`GridError::Rows`].
    pub fn write(&self, fields: &[GridField<'_>], notes: &Notes) -> Result<Vec<u8>, GridError> {
        let mut file = Writer::new("UnstructuredGrid");
        file.line("<UnstructuredGrid>");
        file.notes(notes);
        let (points, cells) = (self.node_count(), self.cell_count());
        file.line(&format!(
            "<Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\">"
        ));
        file.line("<Points>");
        file.array("Points", 3, &self.points);
        file.line("</Points>");
        self.write_cells(&mut file);
        self.write_fields(&mut file, fields)?;
        file.line("</Piece>");
        Ok(file.finish("UnstructuredGrid"))
    }

    fn write_cells(&self, file: &mut Writer) {
        let per_cell = self.nodes_per_cell as i64;
        let ends: Vec<i64> = (1..=self.cell_count() as i64)
            .map(|cell| cell * per_cell)
            .collect();
        let kind = match self.nodes_per_cell {
            6 => VTK_QUADRATIC_TRIANGLE,
            _ => VTK_QUADRATIC_TETRA,
        };
        file.line("<Cells>");
        file.array("connectivity", 1, &self.connectivity);
        file.array("offsets", 1, &ends);
        file.array("types", 1, &vec![kind; self.cell_count()]);
        file.line("</Cells>");
    }

    fn write_fields(&self, file: &mut Writer, fields: &[GridField<'_>]) -> Result<(), GridError> {
        let (on_cells, on_points) = fields
            .iter()
            .partition::<Vec<&GridField<'_>>, _>(|field| self.is_cell_field(field));
        file.line("<PointData>");
        for field in on_points {
            match field.values.len() / field.components.max(1) {
                rows if rows == self.node_count() => write_field(file, field, field.values),
                rows if rows == self.vertex_count => {
                    let values = self.on_nodes(field.components, field.values, middle(field.name));
                    write_field(file, field, &values);
                }
                rows => {
                    let name = field.name.to_owned();
                    return Err(GridError::Rows { name, rows });
                }
            }
        }
        file.line("</PointData>");
        file.line("<CellData>");
        for field in on_cells {
            write_field(file, field, field.values);
        }
        file.line("</CellData>");
        Ok(())
    }

    /// A field is taken as one of cells only when it fits nothing else, or when
    /// it is one that the service sends by cells.
    fn is_cell_field(&self, field: &GridField<'_>) -> bool {
        let rows = field.values.len() / field.components.max(1);
        let by_name = CELL_FIELDS.contains(&field.name);
        let elsewhere = rows == self.node_count() || rows == self.vertex_count;
        rows == self.cell_count() && (by_name || !elsewhere)
    }
}

fn write_field(file: &mut Writer, field: &GridField<'_>, values: &[f64]) {
    let columns: &[&str] = match (field.name, field.components) {
        (name, 3) if name.starts_with("principal_") => &["largest", "middle", "smallest"],
        (_, 3) => &["x", "y", "z"],
        (_, 6) => &["xx", "yy", "zz", "xy", "yz", "zx"],
        (name, components) => return file.array(name, components, values),
    };
    file.named_array(field.name, columns, values);
}

fn mean(a: f64, b: f64) -> f64 {
    0.5 * (a + b)
}

/// A linear field is its mean in the middle of an edge; of states, which know no
/// mean, the smaller one holds for the whole edge.
fn middle(field: &str) -> fn(f64, f64) -> f64 {
    match field {
        "contact_state" => f64::min,
        _ => mean,
    }
}

fn local_edges(vertices_per_cell: usize) -> Result<&'static [(usize, usize)], GridError> {
    match vertices_per_cell {
        3 => Ok(TRIANGLE_EDGES),
        4 => Ok(TETRAHEDRON_EDGES),
        other => Err(GridError::CellKind(other)),
    }
}

fn edge_of(cell: &[u32], a: usize, b: usize) -> Option<(u32, u32)> {
    let (a, b) = (*cell.get(a)?, *cell.get(b)?);
    Some((a.min(b), a.max(b)))
}

/// The unique edges of all cells as (low, high) vertex pairs in lexicographic
/// order: the order of the P2 nodes after the vertices.
pub fn unique_edges(vertices_per_cell: usize, cells: &[u32]) -> Vec<(u32, u32)> {
    let local = local_edges(vertices_per_cell).unwrap_or_default();
    let mut edges: Vec<(u32, u32)> = cells
        .chunks_exact(vertices_per_cell.max(1))
        .flat_map(|cell| local.iter().filter_map(|&(a, b)| edge_of(cell, a, b)))
        .collect();
    edges.sort_unstable();
    edges.dedup();
    edges
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [[f64; 3]; 4] = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
    ];

    #[test]
    fn edges_are_unique_and_lexicographic() {
        let edges = unique_edges(3, &[2, 1, 0, 1, 2, 3]);
        assert_eq!(edges, [(0, 1), (0, 2), (1, 2), (1, 3), (2, 3)]);
    }

    #[test]
    fn tetrahedron_lists_its_edge_nodes_in_vtk_order() {
        let grid = Grid::new(4, &CORNERS, &[0, 1, 2, 3]).unwrap();
        // Sorted edges: 01 02 03 12 13 23 have nodes 4 to 9.
        assert_eq!(grid.connectivity, [0, 1, 2, 3, 4, 7, 5, 6, 8, 9]);
        assert_eq!(&grid.points()[7 * 3..8 * 3], [0.5, 0.5, 0.0]);
    }

    #[test]
    fn middles_of_curved_edges_are_where_the_mesh_has_them() {
        let mut grid = Grid::new(4, &CORNERS, &[0, 1, 2, 3]).unwrap();
        let unknown = ([3, 9], [9.0; 3]);
        grid.bend([([1, 2], [0.25, 0.25, 0.0]), unknown].into_iter());
        assert_eq!(&grid.points()[7 * 3..8 * 3], [0.75, 0.75, 0.0]);
        assert_eq!(&grid.points()[4 * 3..5 * 3], [0.5, 0.0, 0.0]);
    }

    #[test]
    fn vertex_fields_are_linear_on_edges() {
        let grid = Grid::new(4, &CORNERS, &[0, 1, 2, 3]).unwrap();
        let nodes = grid.on_nodes(1, &[0.0, 1.0, 2.0, 4.0], mean);
        assert_eq!(nodes, [0.0, 1.0, 2.0, 4.0, 0.5, 1.0, 2.0, 1.5, 2.5, 3.0]);
    }

    #[test]
    fn an_edge_is_in_contact_when_both_its_ends_are() {
        let grid = Grid::new(3, &CORNERS[..3], &[0, 1, 2]).unwrap();
        let states = grid.on_nodes(1, &[1.0, 1.0, -1.0], middle("contact_state"));
        assert_eq!(states, [1.0, 1.0, -1.0, 1.0, -1.0, -1.0]);
    }

    #[test]
    fn fields_of_a_wrong_length_are_refused() {
        let grid = Grid::new(4, &CORNERS, &[0, 1, 2, 3]).unwrap();
        let field = GridField {
            name: "gap",
            components: 1,
            values: &[0.0; 7],
        };
        let error = grid.write(&[field], &Notes::default()).unwrap_err();
        assert_eq!(
            error,
            GridError::Rows {
                name: "gap".into(),
                rows: 7
            }
        );
    }

    #[test]
    fn cells_with_unknown_vertices_are_refused() {
        let error = Grid::new(4, &CORNERS, &[0, 1, 2, 9]).unwrap_err();
        assert_eq!(
            error,
            GridError::Vertex {
                vertex: 9,
                count: 4
            }
        );
        assert_eq!(
            Grid::new(5, &CORNERS, &[]).unwrap_err(),
            GridError::CellKind(5)
        );
    }

    #[test]
    fn columns_time_and_texts_have_names() {
        let grid = Grid::new(3, &CORNERS[..3], &[0, 1, 2]).unwrap();
        let field = |name, components, values| GridField {
            name,
            components,
            values,
        };
        let fields = [
            field("displacement", 3, &[0.0; 18][..]),
            field("stress", 6, &[0.0; 6]),
            field("principal_stresses", 3, &[0.0; 3]),
        ];
        let notes = Notes {
            time: Some(1.5),
            texts: vec![("scene".to_owned(), "a<b".to_owned())],
            units: [("stress".to_owned(), "N/mm\u{b2} & more".to_owned())].into(),
        };
        let bytes = grid.write(&fields, &notes).unwrap();
        let text = String::from_utf8_lossy(&bytes);
        assert!(text.contains("ComponentName0=\"x\" ComponentName1=\"y\" ComponentName2=\"z\""));
        assert!(text.contains("ComponentName4=\"yz\" ComponentName5=\"zx\""));
        assert!(text.contains("ComponentName0=\"largest\""));
        assert!(text.contains("Name=\"TimeValue\" NumberOfComponents=\"1\" NumberOfTuples=\"1\""));
        assert!(text.contains("<!-- scene: a&lt;b -->"));
        assert_eq!(text.matches("UNITS_LABEL").count(), 1);
        let (_, stress) = text.split_once("Name=\"stress\"").unwrap();
        let (_, key) = stress.split_once("offset=\"").unwrap();
        let (_, key) = key.split_once("\"><InformationKey ").unwrap();
        let unit = "name=\"UNITS_LABEL\" location=\"vtkDataArray\">N/mm\u{b2} &amp; more</InformationKey></DataArray>\n";
        assert!(key.starts_with(unit), "{key}");
    }

    #[test]
    fn appended_arrays_lie_where_the_header_says() {
        let grid = Grid::new(3, &CORNERS[..3], &[0, 1, 2]).unwrap();
        let field = GridField {
            name: "jacobian",
            components: 1,
            values: &[1.5],
        };
        let bytes = grid.write(&[field], &Notes::default()).unwrap();
        let text = String::from_utf8_lossy(&bytes);
        let offset = text.split("Name=\"jacobian\"").nth(1).unwrap();
        let offset: usize = offset
            .split("offset=\"")
            .nth(1)
            .unwrap()
            .split('"')
            .next()
            .unwrap()
            .parse()
            .unwrap();
        let mark = b"<AppendedData encoding=\"raw\">\n_";
        let start = bytes
            .windows(mark.len())
            .position(|window| window == mark)
            .unwrap()
            + mark.len();
        let block = &bytes[start + offset..start + offset + 16];
        assert_eq!(block[..8], 8_u64.to_le_bytes());
        assert_eq!(block[8..], 1.5_f64.to_le_bytes());
    }
}
