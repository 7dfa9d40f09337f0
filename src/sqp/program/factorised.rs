//! A program by a factor of its saddle point: the operators found by products, the nodes
//! ordered, everything handed to the method and dropped behind it.

use super::QuadraticProgram;
use super::solve::Solve;
use crate::assembly::probe::{Probed, Probes};
use crate::inequality::{
    Factorised, InequalitySolver, Matrices, QpNorms, QpOutcome, QpRun, QpScales, QpStatus,
};
use crate::krylov::Verdict;
use crate::linalg::ordering::{Graph, nested_dissection};
use crate::linalg::{SparseRows, Workspace};
use crate::model::Model;
use crate::plan::second_attempt::MOST_FACTOR_FLOPS;
use crate::sqp::linear::Track;

impl QuadraticProgram<'_> {
    /// Solves the program by a factor on each face.
    pub(super) fn run_factorised(
        &self,
        curvature: Option<&SparseRows>,
        solve: Solve<'_>,
        track: &mut Track<'_, '_>,
        work: &mut Workspace,
    ) -> QpOutcome {
        let stopped = || track.poll() == Verdict::Stop;
        let Some(matrices) = self.matrices(curvature, &stopped, work) else {
            return QpOutcome::new(QpStatus::Interrupted);
        };
        let displacement = track.displacement;
        let step = self.block_step(displacement, work);
        let blocks = self.blocks();
        let method = Factorised {
            problem: self.problem(curvature, displacement, &blocks, &*step),
            matrices,
        };
        let guided = self.model.plan.guided_multipliers;
        let mut progress = |norms: &QpNorms, scales: &QpScales, active: usize| {
            track.iteration(norms, scales, active.saturating_sub(guided))
        };
        let mut run = QpRun {
            targets: solve.targets,
            scales: solve.scales,
            iterations: 0,
            directions: solve.directions,
            progress: &mut progress,
            work,
        };
        method.solve(solve.iterate, &mut run)
    }

    /// The matrices of the program; none where it was stopped on the way.
    fn matrices<'m>(
        &'m self,
        curvature: Option<&SparseRows>,
        stopped: &dyn Fn() -> bool,
        work: &mut Workspace,
    ) -> Option<Matrices<'m>> {
        let model = &self.model;
        let space = &model.prepared.space;
        let probes = Probes::new(model.mesh, space);
        let square = Probed {
            operator: self.stiffness(),
            rows: space.components,
        };
        let mut stiffness = probes.matrix(square, stopped, work)?;
        if let Some(curvature) = curvature {
            stiffness = stiffness.plus_multiple(-1.0, curvature);
        }
        let coupling = match self.pressure() {
            Some(pressure) => {
                let operator = pressure.rows;
                Some(probes.matrix(Probed { operator, rows: 1 }, stopped, work)?)
            }
            None => None,
        };
        let block = model.prepared.pressure.as_ref();
        Some(Matrices {
            stiffness,
            coupling,
            stabilisation: block.and_then(|block| block.stabilisation.as_ref()),
            contact: &self.now.coupling,
            places: places(model),
            is_loose: model.plan.is_floating(),
            most_flops: MOST_FACTOR_FLOPS,
        })
    }
}

/// Place of each displacement unknown in the elimination order: a nested dissection of the
/// vertices, each edge with the first of its ends. A separator of vertices with the edges
/// between them parts the cells, and so all nodes.
fn places(model: &Model<'_>) -> Vec<u32> {
    let space = &model.prepared.space;
    let graph = Graph::from_edges(space.vertices, &space.edges);
    let order = nested_dissection(model.mesh.coordinates(), &graph, &[]);
    let mut of_vertex = vec![0; order.len()];
    for (place, &vertex) in order.iter().enumerate() {
        of_vertex[vertex as usize] = place as u32;
    }
    let first_end = |&[a, b]: &[u32; 2]| of_vertex[a as usize].min(of_vertex[b as usize]);
    let nodes = of_vertex.iter().copied();
    nodes
        .chain(space.edges.iter().map(first_end))
        .flat_map(|place| std::iter::repeat_n(place, space.components))
        .collect()
}
