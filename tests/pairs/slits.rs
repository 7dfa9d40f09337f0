//! Blocks with slits of many shapes that are pressed shut: either lip carries, and the surface of the
//! slit may meet itself as one.

use super::folds::{of_itself, together, with_union};
use super::pinched::glued;
use super::scenes::{between, joined, rubber};
use crate::common::meshes::{mesh, moved, unit_grid, with_pad};
use crate::common::scenes::{HELD_IN_PLANE, support};
use crate::common::{assert_converged, solve};
use signorini::scene::ContactPair;
use signorini::{MeshParts, Scene, Step, StepReport};

/// Number `k` of a sequence in \[0, 1) without order.
fn scattered(k: usize) -> f64 {
    ((k as f64 + 1.0) * 0.618_033_988_749_895).fract()
}

/// A slit in a square of side two about the origin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slit {
    /// Half its length.
    half: f64,
    /// Half its opening in the middle.
    open: f64,
    /// Slope and wave of the line along its middle.
    slope: f64,
    wave: f64,
    /// Cells across the lower and the upper half.
    across: [usize; 2],
}

impl Slit {
    pub(crate) fn some(number: usize) -> Self {
        let at = |k: usize| scattered(7 * number + k);
        Self {
            half: 0.4 + 0.3 * at(0),
            open: 0.02 + 0.05 * at(1),
            slope: 0.4 * (at(2) - 0.5),
            wave: 0.1 * (at(3) - 0.5),
            across: [10 + (5.0 * at(4)) as usize, 10 + (5.0 * at(5)) as usize],
        }
    }

    /// Height of the upper or the lower lip, and of the line along which both halves are one.
    fn lip(&self, x: f64, side: f64) -> f64 {
        let inside = (1.0 - (x / self.half).powi(2)).max(0.0);
        let middle = self.slope * x + self.wave * inside * (6.0 * x).sin();
        middle + side * self.open * inside
    }

    /// One half, the lip along `y0` of its grid; columns are those of the other half beside the slit.
    fn half(&self, side: f64, across: usize) -> MeshParts {
        // Two columns beside the slit on either hand.
        let count = across + 4;
        let column = |s: f64| {
            let k = (s * count as f64).round();
            let beside = 0.5 * (1.0 - self.half);
            if k <= 2.0 {
                -1.0 + k * beside
            } else if k >= across as f64 + 2.0 {
                self.half + (k - across as f64 - 2.0) * beside
            } else {
                self.half * (2.0 * (k - 2.0) / across as f64 - 1.0)
            }
        };
        let place = |[s, t, z]: [f64; 3]| {
            let x = column(s);
            let lip = self.lip(x, side);
            [x, lip + t * (side - lip), z]
        };
        let inside = |[s, ..]: [f64; 3]| column(s).abs() <= self.half + 1e-9;
        let grid = with_pad(unit_grid(count, 6), ("lip", "y0"), inside);
        let mut parts = moved(grid, place);
        if side < 0.0 {
            parts.cells.chunks_mut(3).for_each(|cell| cell.swap(1, 2));
        }
        parts
    }

    pub(crate) fn parts(&self) -> MeshParts {
        let [lower, upper] = self.across;
        let halves = [
            ("low_", self.half(-1.0, lower)),
            ("up_", self.half(1.0, upper)),
        ];
        with_union(glued(joined(&halves)), "slit", &["low_lip", "up_lip"])
    }

    /// Its scene, held above and below.
    pub(crate) fn scene(contacts: Vec<ContactPair>) -> Scene {
        let mut scene = Scene {
            supports: vec![
                support("up_y1", HELD_IN_PLANE),
                support("low_y1", HELD_IN_PLANE),
            ],
            contacts,
            ..rubber([("up_body", 1.0), ("low_body", 1.0)], Some(10.0))
        };
        scene.solver.tolerance = 1e-10;
        scene
    }

    /// Pressed by `way` from above and from below.
    fn pressed(&self, contacts: Vec<ContactPair>, way: f64) -> StepReport {
        let scene = Self::scene(contacts);
        let step = Step {
            increments: 3,
            ..together(["up_y1", "low_y1"], way)
        };
        let reports = solve(&scene, &[step], &mesh(self.parts()));
        reports.iter().for_each(assert_converged);
        reports.into_iter().next_back().expect("a report")
    }
}

#[test]
fn slits_of_many_shapes_close_whichever_lip_carries() {
    for number in 0..24 {
        let slit = Slit::some(number);
        let contacts = [
            between("low_lip", "up_lip"),
            between("up_lip", "low_lip"),
            of_itself("slit"),
        ];
        let found = contacts.map(|contacts| slit.pressed(contacts, 0.1));
        let energies = found.each_ref().map(|report| report.strain_energy);
        let forces = found.each_ref().map(|report| report.contacts["pair"].force);
        assert!(
            forces[0][1] < 0.0 && forces[1][1] > 0.0,
            "{slit:?} {forces:?}"
        );
        let apart = (energies[0] / energies[1] - 1.0).abs();
        assert!(apart < 4e-4, "{slit:?} {energies:?}");
        // Both lips follow each other along the surface: one of them carries all along.
        let same = [0, 1].map(|k: usize| (energies[2] / energies[k] - 1.0).abs());
        assert!(same[0].min(same[1]) < 1e-9, "{slit:?} {energies:?}");
        for report in &found {
            let [up, low] = ["up_y1", "low_y1"].map(|name| report.supports[name].force);
            let sum = (0..2).map(|i| (up[i] + low[i]).abs()).fold(0.0, f64::max);
            assert!(sum < 1e-8 * up[1].abs(), "{up:?} {low:?}");
        }
    }
}
