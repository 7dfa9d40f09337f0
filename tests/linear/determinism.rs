//! The same request gives the same bits, whatever the number of threads and
//! whoever solves beside it.

use std::sync::Arc;

use crate::common::meshes::{cube, file, mesh};
use crate::common::scenes::{cube_bend, hertz_sphere};
use crate::common::{run_one, values};
use signorini::report::Seconds;
use signorini::{FieldName, Mesh, Scene, Step};

/// All numbers of a run but times and bytes, and the bits of its fields.
fn trace(scene: &Scene, step: &Step, mesh: &Arc<Mesh>) -> (String, Vec<u64>) {
    let (session, mut report) = run_one(scene, step, mesh);
    report.seconds = Seconds::default();
    report.memory_bytes = 0;
    let fields = FieldName::ALL
        .into_iter()
        .filter(|&name| session.field(name).is_some());
    let bits = fields
        .flat_map(|name| values(&session, name))
        .map(f64::to_bits)
        .collect();
    // The shortest decimal form of a number names its bits.
    (format!("{report:?}"), bits)
}

fn with_threads<T: Send>(threads: usize, task: impl FnOnce() -> T + Send) -> T {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.expect("a pool of a few threads").install(task)
}

/// Cases large enough for several blocks and parallel reductions.
fn cases() -> Vec<(Scene, Step, Arc<Mesh>)> {
    let (scene, step) = hertz_sphere(0.5);
    vec![
        (cube_bend(0.5), Step::default(), mesh(cube(12))),
        (cube_bend(0.3), Step::default(), mesh(cube(8))),
        (scene, step, file("indent_l2")),
    ]
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    for (scene, step, mesh) in cases() {
        let one = with_threads(1, || trace(&scene, &step, &mesh));
        for threads in [2, 3] {
            assert!(
                with_threads(threads, || trace(&scene, &step, &mesh)) == one,
                "{threads}"
            );
        }
    }
}

#[test]
fn a_second_run_changes_no_bit() {
    let (scene, step) = hertz_sphere(0.49);
    let mesh = file("indent_l1");
    assert!(trace(&scene, &step, &mesh) == trace(&scene, &step, &mesh));
}

#[test]
fn another_session_beside_changes_no_bit() {
    let (scene, step) = hertz_sphere(0.5);
    let (bent, other) = (mesh(cube(8)), cube_bend(0.5));
    let mesh = file("indent_l2");
    let alone = with_threads(2, || trace(&scene, &step, &mesh));
    let beside = with_threads(2, || {
        rayon::join(
            || trace(&scene, &step, &mesh),
            || trace(&other, &Step::default(), &bent),
        )
    });
    assert!(beside.0 == alone);
}
