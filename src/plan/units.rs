//! Reference length and stress. Everything inside the solver is divided by
//! them, so that results do not depend on the caller's units: exactly for
//! powers of two, to rounding otherwise.

use crate::mesh::Mesh;
use crate::scene::validate::Resolved;
use crate::scene::{Scene, SceneKind};

/// Reference quantities in the caller's units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units {
    /// Longest side of the body after `mesh_scale`, in the caller's unit of length.
    pub length: f64,
    /// Smallest shear modulus: the displacement residual is then not small beside
    /// the volume residual anywhere in the body, and both fall together.
    pub stress: f64,
    /// Multiplies uploaded coordinates to make them non-dimensional.
    pub coordinate_scale: f64,
    /// 2 or 3; forces in the plane are per unit thickness.
    pub dimension: usize,
    /// Lengths in a volume: 3 where the body, or its full turn, fills space.
    pub extents: usize,
}

/// A mesh with the units of its scene.
#[derive(Clone, Copy, Debug)]
pub(super) struct ScaledMesh<'a> {
    /// Coordinates in the mesh's lengths.
    pub(super) mesh: &'a Mesh,
    /// What makes them non-dimensional, or the caller's.
    pub(super) units: &'a Units,
}

impl Units {
    /// The units of a scene on a mesh: the body becomes one long, the softest material
    /// one stiff.
    pub(crate) fn new(scene: &Scene, resolved: &Resolved, mesh: &Mesh) -> Self {
        let shear = resolved.materials.iter().map(|m| m.law.shear_modulus);
        Self {
            length: mesh.extent() * scene.mesh_scale.unwrap_or(1.0),
            stress: shear.fold(f64::INFINITY, f64::min),
            coordinate_scale: 1.0 / mesh.extent(),
            dimension: mesh.cell_kind().dimension(),
            extents: match resolved.kind {
                SceneKind::Solid | SceneKind::Axisymmetric => 3,
                SceneKind::PlaneStrain | SceneKind::PlaneStress => 2,
            },
        }
    }

    /// A point in the mesh's lengths as one in the caller's.
    pub(crate) fn of_mesh(&self, point: [f64; 3]) -> [f64; 3] {
        point.map(|x| x * self.coordinate_scale * self.length)
    }

    /// Whether every derived quantity keeps its precision.
    pub(crate) fn are_usable(&self) -> bool {
        let derived = [
            self.length,
            self.stress,
            self.coordinate_scale,
            self.area(),
            self.volume(),
            self.force(),
            self.energy(),
            self.body_force(),
        ];
        derived.iter().all(|value| value.is_normal())
    }

    /// Area, or length in the plane.
    pub fn area(&self) -> f64 {
        self.length.powi(self.extents as i32 - 1)
    }

    /// Volume, or area in the plane.
    pub fn volume(&self) -> f64 {
        self.length.powi(self.extents as i32)
    }

    /// Force, or force per thickness.
    pub fn force(&self) -> f64 {
        self.stress * self.area()
    }

    /// Moment and energy, or per thickness.
    pub fn energy(&self) -> f64 {
        self.stress * self.volume()
    }

    /// Force per volume.
    pub fn body_force(&self) -> f64 {
        self.stress / self.length
    }
}
