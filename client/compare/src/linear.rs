//! Programs without contact by the methods that conjugate gradients are compared with:
//! the stationary iteration on the displacement, MINRES and nested Uzawa on
//! displacement and pressure.

use crate::krylov::{minres, stationary};
use crate::saddle::{BlockDiagonal, Uzawa};
use signorini::inequality::linear::ConjugateGradients;
use signorini::inequality::{LinearSolver, LinearSystem};
use signorini::krylov::{Monitor, Outcome};
use signorini::linalg::Workspace;
use signorini::saddle::SaddleOperator;
use signorini::scene::SaddleMethod;

/// Share of the force target that one inner solve of Uzawa may leave.
const INNER_SHARE: f64 = 0.1;

/// The method of that name; none for those that serve contact, and for the solver's
/// own.
pub(crate) fn linear(method: SaddleMethod) -> Option<Box<dyn LinearSolver>> {
    match method {
        SaddleMethod::Stationary => Some(Box::new(Stationary)),
        SaddleMethod::UzawaCg => Some(Box::new(NestedUzawa)),
        SaddleMethod::Minres => Some(Box::new(Minres)),
        SaddleMethod::ConjugateGradients | SaddleMethod::Gcr | SaddleMethod::ArrowHurwicz => None,
    }
}

/// The preconditioner as a stationary iteration, without a Krylov method around it.
struct Stationary;

impl LinearSolver for Stationary {
    fn solve(
        &self,
        system: &LinearSystem<'_>,
        unknowns: (&mut [f64], &mut [f64]),
        monitor: &mut dyn Monitor,
        work: &mut Workspace,
    ) -> Outcome {
        let method = stationary::Stationary {
            operator: system.stiffness,
            preconditioner: system.displacement,
            iterations: system.iterations,
        };
        method.solve(unknowns, monitor, work)
    }
}

/// Conjugate gradients on the pressure, with an inner solve for the displacement in
/// each product.
struct NestedUzawa;

impl LinearSolver for NestedUzawa {
    fn solve(
        &self,
        system: &LinearSystem<'_>,
        (x, r): (&mut [f64], &mut [f64]),
        monitor: &mut dyn Monitor,
        work: &mut Workspace,
    ) -> Outcome {
        let Some(&block) = system.pressure else {
            return ConjugateGradients.solve(system, (x, r), monitor, work);
        };
        let uzawa = Uzawa {
            stiffness: system.stiffness,
            displacement: system.displacement,
            block,
            inner_bound: INNER_SHARE * system.targets.level * system.targets.force_scale,
        };
        uzawa.solve((x, r), system.iterations, monitor, work)
    }
}

/// MINRES with a block diagonal preconditioner.
struct Minres;

impl LinearSolver for Minres {
    fn solve(
        &self,
        system: &LinearSystem<'_>,
        unknowns: (&mut [f64], &mut [f64]),
        monitor: &mut dyn Monitor,
        work: &mut Workspace,
    ) -> Outcome {
        let blocks = system.pressure.map_or(&[][..], std::slice::from_ref);
        let operator = SaddleOperator {
            stiffness: system.stiffness,
            geometric: None,
            blocks,
        };
        let diagonal = BlockDiagonal {
            displacement: system.displacement,
            blocks,
        };
        let method = minres::Minres {
            operator: &operator,
            preconditioner: &diagonal,
            iterations: system.iterations,
        };
        method.solve(unknowns, monitor, work)
    }
}
