//! A block to press on: mesh, upload messages and scene.

use signorini_proto::array;
use signorini_proto::digest::{GroupArrays, MeshArrays, hex, mesh_digest};
use signorini_proto::v1::{self as wire, upload_mesh_request::Part};

/// A unit cube of `n`^3 boxes, six tetrahedra each; facet groups `bottom` and `top`.
pub(crate) struct Block {
    pub(crate) coordinates: Vec<f64>,
    pub(crate) cells: Vec<i32>,
    pub(crate) facets: Vec<i32>,
    pub(crate) bottom: Vec<i32>,
    pub(crate) top: Vec<i32>,
    pub(crate) body: Vec<i32>,
    pub(crate) curved_edges: Vec<i32>,
    pub(crate) edge_offsets: Vec<f64>,
}

impl Block {
    pub(crate) fn new(n: i32) -> Self {
        let mut block = Self {
            coordinates: Vec::new(),
            cells: Vec::new(),
            facets: Vec::new(),
            bottom: Vec::new(),
            top: Vec::new(),
            body: (0..6 * n * n * n).collect(),
            curved_edges: Vec::new(),
            edge_offsets: Vec::new(),
        };
        for k in 0..=n {
            for j in 0..=n {
                for i in 0..=n {
                    block
                        .coordinates
                        .extend([i, j, k].map(|c| f64::from(c) / f64::from(n)));
                }
            }
        }
        for k in 0..n {
            for j in 0..n {
                for i in 0..n {
                    block.add_box(n, [i, j, k]);
                }
            }
        }
        block
    }

    fn add_box(&mut self, n: i32, corner: [i32; 3]) {
        const PATHS: [[usize; 3]; 6] = [
            [0, 1, 2],
            [1, 2, 0],
            [2, 0, 1],
            [0, 2, 1],
            [2, 1, 0],
            [1, 0, 2],
        ];
        let vertex = |at: [i32; 3]| at[0] + (n + 1) * (at[1] + (n + 1) * at[2]);
        for (number, path) in PATHS.iter().enumerate() {
            let mut at = corner;
            let mut cell = vec![(vertex(at), at)];
            for axis in path {
                at[*axis] += 1;
                cell.push((vertex(at), at));
            }
            let facet: Vec<_> = cell.iter().filter(|(_, at)| at[2] == corner[2]).collect();
            self.add_facet(&facet, corner[2] == 0, Side::Bottom);
            let facet: Vec<_> = cell
                .iter()
                .filter(|(_, at)| at[2] == corner[2] + 1)
                .collect();
            self.add_facet(&facet, corner[2] + 1 == n, Side::Top);
            // Odd permutations of the axes turn a cell inside out.
            if number >= 3 {
                cell.swap(2, 3);
            }
            self.cells.extend(cell.iter().map(|(vertex, _)| vertex));
        }
    }

    fn add_facet(&mut self, facet: &[&(i32, [i32; 3])], outside: bool, side: Side) {
        if facet.len() != 3 || !outside {
            return;
        }
        let index = (self.facets.len() / 3) as i32;
        self.facets.extend(facet.iter().map(|(vertex, _)| vertex));
        match side {
            Side::Bottom => self.bottom.push(index),
            Side::Top => self.top.push(index),
        }
    }

    fn groups(&self) -> [(&'static str, wire::GroupKind, &[i32]); 3] {
        [
            ("body", wire::GroupKind::Cells, &self.body),
            ("bottom", wire::GroupKind::Facets, &self.bottom),
            ("top", wire::GroupKind::Facets, &self.top),
        ]
    }

    pub(crate) fn digest(&self) -> String {
        let groups = self.groups().map(|(name, kind, members)| GroupArrays {
            name,
            dimension: if kind == wire::GroupKind::Cells { 3 } else { 2 },
            members,
        });
        hex(&mesh_digest(&MeshArrays {
            vertices_per_cell: 4,
            coordinates: &self.coordinates,
            cells: &self.cells,
            facets: &self.facets,
            groups: &groups,
            curved_edges: &self.curved_edges,
            edge_offsets: &self.edge_offsets,
        }))
    }

    pub(crate) fn header(&self) -> wire::MeshHeader {
        wire::MeshHeader {
            digest: self.digest(),
            cell_kind: wire::CellKind::Tetrahedron.into(),
            vertex_count: (self.coordinates.len() / 3) as i64,
            cell_count: (self.cells.len() / 4) as i64,
            facet_count: (self.facets.len() / 3) as i64,
            groups: Vec::from(self.groups().map(|(name, kind, members)| wire::MeshGroup {
                name: name.into(),
                kind: kind.into(),
                member_count: members.len() as i64,
            })),
            curved_edge_count: (self.curved_edges.len() / 2) as i64,
            edge_count: 0,
        }
    }

    pub(crate) fn messages(&self) -> Vec<wire::UploadMeshRequest> {
        let mut parts = vec![Part::Header(self.header())];
        let mut add = |array: wire::MeshArray, group_index: i32, data: bytes::Bytes, size| {
            parts.extend(array::chunks(data, size).map(|chunk| {
                Part::Chunk(wire::MeshChunk {
                    array: array.into(),
                    group_index,
                    offset_elements: chunk.offset_elements,
                    data: chunk.data,
                })
            }));
        };
        add(
            wire::MeshArray::Coordinates,
            0,
            array::encode(&self.coordinates),
            8,
        );
        add(wire::MeshArray::Cells, 0, array::encode(&self.cells), 4);
        add(wire::MeshArray::Facets, 0, array::encode(&self.facets), 4);
        let curved = array::encode(&self.curved_edges);
        add(wire::MeshArray::CurvedEdges, 0, curved, 4);
        let offsets = array::encode(&self.edge_offsets);
        add(wire::MeshArray::EdgeOffsets, 0, offsets, 8);
        for (index, (_, _, members)) in (0..).zip(self.groups()) {
            add(
                wire::MeshArray::GroupMembers,
                index,
                array::encode(members),
                4,
            );
        }
        parts
            .into_iter()
            .map(|part| wire::UploadMeshRequest { part: Some(part) })
            .collect()
    }

    /// The block held at its bottom under a ball that touches its top.
    pub(crate) fn scene(&self) -> wire::Scene {
        wire::Scene {
            name: "block".into(),
            mesh: format!("meshes/{}", self.digest()),
            materials: vec![rubber()],
            supports: vec![wire::Support {
                name: "base".into(),
                on: vec!["bottom".into()],
                displacement: Some(wire::Components {
                    x: Some(0.0),
                    y: Some(0.0),
                    z: Some(0.0),
                }),
                normal: None,
                ..Default::default()
            }],
            obstacles: vec![ball()],
            solver: Some(wire::SolverOptions {
                tolerance: Some(1e-8),
                ..Default::default()
            }),
            ..Default::default()
        }
    }
}

enum Side {
    Bottom,
    Top,
}

fn rubber() -> wire::Material {
    let law = wire::LinearElastic {
        modulus: Some(wire::linear_elastic::Modulus::ShearModulus(1.0)),
        poisson_ratio: Some(0.5),
    };
    wire::Material {
        group: "body".into(),
        model: Some(wire::material::Model::LinearElastic(law)),
        ..Default::default()
    }
}

fn ball() -> wire::Obstacle {
    let sphere = wire::Sphere {
        centre: vec![0.5, 0.5, 11.0],
        radius: Some(10.0),
    };
    wire::Obstacle {
        name: "ball".into(),
        on: vec!["top".into()],
        shape: Some(wire::Shape {
            kind: Some(wire::shape::Kind::Sphere(sphere)),
            inside: false,
        }),
        ..Default::default()
    }
}
