//! Sites of the recovery: a vertex as one region sees it, with the region's
//! cells around it. A vertex of k regions is k sites.
//!
//! Cost: two passes over the cells; 4 bytes per cell corner.

use crate::mesh::Mesh;

/// All sites, ascending by vertex, then region.
#[derive(Debug)]
pub(super) struct Sites {
    /// First site of each vertex `[vertices + 1]`.
    of_vertex: Vec<u32>,
    /// Vertex of each site.
    vertices: Vec<u32>,
    /// Region of each site.
    regions: Vec<u16>,
    /// First entry in `cells` of each site `[sites + 1]`.
    starts: Vec<u32>,
    cells: Vec<u32>,
    /// Whether a vertex lies on the body's surface.
    on_surface: Vec<bool>,
}

impl Sites {
    pub(super) fn new(mesh: &Mesh, regions: &[u16]) -> Self {
        let (offsets, mut cells) = cells_of_vertices(mesh);
        let mut sites = Self {
            of_vertex: vec![0],
            vertices: Vec::new(),
            regions: Vec::new(),
            starts: Vec::new(),
            cells: Vec::new(),
            on_surface: vec![false; mesh.coordinates().len()],
        };
        for vertex in 0..offsets.len() - 1 {
            let range = offsets[vertex] as usize..offsets[vertex + 1] as usize;
            let around = &mut cells[range.clone()];
            // Ascending cells stay so within a region.
            around.sort_by_key(|&cell| regions[cell as usize]);
            for (index, cell) in range.zip(around.iter()) {
                sites.push(vertex as u32, regions[*cell as usize], index as u32);
            }
            sites.of_vertex.push(sites.vertices.len() as u32);
        }
        sites.starts.push(cells.len() as u32);
        sites.cells = cells;
        for facet in mesh.boundary_facets() {
            for &vertex in &facet.vertices[..mesh.cell_kind().facet_vertices()] {
                sites.on_surface[vertex as usize] = true;
            }
        }
        sites
    }

    /// Opens a site unless the last one is it.
    fn push(&mut self, vertex: u32, region: u16, index: u32) {
        let is_open = self.vertices.last() == Some(&vertex) && self.regions.last() == Some(&region);
        if !is_open {
            self.vertices.push(vertex);
            self.regions.push(region);
            self.starts.push(index);
        }
    }

    /// Number of sites.
    pub(super) fn len(&self) -> usize {
        self.vertices.len()
    }

    /// Vertex of a site.
    pub(super) fn vertex(&self, site: usize) -> usize {
        self.vertices[site] as usize
    }

    /// The region's cells around a site.
    pub(super) fn cells(&self, site: usize) -> &[u32] {
        &self.cells[self.starts[site] as usize..self.starts[site + 1] as usize]
    }

    /// Whether a site lies on the surface of its region.
    pub(super) fn is_rim(&self, site: usize) -> bool {
        let vertex = self.vertex(site);
        self.on_surface[vertex] || self.of_vertex[vertex + 1] - self.of_vertex[vertex] > 1
    }

    /// Sites of a cell's corners, zero beyond them.
    pub(super) fn of_cell(&self, corners: &[u32], region: u16) -> [usize; 4] {
        let mut sites = [0; 4];
        for (site, &vertex) in sites.iter_mut().zip(corners) {
            *site = self.find(vertex, region);
        }
        sites
    }

    /// The site of a vertex in a region that it belongs to.
    fn find(&self, vertex: u32, region: u16) -> usize {
        let range = self.of_vertex[vertex as usize]..self.of_vertex[vertex as usize + 1];
        let first = range.start as usize;
        let found = range.map(|site| self.regions[site as usize]);
        first + found.take_while(|&other| other != region).count()
    }

    /// Sites that share a cell with this one, itself included, ascending.
    pub(super) fn neighbours(&self, mesh: &Mesh, regions: &[u16], site: usize) -> Vec<usize> {
        let cells = self.cells(site).iter().map(|&cell| cell as usize);
        let mut around: Vec<usize> = cells
            .flat_map(|cell| {
                let corners = mesh.cell(cell).iter();
                corners.map(move |&vertex| self.find(vertex, regions[cell]))
            })
            .collect();
        around.sort_unstable();
        around.dedup();
        around
    }

    /// Cells of all these sites, ascending.
    pub(super) fn two_rings(&self, around: &[usize]) -> Vec<u32> {
        let mut cells: Vec<u32> = around
            .iter()
            .flat_map(|&site| self.cells(site))
            .copied()
            .collect();
        cells.sort_unstable();
        cells.dedup();
        cells
    }
}

/// Cells around each vertex, ascending: offsets `[vertices + 1]` and cells.
fn cells_of_vertices(mesh: &Mesh) -> (Vec<u32>, Vec<u32>) {
    let count = mesh.coordinates().len();
    let mut offsets = vec![0_u32; count + 1];
    for &vertex in mesh.cells() {
        offsets[vertex as usize + 1] += 1;
    }
    for vertex in 0..count {
        offsets[vertex + 1] += offsets[vertex];
    }
    let mut next = offsets.clone();
    let mut cells = vec![0; mesh.cells().len()];
    let width = mesh.cell_kind().vertices();
    for (cell, corners) in mesh.cells().chunks_exact(width).enumerate() {
        for &vertex in corners {
            cells[next[vertex as usize] as usize] = cell as u32;
            next[vertex as usize] += 1;
        }
    }
    (offsets, cells)
}
