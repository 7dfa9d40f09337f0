//! Cells with curved edges: fields that are linear in space are exact, an even pressure has no
//! force inside, and forces and tangents are derivatives of the energy.

use std::sync::Arc;

use super::*;
use crate::assembly::strain::{CellLaws, Linearised, Mixed, StrainGrid};
use crate::element::curved_cell::CurvedCell;
use crate::geometry::rigid_motion::rotation_matrix;
use crate::geometry::tensor::{plus, plus_unit};
use crate::material::{InvariantLaw, Isochoric, Rubber};
use crate::mesh::EdgeOffset;

const LAW: Rubber = Rubber {
    isochoric: Isochoric::Invariants(InvariantLaw {
        c10: 0.3,
        c01: 0.2,
        c20: 0.0,
        c30: 0.0,
    }),
    inverse_bulk: 0.1,
};

/// Edges of the surface bent at random, by some tenths of their lengths.
fn bent(parts: MeshParts) -> Sample {
    let mesh = Mesh::new(parts).expect("a valid sample");
    let noise = reproducible_noise(3 * mesh.edges().len());
    let components = mesh.cell_kind().dimension();
    let offsets = mesh
        .edges()
        .iter()
        .zip(noise.chunks_exact(3))
        .map(|(&ends, noise)| {
            let along = |i: usize| if i < components { 0.03 * noise[i] } else { 0.0 };
            EdgeOffset {
                ends,
                offset: [along(0), along(1), along(2)],
            }
        });
    let mesh = Mesh::second_order(mesh_parts(&mesh), offsets.collect()).expect("a valid sample");
    assert!(!mesh.edge_offsets().is_empty());
    Sample::of(mesh)
}

fn mesh_parts(mesh: &Mesh) -> MeshParts {
    MeshParts {
        cell_kind: mesh.cell_kind(),
        coordinates: mesh.coordinates().to_vec(),
        cells: mesh.cells().to_vec(),
        facets: Vec::new(),
        groups: Vec::new(),
    }
}

fn samples_of_two_kinds() -> [Sample; 2] {
    [
        bent(samples::rectangle_parts(5, 4)),
        bent(samples::cube_parts(2)),
    ]
}

/// H X on the hierarchical basis.
fn linear(sample: &Sample, h: &[[f64; 3]; 3]) -> Vec<f64> {
    let c = sample.space.components;
    let vertices = sample.mesh.coordinates().iter().copied();
    let edges = sample.space.edges.iter();
    let offsets = edges.map(|&[a, b]| sample.mesh.offset_between(a, b).unwrap_or_default());
    let values = vertices.chain(offsets).flat_map(|x| {
        let row = |i: usize| -> f64 { (0..3).map(|j| h[i][j] * SCALE * x[j]).sum() };
        (0..c).map(row).collect::<Vec<_>>()
    });
    values.collect()
}

/// Volume of the curved body.
fn volume(sample: &Sample) -> f64 {
    let rule = sample.volume_rule();
    let cells = 0..sample.mesh.cell_count();
    let of = |cell: usize| -> f64 {
        let points = rule.points.iter().zip(&rule.weights);
        let shares = points.map(|(l, weight)| weight * sample.geometry.curves.measure(cell, l));
        sample.geometry.volumes[cell] * shares.sum::<f64>()
    };
    cells.map(of).sum()
}

fn rubber(sample: &Sample, degree: u32) -> StrainGrid {
    let of_cell = vec![0; sample.mesh.cell_count()];
    let laws = CellLaws {
        laws: &[LAW],
        of_cell: &of_cell,
    };
    let simplex = match sample.space.components {
        2 => Simplex::Triangle,
        _ => Simplex::Tetrahedron,
    };
    let grid = Arc::new(sample.grid.clone());
    StrainGrid::new(&sample.mesh, grid, laws, rule(simplex, degree))
}

/// Energy, forces and volume defects.
fn respond(cells: &StrainGrid, u: &[f64], p: &[f64]) -> (f64, Vec<f64>, Vec<f64>) {
    let (mut f, mut c) = (vec![0.0; u.len()], vec![0.0; p.len()]);
    let response = cells.respond((u, p), (&mut f, &mut c), &mut Workspace::new());
    (response.energy, f, c)
}

/// Largest force on a node that has no edge on the surface.
fn inner(sample: &Sample, force: &[f64]) -> f64 {
    let c = sample.space.components;
    let mut on_surface = vec![false; sample.space.nodes()];
    for facet in sample.mesh.boundary_facets() {
        for node in sample.space.facet_nodes(&facet.vertices[..c]) {
            on_surface[node as usize] = true;
        }
    }
    let nodes = force.chunks_exact(c).zip(on_surface);
    let inside = nodes.filter(|(_, is_outside)| !is_outside);
    inside.map(|(force, _)| largest(force)).fold(0.0, f64::max)
}

const H: [[f64; 3]; 3] = [[0.2, -0.1, 0.0], [0.15, -0.05, 0.0], [0.0, 0.0, 0.0]];

#[test]
fn linear_fields_are_exact() {
    for sample in samples_of_two_kinds() {
        let (u, volume) = (linear(&sample, &H), volume(&sample));
        let force = sample.stiffness(Basis::Hierarchical, Rows::All, &u);
        let moduli_differ = inner(&sample, &force) > 1e-3;
        assert!(moduli_differ, "cells of other moduli part");
        let cells = rubber(&sample, 4);
        let p = vec![0.4; sample.space.vertices];
        let (energy, force, defect) = respond(&cells, &u, &p);
        let rest = inner(&sample, &force);
        assert!(rest < 1e-14, "{rest:e}");
        let jacobian = 1.2 * 0.95 + 0.1 * 0.15;
        let exact = -(jacobian - 1.0) * volume;
        let sum: f64 = defect.iter().sum();
        assert!((sum - exact).abs() < 1e-14, "{sum} {exact}");
        let density = energy / volume;
        let straight = rubber(
            &Sample::of(Mesh::new(mesh_parts(&sample.mesh)).expect("a mesh")),
            4,
        );
        let flat = Sample::of(Mesh::new(mesh_parts(&sample.mesh)).expect("a mesh"));
        let (expected, ..) = respond(&straight, &linear(&flat, &H), &p);
        let expected = expected / flat.geometry.volumes.iter().sum::<f64>();
        assert!((density - expected).abs() < 1e-14, "{density} {expected}");
    }
}

#[test]
fn rotations_leave_linear_and_finite_bodies_at_rest() {
    let minus_unit = plus_unit(&[[0.0; 3]; 3]);
    let turn = plus(&rotation_matrix([0.0, 0.0, 2.5]), -1.0, &minus_unit);
    let spin = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0; 3]];
    for sample in samples_of_two_kinds() {
        let p = vec![0.0; sample.space.vertices];
        let (energy, force, _) = respond(&rubber(&sample, 2), &linear(&sample, &turn), &p);
        assert!(energy.abs() < 1e-14 && largest(&force) < 1e-14);
        let force = sample.stiffness(Basis::Hierarchical, Rows::All, &linear(&sample, &spin));
        assert!(largest(&force) < 1e-13, "{:e}", largest(&force));
    }
}

#[test]
fn an_even_pressure_has_no_force_inside() {
    for sample in samples_of_two_kinds() {
        let ones = vec![1.0; sample.space.vertices];
        let force = sample.divergence_transposed(Rows::All, &ones);
        assert!(
            inner(&sample, &force) < 1e-15,
            "{:e}",
            inner(&sample, &force)
        );
    }
}

#[test]
fn products_with_the_divergence_and_the_saddle_point_agree() {
    for sample in samples_of_two_kinds() {
        let u = sample.mask(Rows::Free, reproducible_noise(sample.unknowns()));
        let p = reproducible_noise(sample.space.vertices);
        let left = dot(&sample.divergence(Rows::Free, &u), &p);
        let right = dot(&sample.divergence_transposed(Rows::Free, &p), &u);
        assert!((left - right).abs() < 1e-13 * left.abs(), "{left} {right}");
        let (mut y, mut r) = (vec![0.0; u.len()], vec![0.0; p.len()]);
        let work = &mut Workspace::new();
        sample.grid.saddle((&u, &p), (&mut y, &mut r), work);
        let mut expected = sample.stiffness(Basis::Hierarchical, Rows::Free, &u);
        let pressed = sample.divergence_transposed(Rows::Free, &p);
        expected.iter_mut().zip(&pressed).for_each(|(y, b)| *y += b);
        let apart = y.iter().zip(&expected).map(|(a, b)| (a - b).abs());
        assert!(apart.fold(0.0, f64::max) < 1e-13);
    }
}

#[test]
fn forces_and_tangents_are_derivatives_of_the_energy() {
    let mut away = samples::rectangle_parts(4, 3);
    away.coordinates.iter_mut().for_each(|x| x[0] += 0.5);
    let plane = bent(away);
    let plane = plane.about_axis();
    let turned = rubber(&plane, 4);
    let kinds = samples_of_two_kinds();
    let bodies = kinds.iter().map(|sample| (sample, rubber(sample, 2)));
    for (sample, cells) in bodies.chain([(&plane, turned)]) {
        let mut u = linear(sample, &H);
        let noise = reproducible_noise(u.len());
        u.iter_mut().zip(&noise).for_each(|(u, n)| *u += 0.002 * n);
        let p = reproducible_noise(sample.space.vertices);
        let step: Vec<f64> = noise.iter().rev().map(|n| n * 3e-6).collect();
        let at = |factor: f64| -> Vec<f64> {
            u.iter().zip(&step).map(|(u, d)| u + factor * d).collect()
        };
        let (above, below) = (at(1.0), at(-1.0));
        let (above, below) = (respond(&cells, &above, &p), respond(&cells, &below, &p));
        let mut state = Linearised::default();
        let work = &mut Workspace::new();
        cells.linearise((&u, &p), &mut state, work);
        let (mut y, mut r) = (vec![0.0; u.len()], vec![0.0; p.len()]);
        let still = vec![0.0; p.len()];
        let rows = Rows::All;
        cells.about(&state).apply(
            rows,
            (&step, &still),
            Mixed {
                displacement: &mut y,
                pressure: &mut r,
            },
            work,
        );
        let pairs = above.1.iter().zip(&below.1).zip(&y);
        let apart = pairs.map(|((a, b), y)| (0.5 * (a - b) - y).abs());
        let apart = apart.fold(0.0, f64::max) / largest(&y);
        assert!(apart < 1e-7, "{apart:e}");
        // The force of the pressure is no part of the energy.
        let (force, none) = (respond(&cells, &u, &p).1, respond(&cells, &u, &still).1);
        let work_of = |force: &[f64]| dot(force, &step);
        let gain =
            0.5 * (respond(&cells, &at(1.0), &still).0 - respond(&cells, &at(-1.0), &still).0);
        assert!((gain - work_of(&none)).abs() < 1e-7 * gain.abs());
        let defect: f64 = above
            .2
            .iter()
            .zip(&below.2)
            .zip(&p)
            .map(|((a, b), p)| 0.5 * (a - b) * p)
            .sum();
        let pressed = work_of(&force) - work_of(&none);
        assert!(
            (defect - pressed).abs() < 1e-7 * defect.abs().max(1e-9),
            "{defect} {pressed}"
        );
    }
}

#[test]
fn straight_cells_have_no_curves() {
    let sample = Sample::new(samples::cube_parts(1));
    assert!(sample.geometry.curves.of(0).is_none());
    let straight = CurvedCell::new(&[[0.0; 3]; 4], &[(0, 1)], [[0.0; 3]; 6]);
    assert!((straight.least_measure() - 1.0).abs() < f64::EPSILON);
}
