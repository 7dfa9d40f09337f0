//! Taylor-Hood elements reach their orders against analytic fields, and
//! reproduce what lies in their space.

use crate::common::meshes::{cube, irregular, mesh, square};
use crate::common::scenes::{HELD, elastic, support};
use crate::common::{close, solve_one};
use signorini::{MeshParts, Step};

/// Errors of displacement in L2 and H1 and of pressure in L2.
fn errors(field: &str, parts: MeshParts, tolerance: f64) -> [f64; 3] {
    let mut scene = elastic(0.5);
    scene.supports = vec![support("x0", HELD)];
    scene.manufactured = Some(field.to_owned());
    scene.solver.tolerance = tolerance;
    let report = solve_one(&scene, &Step::default(), &mesh(parts));
    let errors = report.errors.expect("a manufactured scene has errors");
    let pressure = errors
        .pressure_l2
        .expect("an incompressible body has a pressure");
    [errors.displacement_l2, errors.displacement_h1, pressure]
}

/// Orders of convergence between two mesh sizes.
fn orders(coarse: [f64; 3], fine: [f64; 3], refinement: f64) -> [f64; 3] {
    std::array::from_fn(|i| (coarse[i] / fine[i]).ln() / refinement.ln())
}

fn assert_optimal(orders: [f64; 3]) {
    assert!(
        orders[0] >= 2.9 && orders[1] >= 1.9 && orders[2] >= 1.9,
        "{orders:?}"
    );
}

#[test]
fn a1m_has_the_published_errors_and_optimal_orders() {
    let coarse = errors("A1m", cube(6), 1e-8);
    let fine = errors("A1m", cube(10), 1e-8);
    let published = [
        [2.36252416e-3, 1.00733052e-1, 7.95444330e-3],
        [4.81856355e-4, 3.69203765e-2, 2.23612730e-3],
    ];
    for (found, published) in [coarse, fine].iter().zip(published) {
        for (value, exact) in found.iter().zip(published) {
            assert!(close(*value, exact, 5e-4), "{found:?} {published:?}");
        }
    }
    assert_optimal(orders(coarse, fine, 10.0 / 6.0));
}

#[test]
fn a_plane_vortex_converges_at_optimal_orders() {
    let coarse = errors("vortex", square(16), 1e-9);
    let fine = errors("vortex", square(32), 1e-9);
    assert_optimal(orders(coarse, fine, 2.0));
}

#[test]
fn a_trigonometric_field_converges_at_optimal_orders() {
    let coarse = errors("trigonometric", cube(5), 1e-8);
    let fine = errors("trigonometric", cube(10), 1e-8);
    assert_optimal(orders(coarse, fine, 2.0));
}

#[test]
fn quadratic_displacement_with_linear_pressure_is_exact_on_irregular_meshes() {
    for parts in [irregular(cube(3), 3), irregular(square(5), 5)] {
        let errors = errors("polynomial", parts, 1e-12);
        assert!(errors.iter().all(|&error| error < 1e-10), "{errors:?}");
    }
}
