//! Multigrid on real P1 blocks.

use super::*;
use crate::assembly::p1_stiffness::{P1Blocks, StiffCells};
use crate::assembly::{CellGeometry, CellModuli};
use crate::linalg::Held;
use crate::linalg::vector::{add_scaled, dot, norm, reproducible_noise, scale_and_add};
use crate::mesh::{GroupKind, Mesh, MeshParts, samples};
use crate::space::TaylorHood;

struct Sample {
    mesh: Mesh,
    space: TaylorHood,
    blocks: P1Blocks,
    held: Held,
}

/// `mesh` clamped on `x0`, with a shear modulus for each cell centre.
fn sample(mesh: Mesh, shear: impl Fn([f64; 3]) -> f64) -> Sample {
    let space = TaylorHood::new(&mesh);
    let geometry = CellGeometry::new(&mesh, 1.0);
    let corners = mesh.cell_kind().vertices();
    let centre = |cell: &[u32]| {
        [0, 1, 2].map(|axis| {
            let at = |&vertex: &u32| mesh.coordinates()[vertex as usize][axis];
            cell.iter().map(at).sum::<f64>() / corners as f64
        })
    };
    let moduli = CellModuli {
        shear: mesh
            .cells()
            .chunks(corners)
            .map(|cell| shear(centre(cell)))
            .collect(),
        lame: vec![0.0; mesh.cell_count()],
        augmented: vec![0.0; mesh.cell_count()],
        inverse_lame: Vec::new(),
    };
    let cells = StiffCells {
        mesh: &mesh,
        space: &space,
        geometry: &geometry,
        stiffness: &moduli,
    };
    let blocks = cells.p1_blocks(0.0);
    let group = mesh.group("x0", GroupKind::Facets).expect("a side");
    let facets = group.members.iter();
    let mut vertices: Vec<u32> = facets
        .flat_map(|&facet| mesh.facet(facet as usize).to_vec())
        .collect();
    vertices.sort_unstable();
    vertices.dedup();
    let c = space.components as u32;
    let held: Vec<u32> = vertices
        .iter()
        .flat_map(|&vertex| (0..c).map(move |i| vertex * c + i))
        .collect();
    Sample {
        mesh,
        space,
        blocks,
        held: Held::of_entries(c as usize, held),
    }
}

impl Sample {
    fn view(&self) -> VertexBlocks<'_> {
        VertexBlocks {
            components: self.space.components,
            coordinates: self.mesh.coordinates(),
            edges: &self.space.edges,
            diagonal: &self.blocks.diagonal,
            off: &self.blocks.off,
            held: &self.held,
        }
    }

    fn amg(&self, precision: Precision) -> AmgP1 {
        AmgP1::new(&self.view(), precision).expect("a usable hierarchy")
    }

    /// A fixed random vector that vanishes at held unknowns.
    fn noise(&self) -> Vec<f64> {
        let mut x = reproducible_noise(self.space.components * self.space.vertices);
        for &unknown in self.held.entries.iter() {
            x[unknown as usize] = 0.0;
        }
        x
    }
}

/// Conjugate gradients to a reduction of 1e-8.
fn count(matrix: &dyn LinearOperator, amg: &AmgP1, b: &[f64]) -> usize {
    let work = &mut Workspace::new();
    let mut r = b.to_vec();
    let (mut z, mut q) = (vec![0.0; r.len()], vec![0.0; r.len()]);
    amg.apply(&r, &mut z, work);
    let mut p = z.clone();
    let mut rz = dot(&r, &z);
    for iteration in 1..200 {
        matrix.apply(&p, &mut q, work);
        let alpha = rz / dot(&p, &q);
        add_scaled(&mut r, -alpha, &q);
        if norm(&r) < 1e-8 * norm(b) {
            return iteration;
        }
        amg.apply(&r, &mut z, work);
        let next = dot(&r, &z);
        scale_and_add(&mut p, next / rz, &z);
        rz = next;
    }
    200
}

/// Counts on the P1 block of `sample`, in both precisions.
fn counts(sample: &Sample) -> [usize; 2] {
    let b = sample.noise();
    [Precision::Single, Precision::Double].map(|precision| {
        let amg = sample.amg(precision);
        match sample.space.components {
            2 => count(&setup::fine_matrix::<2>(&sample.view()), &amg, &b),
            _ => count(&setup::fine_matrix::<3>(&sample.view()), &amg, &b),
        }
    })
}

/// `mesh` stretched along the last axis.
fn stretched(parts: MeshParts, axis: usize, factor: f64) -> Mesh {
    let mut parts = parts;
    for x in &mut parts.coordinates {
        x[axis] *= factor;
    }
    Mesh::new(parts).expect("a valid mesh")
}

#[test]
fn counts_do_not_depend_on_the_size() {
    let counts = [4, 6, 10, 16, 24].map(|n| counts(&sample(samples::cube(n), |_| 1.0)));
    for [single, double] in counts {
        assert!(single <= 12 && single.abs_diff(double) <= 1, "{counts:?}");
    }
}

#[test]
fn counts_in_the_plane_do_not_depend_on_the_size() {
    let counts = [8, 20, 50, 90].map(|n| counts(&sample(samples::rectangle(n, n), |_| 1.0)));
    for [single, double] in counts {
        assert!(single <= 14 && single.abs_diff(double) <= 1, "{counts:?}");
    }
}

#[test]
fn stiff_and_soft_layers_raise_the_count_by_less_than_half() {
    for contrast in [1e-6, 1e-3, 1e3, 1e6] {
        let layer = |x: [f64; 3]| {
            if (0.3..0.5).contains(&x[2]) {
                contrast
            } else {
                1.0
            }
        };
        let [single, double] = counts(&sample(samples::cube(10), layer));
        assert!(
            single <= 15 && single.abs_diff(double) <= 1,
            "{contrast}: {single} {double}"
        );
    }
}

#[test]
fn single_precision_is_refused_where_it_overshoots() {
    let mesh = stretched(samples::cube_parts(8), 2, 0.01);
    let sample = sample(mesh, |_| 1.0);
    let refused = AmgP1::new(&sample.view(), Precision::Single).err();
    assert_eq!(refused, Some(AmgError::Indefinite));
    let interval = sample.amg(Precision::Double).interval();
    assert!(interval.largest < 1.1, "{interval:?}");
}

#[test]
fn stretched_cells_are_solved() {
    for (axis, factor, bound) in [(2, 0.1, 40), (0, 10.0, 75)] {
        let mesh = stretched(samples::cube_parts(8), axis, factor);
        let [single, double] = counts(&sample(mesh, |_| 1.0));
        assert!(
            single <= bound && single.abs_diff(double) <= 1,
            "{factor}: {single} {double}"
        );
    }
}

/// Largest difference of P B_c and B over vertices that no support touches.
fn reproduction_error<const N: usize, const K: usize>(sample: &Sample) -> f64 {
    let view = sample.view();
    let matrix = setup::fine_matrix::<N>(&view);
    let modes = modes::rigid_modes::<N, K>(view.coordinates, view.held);
    let (level, _, coarse) = setup::coarsen::<f64, N, K>(&matrix, &modes, 0.02).expect("groups");
    let is_held = |vertex: u32| sample.held.entries.contains(&(vertex * N as u32));
    let mut largest: f64 = 0.0;
    let mut compared = 0;
    for vertex in 0..matrix.rows() {
        let edges = sample.space.edges.iter();
        let mut ends = edges.filter(|ends| ends.contains(&(vertex as u32)));
        if is_held(vertex as u32) || ends.any(|ends| ends.iter().any(|&end| is_held(end))) {
            continue;
        }
        compared += 1;
        for mode in 0..K {
            let columns: Vec<_> = coarse.iter().map(|c| c.map(|row| [row[mode]])).collect();
            let found = level.prolongation.row_product(vertex, &columns);
            for i in 0..N {
                largest = largest.max((found[i][0] - modes[vertex][i][mode]).abs());
            }
        }
    }
    assert!(compared > 20);
    largest
}

#[test]
fn the_prolongator_reproduces_rigid_motions() {
    let space = reproduction_error::<3, 6>(&sample(samples::cube(5), |_| 1.0));
    let plane = reproduction_error::<2, 3>(&sample(samples::rectangle(8, 8), |_| 1.0));
    assert!(space < 1e-12 && plane < 1e-12, "{space} {plane}");
}

#[test]
fn the_coarse_modes_carry_no_energy_away_from_supports() {
    let mut sample = sample(samples::cube(5), |_| 1.0);
    sample.held = Held::of_entries(3, []);
    let view = sample.view();
    let matrix = setup::fine_matrix::<3>(&view);
    let modes = modes::rigid_modes::<3, 6>(view.coordinates, &Held::of_entries(3, []));
    let (_, coarse, coarse_modes) =
        setup::coarsen::<f64, 3, 6>(&matrix, &modes, 0.02).expect("groups");
    for mode in 0..6 {
        let columns: Vec<_> = coarse_modes
            .iter()
            .map(|c| c.map(|row| [row[mode]]))
            .collect();
        for row in 0..coarse.rows() {
            let force = coarse.row_product(row, &columns);
            assert!(
                force.iter().all(|value| value[0].abs() < 1e-12),
                "{force:?}"
            );
        }
    }
}

#[test]
fn the_cycle_is_symmetric_and_positive() {
    for (sample, precision, rounding) in [
        (sample(samples::cube(8), |_| 1.0), Precision::Double, 1e-13),
        (sample(samples::cube(8), |_| 1.0), Precision::Single, 1e-5),
        (
            sample(samples::rectangle(9, 7), |_| 1.0),
            Precision::Double,
            1e-13,
        ),
    ] {
        let amg = sample.amg(precision);
        let x = sample.noise();
        let y: Vec<f64> = x.iter().map(|value| (7.0 * value).sin()).collect();
        let work = &mut Workspace::new();
        let mut images = [vec![f64::NAN; x.len()], vec![f64::NAN; x.len()]];
        amg.apply(&x, &mut images[0], work);
        amg.apply(&y, &mut images[1], work);
        let (left, right) = (dot(&images[0], &y), dot(&images[1], &x));
        let (own, other) = (dot(&images[0], &x), dot(&images[1], &y));
        assert!(own > 0.0 && other > 0.0);
        assert!((left - right).abs() < rounding * (own * other).sqrt());
        let interval = amg.interval();
        assert!(
            interval.smallest > 0.5 && interval.largest < 1.05,
            "{interval:?}"
        );
    }
}

#[test]
fn the_bits_do_not_depend_on_the_number_of_threads() {
    let sample = sample(samples::cube(12), |x| 1.0 + x[0]);
    let b = sample.noise();
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("a pool of a few threads").install(|| {
            let amg = sample.amg(Precision::Single);
            let mut z = vec![0.0; b.len()];
            amg.apply(&b, &mut z, &mut Workspace::new());
            let vertices: Vec<u32> = (13..400).collect();
            (z, compliance(&amg, &vertices))
        })
    };
    let (one, two, three) = (run(1), run(2), run(3));
    let bits = |z: &[f64]| z.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&one.0), bits(&two.0));
    assert_eq!(bits(&one.0), bits(&three.0));
    assert_eq!(one.1, two.1);
}

#[test]
fn loads_of_every_size_give_the_same_digits() {
    let sample = sample(samples::cube(6), |_| 1.0);
    let amg = sample.amg(Precision::Single);
    let b = sample.noise();
    let apply = |factor: f64| {
        let scaled: Vec<f64> = b.iter().map(|value| factor * value).collect();
        let mut z = vec![0.0; b.len()];
        amg.apply(&scaled, &mut z, &mut Workspace::new());
        z.into_iter()
            .map(|value| (value / factor).to_bits())
            .collect::<Vec<_>>()
    };
    assert_eq!(apply(1.0), apply(2_f64.powi(200)));
    assert_eq!(apply(1.0), apply(2_f64.powi(-200)));
    let mut z = vec![f64::NAN; b.len()];
    amg.apply(&vec![0.0; b.len()], &mut z, &mut Workspace::new());
    assert!(z.iter().all(|value| value.to_bits() == 0));
}

/// Compliance of `vertices` along one oblique direction.
fn compliance(amg: &AmgP1, vertices: &[u32]) -> DenseMatrix {
    let directions = vec![[0.6, 0.0, 0.8]; vertices.len()];
    let traces = Traces {
        vertices,
        directions: &directions,
    };
    amg.compliance(&traces, &|| true).expect("nobody says no")
}

#[test]
fn one_cycle_gives_the_compliance_to_a_quarter() {
    for (cells, levels) in [(8, 1), (16, 2)] {
        gives_the_compliance_to_a_quarter(cells, levels);
    }
}

/// On a cube of so many cells along an edge, whose hierarchy has so many levels.
fn gives_the_compliance_to_a_quarter(cells: usize, levels: usize) {
    let sample = sample(samples::cube(cells), |_| 1.0);
    let lower = sample
        .blocks
        .lower_columns(&sample.space, &sample.held.entries);
    let order: Vec<u32> = (0..sample.space.vertices as u32).collect();
    let exact = super::super::DirectP1::new(&lower, &order, 3, Precision::Double)
        .expect("positive definite");
    let end = cells as u32;
    let vertices: Vec<u32> = (0..60).map(|k| end + (end + 1) * k).collect();
    let amg = sample.amg(Precision::Single);
    assert_eq!(amg.levels().len(), levels);
    let found = compliance(&amg, &vertices);
    let work = &mut Workspace::new();
    for (j, &vertex) in vertices.iter().enumerate() {
        let mut force = vec![0.0; lower.size()];
        force[3 * vertex as usize] = 0.6;
        force[3 * vertex as usize + 2] = 0.8;
        let mut column = force.clone();
        exact.apply(&force, &mut column, work);
        let along = |vertex: u32| {
            let start = 3 * vertex as usize;
            0.6 * column[start] + 0.8 * column[start + 2]
        };
        let size = along(vertex);
        for (i, &row) in vertices.iter().enumerate() {
            let error = (found.at(i, j) - along(row)).abs();
            assert!(error < 0.25 * size, "{error} of {size}");
            assert_eq!(found.at(i, j).to_bits(), found.at(j, i).to_bits());
        }
    }
}

#[test]
fn the_compliance_is_that_of_the_cycle() {
    // Between the finest level and the coarsest there is none, so that V and W are one.
    let sample = sample(samples::cube(8), |x| 1.0 + x[1]);
    let amg = sample.amg(Precision::Double);
    assert_eq!(amg.levels().len(), 1);
    let vertices: Vec<u32> = (9..159).chain(700..729).collect();
    let found = compliance(&amg, &vertices);
    let work = &mut Workspace::new();
    let along = |x: &[f64], vertex: u32| {
        let start = 3 * vertex as usize;
        0.6 * x[start] + 0.8 * x[start + 2]
    };
    for (j, &vertex) in vertices.iter().enumerate() {
        let mut force = vec![0.0; 3 * 729];
        force[3 * vertex as usize] = 0.6;
        force[3 * vertex as usize + 2] = 0.8;
        let mut column = force.clone();
        amg.apply(&force, &mut column, work);
        for (i, &row) in vertices.iter().enumerate() {
            let error = (found.at(i, j) - along(&column, row)).abs();
            assert!(error < 1e-13 * along(&column, vertex), "{error}");
        }
    }
}

#[test]
fn several_directions_of_a_vertex_in_the_plane_have_a_compliance() {
    let sample = sample(samples::rectangle(12, 9), |_| 1.0);
    let amg = sample.amg(Precision::Double);
    assert_eq!(amg.levels().len(), 1);
    let vertices: Vec<u32> = (0..2 * 100).map(|k| k / 2).collect();
    let along = |k: usize| [[0.8, 0.6, 0.0], [-0.6, 0.8, 0.0]][k % 2];
    let directions: Vec<[f64; 3]> = (0..200).map(along).collect();
    let traces = Traces {
        vertices: &vertices,
        directions: &directions,
    };
    let found = amg.compliance(&traces, &|| true).expect("nobody says no");
    let work = &mut Workspace::new();
    let size = 2 * sample.space.vertices;
    for (j, &vertex) in vertices.iter().enumerate() {
        let mut force = vec![0.0; size];
        let start = 2 * vertex as usize;
        force[start..start + 2].copy_from_slice(&directions[j][..2]);
        let mut column = force.clone();
        amg.apply(&force, &mut column, work);
        for (i, &row) in vertices.iter().enumerate() {
            let start = 2 * row as usize;
            let expected = dot(&column[start..start + 2], &directions[i][..2]);
            assert!((found.at(i, j) - expected).abs() < 1e-12, "{expected}");
        }
    }
    let none = Traces {
        vertices: &[],
        directions: &[],
    };
    assert_eq!(amg.compliance(&none, &|| true).map(|m| m.rows()), Some(0));
}

#[test]
fn columns_can_be_stopped() {
    let amg = sample(samples::cube(6), |_| 1.0).amg(Precision::Single);
    let vertices: Vec<u32> = (0..40).collect();
    let directions = vec![[0.0, 0.0, 1.0]; 40];
    let traces = Traces {
        vertices: &vertices,
        directions: &directions,
    };
    assert!(amg.compliance(&traces, &|| false).is_none());
    let asked = std::sync::atomic::AtomicUsize::new(0);
    let count = || asked.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
    assert!(amg.compliance(&traces, &|| count() < usize::MAX).is_some());
    let last = asked.load(std::sync::atomic::Ordering::Relaxed) - 1;
    asked.store(0, std::sync::atomic::Ordering::Relaxed);
    assert!(amg.compliance(&traces, &|| count() < last).is_none());
}

#[test]
fn a_matrix_that_is_not_positive_is_refused() {
    let mut sample = sample(samples::cube(4), |_| 1.0);
    let vertex = sample.blocks.diagonal.len() / 2;
    sample.blocks.diagonal[vertex][1][1] = -1.0;
    let refused = AmgP1::new(&sample.view(), Precision::Double).err();
    assert_eq!(refused, Some(AmgError::Indefinite));
}

#[test]
fn vertices_without_partners_are_refused() {
    let sample = sample(samples::cube(2), |_| 1.0);
    let mut view = sample.view();
    let nothing = vec![[[0.0; 3]; 3]; view.off.len()];
    view.off = &nothing;
    let refused = AmgP1::new(&view, Precision::Double).err();
    assert!(
        matches!(refused, Some(AmgError::Stalled { .. })),
        "{refused:?}"
    );
}
