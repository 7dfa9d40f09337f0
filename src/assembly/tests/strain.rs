//! The passes of finite strain: against differences of themselves, against the
//! linear operator at rest, and each instruction set against the others.

use std::sync::Arc;

use super::*;
use crate::assembly::Constrained;
use crate::assembly::strain::{
    CellLaws, CellStates, CellTangents, Linearised, Mixed, Response, SingleTangent, StrainGrid,
    TangentBody, TangentDivergence, TangentProducts, TangentStiffness,
};
use crate::linalg::ResidualUpdate;
use crate::linalg::vector::{add_scaled, scale};
use crate::material::{InvariantLaw, Isochoric, Rubber};

/// Shear moduli 1 and 2, bulk moduli infinite and 10, so that a cell's law matters.
const LAWS: [Rubber; 2] = [
    Rubber {
        isochoric: Isochoric::Invariants(InvariantLaw {
            c10: 0.3,
            c01: 0.2,
            c20: 0.0,
            c30: 0.0,
        }),
        inverse_bulk: 0.0,
    },
    Rubber {
        isochoric: Isochoric::Invariants(InvariantLaw {
            c10: 1.0,
            c01: 0.0,
            c20: 0.1,
            c30: 0.05,
        }),
        inverse_bulk: 0.1,
    },
];

struct Body {
    sample: Sample,
    cells: StrainGrid,
}

fn bodies(degree: u32) -> Vec<Body> {
    samples().into_iter().map(|one| body(one, degree)).collect()
}

fn body(sample: Sample, degree: u32) -> Body {
    let of_cell: Vec<u16> = (0..sample.mesh.cell_count() as u16)
        .map(|cell| cell % 2)
        .collect();
    let laws = CellLaws {
        laws: &LAWS,
        of_cell: &of_cell,
    };
    let simplex = match sample.space.components {
        2 => Simplex::Triangle,
        _ => Simplex::Tetrahedron,
    };
    let grid = Arc::new(sample.grid.clone());
    let cells = StrainGrid::new(&sample.mesh, grid, laws, rule(simplex, degree));
    Body { sample, cells }
}

/// The plane ones as sections of bodies of revolution.
fn turned(degree: u32) -> impl Iterator<Item = Body> {
    let plane = samples().into_iter();
    let plane = plane.filter(|sample| sample.space.components == 2);
    plane.map(move |sample| body(sample.about_axis(), degree))
}

/// [`bodies`] and [`turned`] ones, with a penalty on volume changes and without.
fn all_bodies(degree: u32) -> impl Iterator<Item = Body> {
    [0.0, 3.0].into_iter().flat_map(move |penalty| {
        let plain = bodies(degree).into_iter().chain(turned(degree));
        plain.map(move |body| Body {
            cells: body.cells.penalised(penalty),
            sample: body.sample,
        })
    })
}

impl Body {
    /// A deformed state with gradients of some tenths.
    fn state(&self) -> (Vec<f64>, Vec<f64>) {
        let mut u = reproducible_noise(self.sample.unknowns());
        scale(&mut u, 0.002);
        (u, reproducible_noise(self.sample.space.vertices))
    }

    fn respond(&self, u: &[f64], p: &[f64]) -> (Vec<f64>, Vec<f64>, Response) {
        let (mut f, mut c) = (vec![f64::NAN; u.len()], vec![f64::NAN; p.len()]);
        let work = &mut Workspace::new();
        let response = self.cells.respond((u, p), (&mut f, &mut c), work);
        (f, c, response)
    }

    fn linearised(&self, u: &[f64], p: &[f64]) -> Linearised {
        let mut at = Linearised::default();
        self.cells.linearise((u, p), &mut at, &mut Workspace::new());
        at
    }

    fn products(&self, u: &[f64], p: &[f64]) -> TangentProducts {
        let (cells, at) = (self.cells.clone(), self.linearised(u, p));
        TangentProducts::new(&Arc::new(cells), &Arc::new(at), 0.0)
    }

    fn tangent(&self, rows: Rows, u: &[f64], p: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let (at_u, at_p) = self.state();
        let at = self.linearised(&at_u, &at_p);
        let (mut y, mut r) = (vec![f64::NAN; u.len()], vec![f64::NAN; p.len()]);
        let work = &mut Workspace::new();
        let tangent = self.cells.about(&at);
        tangent.apply(
            rows,
            (u, p),
            Mixed {
                displacement: &mut y,
                pressure: &mut r,
            },
            work,
        );
        (y, r)
    }
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    let mut difference = a.to_vec();
    add_scaled(&mut difference, -1.0, b);
    largest(&difference) / largest(b)
}

#[test]
fn a_body_that_is_carried_far_has_no_forces_at_all() {
    for body in bodies(4) {
        let (space, pressures) = (&body.sample.space, vec![0.0; body.sample.space.vertices]);
        let mut carried = vec![0.0; body.sample.unknowns()];
        let vertices = carried[..space.components * space.vertices].chunks_mut(space.components);
        for vertex in vertices {
            vertex.copy_from_slice(&[0.1, -1e3, 7.3][..space.components]);
        }
        let (forces, volumes, _) = body.respond(&carried, &pressures);
        assert!(forces.iter().chain(&volumes).all(|&value| value == 0.0));
    }
}

#[test]
fn the_tangent_is_the_slope_of_the_forces() {
    for degree in [2, 3] {
        for body in all_bodies(degree) {
            let (u, p) = body.state();
            let mut du = reproducible_noise(u.len() + 1)[1..].to_vec();
            scale(&mut du, 0.01);
            let dp = reproducible_noise(p.len() + 1)[1..].to_vec();
            let moved = |length: f64| {
                let (mut u, mut p) = (u.clone(), p.clone());
                add_scaled(&mut u, length, &du);
                add_scaled(&mut p, length, &dp);
                body.respond(&u, &p)
            };
            let (up, down) = (moved(1e-4), moved(-1e-4));
            let slope = |a: &[f64], b: &[f64]| -> Vec<f64> {
                a.iter().zip(b).map(|(a, b)| (a - b) / 2e-4).collect()
            };
            let (y, r) = body.tangent(Rows::All, &du, &dp);
            let errors = [
                distance(&y, &slope(&up.0, &down.0)),
                distance(&r, &slope(&up.1, &down.1)),
            ];
            assert!(
                errors.iter().all(|&e| e < 1e-7),
                "{errors:?} {:?}",
                body.respond(&u, &p).2
            );
        }
    }
}

#[test]
fn the_force_without_pressure_is_the_slope_of_the_energy() {
    for body in all_bodies(2) {
        let (u, _) = body.state();
        let p = vec![0.0; body.sample.space.vertices];
        let mut du = reproducible_noise(u.len() + 1)[1..].to_vec();
        scale(&mut du, 0.01);
        let energy = |length: f64| {
            let mut u = u.clone();
            add_scaled(&mut u, length, &du);
            body.respond(&u, &p).2.energy
        };
        let slope = (energy(1e-5) - energy(-1e-5)) / 2e-5;
        let work = dot(&body.respond(&u, &p).0, &du);
        assert!((slope - work).abs() < 1e-7 * work.abs(), "{slope} {work}");
    }
}

#[test]
fn at_rest_the_tangent_is_that_of_linear_elasticity() {
    for mut body in bodies(2).into_iter().chain(turned(4)) {
        body.sample.moduli.shear = (0..body.sample.mesh.cell_count())
            .map(|cell| 1.0 + (cell % 2) as f64)
            .collect();
        body.sample.moduli.lame.fill(0.0);
        let sample = &body.sample;
        let linear = Grid::new(GridSource {
            mesh: &sample.mesh,
            space: &sample.space,
            geometry: &sample.geometry,
            moduli: &sample.moduli,
            held: &sample.held(),
        });
        let rest = vec![0.0; sample.unknowns()];
        let at = Arc::new(body.linearised(&rest, &vec![0.0; sample.space.vertices]));
        for basis in [Basis::Hierarchical, Basis::Lagrange] {
            let tangent = TangentStiffness {
                // 2 mu dev eps : dev eps + 2/3 mu (div u)^2 = 2 mu eps : eps.
                products: TangentProducts::new(&Arc::new(body.cells.clone()), &at, 2.0 / 3.0),
                basis,
                size: sample.unknowns(),
            };
            let x = sample.mask(Rows::Free, reproducible_noise(sample.unknowns()));
            let (mut found, mut expected) = (x.clone(), x.clone());
            let work = &mut Workspace::new();
            tangent.apply(&x, &mut found, work);
            let form = StiffnessForm {
                basis,
                rows: Rows::Free,
                volume: VolumeTerm::Own,
            };
            linear.stiffness(form, &x, &mut expected, work);
            assert!(distance(&found, &expected) < 1e-13);
        }
    }
}

#[test]
fn operators_make_the_products_that_the_laws_make() {
    for body in all_bodies(3) {
        let (u, p) = body.state();
        let (size, vertices) = (u.len(), p.len());
        let x = reproducible_noise(size + vertices + 1)[1..].to_vec();
        let operator = TangentBody {
            products: body.products(&u, &p),
            vertices,
            size,
        };
        let mut found = vec![f64::NAN; x.len()];
        operator.apply(&x, &mut found, &mut Workspace::new());
        let (y, r) = body.tangent(Rows::Free, &x[..size], &x[size..]);
        assert!(distance(&found[..size], &y) < 1e-13);
        assert!(distance(&found[size..], &r) < 1e-13);
    }
}

#[test]
fn the_divergence_and_its_transpose_are_parts_of_the_tangent() {
    for body in all_bodies(3) {
        let (u, p) = body.state();
        let x = reproducible_noise(u.len() + 1)[1..].to_vec();
        let q = reproducible_noise(p.len() + 1)[1..].to_vec();
        let divergence = TangentDivergence {
            products: body.products(&u, &p),
            vertices: p.len(),
            size: u.len(),
        };
        let work = &mut Workspace::new();
        let (mut r, mut y) = (q.clone(), x.clone());
        divergence.apply(&x, &mut r, work);
        divergence.apply_transposed(&q, &mut y, work);
        let zero_p = vec![0.0; p.len()];
        let zero_u = vec![0.0; u.len()];
        let masked = body.sample.mask(Rows::Free, x.clone());
        assert!(distance(&r, &body.tangent(Rows::Free, &x, &zero_p).1) < 1e-13);
        assert!(distance(&y, &body.tangent(Rows::Free, &zero_u, &q).0) < 1e-13);
        // With a penalty, pressures push less on what gives way to them.
        let error = (dot(&r, &q) - dot(&y, &masked)).abs() / dot(&r, &q).abs();
        assert_eq!(error < 1e-12, body.cells.penalty() == 0.0, "{error}");
    }
}

#[test]
fn every_instruction_set_gives_the_same_response_and_tangent() {
    for set in InstructionSet::ALL.into_iter().filter(|set| set.is_here()) {
        for body in all_bodies(2) {
            let (u, p) = body.state();
            let x = reproducible_noise(u.len() + 1)[1..].to_vec();
            let (f, c, first) = body.respond(&u, &p);
            let expected = body.tangent(Rows::All, &x, &p);
            let grid = body.sample.grid.clone().with_instruction_set(set);
            let other = Body {
                cells: body.cells.clone().on(Arc::new(grid)),
                sample: body.sample,
            };
            let (g, d, second) = other.respond(&u, &p);
            let errors = [distance(&g, &f), distance(&d, &c)];
            assert!(
                errors.iter().all(|&e| e < 1e-13),
                "{errors:?} {first:?} {second:?}"
            );
            assert!((first.energy - second.energy).abs() < 1e-13 * first.energy);
            assert!((first.least_jacobian - second.least_jacobian).abs() < 1e-13);
            let found = other.tangent(Rows::All, &x, &p);
            assert!(distance(&found.0, &expected.0) < 1e-13);
            assert!(distance(&found.1, &expected.1) < 1e-13);
        }
    }
}

#[test]
fn an_element_turned_inside_out_is_told_and_harms_nothing() {
    for body in all_bodies(2) {
        let (mut u, p) = body.state();
        scale(&mut u, 500.0);
        let (f, c, response) = body.respond(&u, &p);
        assert!(response.least_jacobian < 0.0);
        assert!(f.iter().chain(&c).all(|value| value.is_finite()));
    }
}

#[test]
fn a_shift_along_the_axis_strains_nothing_and_one_across_it_does() {
    for body in turned(4) {
        let vertices = 2 * body.sample.space.vertices;
        let p = vec![0.0; body.sample.space.vertices];
        let shifted = |component: usize| {
            let mut u = vec![0.0; body.sample.unknowns()];
            u[..vertices]
                .iter_mut()
                .skip(component)
                .step_by(2)
                .for_each(|u| *u = 0.1);
            body.respond(&u, &p)
        };
        let (force, volume, response) = shifted(1);
        assert!(largest(&force) < 1e-14 && largest(&volume) < 1e-14);
        assert!(response.energy.abs() < 1e-14);
        assert!(shifted(0).2.energy > 1e-3);
    }
}

#[test]
fn a_section_that_opens_along_its_radius_grows_like_its_rings() {
    // u_x = x / 4, u_y = 0: stretched by 5/4 along and around the radius.
    for body in turned(4) {
        let (sample, cells) = (&body.sample, &body.cells);
        let mut u = vec![0.0; sample.unknowns()];
        for (u, x) in u.chunks_exact_mut(2).zip(sample.mesh.coordinates()) {
            u[0] = 0.25 * SCALE * x[0];
        }
        let p = vec![0.0; sample.space.vertices];
        let (mut f, mut c) = (vec![0.0; u.len()], p.clone());
        let response = cells.respond((&u, &p), (&mut f, &mut c), &mut Workspace::new());
        let volume: f64 = sample.geometry.volumes.iter().sum();
        // That of a cylinder of radius and height SCALE.
        assert!((volume - std::f64::consts::PI * SCALE.powi(3)).abs() < 1e-13);
        assert!((response.volume_change - (1.5625 - 1.0) * volume).abs() < 1e-12);
        assert!((response.least_jacobian - 1.5625).abs() < 1e-13);
    }
}

/// A state whose gradient and pressure are the same everywhere.
fn even_state(sample: &Sample) -> (Vec<f64>, Vec<f64>) {
    let slopes = [[0.2, -0.1, 0.3], [0.05, 0.1, -0.2], [-0.15, 0.25, -0.1]];
    let mut u = vec![0.0; sample.unknowns()];
    let nodes = u.chunks_exact_mut(sample.space.components);
    for (u, x) in nodes.zip(sample.mesh.coordinates()) {
        for (u, slope) in u.iter_mut().zip(&slopes) {
            *u = SCALE * dot(slope, x);
        }
    }
    (u, vec![0.7; sample.space.vertices])
}

#[test]
fn tangents_of_cells_in_single_precision_are_those_at_the_points_of_an_even_state() {
    let solid = bodies(2).into_iter();
    for body in solid.filter(|body| body.sample.space.components == 3) {
        let sample = &body.sample;
        let (u, p) = even_state(sample);
        let of_cell = (0..sample.mesh.cell_count() as u16).map(|cell| cell % 2);
        let states = CellStates {
            mesh: &sample.mesh,
            space: &sample.space,
            geometry: &sample.geometry,
            laws: CellLaws {
                laws: &LAWS,
                of_cell: &of_cell.collect::<Vec<_>>(),
            },
            displacement: &u,
            pressure: &p,
        };
        let tangents = CellTangents::new(&states, 0.5);
        let at = Arc::new(body.linearised(&u, &p));
        let x = reproducible_noise(sample.unknowns());
        let narrow: Vec<f32> = x.iter().map(|&x| x as f32).collect();
        for basis in [Basis::Hierarchical, Basis::Lagrange] {
            let exact = Constrained {
                free: TangentStiffness {
                    products: TangentProducts::new(&Arc::new(body.cells.clone()), &at, 0.5),
                    basis,
                    size: sample.unknowns(),
                },
                held: sample.held(),
            };
            let mut expected = x.clone();
            exact.apply(&x, &mut expected, &mut Workspace::new());
            for set in InstructionSet::ALL.into_iter().filter(|set| set.is_here()) {
                let grid = sample.grid.clone().with_instruction_set(set);
                let cells = (&sample.mesh, &grid);
                let single = SingleTangent::new(cells, &tangents, basis, sample.held());
                let mut r = vec![0.0_f32; x.len()];
                let single = single.expect("tetrahedra");
                single.update_residual(&narrow, &mut r, &mut Workspace::new());
                let found: Vec<f64> = r.iter().map(|&r| -f64::from(r)).collect();
                assert!(distance(&found, &expected) < 3e-6, "{}", set.name());
            }
        }
    }
}
