//! What is found from neighbours beside searches that know nothing of them.

use super::twins::{points_near, surfaces};
use super::*;
use crate::obstacle::surface::normals::{self, Fitter};
use crate::obstacle::surface::rings::Rings;
use crate::obstacle::surface::triangle;

#[test]
fn facets_across_edges_are_those_of_sorted_edges() {
    for (vertices, facets) in surfaces() {
        let sorted = topology::by_sorting(facets.clone(), vertices.len()).expect("closed");
        let rings = Rings::new(&facets, vertices.len());
        assert_eq!(rings::across(&facets, &rings), Some(sorted.across));
    }
}

#[test]
fn two_facets_with_the_same_corners_are_told_as_twice_and_left_out() {
    let (vertices, mut facets) = icosphere(1);
    let own = vertices.len() as u32;
    let vertices = [
        vertices,
        vec![[3.0, 0.0, 0.0], [4.0, 0.0, 0.0], [3.0, 1.0, 0.0]],
    ]
    .concat();
    facets.extend([[own, own + 1, own + 2], [own, own + 2, own + 1]]);
    let facet = facets.len() - 1;
    let refused = topology::linked(facets.clone(), vertices.len()).expect_err("twice");
    assert_eq!(refused, SurfaceError::Duplicate { facet });
    let surface = TriangulatedSurface::new(vertices, facets).expect("closed without them");
    assert_eq!(surface.left_out().map(|one| one.facets), Some(2));
}

#[test]
fn two_rings_of_neighbours_are_those_of_a_search_through_facets() {
    let mut seen = 0;
    for (vertices, facets) in surfaces() {
        let surface = TriangulatedSurface::new(vertices, facets).expect("closed");
        let flat = normals::flat(&surface);
        let features = normals::features(&surface, &flat, 0.52);
        let rings = Rings::new(surface.facets(), surface.vertices().len());
        let fitter = Fitter::new(&surface, (&flat, &features), &rings);
        for vertex in 0..rings.vertices() as u32 {
            if !fitter.around.is_plain(vertex) {
                continue;
            }
            let ring = rings.of(vertex as usize).iter();
            let ring: Vec<usize> = ring.map(|&facet| facet as usize).collect();
            assert_eq!(fitter.sector(ring[0], vertex), ring);
            let range = fitter.flats.range(&ring);
            if let Some(found) = fitter.around.two_rings(vertex, range) {
                assert_eq!(found, fitter.flooded(&ring, vertex));
                seen += 1;
            }
        }
    }
    assert!(seen > 1000, "{seen}");
}

#[test]
fn points_beside_each_other_have_the_nearest_facets_of_all() {
    let (vertices, facets) = icosphere(3);
    let far = vertices.into_iter().map(|x| add(x, [300.0, -200.0, 900.0]));
    for surface in surfaces().into_iter().chain([(far.collect(), facets)]) {
        for between in [SMOOTH, Interpolation::Facets] {
            let tool = tool(surface.clone(), between);
            let searched = &tool.geometry.searched;
            for point in points_near(&tool) {
                for size in [1e-4, 0.02, 0.4] {
                    let beside = directions(6).map(|d| add(point, scale(size, d)));
                    let points: Vec<[f64; 3]> = beside.collect();
                    let mut batch = vec![Contact::default(); points.len()];
                    tool.probe(&points, Derivatives::Curvature, &mut batch);
                    for (contact, &point) in batch.iter().zip(&points) {
                        assert_eq!(*contact, tool.distance(point), "{point:?}");
                        let x = point.map(|x| x / tool.geometry.unit);
                        let found = searched.nearest_facet(x);
                        let squares = searched.patches.iter();
                        let squares =
                            squares.map(|patch| triangle::nearest(x, patch.corners).square);
                        let least = squares.fold(f64::INFINITY, f64::min);
                        assert_eq!(found.place.square.to_bits(), least.to_bits());
                    }
                }
            }
        }
    }
}
