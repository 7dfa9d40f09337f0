//! Data of the comparison elements: assembled matrices, the P1 solver that
//! Taylor-Hood uses too, bubbles around it.

use std::sync::Arc;
use std::time::Instant;

use super::Plan;
use super::p1::{self, P1Body};
use super::prepared::{PrepareError, moduli};
use crate::assembly::eliminated::{Eliminated, EliminatedCoupling};
use crate::assembly::enriched::{divergence, pressure_mass, stiffness};
use crate::assembly::{CellGeometry, CellModuli};
use crate::linalg::vector::norm;
use crate::linalg::{DenseMatrix, LinearOperator, Preconditioner, SparseRows, Workspace};
use crate::mesh::Mesh;
use crate::precond::enriched::{BubblesAndP1, Diagonal};
use crate::precond::schur::ChebyshevMass;
use crate::report::{CancelToken, Seconds};
use crate::space::TaylorHood;
use crate::space::enriched::{Enriched, Enrichment};

/// Chebyshev steps that invert a continuous pressure mass.
const MASS_STEPS: usize = 6;

/// A facet whose bubble is held, with the support that holds each component.
#[derive(Clone, Debug)]
pub(crate) struct HeldFacet {
    pub(crate) facet: usize,
    pub(crate) vertices: Vec<u32>,
    pub(crate) supports: [Option<u16>; 3],
}

/// Pressure block.
pub(crate) struct ComparisonPressure {
    pub(crate) coupling: EliminatedCoupling,
    /// C = M / lambda; none when every material is incompressible.
    pub(crate) stabilisation: Option<SparseRows>,
    pub(crate) metric: Box<dyn Preconditioner>,
    /// Integral of each pressure function.
    pub(crate) weights: Vec<f64>,
    /// No free boundary: a constant pressure does no work.
    pub(crate) is_enclosed: bool,
}

/// Prepared data of a comparison element.
pub(crate) struct ComparisonData {
    pub(crate) space: Enriched,
    /// The numbering that contact shares with Taylor-Hood.
    pub(crate) trace: TaylorHood,
    pub(crate) geometry: CellGeometry,
    pub(crate) held: Arc<[u32]>,
    pub(crate) held_facets: Vec<HeldFacet>,
    pub(crate) stiffness: Eliminated,
    pub(crate) displacement: BubblesAndP1,
    pub(crate) pressure: ComparisonPressure,
    /// A11^-1 on the contact vertices; empty without contact.
    pub(crate) compliance: DenseMatrix,
    pub(crate) contact_normals: Vec<[f64; 3]>,
    p1_bytes: u64,
    p1_part: &'static str,
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
    pub(super) fn build(
        plan: &Plan,
        enrichment: Enrichment,
        mesh: &Arc<Mesh>,
        cancel: &CancelToken,
    ) -> Result<Self, PrepareError> {
        let start = Instant::now();
        let poll = || {
            cancel
                .stopped()
                .map_or(Ok(()), |t| Err(PrepareError::Stopped(t)))
        };
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
                held: &held[..on_p1],
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
        let mut is_held = vec![false; space.displacement_unknowns()];
        held.iter()
            .for_each(|&index| is_held[index as usize] = true);
        let displacement = BubblesAndP1::new(
            matrix.clone(),
            space.p1_unknowns(),
            space.bubble_block(),
            is_held,
            p1.solver,
        );
        let total = start.elapsed().as_secs_f64();
        let assemble = p1.assemble + assembled;
        Ok(Self {
            space,
            trace,
            geometry,
            compliance: p1.compliance,
            contact_normals: p1.normals,
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
            seconds: Seconds {
                prepare: (total - assemble - p1.factorise).max(0.0),
                assemble,
                factorise: p1.factorise,
                total,
                ..Seconds::default()
            },
        })
    }

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

    pub(crate) fn seconds(&self) -> Seconds {
        self.seconds
    }

    /// Names of the parts, for reports of reuse.
    pub(crate) fn parts(&self) -> Vec<String> {
        let parts = ["numbering", "geometry", "matrices", self.p1_part];
        parts.into_iter().map(str::to_owned).collect()
    }
}

/// Facets of supports that hold a component along the facet's normal; where
/// supports overlap, the first one named holds.
fn held_facets(plan: &Plan, mesh: &Mesh, space: &Enriched) -> Vec<HeldFacet> {
    if space.enrichment == Enrichment::CellBubbles {
        return Vec::new();
    }
    let mut found: std::collections::BTreeMap<usize, HeldFacet> = Default::default();
    let supports = plan.scene.supports.iter();
    for (index, (support, facets)) in supports.zip(&plan.resolved.support_facets).enumerate() {
        for &member in facets {
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
