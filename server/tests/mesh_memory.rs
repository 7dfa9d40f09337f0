//! What a mesh costs while it is built. Alone in its process: the heap is counted.

mod common;

use std::alloc::System;

use cap::Cap;
use common::Block;
use signorini::mesh::{CellKind, Group, GroupKind, Mesh, MeshParts};

#[global_allocator]
static HEAP: Cap<System> = Cap::new(System, usize::MAX);

fn indices(values: &[i32]) -> Vec<u32> {
    values.iter().map(|value| value.cast_unsigned()).collect()
}

fn group(name: &str, kind: GroupKind, members: &[i32]) -> Group {
    Group {
        name: name.into(),
        kind,
        members: indices(members),
    }
}

/// The block as a mesh of tetrahedra.
fn solid(block: &Block) -> MeshParts {
    MeshParts {
        cell_kind: CellKind::Tetrahedron,
        coordinates: block.coordinates.as_chunks().0.to_vec(),
        cells: indices(&block.cells),
        facets: indices(&block.facets),
        groups: vec![
            group("body", GroupKind::Cells, &block.body),
            group("top", GroupKind::Facets, &block.top),
        ],
    }
}

/// The square of `n` by `n` pairs of triangles.
fn square(n: u32) -> MeshParts {
    let places = |count: u32| (0..count).flat_map(move |y| (0..count).map(move |x| [x, y]));
    let mut coordinates = Vec::with_capacity(((n + 1) * (n + 1)) as usize);
    coordinates.extend(places(n + 1).map(|[x, y]| [f64::from(x), f64::from(y), 0.0]));
    let mut cells = Vec::with_capacity(6 * (n * n) as usize);
    for [x, y] in places(n) {
        let [low, top] = [y, y + 1].map(|y| y * (n + 1) + x);
        cells.extend([low, low + 1, top + 1, low, top + 1, top]);
    }
    MeshParts {
        cell_kind: CellKind::Triangle,
        coordinates,
        cells,
        facets: Vec::new(),
        groups: Vec::new(),
    }
}

/// Checks that the heap never held much more than the mesh. Only for a mesh that
/// is larger than all before.
fn assert_lean(parts: impl FnOnce() -> MeshParts) {
    let before = HEAP.allocated();
    let mesh = Mesh::new(parts()).unwrap();
    let peak = HEAP.max_allocated() - before;
    let held = mesh.bytes() as usize;
    assert!(peak >= held, "the heap is counted");
    assert!(
        peak <= held + held / 20,
        "{peak} bytes for a mesh of {held} bytes"
    );
}

#[test]
fn building_a_mesh_holds_little_beyond_the_mesh() {
    assert_lean(|| square(300));
    let block = Block::new(40);
    assert_lean(|| solid(&block));
}
