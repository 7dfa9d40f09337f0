//! Parts that cross, nest or touch against their union, and facets that bound nothing.

use super::*;
use crate::obstacle::surface::mend::LeftOut;

type Raw = (Vec<[f64; 3]>, Vec<[u32; 3]>);

fn shifted((mut vertices, facets): Raw, by: [f64; 3]) -> Raw {
    vertices
        .iter_mut()
        .for_each(|place| *place = add(*place, by));
    (vertices, facets)
}

fn turned((vertices, mut facets): Raw) -> Raw {
    facets.iter_mut().for_each(|corners| corners.swap(0, 1));
    (vertices, facets)
}

fn joined(parts: &[Raw]) -> Raw {
    let (mut vertices, mut facets): Raw = (Vec::new(), Vec::new());
    for (places, corners) in parts {
        let first = vertices.len() as u32;
        vertices.extend(places);
        facets.extend(corners.iter().map(|own| own.map(|vertex| vertex + first)));
    }
    (vertices, facets)
}

/// Points on and around a box of these half sizes, no deeper than `depth`.
fn around(half: [f64; 3], depth: f64) -> impl Iterator<Item = [f64; 3]> {
    let places = (0..11_u32).flat_map(|i| (0..11_u32).map(move |j| [i, j]));
    places.flat_map(move |place| {
        let [u, v] = place.map(|step| f64::from(step) / 5.0 - 1.0);
        [-depth, 0.3 * depth, 0.2].into_iter().flat_map(move |out| {
            [
                [u * 0.97 * half[0], v * 0.97 * half[1], half[2] + out],
                [half[0] + out, u * 0.97 * half[1], v * 0.97 * half[2]],
            ]
        })
    })
}

#[test]
fn parts_that_cross_or_nest_are_their_union() {
    let whole = tool(cuboid([1.0, 0.5, 0.5]), Interpolation::Facets);
    let half = cuboid([0.6, 0.5, 0.5]);
    let crossing = joined(&[
        shifted(half.clone(), [-0.4, 0.0, 0.0]),
        shifted(half, [0.4, 0.0, 0.0]),
    ]);
    let nested = joined(&[
        cuboid([1.0, 0.5, 0.5]),
        shifted(cuboid([0.3, 0.2, 0.2]), [0.5, 0.1, 0.29]),
    ]);
    for parts in [crossing, nested] {
        let tool = tool(parts, Interpolation::Facets);
        for point in around([1.0, 0.5, 0.5], 0.05) {
            let (found, exact) = (tool.distance(point), whole.distance(point));
            let error = (found.distance - exact.distance).abs();
            assert!(error < 1e-12, "{point:?} {found:?} {exact:?}");
        }
        let centre = tool.distance([0.0; 3]).distance;
        assert!((-0.5..-0.19).contains(&centre), "{centre}");
    }
}

#[test]
fn parts_that_share_a_side_are_one() {
    // The side between them is there twice, in either direction.
    let (vertices, facets) = cuboid([0.5; 3]);
    let mut all = vertices.clone();
    let mut place = |vertex: u32| {
        let moved = add(vertices[vertex as usize], [1.0, 0.0, 0.0]);
        let known = all
            .iter()
            .position(|other| norm(sub(*other, moved)) < 1e-12);
        known.unwrap_or_else(|| {
            all.push(moved);
            all.len() - 1
        }) as u32
    };
    // Seen in a mirror, so that the triangles of the common side are the same.
    let mirror = |vertex: u32| vertex ^ 1;
    let others = facets.iter().map(|corners| corners.map(mirror));
    let others: Vec<[u32; 3]> = others.map(|[a, b, c]| [a, c, b].map(&mut place)).collect();
    let both = [facets, others].concat();
    let surface = TriangulatedSurface::new(all, both).expect("closed");
    let left_out = surface.left_out().expect("the side between them");
    assert_eq!((left_out.facets, surface.facets().len()), (4, 20));
}

#[test]
fn a_part_seen_from_inside_is_a_hole_of_the_part_around_it() {
    let shell = [cuboid([1.0; 3]), turned(cuboid([0.5; 3]))];
    let beside = shifted(cuboid([0.4; 3]), [1.2, 0.0, 0.0]);
    for parts in [
        joined(&shell),
        joined(&[shell[0].clone(), beside, shell[1].clone()]),
    ] {
        let tool = tool(parts, Interpolation::Facets);
        for (point, distance) in [
            ([0.0; 3], 0.5),
            ([0.75, 0.0, 0.0], -0.25),
            ([0.0, 0.0, 1.5], 0.5),
        ] {
            let found = tool.distance(point).distance;
            assert!((found - distance).abs() < 1e-12, "{point:?} {found}");
        }
    }
    let lost = joined(&[
        cuboid([1.0; 3]),
        shifted(cuboid([1.0; 3]), [0.5; 3]),
        shifted(turned(cuboid([0.5; 3])), [9.0, 0.0, 0.0]),
    ]);
    let refused = TriangulatedSurface::new(lost.0, lost.1).expect_err("a hole of nothing");
    assert_eq!(refused, SurfaceError::InsideOutPart { facet: 24 });
}

#[test]
fn facets_that_bound_nothing_are_left_out() {
    let (mut vertices, facets) = cuboid([1.0; 3]);
    // A vertex on an edge, with a facet along it that closes the surface.
    let [a, b, c] = facets[0];
    let ends = [a, b].map(|vertex| vertices[vertex as usize]);
    vertices.push(scale(0.5, add(ends[0], ends[1])));
    let middle = vertices.len() as u32 - 1;
    let mut flat = facets.clone();
    flat.splice(0..1, [[a, middle, c], [middle, b, c], [a, b, middle]]);
    let collapsed = [vec![[a, a, b]], facets.clone()].concat();
    let twice = [facets.clone(), vec![[b, c, a]]].concat();
    let fin = [facets, vec![[0, 3, 5], [5, 3, 0]]].concat();
    for (raw, left_out) in [
        (flat, (1, 2)),
        (collapsed, (1, 0)),
        (twice, (1, 12)),
        (fin, (2, 12)),
    ] {
        let surface = TriangulatedSurface::new(vertices.clone(), raw).expect("closed");
        let (facets, first) = left_out;
        assert_eq!(surface.left_out(), Some(LeftOut { facets, first }));
        let shape = SurfaceShape {
            surface: surface.into(),
            scale: 1.0,
            between: SMOOTH,
        };
        let tool = Triangulated::new(&shape, 1.0).expect("a tool");
        let found = tool.distance([0.3, 0.2, 1.5]).distance;
        assert!((found - 0.5).abs() < 1e-12, "{found}");
    }
}

#[test]
fn a_surface_of_facets_that_bound_nothing_is_empty() {
    let (vertices, _) = cuboid([1.0; 3]);
    for facets in [vec![[0, 1, 1]], vec![[0, 1, 2], [2, 1, 0]]] {
        let refused = TriangulatedSurface::new(vertices.clone(), facets).expect_err("empty");
        assert_eq!(refused, SurfaceError::Empty);
    }
}
