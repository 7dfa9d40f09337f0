//! The points of frictional obstacles and the directions in which supports hold them.

use std::collections::BTreeMap;

use crate::contact::ContactSurface;
use crate::geometry::vector3::{add, normalised, scale};
use crate::plan::Plan;

/// A point of friction.
#[derive(Clone, Debug)]
pub(crate) struct Point {
    /// Its obstacle, in the order of the plan.
    pub(crate) obstacle: usize,
    /// Axes that lie across the undeformed surface, the flattest first.
    pub(super) axes: [[f64; 3]; 2],
    /// Unit vectors along which supports hold its node.
    pub(super) held: Vec<[f64; 3]>,
}

/// Unit vectors along which guides hold nodes, by node.
pub(super) type Guided = BTreeMap<u32, Vec<[f64; 3]>>;

/// Where the surfaces of `guides` hold which nodes: along their outward normals there.
pub(super) fn guided<'a>(guides: impl Iterator<Item = &'a ContactSurface>) -> Guided {
    let mut guided = Guided::new();
    for surface in guides {
        for (&node, normal) in surface.carriers.iter().zip(outward(surface)) {
            guided.entry(node).or_default().extend(normalised(normal));
        }
    }
    guided
}

/// The points of one frictional obstacle.
pub(super) fn points_of(
    (plan, guided): (&Plan, &Guided),
    c: usize,
    (obstacle, surface): (usize, &ContactSurface),
) -> Vec<Point> {
    let mut nodes = vec![0; surface.multipliers()];
    for (function, &node) in (0..).zip(&surface.carriers) {
        let own = surface
            .shares
            .of(function)
            .filter(|&(_, share)| share > 0.99);
        own.for_each(|(multiplier, _)| nodes[multiplier as usize] = node);
    }
    let normals = gathered(surface, &outward(surface));
    let is_held = |node: u32, i: usize| {
        let unknown = node * c as u32 + i as u32;
        let known = plan
            .problem
            .held
            .binary_search_by_key(&unknown, |(held, _)| *held);
        i < c && known.is_ok()
    };
    let held = |node: u32| {
        let components = (0..3).filter(|&i| is_held(node, i)).map(unit);
        let planes = plan
            .problem
            .held_nodes
            .binary_search_by_key(&node, |one| one.held.node);
        let planes = planes.map_or(&[][..], |place| &plan.problem.held_nodes[place].planes);
        let guided = guided.get(&node).into_iter().flatten();
        let normals = planes
            .iter()
            .map(|plane| plane.normal)
            .chain(guided.copied());
        components.chain(normals).collect()
    };
    let point = |own: usize| Point {
        obstacle,
        axes: axes(normals[own]),
        held: held(nodes[own]),
    };
    (0..nodes.len()).map(point).collect()
}

/// Sums of the outward normals of the faces at each function.
fn outward(surface: &ContactSurface) -> Vec<[f64; 3]> {
    let mut sums = vec![[0.0; 3]; surface.carriers.len()];
    for face in &surface.faces {
        for &function in &face.functions {
            let sum = &mut sums[function as usize];
            *sum = add(*sum, scale(face.flat_area, face.normal));
        }
    }
    sums
}

/// Sums at each multiplier of what its functions have.
fn gathered(surface: &ContactSurface, values: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let mut sums = vec![[0.0; 3]; surface.multipliers()];
    for (function, value) in (0..).zip(values) {
        for (multiplier, _) in surface.shares.of(function) {
            let sum = &mut sums[multiplier as usize];
            *sum = add(*sum, *value);
        }
    }
    sums
}

/// Unit vector of an axis.
fn unit(axis: usize) -> [f64; 3] {
    std::array::from_fn(|i| if i == axis { 1.0 } else { 0.0 })
}

/// The two coordinate axes that lie flattest across a normal.
fn axes(normal: [f64; 3]) -> [[f64; 3]; 2] {
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs()));
    [unit(order[0]), unit(order[1])]
}
