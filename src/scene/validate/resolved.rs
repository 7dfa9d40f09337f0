//! A valid scene with its names resolved: every item carries the facets or the
//! cell that its names mean, so that nothing is looked up by position later.
//! Values are in the caller's units; shapes of obstacles are non-dimensional.

use std::sync::Arc;

use super::{Parabola, Spread};
use crate::element::manufactured::Manufactured;
use crate::material::{LinearElastic, Rubber};
use crate::mesh::locate::Located;
use crate::obstacle::Obstacle;
use crate::pairs::Meets;
use crate::scene::{Film, SceneKind, SurfaceGeometry};

/// An item of the scene and the facets of the groups that it names.
#[derive(Clone, Debug)]
pub(crate) struct Placed<'a, T> {
    pub(crate) item: &'a T,
    /// Ascending, each once.
    pub(crate) facets: Vec<u32>,
}

/// A material with its law.
#[derive(Clone, Debug)]
pub(crate) struct ResolvedMaterial {
    /// The law; of a rubber, its moduli at rest (1 / K in the place of 1 / lambda; of a foam that of
    /// its pressure, the rest of K in that of lambda_1).
    pub(crate) law: LinearElastic,
    pub(crate) poisson_ratio: f64,
    /// Whether u is a velocity.
    pub(crate) is_flow: bool,
    /// The law at finite strain.
    pub(crate) rubber: Option<Rubber>,
}

impl ResolvedMaterial {
    /// Whether the volume cannot change at all.
    pub(crate) fn is_incompressible(&self) -> bool {
        self.poisson_ratio >= 0.5
    }

    /// Whether its law has a resistance to changes of volume of its own.
    pub(crate) fn is_foam(&self) -> bool {
        self.rubber.as_ref().is_some_and(|law| law.foam().is_some())
    }
}

/// A plane patch across an axis.
#[derive(Clone, Debug)]
pub(crate) struct HeldPlane {
    /// Facets of the patch.
    pub(crate) facets: Vec<u32>,
    /// The axis that the normal lies along.
    pub(crate) axis: usize,
    /// One where the outward normal points up that axis, else minus one.
    pub(crate) outward: f64,
    /// Coordinate of the plane along the axis, in units of the mesh.
    pub(crate) coordinate: f64,
}

/// A plane patch across no axis.
#[derive(Clone, Debug)]
pub(crate) struct ObliquePlane {
    /// Facets of the patch.
    pub(crate) facets: Vec<u32>,
    /// Outward unit normal.
    pub(crate) normal: [f64; 3],
}

/// Held displacement components of a surface.
#[derive(Clone, Debug)]
pub(crate) struct ResolvedSupport {
    /// Unique among supports.
    pub(crate) name: String,
    /// Facets of the closed surface, ascending.
    pub(crate) facets: Vec<u32>,
    /// Held components with their values, the caller's length; `None` is free.
    pub(crate) displacement: [Option<f64>; 3],
    /// Displacement held along the outward normal, the caller's length; `None` where
    /// the support holds components.
    pub(crate) normal: Option<f64>,
    /// Planes across an axis on which the normal is held: there it is a component.
    pub(crate) planes: Vec<HeldPlane>,
    /// Other planes: there the normal is a direction of each node.
    pub(crate) oblique: Vec<ObliquePlane>,
    /// The other smooth patches of a surface that is held along its normal, by multipliers:
    /// nodes between two of them are held along both normals. None where components are held.
    pub(crate) patches: Vec<Vec<u32>>,
    /// Variation of the values over the surface; `None` where they are constant.
    pub(crate) profile: Option<Parabola>,
    /// Displacement of each node on top, the caller's length.
    pub(crate) values: Spread,
    /// Forces and moments that it shall exert at the end of the first step, in the caller's units
    /// `[6]`.
    pub(crate) push: [Option<f64>; 6],
    /// Springs to the ground along axes and about them, in the caller's units `[6]`.
    pub(crate) spring: [f64; 6],
    /// Reference point at first, the caller's length `[3]`.
    pub(crate) about: [f64; 3],
}

impl ResolvedSupport {
    /// Component `i` of the outward normal of the plane held across that axis which is nearest
    /// to `coordinate`; none without any.
    pub(crate) fn normal_at(&self, i: usize, coordinate: f64) -> Option<f64> {
        let own = self.planes.iter().filter(|plane| plane.axis == i);
        let away = |plane: &HeldPlane| (plane.coordinate - coordinate).abs();
        let nearest = own.min_by(|a, b| away(a).total_cmp(&away(b)));
        nearest.map(|plane| plane.outward)
    }
}

/// A dead load per undeformed area.
#[derive(Clone, Debug)]
pub(crate) struct ResolvedTraction {
    /// Unique among those that have one.
    pub(crate) name: Option<String>,
    /// Loaded facets, ascending.
    pub(crate) facets: Vec<u32>,
    /// The caller's stress `[3]`.
    pub(crate) value: [f64; 3],
    /// Of each node or facet on top, the caller's stress.
    pub(crate) values: Spread,
}

/// A pressure that follows the deformed surface.
#[derive(Clone, Debug)]
pub(crate) struct ResolvedPressure {
    /// Pressed facets, ascending, all on the surface of the body.
    pub(crate) facets: Vec<u32>,
    /// The caller's stress; positive pushes on the body.
    pub(crate) value: f64,
}

/// A fluid that creeps along facets.
#[derive(Clone, Debug)]
pub(crate) struct ResolvedFluid {
    /// Unique among fluids.
    pub(crate) name: String,
    /// Facets that it can reach and may, ascending, all on the surface of the body.
    pub(crate) facets: Vec<u32>,
    /// Facets that are wet from the start, ascending.
    pub(crate) from: Vec<u32>,
    /// Facets that it must not reach, ascending.
    pub(crate) dry: Vec<u32>,
    /// At the end of the first step, the caller's stress.
    pub(crate) pressure: f64,
    /// Contact pressure below which it enters, the caller's stress; none where that is its own.
    pub(crate) threshold: Option<f64>,
    /// What becomes of it where contact closes.
    pub(crate) film: Film,
    /// Relative width of the bracket of the pressure at which it leaks.
    pub(crate) blow_off_tolerance: f64,
    /// Dynamic viscosity, the caller's stress times time.
    pub(crate) viscosity: Option<f64>,
}

/// A rigid body that facets may touch.
#[derive(Clone, Debug)]
pub(crate) struct ResolvedObstacle {
    /// Unique among obstacles.
    pub(crate) name: String,
    /// Facets that may touch it, ascending, all on the surface of the body.
    pub(crate) facets: Vec<u32>,
    /// Its shape in the initial pose, lengths over the reference length.
    pub(crate) shape: Arc<dyn Obstacle>,
    /// Which surface of the body meets it.
    pub(crate) surface: SurfaceGeometry,
    /// Coefficient of friction at the start.
    pub(crate) friction: f64,
    /// Bound of the traction in place of Coulomb's.
    pub(crate) tresca: Option<f64>,
    /// Whether there may be friction at any time.
    pub(crate) is_frictional: bool,
}

/// Two surfaces that may touch, or are tied.
#[derive(Clone, Debug)]
pub(crate) struct ResolvedPair {
    /// Unique among contacts, ties, obstacles and supports.
    pub(crate) name: String,
    /// Facets of the two groups, ascending, all on the surface of the mesh.
    pub(crate) sides: [Vec<u32>; 2],
    /// Whom the first side meets.
    pub(crate) meets: Meets,
    /// Which side the scene has carry the pressure; none where it leaves that open.
    pub(crate) named: Option<usize>,
    /// Coefficient of friction.
    pub(crate) friction: f64,
    /// Largest traction of friction in its place, the caller's stress.
    pub(crate) tresca: Option<f64>,
}

/// A point that each result reports.
#[derive(Clone, Debug)]
pub(crate) struct ResolvedProbe {
    /// Unique among probes.
    pub(crate) name: String,
    /// The cell that holds it, and where in that cell.
    pub(crate) place: Located,
}

/// The scene's items but its obstacles, whose shapes need the units of the plan.
#[derive(Clone, Debug)]
pub(crate) struct Resolved {
    pub(crate) kind: SceneKind,
    /// Material of each cell, a position in `materials`.
    pub(crate) cell_material: Vec<u16>,
    pub(crate) materials: Vec<ResolvedMaterial>,
    /// Whether a pressure unknown carries the volume constraint.
    pub(crate) mixed: bool,
    pub(crate) supports: Vec<ResolvedSupport>,
    pub(crate) tractions: Vec<ResolvedTraction>,
    pub(crate) pressures: Vec<ResolvedPressure>,
    pub(crate) fluids: Vec<ResolvedFluid>,
    /// Surfaces of different bodies that may touch, in the order of the scene.
    pub(crate) pairs: Vec<ResolvedPair>,
    /// Surfaces of different bodies that are bonded, in the order of the scene.
    pub(crate) ties: Vec<ResolvedPair>,
    /// The caller's force per undeformed volume `[3]`.
    pub(crate) body_force: [f64; 3],
    /// The same of each node or cell, on top.
    pub(crate) body_force_values: Spread,
    pub(crate) probes: Vec<ResolvedProbe>,
    /// The analytic field whose loads replace the others.
    pub(crate) manufactured: Option<Manufactured>,
    /// Rigid modes that no support holds.
    pub(crate) free_modes: Vec<String>,
    /// Rigid modes that no support holds of bodies which ties hold; empty without ties.
    pub(crate) free_alone: Vec<String>,
}

impl Resolved {
    /// Whether u is a velocity.
    pub(crate) fn is_flow(&self) -> bool {
        self.materials.iter().any(|material| material.is_flow)
    }

    /// What the shear modulus is called.
    pub(crate) fn modulus_name(&self) -> &'static str {
        if self.is_flow() {
            "viscosity"
        } else {
            "shear modulus"
        }
    }

    /// Whether anything pulls on each volume.
    pub(crate) fn has_body_force(&self) -> bool {
        self.body_force.iter().any(|&force| force != 0.0)
    }

    /// Whether anything grows with the load factor.
    pub(crate) fn is_loaded(&self) -> bool {
        self.manufactured.is_some()
            || self.has_body_force()
            || !self.body_force_values.is_zero()
            || !self.tractions.is_empty()
            || !self.pressures.is_empty()
    }
}
