//! Surfaces with some damage are refused or make a tool, whatever it is.

use super::*;

/// Damaged surfaces.
const CASES: u32 = 3_000;

/// One change of a surface.
#[derive(Clone, Debug)]
enum Damage {
    /// A facet goes.
    Lost(usize),
    /// A facet is turned around.
    Turned(usize),
    /// A facet comes again.
    Twice(usize),
    /// A corner is another vertex.
    Elsewhere(usize, usize, u32),
    /// A vertex lies elsewhere.
    Moved(usize, [f64; 3]),
    /// A vertex lies where another one does, or nearly.
    Onto(usize, usize, f64),
    /// Coordinates are multiplied.
    Scaled(f64),
    /// Coordinates along an axis are.
    Flattened(usize, f64),
}

fn damages() -> impl Strategy<Value = Vec<Damage>> {
    let place = 0..64_usize;
    let factor = prop_oneof![
        Just(1e-300),
        Just(1e-40),
        Just(1e-9),
        Just(1e9),
        Just(1e150),
        Just(1e300),
        Just(0.0),
        Just(-1.0)
    ];
    let number = prop_oneof![-2.0..2.0, Just(f64::NAN), Just(f64::INFINITY), Just(1e200)];
    let one = prop_oneof![
        place.clone().prop_map(Damage::Lost),
        place.clone().prop_map(Damage::Turned),
        place.clone().prop_map(Damage::Twice),
        (place.clone(), 0..3_usize, 0..64_u32).prop_map(|(a, b, c)| Damage::Elsewhere(a, b, c)),
        (place.clone(), prop::array::uniform3(number)).prop_map(|(a, b)| Damage::Moved(a, b)),
        (
            place.clone(),
            place,
            prop_oneof![Just(0.0), Just(1e-15), Just(1e-6)]
        )
            .prop_map(|(a, b, c)| Damage::Onto(a, b, c)),
        factor.clone().prop_map(Damage::Scaled),
        (0..3_usize, factor).prop_map(|(a, b)| Damage::Flattened(a, b)),
    ];
    prop::collection::vec(one, 0..4)
}

fn damage(
    (mut vertices, mut facets): (Vec<[f64; 3]>, Vec<[u32; 3]>),
    all: &[Damage],
) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    for one in all {
        let (of_facets, of_vertices) = (facets.len().max(1), vertices.len());
        match *one {
            Damage::Lost(facet) if !facets.is_empty() => {
                facets.swap_remove(facet % of_facets);
            }
            Damage::Lost(_) => (),
            Damage::Turned(facet) => {
                if let Some(corners) = facets.get_mut(facet % of_facets) {
                    corners.swap(0, 1);
                }
            }
            Damage::Twice(facet) => facets.extend(facets.get(facet % of_facets).copied()),
            Damage::Elsewhere(facet, corner, vertex) => {
                if let Some(corners) = facets.get_mut(facet % of_facets) {
                    corners[corner] = vertex;
                }
            }
            Damage::Moved(vertex, place) => vertices[vertex % of_vertices] = place,
            Damage::Onto(vertex, other, apart) => {
                let place = vertices[other % of_vertices].map(|x| x + apart);
                vertices[vertex % of_vertices] = place;
            }
            Damage::Scaled(factor) => vertices
                .as_flattened_mut()
                .iter_mut()
                .for_each(|x| *x *= factor),
            Damage::Flattened(axis, factor) => {
                vertices.iter_mut().for_each(|place| place[axis] *= factor);
            }
        }
    }
    (vertices, facets)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(CASES))]

    #[test]
    fn a_damaged_surface_is_refused_or_makes_a_tool(
        kind in 0..3_usize,
        all in damages(),
        point in prop::array::uniform3(-2.0..2.0),
        is_smooth in any::<bool>(),
    ) {
        let whole = match kind {
            0 => cuboid([1.0, 0.5, 0.7]),
            1 => icosphere(0),
            _ => icosphere(1),
        };
        let (vertices, facets) = damage(whole, &all);
        match TriangulatedSurface::new(vertices, facets) {
            Ok(surface) => {
                let between = if is_smooth { SMOOTH } else { Interpolation::Facets };
                let shape = SurfaceShape { surface: surface.into(), scale: 1.0, between };
                let tool = Triangulated::new(&shape, 1.0).expect("a tool");
                let size = tool.geometry.unit;
                let found = tool.distance(point.map(|x| x * size));
                prop_assert!(found.distance.is_finite(), "{found:?}");
                prop_assert!((norm(found.normal) - 1.0).abs() < 1e-6, "{found:?}");
                prop_assert!(found.curvature.as_flattened().iter().all(|x| x.is_finite()));
            }
            Err(error) => prop_assert!(!error.to_string().is_empty()),
        }
    }
}
