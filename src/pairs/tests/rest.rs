//! Gaps and slips of linear bodies: those of the volume where surfaces touch, and what they were there
//! wherever the bodies stand.

use super::*;
use crate::pairs::number::First;
use crate::pairs::slip::SlipPart;

/// Gaps of functions, their rows by coordinates, and the rows of slips.
fn listed(gaps: &[Part<First<INPUTS>>], slips: &[SlipPart]) -> [Vec<f64>; 3] {
    let gaps = || gaps.iter().flat_map(|part| part.gaps);
    [
        gaps().map(|gap| gap.value).collect(),
        gaps().flat_map(|gap| gap.first).collect(),
        slips.iter().flat_map(|part| part.rows.concat()).collect(),
    ]
}

fn at_rest(bodies: &Bodies) -> [Vec<f64>; 3] {
    bodies.at(|placed| listed(&placed.gaps_at_rest(), &placed.slips_at_rest()))
}

/// Those of the volume between the surfaces, and of tractions on it.
fn by_volume(bodies: &Bodies) -> [Vec<f64>; 3] {
    let place = |node: u32| bodies.places[node as usize];
    bodies.at(|placed| listed(&placed.first(), &placed.slid(&place)))
}

fn assert_same(found: &[f64], exact: &[f64]) {
    assert_eq!(found.len(), exact.len());
    let size = exact.iter().fold(1e-2, |size: f64, x| size.max(x.abs()));
    for (found, exact) in found.iter().zip(exact) {
        assert!((found - exact).abs() < 1e-13 * size, "{found} {exact}");
    }
}

/// Flat surfaces `open` apart, in the plane and about an axis.
fn flat(open: f64) -> [Bodies; 3] {
    [
        lines([5, 7], open, 0.0),
        lines([7, 3], open, 0.0),
        turned(lines([5, 7], open, 0.0)),
    ]
}

#[test]
fn linear_bodies_that_touch_have_the_derivatives_of_the_volume() {
    for bodies in flat(0.0) {
        let pairs = at_rest(&bodies).into_iter().zip(by_volume(&bodies));
        pairs.for_each(|(found, exact)| assert_same(&found, &exact));
    }
}

#[test]
fn rows_of_linear_bodies_are_the_same_wherever_they_stand() {
    for open in [-0.2, 0.03, 0.2] {
        for (apart, touching) in flat(open).iter().zip(&flat(0.0)) {
            let [gaps, rows, slips] = at_rest(apart);
            let [_, exact, exact_slips] = at_rest(touching);
            assert_same(&rows, &exact);
            assert_same(&slips, &exact_slips);
            // The gap is open everywhere: what raising the upper body by as much adds.
            let areas: Vec<f64> = apart.at(|placed| {
                let slips = placed.slips_at_rest();
                slips.iter().flat_map(|part| part.areas).collect()
            });
            let exact: Vec<f64> = areas.iter().map(|area| open * area).collect();
            assert_same(&gaps, &exact);
        }
    }
}

/// Curved ones, too: no even motion of both bodies changes anything, and the forces on them are opposite.
#[test]
fn forces_between_linear_bodies_add_up_to_nothing() {
    for bodies in five() {
        let vertices = vertices(&bodies);
        bodies.at(|placed| {
            let gaps = placed.gaps_at_rest().into_iter();
            let gaps = gaps.map(|part| (part.nodes, part.gaps.map(|gap| gap.first)));
            let slips = placed.slips_at_rest().into_iter();
            let slips = slips.map(|part| (part.nodes, part.rows));
            for (nodes, rows) in gaps.chain(slips) {
                let is_vertex = nodes.map(|node| vertices.contains(&(node as usize)));
                // Neighbours are named once more where there are none, with nothing to add.
                for (row, i) in rows.iter().flat_map(|row| [(row, 0), (row, 1)]) {
                    let sum: f64 = (0..nodes.len())
                        .filter(|&k| is_vertex[k])
                        .map(|k| row[2 * k + i])
                        .sum();
                    assert!(sum.abs() < 1e-15, "{sum:e}");
                }
            }
        });
    }
}
