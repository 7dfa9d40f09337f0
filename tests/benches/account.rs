//! Account of one application of a linear solve: bytes and floating-point operations of each
//! part, the time that they take at least on this machine, and the time that they take.
//!
//! `cargo bench -p signorini --bench account -- [--cells N]`, N = 34 for 986 k unknowns, 24 for
//! 353 k. Bytes are those of arrays that do not stay in a cache: vectors, and what a part keeps.
//! The least time is that of the bytes at the measured rate of reading, or of the operations at
//! the measured rate of a matrix product, whichever is longer; two threads. What is counted once
//! an application stands at the end beside the whole, measured on a session.

#![allow(clippy::print_stdout)] // The table is what it is for.

mod body;

use std::sync::Arc;
use std::time::{Duration, Instant};

use body::{Body, bent_cube};
use faer::Mat;
use signorini::assembly::grid::{Basis, Rows, SingleGrid};
use signorini::assembly::kernel::Batch;
use signorini::assembly::mass::weighted_mass;
use signorini::element::quadrature::{Simplex, rule};
use signorini::krylov::sweeps::{self, Combination, GROUP, Overlaps};
use signorini::linalg::cholesky::Precision;
use signorini::linalg::vector::reproducible_noise;
use signorini::linalg::{Preconditioner, Workspace};
use signorini::precond::p1::{AmgP1, VertexBlocks};
use signorini::precond::schur::ChebyshevMass;
use signorini::precond::{NodeBlocks, Transfer};
use signorini::{CancelToken, Plan, Prepared, Reuse, Session, Silent, Step};

/// Threads of all measurements.
const THREADS: usize = 2;
/// A part is repeated for this long.
const LONG_ENOUGH: Duration = Duration::from_millis(400);
/// Numbers of a measured read: 512 MB, beyond any cache.
const READ: usize = 1 << 26;
/// Rows of the matrix product whose rate counts as the peak.
const ROWS: usize = 1500;
/// Directions that an iteration is made orthogonal to.
const KEPT: usize = 5;
/// Operations of a product with A on a tetrahedron: gradients at four points (340), the law (120),
/// and forces (500).
const OPERATIONS: f64 = 960.0;
/// Products with its matrix that a multigrid cycle takes on each level.
const PRODUCTS: f64 = 5.0;
/// Steps of the pressure metric.
const MASS_STEPS: usize = 6;

/// What the machine gives at most, by two threads.
struct Machine {
    /// Bytes read a second.
    bandwidth: f64,
    /// Operations a second.
    peak: f64,
}

impl Machine {
    fn measured() -> Self {
        let x = vec![1.0; READ];
        let (low, high) = x.split_at(READ / 2);
        let read = seconds(|| {
            std::hint::black_box(rayon::join(|| total(low), || total(high)));
        });
        let a = Mat::<f64>::from_fn(ROWS, ROWS, |i, j| (i * j % 7) as f64);
        let product = seconds(|| {
            std::hint::black_box(rayon::join(|| &a * &a, || &a * &a));
        });
        Self {
            bandwidth: 8.0 * READ as f64 / read,
            peak: THREADS as f64 * 2.0 * (ROWS as f64).powi(3) / product,
        }
    }

    /// Seconds of a part at least.
    fn least(&self, part: &Part) -> f64 {
        (part.bytes / self.bandwidth).max(part.operations / self.peak)
    }
}

/// The sum of numbers, in so many parts that it waits for memory alone.
fn total(x: &[f64]) -> f64 {
    let mut sums = [0.0; 32];
    for x in x.chunks_exact(32) {
        sums.iter_mut().zip(x).for_each(|(sum, x)| *sum += x);
    }
    sums.iter().sum()
}

/// A part of an application.
struct Part {
    name: &'static str,
    /// How often it runs.
    times: f64,
    /// Bytes of one run.
    bytes: f64,
    /// Operations of one run.
    operations: f64,
    /// Measured seconds of one run.
    seconds: f64,
}

/// Median of repeated runs.
fn seconds(mut task: impl FnMut()) -> f64 {
    task();
    let (start, mut taken) = (Instant::now(), Vec::new());
    while taken.len() < 3 || start.elapsed() < LONG_ENOUGH {
        let one = Instant::now();
        task();
        taken.push(one.elapsed().as_secs_f64());
    }
    taken.sort_by(f64::total_cmp);
    taken[taken.len() / 2]
}

/// Products with A, B^T and both.
fn products(body: &Body) -> Vec<Part> {
    let (grid, mut work) = (body.grid(), Workspace::new());
    let single = SingleGrid::new(&grid);
    let (size, vertices) = (body.space.displacement_unknowns(), body.space.vertices);
    let (x, p) = (reproducible_noise(size), reproducible_noise(vertices));
    let (mut y, mut r) = (vec![0.0; size], vec![0.0; vertices]);
    let (u, mut f) = (rounded(&x), vec![0.0_f32; size]);
    let (n, m) = (8.0 * size as f64, 8.0 * vertices as f64);
    let (kept, cells) = (grid.bytes() as f64, body.geometry.cells() as f64);
    // Numbers of nodes and places of copies, which both precisions read.
    let shared = kept - cells / 8.0 * size_of::<Batch<4, 3, 6>>() as f64;
    vec![
        Part {
            name: "A in the smoother and the correction",
            times: 3.0,
            bytes: single.bytes() as f64 + shared + 1.5 * n,
            operations: cells * OPERATIONS / 2.0,
            seconds: seconds(|| single.subtract_stiffness(Basis::Lagrange, &u, &mut f, &mut work)),
        },
        Part {
            name: "A, B and B^T together",
            times: 1.0,
            bytes: kept + 2.0 * (n + m),
            operations: cells * (OPERATIONS + 60.0),
            seconds: seconds(|| grid.saddle((&x, &p), (&mut y, &mut r), &mut work)),
        },
        Part {
            name: "B^T before the displacement",
            times: 1.0,
            bytes: kept + 2.0 * n + m,
            operations: cells * 250.0,
            seconds: seconds(|| {
                grid.divergence_transposed(Rows::Free, &p, &mut y, &mut work);
            }),
        },
    ]
}

/// In single precision.
fn rounded(x: &[f64]) -> Vec<f32> {
    x.iter().map(|&value| value as f32).collect()
}

/// Smoother, transfers, P1 solve and pressure metric.
fn preconditioner(body: &Body) -> Option<Vec<Part>> {
    let (size, vertices) = (body.space.displacement_unknowns(), body.space.vertices);
    let coarse = 3 * vertices;
    let blocks = body.p1();
    let cycle = AmgP1::new(
        &VertexBlocks {
            components: 3,
            coordinates: body.mesh.coordinates(),
            edges: &body.space.edges,
            diagonal: &blocks.diagonal,
            off: &blocks.off,
            held: &body.held,
        },
        Precision::Single,
    )
    .ok()?;
    let smoother = NodeBlocks::invert(3, body.cells().node_blocks(&body.held));
    let edges = body.space.edges.clone();
    let transfer = Transfer::new(vertices, 3, edges, body.held.clone());
    let mass = weighted_mass(
        (&body.mesh, &body.geometry),
        &rule(Simplex::Tetrahedron, 2),
        |_| 0.5,
    );
    let metric = ChebyshevMass::new(mass, 3, MASS_STEPS);
    let r = reproducible_noise(size);
    let (mut d, mut x) = (vec![0.0_f32; size], vec![0.0_f32; size]);
    let (rest, mut z2) = (rounded(&r), vec![0.0; size]);
    let (r1, mut z1) = (reproducible_noise(coarse), vec![0.0; coarse]);
    let mut z = vec![0.0; vertices];
    let mut work = Workspace::new();
    let n = 8.0 * size as f64;
    Some(vec![
        Part {
            name: "Chebyshev step in node blocks",
            times: 3.0,
            bytes: smoother.bytes() as f64 + 2.5 * n,
            operations: 5.0 * size as f64,
            seconds: seconds(|| smoother.chebyshev_update((0.3, 0.7), &rest, &mut d, &mut x)),
        },
        Part {
            name: "transfers between bases and to P1",
            times: 1.0,
            bytes: 4.25 * n + transfer.bytes() as f64,
            operations: 8.0 * size as f64,
            seconds: seconds(|| {
                transfer.residual_to_lagrange(1.0, &r, &mut x);
                transfer.restrict(&x, &mut z1);
                transfer.prolong(&z1, &mut d);
                transfer.values_to_hierarchical(1.0, &d, &mut z2);
            }),
        },
        Part {
            name: "P1 multigrid cycle",
            times: 1.0,
            bytes: PRODUCTS * cycle.bytes() as f64,
            operations: PRODUCTS * cycle.bytes() as f64 / 2.0,
            seconds: seconds(|| cycle.apply(&r1, &mut z1, &mut work)),
        },
        Part {
            name: "pressure metric",
            times: 1.0,
            bytes: MASS_STEPS as f64 * metric.bytes() as f64,
            operations: MASS_STEPS as f64 * metric.bytes() as f64 / 6.0,
            seconds: seconds(|| metric.apply(&r1[..vertices], &mut z, &mut work)),
        },
    ])
}

/// Orthogonalisation against the kept directions, and updates of x and r.
fn krylov(body: &Body) -> Part {
    let size = body.space.displacement_unknowns() + body.space.vertices;
    let kept: Vec<Vec<f64>> = vec![reproducible_noise(size); 2 * KEPT];
    let view = |first: usize| -> [&[f64]; GROUP] {
        std::array::from_fn(|k| if k < KEPT { &kept[first + k][..] } else { &[] })
    };
    let (directions, images) = (view(0), view(KEPT));
    let (mut d, mut p) = (reproducible_noise(size), reproducible_noise(size));
    let (mut x, mut r) = (vec![0.0; size], vec![0.0; size]);
    let n = 8.0 * size as f64;
    Part {
        name: "Krylov: five directions, x and r",
        times: 1.0,
        bytes: (3 * KEPT + 2 + 8) as f64 * n,
        operations: (6 * KEPT + 4) as f64 * size as f64,
        seconds: seconds(|| {
            let overlaps = Overlaps::of(&p, &r, &images).kept.map(|c| 1e-9 * c);
            let by = Combination {
                overlaps: &overlaps,
                directions,
                images,
                length: 1.0,
                step: 1e-9,
            };
            let (direction, product) = (&mut d[..], &mut p[..]);
            let (x, r) = (&mut x[..], &mut r[..]);
            let step = sweeps::Step {
                direction,
                product,
                x,
                r,
            };
            step.take(&by);
        }),
    }
}

/// Applications and Krylov seconds of cube-bend at 1e-8, and bytes of a session.
fn whole(body: &Body) -> Result<(u32, f64), Box<dyn std::error::Error>> {
    let plan = Arc::new(Plan::new(&bent_cube(), &[], &body.mesh)?);
    let prepared = Arc::new(Prepared::build(&plan, &body.mesh, &CancelToken::new())?);
    let mut session = Session::new(plan, body.mesh.clone(), prepared, Reuse::Reused);
    let mut run = session.begin_step(&Step::default())?;
    let report = session.advance(&mut run, &mut Silent, &CancelToken::new());
    let report = report.ok_or("no increment")?;
    Ok((report.preconditioner_applications, report.seconds.krylov))
}

fn print(machine: &Machine, parts: &[Part]) {
    println!(
        "{:38} {:>5} {:>8} {:>8} {:>8} {:>8} {:>8}",
        "part, all its runs", "runs", "MB", "Mflop", "ms least", "ms", "share"
    );
    for part in parts {
        let least = machine.least(part);
        println!(
            "{:38} {:5} {:8.1} {:8.1} {:8.2} {:8.2} {:7.0}%",
            part.name,
            part.times,
            1e-6 * part.times * part.bytes,
            1e-6 * part.times * part.operations,
            1e3 * part.times * least,
            1e3 * part.times * part.seconds,
            100.0 * least / part.seconds
        );
    }
}

fn account(cells: usize) -> Result<(), Box<dyn std::error::Error>> {
    let machine = Machine::measured();
    let body = Body::new(cells);
    let unknowns = body.space.displacement_unknowns() + body.space.vertices;
    println!(
        "{unknowns} unknowns, {} cells; {THREADS} threads read {:.1} GB/s, multiply at {:.0} Gflop/s",
        body.geometry.cells(),
        1e-9 * machine.bandwidth,
        1e-9 * machine.peak
    );
    let mut parts = products(&body);
    parts.extend(preconditioner(&body).unwrap_or_default());
    parts.push(krylov(&body));
    print(&machine, &parts);
    let sum = |of: &dyn Fn(&Part) -> f64| -> f64 { parts.iter().map(of).sum() };
    let least = sum(&|part| part.times * machine.least(part));
    let measured = sum(&|part| part.times * part.seconds);
    let (applications, seconds) = whole(&body)?;
    println!(
        "all parts: {:.1} ms, {:.1} at least; an application of {applications} in a solve: {:.1} ms",
        1e3 * measured,
        1e3 * least,
        1e3 * seconds / f64::from(applications.max(1))
    );
    Ok(())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let at = arguments.iter().position(|argument| argument == "--cells");
    let cells = at.and_then(|at| arguments.get(at + 1)?.parse().ok());
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(THREADS)
        .build()?;
    pool.install(|| account(cells.unwrap_or(24)).map_err(|error| error.to_string()))?;
    Ok(())
}
