//! Questions about methods, and the runs that answer them.
//!
//! A study compares choices (sets of keys) on some families. What the figures
//! and the table of a study say is computed from its rows in
//! [`crate::study_figures`] and [`crate::answer`]; a choice that the program
//! refuses, or that fails, is shown as a failure.

use crate::families;
use crate::family::{Family, Level};
use crate::method::Method;

/// Label of meshes that the program refines itself.
pub(crate) const REFINED: &str = "refined by the force";

/// One of the compared methods.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Choice {
    /// As figures spell it.
    pub(crate) label: &'static str,
    /// As [`Method`] reads it.
    pub(crate) keys: &'static str,
    /// Where its runs come from.
    pub(crate) origin: Origin,
}

/// Where the runs of a choice come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Origin {
    /// The program.
    Run,
    /// A table: see [`crate::recorded`].
    Recorded,
    /// The program, on the coarsest mesh only, which it refines itself. Choices of the same label
    /// are one curve.
    Refined,
}

impl Choice {
    /// Its settings; none for keys that cannot be read, which a test excludes.
    pub(crate) fn method(&self) -> Option<Method> {
        self.keys.parse().ok()
    }
}

/// A family and the meshes of it that a study takes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scope {
    /// Name of the family.
    pub(crate) family: &'static str,
    /// Levels of a full run.
    pub(crate) full: &'static [u32],
    /// Levels of a quick run.
    pub(crate) quick: &'static [u32],
}

impl Scope {
    /// The family; none for a name that is not there, which a test excludes.
    pub(crate) fn family(&self) -> Option<&'static Family> {
        families::find(self.family).ok()
    }

    /// Its levels of these numbers.
    pub(crate) fn levels(&self, numbers: &[u32]) -> Vec<Level> {
        let letter = self.family().map_or('n', |family| family.source.letter());
        numbers
            .iter()
            .map(|&number| Level { letter, number })
            .collect()
    }
}

/// What the runs of a study are compared by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Measure {
    /// Seconds and applications on the same mesh.
    SameMesh,
    /// Seconds at the same error: the choices are different discretisations.
    SameError,
    /// Error on the same mesh, and the limits that the choices tend to: those of
    /// discretisations of the same problem.
    Limits,
    /// As [`Measure::SameMesh`], on one mesh a family: a table without figures.
    OneMesh,
    /// Error and seconds over the tolerance, on one mesh.
    Tolerance,
    /// Rows of [`crate::extremes`], not runs of families.
    Extremes,
}

/// A question with its runs.
#[derive(Debug)]
pub(crate) struct Study {
    /// As `--study` takes it.
    pub(crate) name: &'static str,
    /// For the title.
    pub(crate) question: &'static str,
    /// What is compared, in two or three sentences.
    pub(crate) about: &'static str,
    pub(crate) scopes: &'static [Scope],
    /// The first is what the plan takes by itself.
    pub(crate) choices: &'static [Choice],
    pub(crate) tolerances: &'static [f64],
    pub(crate) measure: Measure,
}

/// A study by name.
///
/// # Errors
/// A message that names all of them.
pub(crate) fn find(name: &str) -> Result<&'static Study, String> {
    let found = STUDIES.iter().find(|study| study.name == name);
    found.ok_or_else(|| {
        let names: Vec<_> = STUDIES.iter().map(|study| study.name).collect();
        format!("known: {}", names.join(", "))
    })
}

const fn choice(label: &'static str, keys: &'static str) -> Choice {
    Choice {
        label,
        keys,
        origin: Origin::Run,
    }
}

const fn recorded(label: &'static str, keys: &'static str) -> Choice {
    Choice {
        label,
        keys,
        origin: Origin::Recorded,
    }
}

const fn refined(label: &'static str, keys: &'static str) -> Choice {
    Choice {
        label,
        keys,
        origin: Origin::Refined,
    }
}

const fn scope(family: &'static str, full: &'static [u32], quick: &'static [u32]) -> Scope {
    Scope {
        family,
        full,
        quick,
    }
}

const TIGHT: &[f64] = &[1e-8];

/// All studies, in the order of the page.
pub(crate) const STUDIES: &[Study] = &[
    Study {
        name: "element",
        question: "Which element: Taylor-Hood, MINI or SMALL?",
        about: "Taylor-Hood (P2 displacement, P1 pressure), MINI (P1 and a bubble, P1 pressure) and the seed's SMALL element (P1 and normal face bubbles, constant pressure: Bernardi-Raugel) solve the same problems; they are compared at equal error, not on equal meshes. The two others are no longer in the program: their curves are recorded ones, with those of Taylor-Hood on the same machine.",
        scopes: &[
            scope("A1m", &[4, 6, 10, 16, 24], &[4, 6, 10]),
            scope("hertz-plane", &[1, 2, 3, 4], &[1, 2]),
        ],
        choices: &[
            choice("Taylor-Hood", "auto"),
            recorded("Taylor-Hood, recorded", "auto"),
            recorded("MINI, recorded", "element=mini"),
            recorded(
                "SMALL (Bernardi-Raugel), recorded",
                "element=bernardi-raugel",
            ),
        ],
        tolerances: TIGHT,
        measure: Measure::SameError,
    },
    Study {
        name: "saddle",
        question: "Uzawa, Arrow-Hurwicz or block-triangular?",
        about: "Solvers of the saddle point for the same preconditioner of the displacement block. Block-triangular steps inside GCR apply it once an iteration, the symmetric Arrow-Hurwicz step inside GCR (the seed) twice, Uzawa solves for the displacement inside every iteration on the pressure.",
        scopes: &[scope("cube-bend", &[6, 10, 16, 24], &[6, 10])],
        choices: &[
            choice("block-triangular GCR", "auto"),
            choice("Arrow-Hurwicz + GCR", "saddle=arrow-hurwicz"),
            choice("MINRES", "saddle=minres"),
            choice("Uzawa-CG", "saddle=uzawa-cg"),
            choice(
                "the seed: Arrow-Hurwicz + GCR, hierarchical SSOR",
                "saddle=arrow-hurwicz,displacement_preconditioner=hierarchical-ssor",
            ),
        ],
        tolerances: TIGHT,
        measure: Measure::SameMesh,
    },
    Study {
        name: "penalty",
        question: "A penalty r div div, or none?",
        about: "The grad-div term r div u div v is added to the stiffness, its P1 block included, and taken into account by the metric of the pressure. The seed found 35 steps at r = 0 and 25 at r = 5.",
        scopes: &[scope("cube-bend", &[6, 10, 16, 24], &[6, 10])],
        choices: &[
            choice("r = 0", "auto"),
            choice("r = 0.5", "penalty=0.5"),
            choice("r = 1", "penalty=1"),
            choice("r = 5", "penalty=5"),
        ],
        tolerances: TIGHT,
        measure: Measure::SameMesh,
    },
    Study {
        name: "preconditioner",
        question: "p-multigrid or the hierarchical preconditioner?",
        about: "Preconditioners of the displacement block, compressible (Poisson ratio 0.3) inside conjugate gradients. The seed's block SSOR solves P1, sweeps the edges and solves P1 again; alone it is a stationary iteration.",
        scopes: &[scope("cube-elastic", &[6, 10, 16, 24], &[6, 10])],
        choices: &[
            choice("p-multigrid", "auto"),
            choice(
                "hierarchical SSOR",
                "displacement_preconditioner=hierarchical-ssor",
            ),
            choice(
                "hierarchical, additive",
                "displacement_preconditioner=hierarchical-additive",
            ),
            choice(
                "hierarchical SSOR, stationary",
                "saddle=stationary,displacement_preconditioner=hierarchical-ssor",
            ),
            choice("p-multigrid, stationary", "saddle=stationary"),
        ],
        tolerances: TIGHT,
        measure: Measure::SameMesh,
    },
    Study {
        name: "p1-solver",
        question: "P1 by a factor, multigrid or IC-CG?",
        about: "The solver of the P1 block inside every preconditioner: a sparse Cholesky factor, smoothed-aggregation multigrid, or conjugate gradients with an incomplete factor to a tolerance.",
        scopes: &[scope("cube-bend", &[6, 10, 16, 24, 34], &[6, 10, 16])],
        choices: &[
            choice("chosen by the plan", "auto"),
            choice("sparse Cholesky", "p1_solver=cholesky"),
            choice("algebraic multigrid", "p1_solver=amg"),
            choice("IC-CG", "p1_solver=ic-cg"),
        ],
        tolerances: TIGHT,
        measure: Measure::SameMesh,
    },
    Study {
        name: "metric",
        question: "Contact: mass, fractional or compliance metric?",
        about: "The metric that stands for the Schur complement of the contact pressure: the dense compliance of the P1 block, the mass matrix, or a fractional Laplacian of the surface.",
        scopes: &[
            scope("hertz-plane", &[1, 2, 3, 4, 5], &[1, 2, 3]),
            scope("hertz-sphere", &[1, 2, 3, 4], &[1, 2]),
        ],
        choices: &[
            choice("compliance", "auto"),
            choice("mass", "contact_metric=mass"),
            choice("fractional", "contact_metric=fractional"),
        ],
        tolerances: TIGHT,
        measure: Measure::SameMesh,
    },
    Study {
        name: "contact",
        question: "Contact: nested or one level?",
        about: "One level: displacement, pressure and contact pressure together. The others are nested: they solve a problem without contact inside every step on the contact pressure.",
        scopes: &[
            scope("hertz-plane", &[1, 2, 3, 4], &[1, 2]),
            scope("hertz-sphere", &[1, 2, 3], &[1]),
        ],
        choices: &[
            choice("one level", "auto"),
            choice("nested, compliance metric", "contact=nested"),
            choice(
                "conjugate projected gradient",
                "contact=conjugate-projected-gradient",
            ),
            choice("MPRGP", "contact=mprgp"),
            choice("active set", "contact=active-set"),
            choice("projected Arrow-Hurwicz", "contact=projected-arrow-hurwicz"),
        ],
        tolerances: &[1e-6],
        measure: Measure::SameMesh,
    },
    Study {
        name: "friction",
        question: "Friction: all at once, by its threshold, or regularised?",
        about: "A sphere with Coulomb friction. One level solves pressures and tractions together; the iteration on the threshold (the seed's) solves contact with given thresholds until these stay; springs on the slip (the seed's regularised term) hold what sticks, and are moved until nothing creeps.",
        scopes: &[scope("hertz-rough", &[1, 2, 3], &[1])],
        choices: &[
            choice("one level", "auto"),
            choice("iteration on the threshold", "contact=threshold-iteration"),
            choice("springs on the slip", "contact=regularised-friction"),
        ],
        tolerances: &[1e-6],
        measure: Measure::SameMesh,
    },
    Study {
        name: "contact-space",
        question: "Contact pressure: hats or quadratic functions?",
        about: "Hats at the vertices, or quadratic Bernstein functions at all displacement nodes of the surface. On straight facets of a ball quadratic functions see the corners, and the largest pressure does not settle; on arcs fitted to the normals of the facets it does. Errors are those against the limit of the reference values: for force and strain energy those of hats on meshes down to l6, for pressure and radius those of quadratic functions.",
        scopes: &[
            scope("hertz-sphere", &[1, 2, 3, 4], &[1, 2, 3]),
            scope("hertz-plane", &[1, 2, 3, 4], &[1, 2, 3]),
            scope("mr-sphere", &[1, 2, 3, 4], &[1, 2]),
        ],
        choices: &[
            choice("quadratic", "auto"),
            choice("hats", "contact_space=linear"),
            choice("quadratic, fitted arcs", "obstacle.0.surface=smooth"),
        ],
        tolerances: TIGHT,
        measure: Measure::Limits,
    },
    Study {
        name: "poisson",
        question: "What does incompressibility cost?",
        about: "The same cube for Poisson ratios from 0.3 (displacement only) through the mixed form to one half.",
        scopes: &[scope("cube-bend", &[6, 10, 16, 24], &[6, 10])],
        choices: &[
            choice("Poisson ratio 0.5", "auto"),
            choice("Poisson ratio 0.4999", "material.body.poisson_ratio=0.4999"),
            choice("Poisson ratio 0.49", "material.body.poisson_ratio=0.49"),
            choice("Poisson ratio 0.45", "material.body.poisson_ratio=0.45"),
            choice(
                "Poisson ratio 0.3 (displacement only)",
                "material.body.poisson_ratio=0.3",
            ),
        ],
        tolerances: TIGHT,
        measure: Measure::SameMesh,
    },
    Study {
        name: "poor-cells",
        question: "Poor cells and contrasts of stiffness: does every method hold?",
        about: "The bent incompressible cube with flat and tall cells and slivers, and with a layer or a ball a million times as stiff or as soft.",
        scopes: &[
            scope("cube-flat-10", &[8], &[8]),
            scope("cube-flat-100", &[8], &[8]),
            scope("cube-tall-10", &[8], &[8]),
            scope("cube-slivers", &[8], &[8]),
            scope("layer-stiff", &[8, 16], &[8]),
            scope("layer-soft", &[8, 16], &[8]),
            scope("ball-stiff", &[8, 16], &[8]),
            scope("ball-soft", &[8, 16], &[8]),
        ],
        choices: &[
            choice("chosen by the plan", "auto"),
            choice("sparse Cholesky", "p1_solver=cholesky"),
            choice("algebraic multigrid", "p1_solver=amg"),
        ],
        tolerances: TIGHT,
        measure: Measure::OneMesh,
    },
    Study {
        name: "extremes",
        question: "Stiff and extreme cases: what holds, and what does not?",
        about: "Scenes whose result is known without this solver: in closed form, by another solver, by another path to the same body, or because mechanics leaves no choice. Each runs once, cold, with the methods that the plan takes by itself. An error is relative to what is known; a row that must end early, or must warn, is right where it does; a row with nothing known is not judged.",
        scopes: &[],
        choices: &[],
        tolerances: TIGHT,
        measure: Measure::Extremes,
    },
    Study {
        name: "flow",
        question: "Viscous flow: the scenes of the seed",
        about: "A plane channel around a cylinder and a channel around a ball, near the sizes of the seed, with its methods and ours.",
        scopes: &[
            scope("stokes-cylinder", &[1, 2], &[1, 2]),
            scope("stokes-obstacle", &[1], &[1]),
        ],
        choices: &[
            choice("block-triangular GCR", "auto"),
            choice("Uzawa-CG", "saddle=uzawa-cg"),
            choice("Uzawa-CG, r = 5", "saddle=uzawa-cg,penalty=5"),
            choice(
                "Arrow-Hurwicz + GCR, hierarchical SSOR",
                "saddle=arrow-hurwicz,displacement_preconditioner=hierarchical-ssor",
            ),
            choice(
                "Arrow-Hurwicz + GCR, hierarchical SSOR, r = 5",
                "saddle=arrow-hurwicz,displacement_preconditioner=hierarchical-ssor,penalty=5",
            ),
        ],
        tolerances: TIGHT,
        measure: Measure::SameMesh,
    },
    Study {
        name: "accuracy",
        question: "A finer mesh everywhere, or where the force asks for it?",
        about: "The meshes of the families, and meshes that `[accuracy]` refines from the coarsest one until the force is known to 10, 5, 2, 1, 0.5 and 0.2 per cent; their seconds are those of all rounds with the last mesh. Flat facets of a ball stay flat when they are halved, so that arcs are fitted over them. Gmsh meshes are finer under the contact already; the bonded edges of mr-block turn inside out on small cells, which ends its curve.",
        scopes: &[
            scope("hertz-plane", &[1, 2, 3, 4], &[1, 2, 3]),
            scope("hertz-sphere", &[1, 2, 3, 4], &[1, 2, 3]),
            scope("mr-sphere", &[1, 2, 3], &[1, 2]),
            scope("mr-block", &[6, 10, 16], &[6, 10]),
        ],
        choices: &[
            choice("meshes of the family", "auto"),
            choice(
                "meshes of the family, fitted arcs",
                "obstacle.0.surface=smooth",
            ),
            refined(
                REFINED,
                "obstacle.0.surface=smooth,accuracy.max_time=60,accuracy.force.OBSTACLE=0.1",
            ),
            refined(
                REFINED,
                "obstacle.0.surface=smooth,accuracy.max_time=60,accuracy.force.OBSTACLE=0.05",
            ),
            refined(
                REFINED,
                "obstacle.0.surface=smooth,accuracy.max_time=60,accuracy.force.OBSTACLE=0.02",
            ),
            refined(
                REFINED,
                "obstacle.0.surface=smooth,accuracy.max_time=60,accuracy.force.OBSTACLE=0.01",
            ),
            refined(
                REFINED,
                "obstacle.0.surface=smooth,accuracy.max_time=60,accuracy.force.OBSTACLE=0.005",
            ),
            refined(
                REFINED,
                "obstacle.0.surface=smooth,accuracy.max_time=60,accuracy.force.OBSTACLE=0.002",
            ),
        ],
        tolerances: TIGHT,
        measure: Measure::SameError,
    },
    Study {
        name: "rule",
        question: "Rubber: how exactly must stress be integrated?",
        about: "The rule of degree 2 has four points a tetrahedron, as linear elasticity needs; degree 4 has 14 and degree 8 has 150. The work of a product with the tangent grows with the points, the order of convergence does not depend on them.",
        scopes: &[
            scope("mr-block", &[6, 10], &[6]),
            scope("mr-sphere", &[1, 2, 3], &[1]),
        ],
        choices: &[
            choice("degree 2", "auto"),
            choice("degree 4", "quadrature_degree=4"),
            choice("degree 8", "quadrature_degree=8"),
        ],
        tolerances: TIGHT,
        measure: Measure::SameError,
    },
    Study {
        name: "tolerance",
        question: "How tight must the algebra be?",
        about: "One mesh, tolerances from loose to tight, and the choice that stops the algebra at a tenth of the estimated error of the discretisation.",
        scopes: &[
            scope("A1m", &[10, 24], &[10]),
            scope("hertz-plane", &[2, 4], &[2]),
            scope("hertz-sphere", &[2, 4], &[2]),
        ],
        choices: &[
            choice("a tolerance", "auto"),
            choice("tolerance = discretisation", "tolerance=discretisation"),
        ],
        tolerances: &[1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 1e-10],
        measure: Measure::Tolerance,
    },
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_study_names_families_and_keys_that_can_be_read() {
        for study in STUDIES {
            assert!(
                study.choices.iter().all(|choice| choice.method().is_some()),
                "{}",
                study.name
            );
            for scope in study.scopes {
                assert!(scope.family().is_some(), "{} {}", study.name, scope.family);
                assert!(
                    scope.quick.iter().all(|level| scope.full.contains(level)),
                    "{}",
                    study.name
                );
            }
        }
    }

    #[test]
    fn unknown_studies_are_told_the_known_ones() {
        assert_eq!(find("saddle").unwrap().name, "saddle");
        assert!(find("chess").unwrap_err().contains("element, saddle"));
    }
}
