//! What the store promises about room and use.

use signorini::mesh::{CellKind, MeshParts};

use super::*;

fn triangle(size: f64) -> Mesh {
    Mesh::new(MeshParts {
        cell_kind: CellKind::Triangle,
        coordinates: vec![[0.0; 3], [size, 0.0, 0.0], [0.0, size, 0.0]],
        cells: vec![0, 1, 2],
        facets: Vec::new(),
        groups: Vec::new(),
    })
    .unwrap()
}

fn store(meshes: u64) -> (Arc<Store>, u64) {
    let bytes = triangle(1.0).bytes();
    (Store::new(meshes * bytes, &Metrics::new().unwrap()), bytes)
}

#[test]
fn room_is_made_least_recently_used_first_and_never_from_what_is_in_use() {
    let (store, bytes) = store(3);
    let used = store.insert_mesh(triangle(1.0), Owners::default());
    let old = store
        .insert_mesh(triangle(2.0), Owners::default())
        .value()
        .id();
    let new = store
        .insert_mesh(triangle(3.0), Owners::default())
        .value()
        .id();
    let reservation = store.reserve(bytes).unwrap();
    assert!(store.mesh(old).is_err());
    assert!(store.mesh(new).is_ok());
    let refused = store.reserve(2 * bytes).map(drop);
    assert!(matches!(refused, Err(Fault::MemoryBudget { .. })));
    assert!(store.mesh(used.value().id()).is_ok());
    drop(reservation);
    assert!(store.reserve(2 * bytes).is_ok());
}

#[test]
fn a_mesh_in_use_is_not_deleted() {
    let (store, _) = store(3);
    let lease = store.insert_mesh(triangle(1.0), Owners::default());
    let id = lease.value().id();
    assert!(matches!(
        store.delete_mesh(id),
        Err(Fault::MeshInUse { sessions: 1, .. })
    ));
    drop(lease);
    assert_eq!(store.delete_mesh(id), Ok(()));
    assert!(matches!(store.delete_mesh(id), Err(Fault::MeshNotFound(_))));
}

#[test]
fn what_cannot_fit_drops_nothing() {
    let (store, bytes) = store(3);
    let _used = store.insert_mesh(triangle(1.0), Owners::default());
    let unused = store
        .insert_mesh(triangle(2.0), Owners::default())
        .value()
        .id();
    let refused = store.reserve(3 * bytes).map(drop);
    let budget = 3 * bytes;
    let expected = Fault::MemoryBudget {
        predicted: budget,
        held: bytes,
        budget,
    };
    assert_eq!(refused, Err(expected));
    assert!(store.mesh(unused).is_ok());
}
