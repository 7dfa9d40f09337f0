//! The path from wet to dry on which a fluid leaks first:
//!
//! ```text
//! margin = min over paths of the max of the pressure on the path
//! ```
//!
//! exact for the piecewise linear interpolant of the nodes' values: a path through a triangle is no
//! worse along its sides. Nodes join by ascending pressure until wet and dry ones are joined (Kruskal;
//! O(n log n)); of all paths with that margin the shortest is told (Dijkstra).
//!
//! Shapes `[nodes of the surface]`; pressures and lengths in any one unit.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::surface::FluidSurface;
use crate::geometry::vector3::{norm, sub};

/// What a fluid would have to pass.
#[derive(Clone, Copy, Debug)]
pub struct Barrier<'a> {
    /// The surface.
    pub surface: &'a FluidSurface,
    /// Wet nodes, which cost nothing.
    pub wet: &'a [bool],
    /// Nodes that it must not reach.
    pub dry: &'a [bool],
    /// Pressure at the nodes; infinite where no path may lead.
    pub pressure: &'a [f64],
}

/// A path from a wet node to a dry one.
#[derive(Clone, Debug, PartialEq)]
pub struct LeakPath {
    /// Its largest pressure.
    pub margin: f64,
    /// Its nodes, by their places on the surface, from wet to dry.
    pub nodes: Vec<usize>,
}

impl Barrier<'_> {
    /// The path on which the fluid leaks first, nodes at `places`; none where none leads to a dry node.
    pub fn path(&self, places: &[[f64; 3]]) -> Option<LeakPath> {
        let margin = self.margin()?.0;
        let nodes = self.shortest_below(margin, places)?;
        Some(LeakPath { margin, nodes })
    }

    fn cost(&self, place: usize) -> f64 {
        if self.wet[place] {
            0.0
        } else {
            self.pressure[place]
        }
    }

    /// The least pressure up to which nodes join wet and dry ones, and the place of a node that has it;
    /// none where none do.
    pub fn margin(&self) -> Option<(f64, usize)> {
        let count = self.wet.len();
        let costs: Vec<f64> = (0..count).map(|place| self.cost(place)).collect();
        let mut order: Vec<usize> = (0..count)
            .filter(|&place| costs[place].is_finite())
            .collect();
        order.sort_by(|&a, &b| costs[a].total_cmp(&costs[b]).then(a.cmp(&b)));
        // Two nodes more stand for all that is wet and all that is dry.
        let [wet, dry] = [count, count + 1];
        let mut roots: Vec<usize> = (0..count + 2).collect();
        let mut is_in = vec![false; count];
        for place in order {
            is_in[place] = true;
            let beside = self.surface.beside(place);
            let mut joined: Vec<usize> = beside.filter(|&other| is_in[other]).collect();
            joined.extend(self.wet[place].then_some(wet));
            joined.extend(self.dry[place].then_some(dry));
            for other in joined {
                join(&mut roots, place, other);
            }
            if root(&mut roots, wet) == root(&mut roots, dry) {
                return Some((costs[place], place));
            }
        }
        None
    }

    /// The shortest path through nodes of at most that pressure.
    fn shortest_below(&self, most: f64, places: &[[f64; 3]]) -> Option<Vec<usize>> {
        let count = self.wet.len();
        let mut from: Vec<Option<(f64, usize)>> = vec![None; count];
        let mut heap = BinaryHeap::new();
        for place in (0..count).filter(|&place| self.wet[place]) {
            from[place] = Some((0.0, place));
            heap.push((Reverse(Length(0.0)), Reverse(place)));
        }
        while let Some((Reverse(Length(length)), Reverse(place))) = heap.pop() {
            if from[place].is_some_and(|(known, _)| known < length) {
                continue;
            }
            if self.dry[place] {
                return Some(traced(&from, place));
            }
            for other in self
                .surface
                .beside(place)
                .filter(|&other| self.cost(other) <= most)
            {
                let step = norm(sub(places[other], places[place]));
                let reached = length + step;
                if from[other].is_none_or(|(known, _)| reached < known) {
                    from[other] = Some((reached, place));
                    heap.push((Reverse(Length(reached)), Reverse(other)));
                }
            }
        }
        None
    }
}

/// A length as a key of a heap.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Length(f64);

impl Eq for Length {}

impl PartialOrd for Length {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Length {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

/// The way that led to `last`, from its begin.
fn traced(from: &[Option<(f64, usize)>], last: usize) -> Vec<usize> {
    let mut nodes = vec![last];
    let mut place = last;
    while let Some((_, before)) = from[place].filter(|(_, before)| *before != place) {
        nodes.push(before);
        place = before;
    }
    nodes.reverse();
    nodes
}

fn root(roots: &mut [usize], mut place: usize) -> usize {
    while roots[place] != place {
        roots[place] = roots[roots[place]];
        place = roots[place];
    }
    place
}

fn join(roots: &mut [usize], a: usize, b: usize) {
    let [a, b] = [root(roots, a), root(roots, b)];
    roots[a.max(b)] = a.min(b);
}

#[cfg(test)]
mod tests {
    use super::super::surface::Reach;
    use super::*;
    use crate::linalg::vector::reproducible_noise;
    use crate::mesh::{GroupKind, samples};
    use crate::space::TaylorHood;

    /// The top of a cube, wet at one side and dry at the other, with the places of its nodes.
    fn top() -> (FluidSurface, Vec<[f64; 3]>) {
        let mesh = samples::cube(1);
        let space = TaylorHood::new(&mesh);
        let group = |name: &str| {
            let group = mesh.group(name, GroupKind::Facets).expect("a side");
            group.members.clone()
        };
        let [facets, from, dry] = ["z1", "x0", "x1"].map(group);
        let reach = Reach {
            facets: &facets,
            from: &from,
            dry: &dry,
        };
        let surface = FluidSurface::new(&mesh, &space, reach);
        let places = surface
            .nodes
            .iter()
            .map(|&node| space.node_place(&mesh, node));
        let places = places.collect();
        (surface, places)
    }

    /// The least margin of all paths that visit no node twice.
    fn by_all_paths(barrier: &Barrier<'_>, at: usize, worst: f64, seen: &mut Vec<bool>) -> f64 {
        let worst = worst.max(barrier.cost(at));
        if barrier.dry[at] {
            return worst;
        }
        seen[at] = true;
        let mut best = f64::INFINITY;
        for other in barrier.surface.beside(at).collect::<Vec<_>>() {
            if !seen[other] {
                best = best.min(by_all_paths(barrier, other, worst, seen));
            }
        }
        seen[at] = false;
        best
    }

    #[test]
    fn margins_are_those_of_all_paths_on_a_hundred_random_surfaces() {
        let (surface, places) = top();
        let count = surface.nodes.len();
        let noise = reproducible_noise(100 * count);
        for values in noise.chunks_exact(count) {
            let pressure: Vec<f64> = values.iter().map(|x| x.abs()).collect();
            let barrier = Barrier {
                surface: &surface,
                wet: &surface.sources,
                dry: &surface.dry,
                pressure: &pressure,
            };
            let path = barrier.path(&places).expect("the sides are joined");
            let starts = (0..count).filter(|&place| surface.sources[place]);
            let all = starts.map(|at| by_all_paths(&barrier, at, 0.0, &mut vec![false; count]));
            let least = all.fold(f64::INFINITY, f64::min);
            assert_eq!(path.margin.to_bits(), least.to_bits());
            let costs = path.nodes.iter().map(|&place| barrier.cost(place));
            let most = costs.fold(0.0, f64::max);
            assert_eq!(most.to_bits(), path.margin.to_bits());
            let [first, last] = [path.nodes[0], path.nodes[path.nodes.len() - 1]];
            assert!(surface.sources[first] && surface.dry[last]);
            let mut pairs = path.nodes.windows(2);
            assert!(pairs.all(|pair| surface.beside(pair[0]).any(|other| other == pair[1])));
        }
    }

    #[test]
    fn of_paths_with_one_margin_the_shortest_is_told() {
        let (surface, places) = top();
        let barrier = Barrier {
            surface: &surface,
            wet: &surface.sources,
            dry: &surface.dry,
            pressure: &vec![2.0; surface.nodes.len()],
        };
        let path = barrier.path(&places).expect("the sides are joined");
        let ends = path.nodes.windows(2);
        let length: f64 = ends
            .map(|pair| norm(sub(places[pair[0]], places[pair[1]])))
            .sum();
        assert!((path.margin - 2.0).abs() < 1e-15);
        assert!((length - 1.0).abs() < 1e-12, "{length}");
    }

    #[test]
    fn no_path_leads_through_what_is_blocked() {
        let (surface, places) = top();
        let barrier = Barrier {
            surface: &surface,
            wet: &surface.sources,
            dry: &surface.dry,
            pressure: &vec![f64::INFINITY; surface.nodes.len()],
        };
        assert_eq!(barrier.path(&places), None);
    }
}
