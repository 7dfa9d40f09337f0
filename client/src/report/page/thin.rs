//! Fewer nodes: first those that no triangle has, then by cells of a grid of which each
//! keeps its first node.

use std::collections::HashMap;

use super::shape::{Surface, Vector};

/// Growth of the grid's cells from try to try.
const GROWTH: f64 = 1.25;

/// The surface with its used nodes only, in their order.
pub(super) fn used(surface: Surface) -> Surface {
    let mut is_used = vec![false; surface.points.len()];
    for node in surface.triangles.as_flattened() {
        if let Some(used) = is_used.get_mut(*node as usize) {
            *used = true;
        }
    }
    let kept: Vec<usize> = (0..surface.points.len())
        .filter(|node| is_used.get(*node).copied().unwrap_or_default())
        .collect();
    let mut new = vec![u32::MAX; surface.points.len()];
    for (index, node) in kept.iter().enumerate() {
        if let Some(place) = new.get_mut(*node) {
            *place = index as u32;
        }
    }
    renumbered(&surface, &kept, &new)
}

/// The surface with at most so many nodes.
pub(super) fn to(mut surface: Surface, most: usize) -> Surface {
    let (low, high) = bounds(&surface.points);
    let mut size = {
        let extent = low.iter().zip(high).map(|(low, high)| high - low);
        // As many cells as nodes may stay of a flat sheet; of a body they grow.
        extent.fold(0.0, f64::max) / (most as f64).sqrt()
    };
    while surface.points.len() > most && size > 0.0 {
        surface = gathered(&surface, low, size);
        size *= GROWTH;
    }
    surface
}

/// Each cell of the grid keeps its first node.
fn gathered(surface: &Surface, low: Vector, size: f64) -> Surface {
    let mut cells: HashMap<[i64; 3], u32> = HashMap::new();
    let (mut kept, mut new) = (Vec::new(), Vec::with_capacity(surface.points.len()));
    for (node, [x, y, z]) in surface.points.iter().enumerate() {
        let [lx, ly, lz] = low;
        let cell = [x - lx, y - ly, z - lz].map(|offset| (offset / size) as i64);
        let next = kept.len() as u32;
        let index = *cells.entry(cell).or_insert(next);
        if index == next {
            kept.push(node);
        }
        new.push(index);
    }
    renumbered(surface, &kept, &new)
}

/// The kept nodes, and the triangles that are left of the old ones.
fn renumbered(surface: &Surface, kept: &[usize], new: &[u32]) -> Surface {
    let new_of = |node: u32| new.get(node as usize).copied().unwrap_or_default();
    let mut triangles: Vec<[u32; 3]> = surface
        .triangles
        .iter()
        .map(|triangle| triangle.map(new_of))
        .filter(|[a, b, c]| a != b && b != c && c != a)
        .collect();
    let mut seen = std::collections::HashSet::new();
    triangles.retain(|triangle| {
        let mut corners = *triangle;
        corners.sort_unstable();
        seen.insert(corners)
    });
    let rim = surface.rim.iter().map(|edge| edge.map(new_of));
    Surface {
        points: picked(&surface.points, kept),
        displacement: surface.displacement.as_ref().map(|all| picked(all, kept)),
        fields: surface
            .fields
            .iter()
            .map(|(name, values)| (name.clone(), picked(values, kept)))
            .collect(),
        triangles,
        rim: rim.filter(|[from, to]| from != to).collect(),
    }
}

fn picked<T: Copy>(all: &[T], kept: &[usize]) -> Vec<T> {
    kept.iter()
        .filter_map(|node| all.get(*node).copied())
        .collect()
}

/// The box around points.
pub(super) fn bounds(points: &[Vector]) -> (Vector, Vector) {
    let empty = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    points.iter().fold(empty, |(mut low, mut high), point| {
        for ((low, high), x) in low.iter_mut().zip(&mut high).zip(point) {
            *low = low.min(*x);
            *high = high.max(*x);
        }
        (low, high)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A flat sheet of squares, two triangles each, and one node that none has.
    fn sheet(side: u32) -> Surface {
        let node = |x: u32, y: u32| y * (side + 1) + x;
        let mut surface = Surface::default();
        for y in 0..=side {
            for x in 0..=side {
                surface.points.push([f64::from(x), f64::from(y), 0.0]);
            }
        }
        surface.points.push([9e9; 3]);
        for y in 0..side {
            for x in 0..side {
                let corners = [
                    node(x, y),
                    node(x + 1, y),
                    node(x + 1, y + 1),
                    node(x, y + 1),
                ];
                let [a, b, c, d] = corners;
                surface.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        let heights = surface.points.iter().map(|point| point[1]).collect();
        surface.fields = vec![("height".to_owned(), heights)];
        surface
    }

    #[test]
    fn nodes_without_triangles_go_first() {
        let surface = used(sheet(3));
        assert_eq!((surface.points.len(), surface.triangles.len()), (16, 18));
    }

    #[test]
    fn a_large_sheet_becomes_a_small_one_with_its_field() {
        let surface = to(used(sheet(100)), 1000);
        assert!(surface.points.len() <= 1000 && surface.points.len() > 200);
        assert!(surface.triangles.len() > 300);
        let (_, heights) = &surface.fields[0];
        for (point, height) in surface.points.iter().zip(heights) {
            assert!((point[1] - height).abs() < 1e-15);
        }
        let nodes = surface.points.len() as u32;
        assert!(
            surface
                .triangles
                .as_flattened()
                .iter()
                .all(|node| *node < nodes)
        );
    }
}
