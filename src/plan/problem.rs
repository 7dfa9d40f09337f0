//! The problem: what the scene's names stand for, the units, and the unknowns with their layout.

use super::held::held_unknowns;
use super::held_nodes::{HeldByPlanes, held_nodes};
use super::pairs::{self, PlannedPair};
use super::settings::Settings;
use super::surfaces::{self, ContactLayout, Surfaces};
use super::ties::{self, PlannedTie};
use super::units::ScaledMesh;
use super::{Units, behind, compared, element, friction, overlap, true_surface};
use crate::comparisons::Comparisons;
use crate::fluid::surface::{FluidSurface, Reach};
use crate::mesh::{EdgeOffset, Mesh, MeshId};
use crate::report::Unknowns;
use crate::scene::validate::{Resolved, ResolvedObstacle, build, resolve};
use crate::scene::{ContactSpace, Scene, SceneError, Step, Violation};
use crate::space::TaylorHood;

/// A scene on a mesh, resolved.
#[derive(Clone, Debug)]
pub(crate) struct Problem {
    /// The scene as it was given.
    pub(crate) scene: Scene,
    /// What the scene's names stand for: items with facets, values and built shapes.
    pub(crate) resolved: Resolved,
    /// Obstacles in the order of the scene, shapes non-dimensional.
    pub(crate) obstacles: Vec<ResolvedObstacle>,
    /// What the scene asks of every increment: tolerance, limits, options.
    pub(crate) settings: Settings,
    /// Reference length and stress, by which everything is made non-dimensional.
    pub(crate) units: Units,
    /// Digest of the mesh that the plan was made for.
    pub(crate) mesh_id: MeshId,
    /// Number of unknowns by kind.
    pub(crate) unknowns: Unknowns,
    /// Number of mesh vertices.
    pub(crate) vertices: usize,
    /// Number of mesh cells.
    pub(crate) cells: usize,
    /// Mean quality of the cells, in (0, 1]; low values ask for smoothing along short
    /// edges.
    pub(crate) quality: f64,
    /// Held unknown and the support that holds it ([`super::held::AXIS`] where none does),
    /// ascending by unknown.
    pub(crate) held: Vec<(u32, u16)>,
    /// Nodes that planes hold, ascending.
    pub(crate) held_nodes: Vec<HeldByPlanes>,
    /// Functions of the contact pressure.
    pub(crate) contact_space: ContactSpace,
    /// Functions and multipliers of each obstacle's surface.
    pub(crate) contact_layouts: Vec<ContactLayout>,
    /// Contacts between bodies, in the order of the scene.
    pub(crate) pairs: Vec<PlannedPair>,
    /// Functions and multipliers of the carrier of each of them, after those of obstacles.
    pub(crate) pair_layouts: Vec<ContactLayout>,
    /// Ties between bodies, in the order of the scene.
    pub(crate) ties: Vec<PlannedTie>,
    /// What each fluid can reach.
    pub(crate) fluid_surfaces: Vec<FluidSurface>,
    /// Tractions of friction, after the pressures of all obstacles.
    pub(crate) tangential_multipliers: usize,
    /// Multipliers of supports that hold their normal component and of ties, after those of
    /// obstacles.
    pub(crate) guided_multipliers: usize,
    /// Number of edges of the surface that have an offset.
    pub(crate) curved_edges: usize,
    /// Offsets of all edges where arcs are fitted over some of them, else empty.
    pub(crate) fitted: Vec<EdgeOffset>,
}

/// A problem, and what is made with it and not kept.
pub(super) struct Stated {
    /// The problem.
    pub(super) problem: Problem,
    /// The mesh with arcs fitted to its surface; none where none are asked for.
    pub(super) fitted: Option<Mesh>,
    /// Mesh vertices of all surfaces that carry multipliers, ascending.
    pub(super) surface_vertices: Vec<u32>,
}

/// Items of a scene without names, and their units.
struct Items {
    resolved: Resolved,
    obstacles: Vec<ResolvedObstacle>,
    units: Units,
}

/// The problem of `scene`, which may name methods of `comparisons`, and `steps` on `mesh`.
///
/// # Errors
/// [`SceneError`] with the path of every faulty key.
pub(super) fn state(
    scene: &Scene,
    steps: &[Step],
    mesh: &Mesh,
    comparisons: Option<&dyn Comparisons>,
) -> Result<Stated, SceneError> {
    let (resolved, obstacles) = resolve(scene, steps, mesh)?;
    compared::check(&scene.solver, comparisons)?;
    let units = usable_units(scene, &resolved, mesh)?;
    let mut obstacles = build(obstacles, units.length)?;
    let fitted = true_surface::fitted(mesh, &obstacles);
    let body = ScaledMesh {
        mesh: fitted.as_ref().unwrap_or(mesh),
        units: &units,
    };
    overlap::refuse((&scene.obstacles, &obstacles), body)?;
    behind::refuse((&scene.obstacles, &obstacles), steps, body)?;
    friction::assign_friction(&mut obstacles, steps);
    let items = Items {
        resolved,
        obstacles,
        units,
    };
    let (mut problem, surface_vertices) = problem(scene, items, fitted.as_ref().unwrap_or(mesh))?;
    problem.fitted = fitted.as_ref().map_or(&[][..], Mesh::edge_offsets).to_vec();
    Ok(Stated {
        problem,
        fitted,
        surface_vertices,
    })
}

/// The problem of those items, with the mesh vertices of its surfaces.
///
/// # Errors
/// [`SceneError::Invalid`] where the surfaces of a tie do not meet.
fn problem(scene: &Scene, items: Items, mesh: &Mesh) -> Result<(Problem, Vec<u32>), SceneError> {
    let Items {
        resolved,
        obstacles,
        units,
    } = items;
    let space = TaylorHood::new(mesh);
    let natural = ContactSpace::Quadratic;
    let contact_space = scene.solver.contact_space.named().unwrap_or(natural);
    let held = held_unknowns(&resolved, mesh, &space);
    let body = surfaces::Body {
        mesh,
        space: &space,
        held: &held,
    };
    let pairs = pairs::choose(&resolved.pairs, &resolved, mesh);
    let held_nodes = held_nodes(&resolved, (mesh, &space), &held);
    let others = acted_on(&resolved, &obstacles, &pairs);
    let ties = planned_ties(body, &resolved, &held_nodes, (&others, &units))?;
    let acting = surfaces::Acting {
        obstacles: &obstacles,
        pairs: &pairs,
        ties: &ties,
    };
    let surfaces = Surfaces::of(body, acting, &resolved, contact_space);
    let tangential_multipliers = friction::tangential_multipliers(
        (&obstacles, &surfaces.layouts),
        (&pairs, &surfaces.pair_layouts),
        units.dimension,
    );
    let multipliers = surfaces.contacts + tangential_multipliers + surfaces.guided;
    let problem = Problem {
        scene: scene.clone(),
        settings: Settings::new(&scene.solver),
        mesh_id: mesh.id(),
        unknowns: Unknowns {
            contact: multipliers as u64,
            ..element::unknowns(&space, &resolved)
        },
        vertices: space.vertices,
        cells: mesh.cell_count(),
        quality: mesh.quality().mean,
        held_nodes,
        held,
        contact_space,
        contact_layouts: surfaces.layouts,
        pairs,
        pair_layouts: surfaces.pair_layouts,
        ties,
        fluid_surfaces: fluid_surfaces(&resolved, mesh, &space),
        tangential_multipliers,
        guided_multipliers: surfaces.guided,
        curved_edges: mesh.edge_offsets().len(),
        fitted: Vec::new(),
        resolved,
        obstacles,
        units,
    };
    Ok((problem, surfaces.vertices))
}

/// Facets on which something else than ties acts by multipliers.
fn acted_on<'a>(
    resolved: &'a Resolved,
    obstacles: &'a [ResolvedObstacle],
    pairs: &'a [PlannedPair],
) -> Vec<&'a [u32]> {
    let candidates = obstacles.iter().map(|obstacle| &obstacle.facets);
    let sides = pairs.iter().flat_map(|pair| [&pair.carrier, &pair.other]);
    let supports = resolved.supports.iter();
    let patches = supports.flat_map(|support| &support.patches);
    let others = candidates.chain(sides).chain(patches);
    others.map(|facets| &facets[..]).collect()
}

/// The ties of a scene, beside those `others`.
fn planned_ties(
    body: surfaces::Body<'_>,
    resolved: &Resolved,
    held_nodes: &[HeldByPlanes],
    (others, units): (&[&[u32]], &Units),
) -> Result<Vec<PlannedTie>, SceneError> {
    let ground = ties::Ground {
        mesh: body.mesh,
        space: body.space,
        scale: units.coordinate_scale,
        held: body.held,
        held_nodes,
        others,
    };
    ties::choose(resolved, ground)
}

/// What each fluid can reach.
fn fluid_surfaces(resolved: &Resolved, mesh: &Mesh, space: &TaylorHood) -> Vec<FluidSurface> {
    let fluids = resolved.fluids.iter().map(|fluid| Reach {
        facets: &fluid.facets,
        from: &fluid.from,
        dry: &fluid.dry,
    });
    fluids
        .map(|reach| FluidSurface::new(mesh, space, reach))
        .collect()
}

/// The units of a scene.
///
/// # Errors
/// [`SceneError::Invalid`] where they leave the range of numbers.
fn usable_units(scene: &Scene, resolved: &Resolved, mesh: &Mesh) -> Result<Units, SceneError> {
    let units = Units::new(scene, resolved, mesh);
    if units.are_usable() {
        return Ok(units);
    }
    Err(SceneError::Invalid(vec![Violation {
        path: "mesh_scale".to_owned(),
        message: format!(
            "a body of length {:e} with a {} of {:e} leaves the range of numbers",
            units.length,
            resolved.modulus_name(),
            units.stress
        ),
    }]))
}

impl Problem {
    /// Facets of the surfaces that multipliers act on: those that may touch each obstacle, both
    /// sides of each contact between bodies and of each tie, then the smooth patches of supports along
    /// their normal.
    pub(crate) fn surfaces(&self) -> impl Iterator<Item = &[u32]> {
        let candidates = self.obstacles.iter().map(|obstacle| &obstacle.facets[..]);
        let pairs = self.pairs.iter();
        let pairs = pairs.flat_map(|pair| [&pair.carrier[..], &pair.other[..]]);
        let ties = self.ties.iter();
        let ties = ties.flat_map(|tie| tie.sides().map(|side| &side[..]));
        candidates
            .chain(pairs)
            .chain(ties)
            .chain(self.patches().map(|patch| &patch[..]))
    }

    /// Smooth patches of supports along their normal, their facets.
    pub(crate) fn patches(&self) -> impl Iterator<Item = &Vec<u32>> {
        let supports = self.resolved.supports.iter();
        supports.flat_map(|support| &support.patches)
    }

    /// Whether multipliers of quadratic functions are there.
    pub(crate) fn has_quadratic_multipliers(&self) -> bool {
        let contacts = self.normal_multipliers();
        let is_quadratic = self.contact_space == ContactSpace::Quadratic;
        let is_other = self.guided_multipliers > 0 || !self.pairs.is_empty();
        is_other || (is_quadratic && contacts > 0)
    }

    /// Number of contact pressures of all obstacles and contacts, which come first among the
    /// multipliers.
    pub(crate) fn normal_multipliers(&self) -> usize {
        let others = self.tangential_multipliers + self.guided_multipliers;
        self.unknowns.contact as usize - others
    }

    /// Whether there is friction on some obstacle.
    pub(crate) fn has_friction(&self) -> bool {
        self.tangential_multipliers > 0
    }

    /// Whether supports leave rigid modes that only contact can hold.
    pub(crate) fn is_floating(&self) -> bool {
        !self.resolved.free_modes.is_empty()
    }

    /// Largest over smallest shear modulus of the body.
    pub(crate) fn contrast(&self) -> f64 {
        let shear = self.resolved.materials.iter();
        let shear = shear.map(|material| material.law.shear_modulus);
        shear.clone().fold(0.0, f64::max) / shear.fold(f64::INFINITY, f64::min)
    }
}
