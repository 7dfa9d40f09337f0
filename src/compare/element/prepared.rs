//! Data of the comparison elements: assembled matrices, the P1 solver that
//! Taylor-Hood uses too, bubbles around it.

use std::sync::Arc;
use std::time::Instant;

use crate::assembly::{CellGeometry, CellModuli};
use crate::compare::assembly::eliminated::{Eliminated, EliminatedCoupling};
use crate::compare::assembly::enriched::{divergence, pressure_mass, stiffness};
use crate::compare::precond::enriched::{BubblesAndP1, Diagonal};
use crate::compare::space::enriched::{Enriched, Enrichment};
use crate::linalg::vector::norm;
use crate::linalg::{DenseMatrix, Held, LinearOperator, Preconditioner, SparseRows, Workspace};
use crate::mesh::Mesh;
use crate::plan::Plan;
use crate::precond::schur::ChebyshevMass;
use crate::prepare::PrepareError;
use crate::prepare::bodies::P1Body;
use crate::prepare::moduli::moduli;
use crate::prepare::p1;
use crate::prepare::traces::TraceDirections;
use crate::report::{CancelToken, Seconds};
use crate::space::TaylorHood;

/// Chebyshev steps that invert a continuous pressure mass.
const MASS_STEPS: usize = 6;

/// A facet whose bubble is held, with the support that holds each component.
#[derive(Clone, Debug)]
pub(crate) struct HeldFacet {
    /// Position of the facet among the facets of the space, 0-based.
    pub(crate) facet: usize,
    /// Mesh vertices of the facet: three in space, two in the plane.
    pub(crate) vertices: Vec<u32>,
    /// Number of the support that holds each component `[3]`; none where the component
    /// is free.
    pub(crate) supports: [Option<u16>; 3],
}

/// Pressure block.
pub(crate) struct ComparisonPressure {
    /// B with held columns left out `[pressures, unknowns]`.
    pub(crate) coupling: EliminatedCoupling,
    /// C = M / lambda; none when every material is incompressible.
    pub(crate) stabilisation: Option<SparseRows>,
    /// Approximate inverse of the Schur complement: a weighted mass, or its diagonal
    /// where the pressure is constant on cells.
    pub(crate) metric: Box<dyn Preconditioner>,
    /// Integral of each pressure function `[pressures]`, volume of the scaled body.
    pub(crate) weights: Vec<f64>,
    /// No free boundary: a constant pressure does no work.
    pub(crate) is_enclosed: bool,
}

/// Prepared data of a comparison element.
pub(crate) struct ComparisonData {
    /// Numbering and shapes of the enriched space.
    pub(crate) space: Enriched,
    /// The numbering that contact shares with Taylor-Hood.
    pub(crate) trace: TaylorHood,
    /// Volumes and barycentric gradients of the scaled cells.
    pub(crate) geometry: CellGeometry,
    /// Indices of the held unknowns, ascending.
    pub(crate) held: Arc<[u32]>,
    /// Facets whose bubbles supports hold, so that prescribed values reach them too.
    pub(crate) held_facets: Vec<HeldFacet>,
    /// A with held rows and columns the identity `[unknowns, unknowns]`, in units of
    /// the smallest shear modulus.
    pub(crate) stiffness: Eliminated,
    /// Approximate inverse of A: bubbles by blocks of their diagonal, P1 by its solver.
    pub(crate) displacement: BubblesAndP1,
    /// The pressure block; these elements are mixed, so that there always is one.
    pub(crate) pressure: ComparisonPressure,
    /// A11^-1 on the contact vertices; empty without contact.
    pub(crate) compliance: Arc<DenseMatrix>,
    /// Contact vertices and the directions in which the compliance is taken there.
    pub(crate) traces: TraceDirections,
    /// Bytes that the P1 solver holds.
    p1_bytes: u64,
    /// Name of the P1 part, for reports of what was built and reused.
    p1_part: &'static str,
    /// Wall seconds that building took, by phase.
    seconds: Seconds,
}

impl std::fmt::Debug for ComparisonData {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.debug_struct("ComparisonData")
            .field("unknowns", &self.space.displacement_unknowns())
            .field("bytes", &self.bytes())
            .finish_non_exhaustive()
    }
}

impl ComparisonData {
    /// Assembles the operators, factorises the P1 block and takes the compliance at the
    /// contact vertices; ends early where `cancel` says so. Cost: that of the P1 solver
    /// and one of its solves a trace.
    pub(crate) fn build(
        plan: &Plan,
        enrichment: Enrichment,
        mesh: &Arc<Mesh>,
        cancel: &CancelToken,
    ) -> Result<Self, PrepareError> {
        let start = Instant::now();
        let stopped = |termination| Err(PrepareError::Stopped(termination));
        let poll = || cancel.stopped().map_or(Ok(()), stopped);
        let space = Enriched::new(mesh, enrichment);
        let trace = TaylorHood::new(mesh);
        let geometry = CellGeometry::new(mesh, plan.units.coordinate_scale);
        let moduli = moduli(plan);
        let held_facets = held_facets(plan, mesh, &space);
        let held = held(plan, &space, &held_facets);
        poll()?;
        let on_p1 = held.partition_point(|&unknown| (unknown as usize) < space.p1_unknowns());
        let p1 = p1::build(
            plan,
            P1Body {
                mesh,
                space: &trace,
                geometry: &geometry,
                stiffness: &moduli,
                held: &Held::of_entries(space.components, &held[..on_p1]),
                moved: &[],
            },
            cancel,
        )?;
        poll()?;
        let assembling = Instant::now();
        let matrix = Arc::new(stiffness(&space, mesh, &geometry, &moduli));
        let pressure = pressure(&space, mesh, &geometry, &moduli, &held);
        let assembled = assembling.elapsed().as_secs_f64();
        poll()?;
        let displacement = around_p1(&space, matrix.clone(), &held, p1.solver);
        let seconds = seconds(start, p1.assemble + assembled, p1.factorise);
        Ok(Self {
            space,
            trace,
            geometry,
            compliance: p1.compliance,
            traces: p1.traces,
            stiffness: Eliminated {
                matrix,
                held: held.clone(),
            },
            held,
            held_facets,
            displacement,
            pressure,
            p1_bytes: p1.bytes,
            p1_part: p1.part,
            seconds,
        })
    }

    /// Bytes that the matrices and the P1 solver hold, for the budget of prepared data.
    pub(crate) fn bytes(&self) -> u64 {
        let pressure = &self.pressure;
        let matrices = self.stiffness.matrix.bytes() + pressure.coupling.bytes();
        let volume = pressure.stabilisation.as_ref().map_or(0, SparseRows::bytes);
        self.space.bytes()
            + self.geometry.bytes()
            + matrices
            + volume
            + self.compliance.bytes()
            + self.displacement.bytes()
            + self.p1_bytes
            + (8 * pressure.weights.len() + 4 * self.held.len()) as u64
    }

    /// Wall seconds that building took, by phase.
    pub(crate) fn seconds(&self) -> Seconds {
        self.seconds
    }

    /// Names of the parts, for reports of reuse.
    pub(crate) fn parts(&self) -> Vec<String> {
        let parts = ["numbering", "geometry", "matrices", self.p1_part];
        parts.into_iter().map(str::to_owned).collect()
    }
}

/// What building took since `start`, of which two parts are named.
fn seconds(start: Instant, assemble: f64, factorise: f64) -> Seconds {
    let total = start.elapsed().as_secs_f64();
    Seconds {
        prepare: (total - assemble - factorise).max(0.0),
        assemble,
        factorise,
        total,
        ..Seconds::default()
    }
}

/// The P1 solver between sweeps over the bubbles.
fn around_p1(
    space: &Enriched,
    matrix: Arc<SparseRows>,
    held: &[u32],
    p1: Arc<dyn Preconditioner>,
) -> BubblesAndP1 {
    let mut is_held = vec![false; space.displacement_unknowns()];
    held.iter()
        .for_each(|&index| is_held[index as usize] = true);
    BubblesAndP1::new(
        matrix,
        space.p1_unknowns(),
        space.bubble_block(),
        is_held,
        p1,
    )
}

/// Facets of supports that hold a component along the facet's normal; where
/// supports overlap, the first one named holds.
fn held_facets(plan: &Plan, mesh: &Mesh, space: &Enriched) -> Vec<HeldFacet> {
    if space.enrichment == Enrichment::CellBubbles {
        return Vec::new();
    }
    let mut found: std::collections::BTreeMap<usize, HeldFacet> = Default::default();
    for (index, support) in plan.resolved.supports.iter().enumerate() {
        for &member in &support.facets {
            let vertices = mesh.facet(member as usize);
            let facet = space.facet(vertices);
            let entry = found.entry(facet).or_insert_with(|| HeldFacet {
                facet,
                vertices: vertices.to_vec(),
                supports: [None; 3],
            });
            for (slot, value) in entry.supports.iter_mut().zip(support.displacement) {
                *slot = slot.or(value.map(|_| index as u16));
            }
        }
    }
    let holds = |held: &HeldFacet| {
        let normal = space.normal(held.facet);
        (0..space.components).any(|i| held.supports[i].is_some() && normal[i].abs() > 1e-9)
    };
    found.into_values().filter(holds).collect()
}

/// All held unknowns, ascending.
fn held(plan: &Plan, space: &Enriched, facets: &[HeldFacet]) -> Arc<[u32]> {
    let p1 = plan.held.iter().map(|&(unknown, _)| unknown);
    let on_vertices = p1.filter(|&unknown| (unknown as usize) < space.p1_unknowns());
    let bubbles = facets
        .iter()
        .map(|held| space.facet_unknown(held.facet) as u32);
    on_vertices.chain(bubbles).collect()
}

/// The divergence, the stabilisation of compressible materials, and the mass weighted
/// by 1 / (2 mu) + 1 / lambda as metric.
fn pressure(
    space: &Enriched,
    mesh: &Mesh,
    geometry: &CellGeometry,
    moduli: &CellModuli,
    held: &Arc<[u32]>,
) -> ComparisonPressure {
    let schur = |cell: usize| 0.5 / moduli.shear[cell] + moduli.inverse_lame[cell];
    let mass = |weight: &dyn Fn(usize) -> f64| pressure_mass(space, mesh, geometry, weight);
    let compressible = moduli.inverse_lame.iter().any(|&inverse| inverse != 0.0);
    let coupling = EliminatedCoupling::new(divergence(space, mesh, geometry), held.clone());
    let metric: Box<dyn Preconditioner> = match space.enrichment {
        Enrichment::CellBubbles => {
            let steps = MASS_STEPS;
            Box::new(ChebyshevMass::new(mass(&schur), space.components, steps))
        }
        Enrichment::FacetBubbles => Box::new(Diagonal::new(&mass(&schur).diagonal())),
    };
    let mut weights = vec![0.0; space.pressure_unknowns()];
    let ones = vec![1.0; weights.len()];
    mass(&|_| 1.0).apply(&ones, &mut weights, &mut Workspace::new());
    ComparisonPressure {
        is_enclosed: !compressible && constant_pressure_is_idle(&coupling),
        coupling,
        stabilisation: compressible.then(|| mass(&|cell| moduli.inverse_lame[cell])),
        metric,
        weights,
    }
}

/// Whether B^T 1 vanishes on free rows.
fn constant_pressure_is_idle(coupling: &EliminatedCoupling) -> bool {
    let mut work = Workspace::new();
    let ones = vec![1.0; coupling.rows()];
    let (mut free, mut all) = (vec![0.0; coupling.columns()], vec![0.0; coupling.columns()]);
    coupling.apply_transposed(&ones, &mut free, &mut work);
    coupling.transposed.apply(&ones, &mut all, &mut work);
    norm(&free) <= 1e-12 * norm(&all)
}
