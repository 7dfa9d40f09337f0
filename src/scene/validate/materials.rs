//! Materials: parameters, one per cell, and the formulation that follows.

use super::{Faults, ResolvedMaterial, names, rubber};
use crate::material::{LinearElastic, Stokes};
use crate::mesh::{GroupKind, Mesh};
use crate::scene::{Formulation, MaterialModel, Modulus, Scene};

/// From this Poisson ratio on, a pressure unknown carries the volume constraint.
const MIXED_FROM: f64 = 0.45;
/// Below, the volume compliance of a mixed cell is no longer well scaled, and displacements
/// carry a part of it.
const LEAST_MIXED: f64 = 0.01;
/// Below, what a pressure could carry beside them is too small as well.
const LEAST_BESIDE_A_PRESSURE: f64 = -0.9;
const NO_MATERIAL: u16 = u16::MAX;

/// Laws, and the law of each cell.
pub(crate) fn resolve(
    scene: &Scene,
    mesh: &Mesh,
    faults: &mut Faults,
) -> (Vec<ResolvedMaterial>, Vec<u16>) {
    let mut of_cell = vec![NO_MATERIAL; mesh.cell_count()];
    let mut materials = Vec::new();
    if scene.materials.is_empty() {
        faults.add(
            "material",
            "the scene has no material; every cell needs one",
        );
    }
    if scene.materials.len() >= usize::from(NO_MATERIAL) {
        faults.add("material", "too many materials");
        return (materials, of_cell);
    }
    let has_rubber = scene.materials.iter().any(|one| one.model.is_rubber());
    for (index, material) in scene.materials.iter().enumerate() {
        if faults.is_full() {
            break;
        }
        let path = format!("material.{}", material.group);
        let resolved = law(&material.model, &path, faults);
        materials.push(if has_rubber {
            rubber::beside_rubber(resolved)
        } else {
            resolved
        });
        match mesh.group(&material.group, GroupKind::Cells) {
            None => faults.add(
                &path,
                names::missing(mesh, GroupKind::Cells, &material.group),
            ),
            Some(group) => {
                if let Some(cell) = assign(index as u16, &group.members, &mut of_cell) {
                    faults.add(path, format!("cell {cell} has another material already"));
                }
            }
        }
    }
    let bare = of_cell.iter().filter(|&&m| m == NO_MATERIAL).count();
    if bare > 0 && !scene.materials.is_empty() {
        let first = of_cell.iter().position(|&m| m == NO_MATERIAL).unwrap_or(0);
        faults.add(
            "material",
            format!("{bare} cells have no material, the first is cell {first}"),
        );
    }
    (materials, of_cell)
}

/// Gives the cells `members` the material `index`; the first of them that had another.
fn assign(index: u16, members: &[u32], of_cell: &mut [u16]) -> Option<u32> {
    let mut taken = None;
    for &cell in members {
        let slot = &mut of_cell[cell as usize];
        if *slot != NO_MATERIAL && *slot != index {
            taken.get_or_insert(cell);
        }
        *slot = index;
    }
    taken
}

fn law(model: &MaterialModel, path: &str, faults: &mut Faults) -> ResolvedMaterial {
    match model {
        MaterialModel::LinearElastic {
            modulus,
            poisson_ratio,
            ..
        } => linear_elastic(*modulus, *poisson_ratio, path, faults),
        MaterialModel::Stokes { viscosity, .. } => {
            faults.above_zero(&format!("{path}.viscosity"), *viscosity);
            let flow = Stokes {
                viscosity: *viscosity,
            };
            ResolvedMaterial {
                law: flow.elastic(),
                poisson_ratio: 0.5,
                is_flow: true,
                rubber: None,
            }
        }
        MaterialModel::Rubber {
            model,
            bulk_modulus,
            ..
        } => rubber::resolve(model, *bulk_modulus, path, faults),
    }
}

/// Refuses the displacement form of what has none.
pub(crate) fn check_formulations(
    scene: &Scene,
    materials: &[ResolvedMaterial],
    faults: &mut Faults,
) {
    for (material, resolved) in scene.materials.iter().zip(materials) {
        if formulation(&material.model) == Formulation::Displacement
            && let Some(message) = only_mixed(resolved)
        {
            faults.add(format!("material.{}.formulation", material.group), message);
        }
    }
}

/// Why a material has no displacement form.
fn only_mixed(material: &ResolvedMaterial) -> Option<&'static str> {
    if material.is_flow {
        Some("a flow needs the mixed formulation")
    } else if material.rubber.is_some() {
        Some("rubber needs the mixed formulation")
    } else if material.is_incompressible() {
        Some("an incompressible material needs the mixed formulation")
    } else {
        None
    }
}

fn linear_elastic(
    modulus: Modulus,
    poisson_ratio: f64,
    path: &str,
    faults: &mut Faults,
) -> ResolvedMaterial {
    let (key, value, law) = match modulus {
        Modulus::Shear(value) => (
            "shear_modulus",
            value,
            LinearElastic::from_shear_modulus(value, poisson_ratio),
        ),
        Modulus::Young(value) => (
            "young_modulus",
            value,
            LinearElastic::from_young_modulus(value, poisson_ratio),
        ),
    };
    faults.above_zero(&format!("{path}.{key}"), value);
    if !(poisson_ratio > -1.0 && poisson_ratio <= 0.5) {
        let message = format!("must lie above -1 and at most 0.5, not {poisson_ratio}");
        faults.add(format!("{path}.poisson_ratio"), message);
    }
    ResolvedMaterial {
        law,
        poisson_ratio,
        is_flow: false,
        rubber: None,
    }
}

/// Turns materials into those of plane strain that a sheet of them is like.
pub(crate) fn flatten(scene: &Scene, materials: &mut [ResolvedMaterial], faults: &mut Faults) {
    if scene.manufactured.is_some() {
        faults.add("manufactured.field", "is one of plane strain");
    }
    for (material, resolved) in scene.materials.iter().zip(materials) {
        let path = format!("material.{}", material.group);
        if resolved.is_flow {
            faults.add(format!("{path}.model"), "a flow is in plane strain");
            continue;
        }
        if formulation(&material.model) == Formulation::Mixed {
            let message = "a sheet has no pressure of its own: leave the formulation out";
            faults.add(format!("{path}.formulation"), message);
        }
        match resolved.rubber.take() {
            Some(rubber) => rubber::flatten(rubber, resolved),
            None => {
                resolved.law = resolved.law.of_a_sheet();
                resolved.poisson_ratio = resolved.law.poisson_ratio();
            }
        }
    }
}

fn formulation(model: &MaterialModel) -> Formulation {
    match model {
        MaterialModel::LinearElastic { formulation, .. }
        | MaterialModel::Stokes { formulation, .. }
        | MaterialModel::Rubber { formulation, .. } => *formulation,
    }
}

/// Refuses what has no meaning where u is a velocity.
pub(crate) fn check_flow(scene: &Scene, materials: &[ResolvedMaterial], faults: &mut Faults) {
    if !materials.iter().any(|material| material.is_flow) {
        return;
    }
    let solid = scene
        .materials
        .iter()
        .zip(materials)
        .find(|(_, resolved)| !resolved.is_flow);
    if let Some((material, _)) = solid {
        let path = format!("material.{}.model", material.group);
        faults.add(path, "a solid cannot share a scene with a flow");
    }
    for obstacle in &scene.obstacles {
        let path = format!("obstacle.{}", obstacle.name);
        let message = "a flow has velocities, which close no gap: leave obstacles out";
        faults.add(path, message);
    }
}

/// Whether the scene carries a pressure unknown: one formulation for all cells.
pub(crate) fn mixed(
    scene: &Scene,
    materials: &mut [ResolvedMaterial],
    faults: &mut Faults,
) -> bool {
    let asked = |material: &crate::scene::Material| formulation(&material.model);
    let mixed = scene
        .materials
        .iter()
        .zip(&*materials)
        .any(|(material, resolved)| match asked(material) {
            Formulation::Mixed => true,
            Formulation::Displacement => false,
            Formulation::Auto => resolved.rubber.is_some() || resolved.poisson_ratio >= MIXED_FROM,
        });
    for (material, resolved) in scene.materials.iter().zip(&mut *materials) {
        let path = format!("material.{}", material.group);
        if mixed && asked(material) == Formulation::Displacement {
            let message =
                "all materials of a scene share one formulation, and another one is mixed";
            faults.unsupported(format!("{path}.formulation"), message);
        }
        if !mixed || resolved.poisson_ratio >= LEAST_MIXED || resolved.is_foam() {
            continue;
        }
        match resolved.rubber {
            Some(_) if material.model.is_rubber() => faults.unsupported(
                format!("{path}.bulk_modulus"),
                "is below two thirds of the shear modulus at rest",
            ),
            Some(_) => faults.unsupported(
                format!("{path}.poisson_ratio"),
                format!("below {LEAST_MIXED}, a material cannot share a scene with rubber"),
            ),
            None if resolved.poisson_ratio < LEAST_BESIDE_A_PRESSURE => faults.unsupported(
                format!("{path}.poisson_ratio"),
                format!("below {LEAST_BESIDE_A_PRESSURE}, a material cannot share a scene with a mixed one"),
            ),
            None => resolved.law = resolved.law.beside_a_pressure(),
        }
    }
    mixed
}
