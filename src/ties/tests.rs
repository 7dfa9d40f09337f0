//! Rows of ties against closed integrals.

use super::{Seam, Sides, Tied};
use crate::contact::basis::Bernstein;
use crate::contact::layout::Layout;
use crate::contact::{ContactSurface, Deformed, Measure};
use crate::element::quadrature::{Simplex, rule};
use crate::mesh::{CellKind, Group, GroupKind, Mesh, MeshParts, samples};
use crate::space::TaylorHood;

/// A grid on a grid: facets `0..` of the upper one, then of the lower one along y = `height(x)`.
fn two(faces: [usize; 2], height: impl Fn(f64) -> f64) -> (Mesh, [Vec<u32>; 2]) {
    let (mut coordinates, mut cells, mut facets) = (Vec::new(), Vec::new(), Vec::new());
    let mut sides = [Vec::new(), Vec::new()];
    for (body, count) in faces.into_iter().enumerate() {
        let first = coordinates.len() as u32;
        let up = if body == 0 { 0.4 } else { -0.4 };
        for i in 0..=count {
            let x = i as f64 / count as f64;
            coordinates.push([x, height(x), 0.0]);
            coordinates.push([x, height(x) + up, 0.0]);
        }
        for i in 0..count as u32 {
            let [a, b, c, d] = [0, 1, 2, 3].map(|k| first + 2 * i + k);
            cells.extend([a, c, d, a, d, b]);
            sides[body].push(facets.len() as u32 / 2);
            facets.extend([a, c]);
        }
    }
    let groups = vec![Group {
        name: "body".to_owned(),
        kind: GroupKind::Cells,
        members: (0..cells.len() as u32 / 3).collect(),
    }];
    let parts = MeshParts {
        cell_kind: CellKind::Triangle,
        coordinates,
        cells,
        facets,
        groups,
    };
    (Mesh::new(parts).expect("a mesh"), sides)
}

fn seam(mesh: &Mesh, [carrier, other]: &[Vec<u32>; 2]) -> (Seam, ContactSurface, Layout) {
    let space = TaylorHood::new(mesh);
    let corners = carrier.iter().map(|&f| mesh.facet(f as usize).to_vec());
    let corners: Vec<Vec<u32>> = corners.collect();
    let base = Layout::of_sides(mesh, &space, carrier);
    let surface = ContactSurface::new(mesh, &space, 1.0, &corners);
    let surface = surface.with_layout(&Bernstein, base.clone());
    let sides = Sides {
        surface: &surface,
        other,
    };
    (Seam::new((mesh, &space), sides), surface, base)
}

/// Values of a field at nodes, hierarchical.
fn nodal(mesh: &Mesh, field: impl Fn([f64; 3]) -> f64) -> Vec<f64> {
    let space = TaylorHood::new(mesh);
    let value = |node: u32| field(space.node_place(mesh, node));
    let mut all: Vec<f64> = (0..space.nodes() as u32).map(value).collect();
    for (edge, &[a, b]) in space.edges.iter().enumerate() {
        all[space.vertices + edge] -= 0.5 * (all[a as usize] + all[b as usize]);
    }
    all
}

#[test]
fn a_linear_field_meets_the_equations_on_curved_facets_that_do_not_match() {
    let wave = |x: f64| 0.1 * (3.0 * x).sin();
    for faces in [[7, 5], [4, 9]] {
        let (mesh, sides) = two(faces, wave);
        let (seam, surface, _) = seam(&mesh, &sides);
        let values = nodal(&mesh, |[x, y, _]| 0.3 + 2.0 * x - 5.0 * y);
        for (own, other) in seam.own.iter().zip(&seam.other) {
            let at = |row: &[(u32, f64)]| -> f64 {
                row.iter().map(|&(node, w)| w * values[node as usize]).sum()
            };
            assert!((at(own) - at(other)).abs() < 1e-14);
        }
        assert!((seam.share(&surface) - 1.0).abs() < 1e-13);
        let gap = seam.gap.expect("facets that do not match").width;
        assert!(gap > 1e-3 && gap < 1e-2, "{gap}");
    }
}

#[test]
fn rows_are_the_integrals_of_products_on_the_common_refinement() {
    let (mesh, sides) = two([5, 3], |_| 0.0);
    let (seam, surface, _) = seam(&mesh, &sides);
    let field = |[x, y, _]: [f64; 3]| 1.0 - x + x * x + y;
    let values = nodal(&mesh, field);
    for rows in [&seam.own, &seam.other] {
        let mut sum = 0.0;
        for row in rows {
            sum += row
                .iter()
                .map(|&(node, w)| w * values[node as usize])
                .sum::<f64>();
        }
        let rule = rule(Simplex::Segment, 4);
        let points = rule.points.iter().zip(&rule.weights);
        let exact: f64 = points.map(|(l, w)| w * field([l[1], 0.0, 0.0])).sum();
        assert!((sum - exact).abs() < 1e-14, "{sum} {exact}");
    }
    let whole: f64 = surface.weights.iter().sum();
    assert!((whole - 1.0).abs() < 1e-14);
}

#[test]
fn forces_of_a_tie_have_no_sum_and_no_moment() {
    let (mesh, sides) = two([7, 5], |x| 0.1 * (3.0 * x).sin());
    let space = TaylorHood::new(&mesh);
    let (seam, _, base) = seam(&mesh, &sides);
    // Turned by 1.
    let (sine, cosine) = 1.0_f64.sin_cos();
    let along = [
        nodal(&mesh, |[x, y, _]| (cosine - 1.0) * x - sine * y),
        nodal(&mesh, |[x, y, _]| sine * x + (cosine - 1.0) * y),
    ];
    let unknowns = 0..space.displacement_unknowns();
    let displacement: Vec<f64> = unknowns.map(|k| along[k % 2][k / 2]).collect();
    let rule = rule(Simplex::Segment, 4);
    let body = Deformed {
        mesh: &mesh,
        scale: 1.0,
        space: &space,
        displacement: &displacement,
        rule: &rule,
        measure: Measure::Undeformed,
    };
    let mut sums = [[0.0; 3]; 2];
    for component in [0, 1] {
        let one = Tied::new(&seam, &base, [component, 2]);
        let gaps = one.gaps(&displacement);
        assert!(gaps.iter().all(|gap| gap.abs() < 1e-14));
        let tractions: Vec<f64> = (0..gaps.len()).map(|k| (3.0 * k as f64).cos()).collect();
        let found = one.forces(&body, &tractions);
        let both = found.on_carrier.iter().zip(&found.on_other);
        for (sum, (a, b)) in sums.iter_mut().zip(both) {
            (0..3).for_each(|i| sum[i] += a[i] + b[i]);
        }
    }
    let all = sums.as_flattened();
    assert!(all.iter().all(|x| x.abs() < 1e-13), "{sums:?}");
}

#[test]
fn surfaces_that_are_far_apart_have_no_partner() {
    let mesh = samples::rectangle(2, 1);
    let group = |name: &str| {
        let group = mesh.group(name, GroupKind::Facets).expect("a side");
        group.members.clone()
    };
    let (seam, surface, _) = seam(&mesh, &[group("y0"), group("y1")]);
    assert!(seam.share(&surface) <= 0.0);
    assert_eq!(seam.gap, None);
}
