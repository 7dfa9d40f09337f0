//! What a plan decides and says of rubber.

use crate::element::quadrature::{Simplex, rule};
use crate::krylov::gcr::{self, Directions};
use crate::material::Rubber;
use crate::plan::Plan;
use crate::plan::estimate;
use crate::scene::{ContactSpace, MaterialModel, OnInstability, SceneKind};

/// Degree of the rule for stress, volume and tangent where the scene names none:
/// exact for linear elasticity, so that the order of convergence is that of exact
/// integration, with the fewest points.
const DEGREE: u32 = 2;

/// About an axis, where the stretch around it is no polynomial.
const DEGREE_ABOUT_AXIS: u32 = 4;

/// In space where cells have curved edges: an even pressure has no force inside the body by it, the
/// volume being cubic in the displacement gradient.
const DEGREE_OF_CURVED: u32 = 4;

/// Krylov directions kept: near a limit of stability a few eigenvalues are far from
/// the others, and ten directions forget them (mr-sphere l2: 312 applications in
/// the last increment instead of 228).
const KEPT_DIRECTIONS: usize = 40;
/// The same where tractions follow pressures: the system is not symmetric, and truncation
/// costs it more.
const KEPT_WITH_FRICTION: usize = 50;

/// The same for a linear body of good cells under loads alone, whose augmented system is nearly
/// one of a short recurrence: half the vectors move, for two applications in a hundred (decision 50).
const KEPT_OF_GOOD_CELLS: usize = 5;

/// Weights of the volume term where an equilibrium is lost without it, in units of
/// the shear modulus: the first, and more up to the pressure (decision 22). The least is for bodies
/// that fall, and motions that it is known to hold.
const PENALTIES: [f64; 4] = [1.0, 4.0, 16.0, 64.0];

/// Vertex gradients and pressures of a tetrahedron.
const VERTEX_NUMBERS: u64 = 40;
/// Bytes per cell of its laws, of its tangent while an inverse is made and of that which the
/// smoother keeps.
const CELL_TANGENT_BYTES: u64 = 650;

impl Plan {
    /// No more Krylov directions than the body makes use of.
    pub(crate) fn directions(&self) -> Directions {
        match (self.has_friction(), self.problem.resolved.is_rubber()) {
            (true, _) => Directions::sliding(KEPT_WITH_FRICTION),
            (false, true) => Directions::keeping(KEPT_DIRECTIONS),
            (false, false) if self.forgets_early() => Directions::starting_with(KEPT_OF_GOOD_CELLS),
            (false, false) => Directions::default(),
        }
    }

    /// Whether a few directions do as well as ten.
    fn forgets_early(&self) -> bool {
        let is_simple = self.problem.units.dimension == 3 && self.problem.unknowns.contact == 0;
        is_simple && self.is_augmented() && self.decisions.smoother_degree == 2
    }

    /// Weight of the volume term at the start, in units of the shear modulus.
    pub(crate) fn first_penalty(&self) -> f64 {
        self.problem.settings.penalty.unwrap_or(0.0)
    }

    /// Its weight where an equilibrium is lost with `present` under pressures up to
    /// `largest`, in units of the shear modulus; none where that is enough and where
    /// the scene says.
    pub(crate) fn next_penalty(&self, present: f64, largest: f64) -> Option<f64> {
        let is_free = self.problem.resolved.is_rubber() && self.problem.settings.penalty.is_none();
        let may_help = is_free && (present == 0.0 || present < largest);
        let first = usize::from(!self.snaps_through());
        let mut weights = PENALTIES.into_iter().skip(first).filter(|_| may_help);
        weights.find(|&weight| weight > present)
    }

    /// Whether a body that loses its equilibrium may snap through to the next one: under hats on any tool
    /// but a half-space the mesh alone may lose it, above some 4 mu R / h on faces of size h under a
    /// radius R.
    pub(crate) fn may_snap_through(&self) -> bool {
        let has_curved = self
            .problem
            .obstacles
            .iter()
            .any(|tool| !tool.shape.is_flat());
        let is_held = !has_curved || self.problem.contact_space == ContactSpace::Quadratic;
        self.problem.settings.on_instability == OnInstability::Descend && is_held
    }

    /// Whether a body that loses its equilibrium snaps through to the next one, and functions of the
    /// pressure let it.
    pub(crate) fn snaps_through(&self) -> bool {
        self.problem.settings.on_instability == OnInstability::Descend
            && self.problem.contact_space == ContactSpace::Quadratic
    }

    /// Degree of the rule for stress, volume and tangent.
    pub(crate) fn strain_degree(&self) -> u32 {
        let is_curved = self.problem.curved_edges > 0 && self.problem.units.dimension == 3;
        let degree = if self.is_axisymmetric() {
            DEGREE_ABOUT_AXIS
        } else if is_curved {
            DEGREE_OF_CURVED
        } else {
            DEGREE
        };
        self.problem.settings.quadrature_degree.unwrap_or(degree)
    }

    /// Whether the mesh is the section of a body of revolution.
    pub(crate) fn is_axisymmetric(&self) -> bool {
        self.problem.resolved.kind == SceneKind::Axisymmetric
    }

    /// Laws by material, as cells count them, non-dimensional; none of linear bodies. Where one
    /// material is rubber all have a law for finite strain.
    pub(crate) fn laws(&self) -> Vec<Rubber> {
        let materials = self.problem.resolved.materials.iter();
        let unit = self.problem.units.stress;
        let laws = materials.map(|material| Some(material.rubber.as_ref()?.over(unit)));
        laws.collect::<Option<_>>().unwrap_or_default()
    }

    /// The same with the law of finite strain that has the moduli of each linear material: its
    /// tangent at rest is linear elasticity.
    pub(crate) fn laws_at_rest(&self) -> Vec<Rubber> {
        let materials = self.problem.resolved.materials.iter();
        let unit = self.problem.units.stress;
        let laws = materials.map(|material| match &material.rubber {
            Some(rubber) => rubber.over(unit),
            None => {
                let law = &material.law;
                Rubber::neo_hookean(law.shear_modulus, law.inverse_bulk()).over(unit)
            }
        });
        laws.collect()
    }

    /// What rubber holds at its peak beside a linear body: kept directions, two
    /// states with their tangents, and an approximate inverse of its own.
    pub(crate) fn rubber_bytes(&self, vertices: u64) -> u64 {
        if !self.problem.resolved.is_rubber() {
            return 0;
        }
        let mut rubbers = self
            .problem
            .resolved
            .materials
            .iter()
            .filter_map(|m| m.rubber.as_ref());
        let by_point = rubbers.any(|rubber| rubber.isochoric.is_by_point());
        let simplex = match self.problem.units.dimension {
            2 => Simplex::Triangle,
            _ => Simplex::Tetrahedron,
        };
        let points = rule(simplex, self.strain_degree()).len() as u64;
        let of_point = if by_point { 46 } else { 1 };
        let of_cell = 16 * (VERTEX_NUMBERS + of_point * points) + CELL_TANGENT_BYTES;
        let unknowns = self.problem.unknowns.displacement
            + self.problem.unknowns.pressure
            + self.problem.unknowns.contact;
        let directions = 16 * (KEPT_DIRECTIONS + gcr::KEPT) as u64 * unknowns;
        let inverse =
            estimate::p1_solver(self, vertices).0 as u64 + 24 * self.problem.unknowns.displacement;
        of_cell * self.problem.cells as u64 + directions + inverse
    }

    /// Laws with their bulk moduli, each once.
    pub(crate) fn rubber_laws(&self) -> String {
        let mut laws: Vec<String> = Vec::new();
        for (material, resolved) in self
            .problem
            .scene
            .materials
            .iter()
            .zip(&self.problem.resolved.materials)
        {
            let (name, bulk) = match &material.model {
                MaterialModel::Rubber {
                    model,
                    bulk_modulus,
                    ..
                } => (model.name().to_owned(), *bulk_modulus),
                other @ (MaterialModel::LinearElastic { .. } | MaterialModel::Stokes { .. }) => {
                    let law = resolved.rubber.as_ref();
                    let name = format!("neo-hookean in the place of {}", other.name());
                    (name, law.map(Rubber::bulk_modulus))
                }
            };
            let foam = resolved.rubber.as_ref().and_then(Rubber::foam);
            let law = match (bulk.filter(|bulk| bulk.is_finite()), foam) {
                (None, Some(foam)) => {
                    // Rounded here so that zero has no sign.
                    let ratio = (1e3 * foam.poisson_ratio()).round() / 1e3 + 0.0;
                    format!("{name}, Poisson ratio {ratio:.3} at rest")
                }
                (None, None) => format!("{name}, incompressible"),
                (Some(bulk), _) => format!("{name}, bulk modulus {bulk}"),
            };
            if !laws.contains(&law) {
                laws.push(law);
            }
        }
        laws.join("; ")
    }

    /// The rule that integrates stress and tangent.
    pub(crate) fn rubber_rule(&self) -> (String, &'static str) {
        let rule = format!("degree {}", self.strain_degree());
        match self.problem.settings.quadrature_degree {
            Some(_) => (rule, "asked for"),
            None if self.is_axisymmetric() => {
                (rule, "a higher one for the stretch around the axis")
            }
            None => (rule, "fewer points would lower the order of convergence"),
        }
    }

    /// Decisions that only rubber needs.
    pub(crate) fn push_rubber(&self, push: &mut dyn FnMut(&str, String, &str)) {
        if !self.problem.resolved.is_rubber() {
            return;
        }
        let reason = match self.problem.resolved.kind {
            SceneKind::PlaneStress => "energy of the plane at finite strain",
            SceneKind::Solid | SceneKind::PlaneStrain | SceneKind::Axisymmetric => {
                "isochoric energy and volume constraint at finite strain"
            }
        };
        push("material", self.rubber_laws(), reason);
        let (rule, reason) = self.rubber_rule();
        push("volume rule", rule, reason);
        if !self.problem.resolved.pressures.is_empty() {
            push(
                "pressure load",
                "follows the deformed faces".into(),
                "a pressure, no dead load; where the pressed surface has an edge, the tangent is not symmetric",
            );
        }
        push(
            "tangent",
            "computed cell by cell, no matrix is stored".into(),
            "quicker, since it is another one in each iteration, and smaller",
        );
        push(
            "stability",
            self.stability_in_words(),
            self.decisions.stability.reason,
        );
        let (penalty, reason) = match self.problem.settings.penalty {
            Some(weight) => (
                format!("{weight} mu of pointwise volume change"),
                "asked for",
            ),
            None if self.snaps_through() => (
                "none, or 1 mu or more where the mesh has no stable state without it".into(),
                "suppresses snap-through of the mesh, not of the body; results tell the `penalty`",
            ),
            None => (
                "none, or 4 mu or more from where an equilibrium is lost".into(),
                "suppresses instabilities of the mesh; results tell the `penalty`",
            ),
        };
        push("penalty", penalty, reason);
        push(
            "refactorisation",
            "where a quadratic program takes three times the iterations of the first, or fails"
                .into(),
            "judged by counts, not by seconds: the same on every machine",
        );
    }
}
