//! The digest that names a mesh: SHA-256 over its canonical bytes, defined in
//! `mesh_service.proto`.
//!
//! Works on wire arrays, so that a client can name a mesh before it uploads a
//! byte. Cost: one pass, no copy of the arrays.

use sha2::{Digest, Sha256};

use crate::array::Element;

const MAGIC: &[u8] = b"signorini-mesh-v1\n";
/// Of meshes with curved edges.
const CURVED_MAGIC: &[u8] = b"signorini-mesh-v2\n";

/// Of triangulated surfaces.
const SURFACE_MAGIC: &[u8] = b"signorini-surface-v1\n";

/// Of grids.
const GRID_MAGIC: &[u8] = b"signorini-grid-v1\n";

/// One named set of cells or facets.
#[derive(Clone, Copy, Debug)]
pub struct GroupArrays<'a> {
    /// Name, hashed as UTF-8.
    pub name: &'a str,
    /// Topological dimension of the members: of cells or one less.
    pub dimension: u8,
    /// Indices of cells or facets, from 0.
    pub members: &'a [i32],
}

/// The arrays of one mesh as they travel.
#[derive(Clone, Copy, Debug)]
pub struct MeshArrays<'a> {
    /// 3 for triangles, 4 for tetrahedra.
    pub vertices_per_cell: u8,
    /// `[vertices, 3]`, flat.
    pub coordinates: &'a [f64],
    /// `[cells, vertices_per_cell]`, flat.
    pub cells: &'a [i32],
    /// `[facets, vertices_per_cell - 1]`, flat.
    pub facets: &'a [i32],
    /// In the order of the header.
    pub groups: &'a [GroupArrays<'a>],
    /// Ends of the curved edges, `[edges, 2]`, flat.
    pub curved_edges: &'a [i32],
    /// Their offsets, `[edges, 3]`, flat.
    pub edge_offsets: &'a [f64],
}

/// SHA-256 of the canonical bytes.
pub fn mesh_digest(mesh: &MeshArrays<'_>) -> [u8; 32] {
    let per_cell = usize::from(mesh.vertices_per_cell).max(2);
    let mut hash = Sha256::new();
    hash.update(match mesh.curved_edges {
        [] => MAGIC,
        _ => CURVED_MAGIC,
    });
    hash.update([mesh.vertices_per_cell]);
    put_count(&mut hash, mesh.coordinates.len() / 3);
    put_count(&mut hash, mesh.cells.len() / per_cell);
    put_count(&mut hash, mesh.facets.len() / (per_cell - 1));
    put_count(&mut hash, mesh.groups.len());
    put_array(&mut hash, mesh.coordinates);
    put_array(&mut hash, mesh.cells);
    put_array(&mut hash, mesh.facets);
    for group in mesh.groups {
        put_count(&mut hash, group.name.len());
        hash.update(group.name.as_bytes());
        hash.update([group.dimension]);
        put_count(&mut hash, group.members.len());
        put_array(&mut hash, group.members);
    }
    if !mesh.curved_edges.is_empty() {
        put_count(&mut hash, mesh.curved_edges.len() / 2);
        put_array(&mut hash, mesh.curved_edges);
        put_array(&mut hash, mesh.edge_offsets);
    }
    hash.finalize().into()
}

/// SHA-256 of the canonical bytes of a triangulated surface, defined in
/// `surface_service.proto`: coordinates `[vertices, 3]` and facets `[facets, 3]`, flat.
pub fn surface_digest(coordinates: &[f64], facets: &[i32]) -> [u8; 32] {
    let mut hash = Sha256::new();
    hash.update(SURFACE_MAGIC);
    put_count(&mut hash, coordinates.len() / 3);
    put_count(&mut hash, facets.len() / 3);
    put_array(&mut hash, coordinates);
    put_array(&mut hash, facets);
    hash.finalize().into()
}

/// SHA-256 of the canonical bytes of a grid, defined in `surface_service.proto`: one count,
/// coordinate of the origin and spacing an axis, and the values.
pub fn grid_digest(
    counts: &[usize],
    (origin, spacing): (&[f64], &[f64]),
    values: &[f64],
) -> [u8; 32] {
    let mut hash = Sha256::new();
    hash.update(GRID_MAGIC);
    put_count(&mut hash, counts.len());
    counts.iter().for_each(|&count| put_count(&mut hash, count));
    put_array(&mut hash, origin);
    put_array(&mut hash, spacing);
    put_array(&mut hash, values);
    hash.finalize().into()
}

/// Lower-case hexadecimal digits, as names of resources use them.
pub fn hex(digest: &[u8; 32]) -> String {
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn put_count(hash: &mut Sha256, count: usize) {
    hash.update((count as u64).to_le_bytes());
}

fn put_array<E: Element>(hash: &mut Sha256, values: &[E]) {
    let mut block = Vec::with_capacity(4096 * E::SIZE);
    for part in values.chunks(4096) {
        block.clear();
        for value in part {
            value.put(&mut block);
        }
        hash.update(&block);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digest_is_the_hash_of_the_documented_bytes() {
        let members = [0];
        let groups = [GroupArrays {
            name: "body",
            dimension: 2,
            members: &members,
        }];
        let mesh = MeshArrays {
            vertices_per_cell: 3,
            coordinates: &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0],
            cells: &[0, 1, 2],
            facets: &[0, 1],
            groups: &groups,
            curved_edges: &[],
            edge_offsets: &[],
        };
        let mut bytes = b"signorini-mesh-v1\n\x03".to_vec();
        for count in [3_u64, 1, 1, 1] {
            bytes.extend(count.to_le_bytes());
        }
        for value in mesh.coordinates {
            bytes.extend(value.to_le_bytes());
        }
        for index in [0_i32, 1, 2, 0, 1] {
            bytes.extend(index.to_le_bytes());
        }
        bytes.extend(4_u64.to_le_bytes());
        bytes.extend(b"body\x02");
        bytes.extend(1_u64.to_le_bytes());
        bytes.extend(0_i32.to_le_bytes());
        let expected: [u8; 32] = Sha256::digest(&bytes).into();
        assert_eq!(mesh_digest(&mesh), expected);
        assert_eq!(hex(&expected).len(), 64);
        let curved = MeshArrays {
            curved_edges: &[0, 2],
            edge_offsets: &[-0.25, 0.0, 0.0],
            ..mesh
        };
        bytes[16] = b'2';
        bytes.extend(1_u64.to_le_bytes());
        bytes.extend([0_i32, 2].iter().flat_map(|vertex| vertex.to_le_bytes()));
        bytes.extend(curved.edge_offsets.iter().flat_map(|x| x.to_le_bytes()));
        let expected: [u8; 32] = Sha256::digest(&bytes).into();
        assert_eq!(mesh_digest(&curved), expected);
    }
    #[test]
    fn digest_of_a_grid_is_the_hash_of_the_documented_bytes() {
        let mut bytes = b"signorini-grid-v1\n".to_vec();
        for count in [2_u64, 2, 1] {
            bytes.extend(count.to_le_bytes());
        }
        for value in [0.5_f64, -0.5, 1.0, 2.0, 7.0, 8.0] {
            bytes.extend(value.to_le_bytes());
        }
        let expected: [u8; 32] = Sha256::digest(&bytes).into();
        let found = grid_digest(&[2, 1], (&[0.5, -0.5], &[1.0, 2.0]), &[7.0, 8.0]);
        assert_eq!(found, expected);
    }
}
