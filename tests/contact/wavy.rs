//! Random wavy tools: all are solved, on sets that are found at once or nearly.

use std::f64::consts::TAU;
use std::sync::Arc;

use crate::common::meshes::{cube, mesh};
use crate::common::scenes::{HELD, elastic, obstacle, push, support};
use crate::common::{assert_converged, solve_one};
use crate::grids::values;
use signorini::obstacle::grid::{HeightField, Lattice};
use signorini::scene::Shape;

const TOOLS: u64 = 40;
/// Revisions of the set that most tools take at most, and the share that may take more.
const REVISIONS: u32 = 3;
const MORE: f64 = 0.05;

/// Numbers in [0, 1) by Steele, Lea and Flood's generator.
struct Random(u64);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        let share = ((bits ^ (bits >> 31)) >> 11) as f64 / (1_u64 << 53) as f64;
        low + share * (high - low)
    }
}

/// Five waves, together at most 0.04 high, above the unit square, which the lowest point in it
/// touches.
fn waves(seed: u64) -> Shape {
    let mut random = Random(seed);
    let waves: [[f64; 4]; 5] = std::array::from_fn(|_| {
        let [x, y] = [0, 1].map(|_| random.between(-9.0, 9.0));
        [x, y, random.between(0.2, 1.0), random.between(0.0, TAU)]
    });
    let height = |[x, y]: [f64; 2]| -> f64 {
        let wave = |[k, l, size, phase]: &[f64; 4]| size * (k * x + l * y + phase).sin();
        waves.iter().map(wave).sum()
    };
    let lattice = Lattice {
        counts: [81; 2],
        origin: [-0.3; 2],
        spacing: [0.02; 2],
    };
    let mut heights = values(&lattice, height);
    let largest = heights.iter().fold(0.0_f64, |most, z| most.max(z.abs()));
    heights.iter_mut().for_each(|z| *z *= 0.04 / largest);
    let inside = |index: &usize| {
        [index / 81, index % 81]
            .iter()
            .all(|&node| (15..=65).contains(&node))
    };
    let over_body = (0..heights.len())
        .filter(inside)
        .map(|index| heights[index]);
    let lowest = over_body.fold(f64::INFINITY, f64::min);
    heights.iter_mut().for_each(|z| *z += 1.0 - lowest);
    let field = HeightField::new(lattice, &heights).expect("waves");
    Shape::Cavity(Shape::HeightField(Arc::new(field)).into())
}

#[test]
fn random_wavy_tools_are_pressed_on_sets_that_are_hardly_revised() {
    let mesh = mesh(cube(6));
    let mut slow = 0;
    for seed in 0..TOOLS {
        let mut scene = elastic(0.5);
        scene.supports = vec![support("z0", HELD)];
        scene.obstacles = vec![obstacle("waves", "z1", waves(seed))];
        scene.solver.tolerance = 1e-6;
        let report = solve_one(&scene, &push("waves", [0.0, 0.0, -0.03]), &mesh);
        assert_converged(&report);
        assert!(report.obstacles["waves"].force[2] < 0.0, "{seed}");
        slow += u32::from(report.active_set_changes > REVISIONS);
    }
    assert!(f64::from(slow) <= MORE * TOOLS as f64, "{slow}");
}
