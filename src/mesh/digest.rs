//! The identity of a mesh: SHA-256 over its canonical bytes.
//!
//! Canonical bytes, little-endian: `signorini-mesh-v1\n`; u8 vertices per cell;
//! u64 counts of vertices, cells, facets, groups; coordinates f64 `[vertices, 3]`;
//! cells i32; facets i32; for each group u64 name length, name (UTF-8), u8
//! dimension, u64 member count, members i32. Arrays are as uploaded, vertices
//! that no cell uses included. A mesh with offsets of edges begins with
//! `signorini-mesh-v2\n` instead and ends with their u64 count, their ends i32
//! `[edges, 2]` and the offsets f64 `[edges, 3]`; one that keeps those inside the body begins with
//! `signorini-mesh-v3\n`. Cost: one pass over the arrays.

use std::fmt;

use sha2::{Digest, Sha256};

use super::offsets::Inside;
use super::{EdgeOffset, GroupKind, MeshParts};

/// Content address of a mesh; displayed as 64 lower-case hexadecimal digits.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct MeshId([u8; 32]);

impl MeshId {
    /// From the digest itself.
    pub fn from_bytes(bytes: [u8; 32]) -> Self {
        Self(bytes)
    }

    /// From 64 lower-case hexadecimal digits; `None` for anything else.
    pub fn from_hex(text: &str) -> Option<Self> {
        let digits = text.as_bytes();
        if digits.len() != 64 {
            return None;
        }
        let mut bytes = [0; 32];
        for (byte, pair) in bytes.iter_mut().zip(digits.chunks_exact(2)) {
            *byte = 16 * hexadecimal(pair[0])? + hexadecimal(pair[1])?;
        }
        Some(Self(bytes))
    }

    /// The digest itself.
    pub fn as_bytes(&self) -> &[u8; 32] {
        &self.0
    }
}

impl fmt::Display for MeshId {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0
            .iter()
            .try_for_each(|byte| write!(formatter, "{byte:02x}"))
    }
}

impl fmt::Debug for MeshId {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "MeshId({self})")
    }
}

/// Value of one lower-case hexadecimal digit.
fn hexadecimal(digit: u8) -> Option<u8> {
    match digit {
        b'0'..=b'9' => Some(digit - b'0'),
        b'a'..=b'f' => Some(digit - b'a' + 10),
        _ => None,
    }
}

/// Digest of arrays whose counts and indices fit 31 bits.
pub(super) fn digest(parts: &MeshParts, offsets: &[EdgeOffset], inside: Inside) -> MeshId {
    let kind = parts.cell_kind;
    let mut hasher = Sha256::new();
    hasher.update(match (offsets, inside) {
        ([], _) => b"signorini-mesh-v1\n",
        (_, Inside::LeftOut) => b"signorini-mesh-v2\n",
        (_, Inside::Kept) => b"signorini-mesh-v3\n",
    });
    hasher.update([kind.vertices() as u8]);
    let cells = parts.cells.len() / kind.vertices();
    let facets = parts.facets.len() / kind.facet_vertices();
    for count in [parts.coordinates.len(), cells, facets, parts.groups.len()] {
        hasher.update((count as u64).to_le_bytes());
    }
    update_all(&mut hasher, parts.coordinates.as_flattened(), |value| {
        value.to_le_bytes()
    });
    // An index below 2^31 has the same bytes as i32 and as u32.
    update_all(&mut hasher, &parts.cells, |index| index.to_le_bytes());
    update_all(&mut hasher, &parts.facets, |index| index.to_le_bytes());
    for group in &parts.groups {
        hasher.update((group.name.len() as u64).to_le_bytes());
        hasher.update(group.name.as_bytes());
        hasher.update([dimension(group.kind, kind.dimension())]);
        hasher.update((group.members.len() as u64).to_le_bytes());
        update_all(&mut hasher, &group.members, |index| index.to_le_bytes());
    }
    update_offsets(&mut hasher, offsets);
    MeshId(hasher.finalize().into())
}

/// Nothing for a straight mesh.
fn update_offsets(hasher: &mut Sha256, offsets: &[EdgeOffset]) {
    if offsets.is_empty() {
        return;
    }
    hasher.update((offsets.len() as u64).to_le_bytes());
    for one in offsets {
        update_all(hasher, &one.ends, |vertex| vertex.to_le_bytes());
    }
    for one in offsets {
        update_all(hasher, &one.offset, |value| value.to_le_bytes());
    }
}

/// Dimension of the members of a group: that of the cells, or one less.
fn dimension(kind: GroupKind, of_cells: usize) -> u8 {
    match kind {
        GroupKind::Cells => of_cells as u8,
        GroupKind::Facets => of_cells as u8 - 1,
    }
}

/// Feeds the values in blocks, since single values are too short for the hash.
fn update_all<T: Copy, const N: usize>(hasher: &mut Sha256, values: &[T], bytes: fn(T) -> [u8; N]) {
    let mut buffer = Vec::with_capacity(1024 * N);
    for block in values.chunks(1024) {
        buffer.clear();
        for &value in block {
            buffer.extend_from_slice(&bytes(value));
        }
        hasher.update(&buffer);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{CellKind, Group};

    fn parts() -> MeshParts {
        MeshParts {
            cell_kind: CellKind::Triangle,
            coordinates: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            cells: vec![0, 1, 2],
            facets: vec![0, 1],
            groups: vec![Group {
                name: "edge".to_owned(),
                kind: GroupKind::Facets,
                members: vec![0],
            }],
        }
    }

    /// The canonical bytes, written down by hand.
    fn canonical() -> Vec<u8> {
        let mut bytes = b"signorini-mesh-v1\n\x03".to_vec();
        for count in [3_u64, 1, 1, 1] {
            bytes.extend(count.to_le_bytes());
        }
        for value in [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0_f64] {
            bytes.extend(value.to_le_bytes());
        }
        for index in [0, 1, 2, 0, 1_i32] {
            bytes.extend(index.to_le_bytes());
        }
        bytes.extend(4_u64.to_le_bytes());
        bytes.extend(b"edge\x01");
        bytes.extend(1_u64.to_le_bytes());
        bytes.extend(0_i32.to_le_bytes());
        bytes
    }

    #[test]
    fn digest_is_sha_256_of_the_canonical_bytes() {
        let expected: [u8; 32] = Sha256::digest(canonical()).into();
        assert_eq!(digest(&parts(), &[], Inside::LeftOut).as_bytes(), &expected);
    }

    /// The offset of one edge.
    fn bent() -> EdgeOffset {
        EdgeOffset {
            ends: [0, 2],
            offset: [-0.25, 0.0, 0.0],
        }
    }

    #[test]
    fn a_curved_mesh_has_the_digest_of_its_second_version() {
        let mut bytes = canonical();
        bytes[16] = b'2';
        bytes.extend(1_u64.to_le_bytes());
        bytes.extend([0_i32, 2].iter().flat_map(|vertex| vertex.to_le_bytes()));
        bytes.extend([-0.25, 0.0, 0.0_f64].iter().flat_map(|x| x.to_le_bytes()));
        let expected: [u8; 32] = Sha256::digest(bytes).into();
        assert_eq!(
            digest(&parts(), &[bent()], Inside::LeftOut).as_bytes(),
            &expected
        );
    }

    #[test]
    fn a_straight_mesh_keeps_its_digest() {
        let expected = "293466b0cc4706f1de4b40fe09e909ad2d3ea9025136cf75c6201656f8fac7b5";
        assert_eq!(digest(&parts(), &[], Inside::LeftOut).to_string(), expected);
    }

    #[test]
    fn every_array_counts() {
        let base = digest(&parts(), &[], Inside::LeftOut);
        let changes: [fn(&mut MeshParts); 5] = [
            |parts| parts.coordinates[1][2] = 1e-300,
            |parts| parts.cells.swap(0, 1),
            |parts| parts.facets.swap(0, 1),
            |parts| parts.groups[0].name.push('s'),
            |parts| parts.groups[0].kind = GroupKind::Cells,
        ];
        for change in changes {
            let mut changed = parts();
            change(&mut changed);
            assert_ne!(digest(&changed, &[], Inside::LeftOut), base);
        }
    }

    #[test]
    fn hexadecimal_form_round_trips() {
        let id = digest(&parts(), &[], Inside::LeftOut);
        assert_eq!(MeshId::from_hex(&id.to_string()), Some(id));
        assert_eq!(MeshId::from_hex(&id.to_string().to_uppercase()), None);
        assert_eq!(MeshId::from_hex("00"), None);
        assert_eq!(MeshId::from_hex(&"é".repeat(32)), None);
    }
}
