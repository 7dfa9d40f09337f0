//! Seconds of the parts of a solve, and unknowns a second: a guard against
//! regressions of one part that a whole solve would hide.
//!
//! `cargo bench -p signorini --bench parts -- [--cells N] [--only PART] [--save FILE] [--against FILE]`
//! measures the unit cube of N^3 cells (24: 353 k unknowns) and a dense problem,
//! for every instruction set of the machine where a part has kernels of its own,
//! and for one and two threads. A part runs for half a second at least; the
//! figure is the median. `--save` writes them as CSV; `--against` prints the ratio to a
//! saved file. Only what is public is measured: no door is opened for it.

#![allow(clippy::print_stdout)] // The table is what it is for.

mod body;
mod notebook;

use std::sync::Arc;

use body::{Body, bent_cube};
use notebook::{Notebook, Wishes};
use signorini::assembly::grid::{Basis, Rows, StiffnessForm, VolumeTerm};
use signorini::assembly::simd::InstructionSet;
use signorini::assembly::strain::{CellLaws, Linearised, Mixed, StrainGrid};
use signorini::contact::gap::{Deformed, Measure};
use signorini::contact::{ContactSurface, curvature, evaluate_gaps, linearise};
use signorini::element::quadrature::{Simplex, rule};
use signorini::inequality::dense_cone;
use signorini::linalg::cholesky::Precision;
use signorini::linalg::vector::{add_scaled, dot, reproducible_noise};
use signorini::linalg::{DenseMatrix, Preconditioner, Workspace};
use signorini::material::{InvariantLaw, Isochoric, Rubber};
use signorini::obstacle::{Moving, Obstacle, Sphere};
use signorini::precond::NodeBlocks;
use signorini::precond::p1::{AmgP1, DirectP1, VertexBlocks, vertex_order};
use signorini::saddle::{AdmissibleSet, ProductSet, SetPart, Status};
use signorini::{CancelToken, GroupKind, Plan, Prepared, Reuse, Session, Silent, Step};

const THREADS: [usize; 2] = [1, 2];

/// A product as programs without contact have it.
fn form(basis: Basis) -> StiffnessForm {
    StiffnessForm {
        basis,
        rows: Rows::Free,
        volume: VolumeTerm::Own,
    }
}

/// A, B and B^T in every instruction set of the machine.
fn kernels(notebook: &mut Notebook, body: &Body) {
    let (size, vertices) = (body.space.displacement_unknowns(), body.space.vertices);
    let (x, p) = (reproducible_noise(size), reproducible_noise(vertices));
    let (mut y, mut r) = (vec![0.0; size], vec![0.0; vertices]);
    let here = InstructionSet::ALL.into_iter().filter(|set| set.is_here());
    for set in here {
        let grid = body.grid().with_instruction_set(set);
        let (name, mut work) = (set.name(), Workspace::new());
        for threads in THREADS {
            notebook.measure("operator, Lagrange", name, threads, size, || {
                grid.stiffness(form(Basis::Lagrange), &x, &mut y, &mut work);
            });
            notebook.measure("operator, hierarchical", name, threads, size, || {
                grid.stiffness(form(Basis::Hierarchical), &x, &mut y, &mut work);
            });
            notebook.measure("divergence", name, threads, size, || {
                grid.divergence(Rows::Free, &x, &mut r, &mut work);
            });
            notebook.measure("divergence, transposed", name, threads, size, || {
                grid.divergence_transposed(Rows::Free, &p, &mut y, &mut work);
            });
        }
    }
}

/// A law of Mooney and Rivlin.
const RUBBER: Rubber = Rubber {
    isochoric: Isochoric::Invariants(InvariantLaw {
        c10: 0.4,
        c01: 0.1,
        c20: 0.0,
        c30: 0.0,
    }),
    inverse_bulk: 0.0,
};

/// A and B of the tangent of rubber at strains of some per cent, and the residual,
/// by rules of degree 2 and 4.
fn rubber(notebook: &mut Notebook, body: &Body) {
    let (size, vertices) = (body.space.displacement_unknowns(), body.space.vertices);
    let (x, p) = (reproducible_noise(size), reproducible_noise(vertices));
    let state: Vec<f64> = x.iter().map(|x| 0.002 * x).collect();
    let (mut y, mut r) = (vec![0.0; size], vec![0.0; vertices]);
    let of_cell = vec![0; body.geometry.cells()];
    let laws = CellLaws {
        laws: &[RUBBER],
        of_cell: &of_cell,
    };
    for set in InstructionSet::ALL.into_iter().filter(|set| set.is_here()) {
        let grid = Arc::new(body.grid().with_instruction_set(set));
        let (name, mut work) = (set.name(), Workspace::new());
        for degree in [2, 4] {
            let rule = rule(Simplex::Tetrahedron, degree);
            let cells = StrainGrid::new(&body.mesh, grid.clone(), laws, rule);
            let mut at = Linearised::default();
            cells.linearise((&state, &p), &mut at, &mut work);
            for threads in THREADS {
                let mut measure = |part: &str, task: &mut (dyn FnMut() + Send)| {
                    let part = format!("rubber {degree}, {part}");
                    notebook.measure(&part, name, threads, size, task);
                };
                measure("tangent", &mut || {
                    let tangent = cells.about(&at);
                    let into = Mixed {
                        displacement: &mut y,
                        pressure: &mut r,
                    };
                    tangent.apply(Rows::Free, (&x, &p), into, &mut work);
                });
                measure("residual", &mut || {
                    let _sums = cells.respond((&state, &p), (&mut y, &mut r), &mut work);
                });
            }
        }
    }
}

/// Smoother, P1 solvers and vector updates.
fn preconditioner(notebook: &mut Notebook, body: &Body) {
    let set = InstructionSet::of_this_machine().name();
    let (size, coarse) = (body.space.displacement_unknowns(), 3 * body.space.vertices);
    let stiffness = body.cells().node_blocks(&body.held);
    let smoother = NodeBlocks::invert(3, stiffness);
    let (r, r1) = (reproducible_noise(size), reproducible_noise(coarse));
    let (mut d, mut x, mut z) = (vec![0.0; size], vec![0.0; size], vec![0.0; coarse]);
    let mut work = Workspace::new();
    let blocks = body.p1();
    let view = VertexBlocks {
        components: 3,
        coordinates: body.mesh.coordinates(),
        edges: &body.space.edges,
        diagonal: &blocks.diagonal,
        off: &blocks.off,
        held: &body.held,
    };
    let cycle = AmgP1::new(&view, Precision::Single).ok();
    let matrix = blocks.lower_columns(&body.space, &body.held.entries);
    let order = vertex_order(body.mesh.coordinates(), &body.space.edges, &[]);
    let factor = DirectP1::new(&matrix, &order, 3, Precision::Single).ok();
    for threads in THREADS {
        notebook.measure("Chebyshev update", set, threads, size, || {
            smoother.chebyshev_update((0.3, 0.7), &r, &mut d, &mut x);
        });
        notebook.measure("P1 multigrid, set-up", set, threads, coarse, || {
            let _built = AmgP1::new(&view, Precision::Single).ok();
        });
        if let Some(cycle) = &cycle {
            notebook.measure("P1 multigrid, cycle", set, threads, coarse, || {
                cycle.apply(&r1, &mut z, &mut work);
            });
        }
        notebook.measure("P1 factor", set, threads, coarse, || {
            let _built = DirectP1::new(&matrix, &order, 3, Precision::Single).ok();
        });
        if let Some(factor) = &factor {
            notebook.measure("P1 factor, solution", set, threads, coarse, || {
                factor.apply(&r1, &mut z, &mut work);
            });
        }
    }
}

/// A ball of radius one in the middle of z1, a little deep and turned.
fn ball() -> Option<Moving> {
    let ball = Sphere::new([0.5, 0.5, 2.0], 1.0).ok()?;
    Some(Moving::new(
        Arc::new(ball),
        [0.0, 0.0, -0.02],
        [0.1, 0.2, 0.3],
    ))
}

/// Gaps, coupling and curvature of the contact of z1 with a ball.
fn contact(notebook: &mut Notebook, body: &Body) {
    let members = body
        .mesh
        .group("z1", GroupKind::Facets)
        .map_or(&[][..], |group| &group.members);
    let facets: Vec<Vec<u32>> = members
        .iter()
        .map(|&facet| body.mesh.facet(facet as usize).to_vec())
        .collect();
    let surface = ContactSurface::new(&body.mesh, &body.space, 1.0, &facets);
    let unknowns = body.space.displacement_unknowns();
    let displacement: Vec<f64> = (reproducible_noise(unknowns).into_iter())
        .map(|x| 1e-3 * x)
        .collect();
    let deformed = Deformed {
        mesh: &body.mesh,
        scale: 1.0,
        space: &body.space,
        displacement: &displacement,
        rule: &rule(Simplex::Triangle, 8),
        measure: Measure::Undeformed,
    };
    let Some(ball) = ball() else { return };
    let held = vec![false; unknowns];
    let size = surface.multipliers();
    let pressure = vec![1.0; size];
    for threads in THREADS {
        notebook.measure("contact, gaps", "any", threads, size, || {
            std::hint::black_box(evaluate_gaps(&deformed, &surface, &ball));
        });
        notebook.measure("contact, linearisation", "any", threads, size, || {
            std::hint::black_box(linearise(&deformed, &surface, &ball, &held));
        });
        notebook.measure("contact, curvature", "any", threads, size, || {
            let surfaces = [(&surface, &ball as &dyn Obstacle, &pressure[..])];
            std::hint::black_box(curvature(&deformed, &surfaces, &held));
        });
    }
}

fn vectors(notebook: &mut Notebook, size: usize) {
    let (x, mut y) = (reproducible_noise(size), vec![1.0; size]);
    for threads in THREADS {
        let mut sum = 0.0;
        notebook.measure("dot product", "any", threads, size, || sum += dot(&x, &x));
        notebook.measure("vector update", "any", threads, size, || {
            add_scaled(&mut y, 1e-9, &x)
        });
        std::hint::black_box(sum);
    }
}

/// The contact problem of some hundred vertices: a kernel 1 / (1 + distance).
fn dense(notebook: &mut Notebook) {
    for count in [300, 1000] {
        let mut matrix = DenseMatrix::zeros(count, count);
        for row in 0..count {
            for column in 0..count {
                *matrix.at_mut(row, column) = 1.0 / (1.0 + row.abs_diff(column) as f64);
            }
        }
        let linear: Vec<f64> = (0..count)
            .map(|i| (i as f64 / count as f64 - 0.3).signum() - 0.2)
            .collect();
        let guess = vec![Status::Stick; count];
        let set = ProductSet::Uniform(SetPart {
            size: count,
            set: AdmissibleSet::NonNegative,
        });
        notebook.measure(&format!("dense QP of {count}"), "any", 1, count, || {
            let _solved =
                dense_cone::solve(&matrix, &linear, set, (&guess, &vec![0.0; guess.len()])).ok();
        });
    }
}

/// Preparation and step of cube-bend at 1e-8.
fn whole(notebook: &mut Notebook, body: &Body) -> Result<(), Box<dyn std::error::Error>> {
    let set = InstructionSet::of_this_machine().name();
    let plan = Arc::new(Plan::new(&bent_cube(), &[], &body.mesh)?);
    let prepared = Arc::new(Prepared::build(&plan, &body.mesh, &CancelToken::new())?);
    let size = body.space.displacement_unknowns();
    for threads in THREADS {
        notebook.measure("preparation", set, threads, size, || {
            let _built = Prepared::build(&plan, &body.mesh, &CancelToken::new()).ok();
        });
        notebook.measure("step, prepared", set, threads, size, || {
            let mut session = Session::new(
                plan.clone(),
                body.mesh.clone(),
                prepared.clone(),
                Reuse::Reused,
            );
            if let Ok(mut run) = session.begin_step(&Step::default()) {
                let _report = session.advance(&mut run, &mut Silent, &CancelToken::new());
            }
        });
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut notebook = Notebook::new(Wishes::read());
    let body = Body::new(notebook.wishes.cells);
    kernels(&mut notebook, &body);
    rubber(&mut notebook, &body);
    preconditioner(&mut notebook, &body);
    contact(&mut notebook, &body);
    vectors(&mut notebook, body.space.displacement_unknowns());
    dense(&mut notebook);
    whole(&mut notebook, &body)?;
    notebook.save()?;
    Ok(())
}
