//! Fluids: names, groups, values, and what steps ask of them.

use super::{Faults, ResolvedFluid, ResolvedPair, names};
use crate::mesh::Mesh;
use crate::pairs::Meets;
use crate::scene::names::hint;
use crate::scene::{
    Fluid, FluidLoad, FluidThreshold, Material, MaterialModel, Scene, SceneKind, Step,
};

/// Fluids of a scene at most: each costs a pass over its surface.
const MOST_FLUIDS: usize = 64;
/// Widest bracket of a blow-off pressure.
const WIDEST: f64 = 0.5;

/// The fluids on their facets.
pub(crate) fn resolve(scene: &Scene, mesh: &Mesh, faults: &mut Faults) -> Vec<ResolvedFluid> {
    if scene.fluids.is_empty() {
        return Vec::new();
    }
    let all = scene.fluids.iter().map(|fluid| fluid.name.as_str());
    names::check_unique(faults, "fluid", all);
    refuse(scene, faults);
    let fluids = scene.fluids.iter().take(MOST_FLUIDS);
    let all: Vec<ResolvedFluid> = fluids.map(|fluid| one(fluid, mesh, faults)).collect();
    apart(mesh, &all, faults);
    all
}

/// Fluids that begin at one place have leaked into each other before anything moves.
fn apart(mesh: &Mesh, all: &[ResolvedFluid], faults: &mut Faults) {
    let sources: Vec<Vec<u32>> = all.iter().map(|one| vertices(mesh, &one.from)).collect();
    for (k, one) in all.iter().enumerate() {
        let mut earlier = all.iter().zip(&sources).take(k);
        let met = earlier.find_map(|(other, own)| Some((other, shared(own, &sources[k])?)));
        if let Some((other, vertex)) = met {
            let vertex = mesh.used_vertices()[vertex as usize];
            let message = format!(
                "meets `from` of fluid `{}` at vertex {vertex}: leave facets between them",
                other.name
            );
            faults.add(format!("fluid.{}.from", one.name), message);
        }
    }
}

/// Vertices of facets, ascending.
fn vertices(mesh: &Mesh, facets: &[u32]) -> Vec<u32> {
    let corners = facets.iter().flat_map(|&facet| mesh.facet(facet as usize));
    let mut vertices: Vec<u32> = corners.copied().collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices
}

/// The first vertex of one that is among the other, both ascending.
fn shared(one: &[u32], other: &[u32]) -> Option<u32> {
    let mut common = one.iter().copied();
    common.find(|vertex| other.binary_search(vertex).is_ok())
}

/// Refuses scenes that no fluid surrounds.
fn refuse(scene: &Scene, faults: &mut Faults) {
    if scene.fluids.len() > MOST_FLUIDS {
        let message = format!(
            "are {}; at most {MOST_FLUIDS} are allowed",
            scene.fluids.len()
        );
        faults.add("fluid", message);
    }
    if scene.manufactured.is_some() {
        faults.add(
            "fluid",
            "stands beside a manufactured field, which brings its own loads",
        );
    }
    if scene.kind == Some(SceneKind::PlaneStress) {
        faults.unsupported("fluid", "a fluid on a sheet, whose thickness changes");
    }
    let is_flow = |one: &Material| matches!(one.model, MaterialModel::Stokes { .. });
    if scene.materials.iter().any(is_flow) {
        faults.unsupported("fluid", "a fluid beside a body that flows itself");
    }
}

fn one(fluid: &Fluid, mesh: &Mesh, faults: &mut Faults) -> ResolvedFluid {
    let path = format!("fluid.{}", fluid.name);
    let mut groups = |key: &str, on: &[String]| {
        let key = format!("{path}.{key}");
        let facets = names::facets(mesh, &key, on, faults);
        names::refuse_inner_facets(mesh, &facets, key, faults);
        facets
    };
    let on = groups("on", &fluid.on);
    let from = groups("from", &fluid.from);
    let dry = match &fluid.dry[..] {
        [] => Vec::new(),
        dry => groups("dry", dry),
    };
    values(fluid, &path, faults);
    let mut facets = [on, from.clone()].concat();
    facets.sort_unstable();
    facets.dedup();
    if faults.is_empty() {
        surfaces(mesh, [&facets, &from, &dry], &path, faults);
    }
    facets.retain(|facet| dry.binary_search(facet).is_err());
    ResolvedFluid {
        name: fluid.name.clone(),
        facets,
        from,
        dry,
        pressure: fluid.pressure,
        threshold: match fluid.threshold {
            FluidThreshold::Fluid => None,
            FluidThreshold::Pressure(pressure) => Some(pressure),
        },
        film: fluid.film,
        blow_off_tolerance: fluid.blow_off_tolerance,
        viscosity: fluid.viscosity,
    }
}

fn values(fluid: &Fluid, path: &str, faults: &mut Faults) {
    faults.not_negative(&format!("{path}.pressure"), fluid.pressure);
    if let FluidThreshold::Pressure(pressure) = fluid.threshold {
        faults.not_negative(&format!("{path}.threshold"), pressure);
    }
    if let Some(viscosity) = fluid.viscosity {
        faults.above_zero(&format!("{path}.viscosity"), viscosity);
    }
    let tolerance = fluid.blow_off_tolerance;
    if !(tolerance > 0.0 && tolerance <= WIDEST) {
        let message = format!("must be above zero and at most {WIDEST}, not {tolerance}");
        faults.add(format!("{path}.blow_off_tolerance"), message);
    }
}

/// What is wet, what shall stay dry and the surface between them belong together.
fn surfaces(mesh: &Mesh, facets: [&[u32]; 3], path: &str, faults: &mut Faults) {
    let [all, from, dry] = facets;
    let [all, from, dry] = [all, from, dry].map(|facets| vertices(mesh, facets));
    let key = format!("{path}.dry");
    if let Some(vertex) = shared(&dry, &from) {
        let vertex = mesh.used_vertices()[vertex as usize];
        let message = format!(
            "meets `from` at vertex {vertex}: the fluid is there from the start; leave facets between them"
        );
        faults.add(key, message);
    } else if !dry.is_empty() && shared(&dry, &all).is_none() {
        faults.add(
            key,
            "touches nothing of `on` and `from`: the fluid can never reach it",
        );
    }
}

/// Between two bodies a fluid presses on both, so that it has to be able to reach both.
pub(super) fn check_beside(
    mesh: &Mesh,
    (fluids, pairs): (&[ResolvedFluid], &[ResolvedPair]),
    faults: &mut Faults,
) {
    let is_in_space = mesh.cell_kind().dimension() == 3;
    for fluid in fluids {
        let reaches = |side: &Vec<u32>| {
            let mut facets = side.iter();
            facets.any(|facet| fluid.facets.binary_search(facet).is_ok())
        };
        let sides = pairs
            .iter()
            .map(|pair| (pair, pair.sides.each_ref().map(reaches)));
        for (pair, sides) in sides {
            match sides {
                [false, false] => {}
                [true, true] => refuse_between(fluid, (pair, is_in_space), faults),
                [true, false] | [false, true] => {
                    let message = format!(
                        "has facets of one surface of contact `{}` alone: between two bodies a fluid presses on both, name the other one, too",
                        pair.name
                    );
                    faults.add(format!("fluid.{}.on", fluid.name), message);
                }
            }
        }
    }
}

/// Refuses what is not solved of a fluid that reaches a contact between bodies.
fn refuse_between(
    fluid: &ResolvedFluid,
    (pair, is_in_space): (&ResolvedPair, bool),
    faults: &mut Faults,
) {
    let ResolvedPair { name, meets, .. } = pair;
    let reason = match meets {
        Meets::Itself => {
            Some("of a surface with itself is not solved yet, between two surfaces it is")
        }
        Meets::ItsBody if is_in_space => {
            Some("of one body with itself in space is not solved yet, between two bodies it is")
        }
        Meets::AnotherBody | Meets::ItsBody => None,
    };
    if let Some(reason) = reason {
        let message = format!("a fluid in contact `{name}` {reason}");
        faults.unsupported(format!("fluid.{}.on", fluid.name), message);
    }
    if fluid.viscosity.is_some() {
        let message = format!(
            "what flows through contact `{name}` between bodies is not solved yet, past obstacles it is"
        );
        faults.unsupported(format!("fluid.{}.viscosity", fluid.name), message);
    }
}

/// Adds the faults of what a step asks of fluids, whose key is `path`.
pub(super) fn check_step(scene: &Scene, step: &Step, path: &str, faults: &mut Faults) {
    for target in &step.fluids {
        if faults.is_full() {
            return;
        }
        let path = format!("{path}.fluid.{}", target.name);
        let known = scene.fluids.iter().map(|one| one.name.as_str());
        if !known.clone().any(|name| name == target.name) {
            let hint = hint(&target.name, known);
            let message = format!("the scene has no fluid `{}`{hint}", target.name);
            faults.add(&path, message);
        }
        match target.load {
            FluidLoad::To(pressure) => {
                faults.not_negative(&format!("{path}.pressure"), pressure);
            }
            FluidLoad::ToBlowOff(most) => {
                faults.above_zero(&format!("{path}.up_to"), most);
            }
        }
    }
}
