use std::collections::BTreeSet;

use proptest::prelude::*;

use super::*;
use crate::geometry::vector3::{cross, norm, sub};
use crate::linalg::vector::reproducible_noise;
use crate::mesh::quality::mean_ratio;
use crate::mesh::samples::{cube, cube_parts, rectangle, rectangle_parts};

/// Numbers from zero to one.
struct Noise(Vec<f64>);

impl Noise {
    fn new() -> Self {
        Self(
            reproducible_noise(4096)
                .iter()
                .map(|x| 0.5 * (x + 1.0))
                .collect(),
        )
    }

    fn next(&mut self) -> f64 {
        self.0.rotate_left(1);
        self.0[0]
    }

    /// Weights of a point of a simplex with that many vertices.
    fn inside(&mut self, vertices: usize) -> Vec<f64> {
        let raw: Vec<f64> = (0..vertices).map(|_| 0.05 + self.next()).collect();
        let sum: f64 = raw.iter().sum();
        raw.iter().map(|x| x / sum).collect()
    }
}

fn volume(mesh: &Mesh) -> f64 {
    let cells = 0..mesh.cell_count();
    cells
        .map(|cell| mesh.cell_kind().signed_measure(&mesh.corners(cell)))
        .sum()
}

fn area(mesh: &Mesh, facet: &[u32]) -> f64 {
    let at = |i: usize| mesh.coordinates()[facet[i] as usize];
    match facet.len() {
        2 => norm(sub(at(1), at(0))),
        _ => 0.5 * norm(cross(sub(at(1), at(0)), sub(at(2), at(0)))),
    }
}

fn surface(mesh: &Mesh) -> f64 {
    let width = mesh.cell_kind().facet_vertices();
    let facets = mesh.boundary_facets().iter();
    facets
        .map(|facet| area(mesh, &facet.vertices[..width]))
        .sum()
}

fn group_sizes(mesh: &Mesh) -> Vec<f64> {
    let of_member = |kind: GroupKind, member: u32| match kind {
        GroupKind::Cells => mesh
            .cell_kind()
            .signed_measure(&mesh.corners(member as usize)),
        GroupKind::Facets => area(mesh, mesh.facet(member as usize)),
    };
    let groups = mesh.groups().iter();
    groups
        .map(|group| {
            group
                .members
                .iter()
                .map(|&m| of_member(group.kind, m))
                .sum()
        })
        .collect()
}

fn hierarchy(mesh: Mesh) -> Hierarchy {
    Hierarchy::new(Arc::new(mesh))
}

fn refine(hierarchy: &Hierarchy, marked: &[u32]) -> Refined {
    hierarchy
        .refine(marked, Limits::default())
        .expect("it is within the limits")
}

/// Cells that have a corner within `radius` of a point.
fn near(mesh: &Mesh, point: [f64; 3], radius: f64) -> Vec<u32> {
    let is_near = |&cell: &u32| {
        let corners = mesh.cell(cell as usize).iter();
        let mut points = corners.map(|&v| mesh.coordinates()[v as usize]);
        points.any(|corner| norm(sub(corner, point)) <= radius)
    };
    (0..mesh.cell_count() as u32).filter(is_near).collect()
}

/// Volume, surface and groups as before: a vertex that hangs on an edge or a facet would leave
/// facets of one cell inside the body.
fn assert_conforming(before: &Mesh, after: &Mesh) {
    let whole = volume(before);
    assert!(
        (volume(after) - whole).abs() < 1e-13 * whole,
        "{}",
        volume(after) - whole
    );
    let whole = surface(before);
    assert!(
        (surface(after) - whole).abs() < 1e-12 * whole,
        "a vertex hangs"
    );
    for (was, is) in group_sizes(before).iter().zip(group_sizes(after)) {
        assert!((was - is).abs() < 1e-12 * was, "{was} {is}");
    }
    assert!(after.warnings().is_empty(), "{:?}", after.warnings());
}

fn samples() -> [MeshParts; 3] {
    [cube_parts(1), cube_parts(2), rectangle_parts(3, 2)]
}

/// The same with vertices inside moved, so that no two edges are equally long.
fn shaken(mut parts: MeshParts, seed: u64) -> MeshParts {
    let noise = reproducible_noise(3 * parts.coordinates.len() + 64);
    let noise = &noise[(seed % 64) as usize..];
    for (vertex, point) in parts.coordinates.iter_mut().enumerate() {
        for (axis, x) in point.iter_mut().enumerate() {
            if *x > 1e-9 && *x < 1.0 - 1e-9 {
                *x += 0.08 * noise[3 * vertex + axis];
            }
        }
    }
    parts
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_marks_leave_no_hanging_vertex_and_keep_volume_and_groups(
        sample in 0_usize..3,
        seed in 0_u64..1000,
        rounds in prop::collection::vec(prop::collection::vec(any::<prop::sample::Index>(), 1..40), 1..6),
    ) {
        let [first, second, third] = samples();
        let parts = shaken([first, second, third][sample].clone(), seed);
        let mesh = Mesh::new(parts).expect("a valid sample");
        let mut present = hierarchy(mesh.clone());
        for round in rounds {
            let cells = present.mesh().cell_count();
            let marked: Vec<u32> = round.iter().map(|index| index.index(cells) as u32).collect();
            let next = refine(&present, &marked);
            let of_marked: BTreeSet<u32> = marked.iter().copied().collect();
            for cell in of_marked {
                let halves = next.lineage.cells().iter().filter(|&&origin| origin == cell);
                prop_assert!(halves.count() >= 2);
            }
            present = next.hierarchy;
            assert_conforming(&mesh, present.mesh());
        }
    }
}

#[test]
fn twenty_levels_of_local_refinement_keep_half_of_the_quality() {
    for parts in [rectangle_parts(3, 2), cube_parts(2)] {
        for seed in 0..4 {
            let parts = if seed == 0 {
                parts.clone()
            } else {
                shaken(parts.clone(), seed)
            };
            let mesh = Mesh::new(parts).expect("a valid sample");
            let start = mesh.quality().minimum;
            let mut present = hierarchy(mesh.clone());
            let mut radius = 0.3;
            for _ in 0..20 {
                let marked = near(present.mesh(), [0.0, 0.5, 0.0], radius);
                let refined = present.halve(&marked, Limits::default());
                present = refined.expect("it is within the limits").hierarchy;
                radius *= 0.5;
            }
            assert_conforming(&mesh, present.mesh());
            let least = present.mesh().quality().minimum;
            assert!(least >= 0.5 * start, "{least} from {start}, seed {seed}");
        }
    }
}

/// Shapes up to size and rotation, as sorted squares of edges over the largest.
fn classes(mesh: &Mesh) -> BTreeSet<Vec<i64>> {
    let shape = |cell: usize| {
        let corners = mesh.corners(cell);
        let pairs = mesh.cell_kind().edges().iter();
        let squares = pairs.map(|&(a, b)| norm(sub(corners[a], corners[b])).powi(2));
        let mut squares: Vec<f64> = squares.collect();
        squares.sort_by(f64::total_cmp);
        let largest = squares[squares.len() - 1];
        squares
            .iter()
            .map(|s| (1e9 * s / largest).round() as i64)
            .collect()
    };
    (0..mesh.cell_count()).map(shape).collect()
}

#[test]
fn uniform_bisection_makes_a_bounded_number_of_shapes() {
    let flat = [[0.0; 3], [1.0, 0.0, 0.0], [0.3, 0.7, 0.0]];
    let solid = [[0.0; 3], [1.0, 0.1, 0.0], [0.3, 0.8, 0.1], [0.2, 0.4, 0.9]];
    for (kind, points, most) in [
        (CellKind::Triangle, &flat[..], 4),
        (CellKind::Tetrahedron, &solid[..], 36),
    ] {
        let mesh = Mesh::new(MeshParts {
            cell_kind: kind,
            coordinates: points.to_vec(),
            cells: (0..points.len() as u32).collect(),
            facets: Vec::new(),
            groups: Vec::new(),
        });
        let mut present = hierarchy(mesh.expect("a valid cell"));
        let mut found = classes(present.mesh());
        let mut counts = Vec::new();
        for _ in 0..12 {
            let all: Vec<u32> = (0..present.mesh().cell_count() as u32).collect();
            present = refine(&present, &all).hierarchy;
            found.extend(classes(present.mesh()));
            counts.push(found.len());
        }
        assert!(found.len() <= most, "{counts:?}");
        assert_eq!(counts[8], counts[11], "{counts:?}");
    }
}

/// The middle of the square's lower side and the cube's lower face, bent.
fn bent(parts: MeshParts) -> Mesh {
    let mesh = Mesh::new(parts.clone()).expect("a valid sample");
    let low = parts.cell_kind.dimension() - 1;
    let on_side = |&v: &u32| mesh.coordinates()[v as usize][low] < 1e-9;
    let edges = mesh.edges().iter().filter(|ends| ends.iter().all(on_side));
    let offset = |&ends: &[u32; 2]| {
        let mut offset = [0.0; 3];
        offset[low] = -0.02;
        offset[0] = 0.01;
        EdgeOffset { ends, offset }
    };
    Mesh::second_order(parts, edges.map(offset).collect()).expect("a valid sample")
}

fn value(mesh: &Mesh, field: &[f64], cell: usize, l: &[f64]) -> f64 {
    let corners = mesh.cell(cell).iter().zip(l);
    let linear: f64 = corners.map(|(&v, l)| l * field[v as usize]).sum();
    let edges = mesh.cell_kind().edges().iter();
    let width = mesh.cell_kind().edges().len();
    let own = &mesh.cell_edges()[cell * width..];
    let vertices = mesh.coordinates().len();
    let bubbles = edges.zip(own);
    let bubble = |(&(a, b), &edge): (&(usize, usize), &u32)| {
        4.0 * l[a] * l[b] * field[vertices + edge as usize]
    };
    linear + bubbles.map(bubble).sum::<f64>()
}

/// Two rounds of refinement of `mesh`, where it is curved too.
fn twice(mesh: &Mesh) -> [Refined; 2] {
    let first = refine(&hierarchy(mesh.clone()), &[0, 3]);
    let few: Vec<u32> = (0..first.hierarchy.mesh().cell_count() as u32)
        .step_by(3)
        .collect();
    let second = refine(&first.hierarchy, &few);
    [first, second]
}

#[test]
fn quadratic_fields_and_curved_cells_keep_their_values() {
    for mesh in [
        cube(2),
        rectangle(3, 2),
        bent(cube_parts(2)),
        bent(rectangle_parts(3, 2)),
    ] {
        let nodes = mesh.coordinates().len() + mesh.edges().len();
        let field = reproducible_noise(nodes);
        let [first, second] = twice(&mesh);
        let on_first = first.lineage.quadratic(&field, 1);
        let on_second = second.lineage.quadratic(&on_first, 1);
        let fine = second.hierarchy.mesh();
        let mut noise = Noise::new();
        let width = mesh.cell_kind().vertices();
        for cell in 0..fine.cell_count() {
            let origin = first.lineage.cells()[second.lineage.cells()[cell] as usize] as usize;
            let l = noise.inside(width);
            // The ancestor's barycentric coordinates are P1 fields.
            let above: Vec<f64> = mesh
                .cell(origin)
                .iter()
                .map(|&vertex| {
                    let mut hat = vec![0.0; mesh.coordinates().len()];
                    hat[vertex as usize] = 1.0;
                    let hat = second.lineage.linear(&first.lineage.linear(&hat));
                    fine.cell(cell)
                        .iter()
                        .zip(&l)
                        .map(|(&v, l)| l * hat[v as usize])
                        .sum()
                })
                .collect();
            let difference =
                value(fine, &on_second, cell, &l) - value(&mesh, &field, origin, &above);
            assert!(difference.abs() < 1e-14, "{difference}");
            let way = sub(fine.position_in(cell, &l), mesh.position_in(origin, &above));
            assert!(norm(way) < 1e-15, "{way:?}");
        }
    }
}

#[test]
fn facets_know_their_places_and_contact_pressures_stay_above_zero() {
    for mesh in [cube(2), rectangle(3, 2)] {
        let [first, second] = twice(&mesh);
        let middle = first.hierarchy.mesh();
        let fine = second.hierarchy.mesh();
        for (facet, origin) in second.lineage.facets().iter().enumerate() {
            let above = middle.facet(origin.facet as usize);
            for (&vertex, row) in fine.facet(facet).iter().zip(&origin.corners) {
                assert!(row.iter().all(|share| *share >= 0.0));
                assert!((row.iter().sum::<f64>() - 1.0).abs() < 1e-15);
                let mut place = [0.0; 3];
                for (&corner, share) in above.iter().zip(row) {
                    let corner = middle.coordinates()[corner as usize];
                    (0..3).for_each(|i| place[i] += share * corner[i]);
                }
                assert!(norm(sub(place, fine.coordinates()[vertex as usize])) < 1e-15);
            }
        }
        assert!(second.lineage.facets().len() > middle.facet_count());
    }
}

#[test]
fn refinement_stops_at_its_limits_and_names_what_is_wrong() {
    let start = hierarchy(cube(2));
    let cells = start.mesh().cell_count();
    let all: Vec<u32> = (0..cells as u32).collect();
    let few = Limits {
        cells: 2 * cells - 1,
        ..Limits::default()
    };
    let refused = start.refine(&all, few).expect_err("it is too many");
    assert_eq!(
        refused,
        RefinementError::TooManyCells {
            limit: 2 * cells - 1
        }
    );
    let little = Limits {
        bytes: 1000,
        ..Limits::default()
    };
    let refused = start.refine(&[0], little).expect_err("it is too much");
    assert!(matches!(
        refused,
        RefinementError::TooMuchMemory { limit: 1000 }
    ));
    let refused = start
        .refine(&[cells as u32], Limits::default())
        .expect_err("no such cell");
    assert!(
        refused
            .to_string()
            .contains("is marked, but the mesh has 48 cells"),
        "{refused}"
    );
    let same = refine(&start, &[]);
    assert_eq!(same.hierarchy.mesh().id(), start.mesh().id());
}

#[test]
fn whole_halvings_make_no_cell_finer_than_it_is_asked_to_be() {
    for seed in 1..6 {
        let parts = shaken(cube_parts(3), seed);
        let mut present = hierarchy(Mesh::new(parts).expect("a valid sample"));
        for level in 1..4 {
            let marked = near(present.mesh(), [0.5; 3], 0.4);
            let halved = present.halve(&marked, Limits::default());
            present = halved.expect("it is within the limits").hierarchy;
            let generations = present.cells.iter().map(|marks| marks.generation);
            assert_eq!(generations.max(), Some(3 * level));
        }
    }
}

#[test]
fn values_of_cells_go_to_their_halves() {
    let start = hierarchy(rectangle(2, 2));
    let refined = refine(&start, &[0, 5]);
    let values: Vec<u32> = (0..start.mesh().cell_count() as u32).collect();
    assert_eq!(refined.lineage.of_cells(&values), refined.lineage.cells());
    assert!(refined.lineage.cells().is_sorted());
    assert!(mean_ratio(CellKind::Triangle, &refined.hierarchy.mesh().corners(0)) > 0.5);
}
