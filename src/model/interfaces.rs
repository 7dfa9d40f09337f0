//! The surfaces of the body that carry multipliers, with what each of them meets:
//! candidate surfaces with their obstacles, carriers of contacts between bodies, the smooth
//! patches that supports hold along their normal, then carriers of ties, one interface a component.
//! The multipliers of all of them stand one after the other.
//!
//! ```text
//! multipliers:  obstacle 1 | ... | contact 1 | ... | patch 1 of support 1 | ... | tie 1, x | tie 1, y | ...
//! sets:         NonNegative ................... | Free ...................................
//! ```
//!
//! Obstacles have quadratic functions at all nodes or hats at the vertices, as the plan
//! says, patches quadratic functions at all nodes. What a
//! surface meets is placed by a drive; the surface itself never moves, since all integrals
//! are over the undeformed body. Cost: one pass over the faces.

use std::borrow::Cow;
use std::sync::Arc;

use super::contact_moduli::contact_moduli;
use super::drive::Drive;
use super::friction::Friction;
use super::placed::Placed;
use super::state::State;
use super::surface_metric::SurfaceMetric;
use crate::contact::basis::Bernstein;
use crate::contact::gap::Deformed;
use crate::contact::patches::outward;
use crate::contact::smooth::sagittas;
use crate::contact::surface::{FACE_DEGREE, KINKED_DEGREE, face_rule};
use crate::contact::{ContactSurface, Guide, Measure};
use crate::element::quadrature::Rule;
use crate::geometry::RigidMotion;
use crate::mesh::Mesh;
use crate::obstacle::{Moving, Obstacle};
use crate::pairs::{Ground, PairSurface, Section, Support, lending};
use crate::plan::Plan;
use crate::plan::pairs::PlannedPair;
use crate::plan::surfaces::ContactLayout;
use crate::plan::ties::PlannedTie;
use crate::saddle::{AdmissibleSet, SetPart};
use crate::scene::ContactSpace;
use crate::scene::validate::ResolvedObstacle;
use crate::space::TaylorHood;
use crate::ties::Tied;

/// Component of a unit normal that counts as one.
const HELD_ALONG: f64 = 1e-9;

/// A surface with multipliers and what it meets.
#[derive(Clone, Debug)]
pub(crate) struct Interface {
    /// Name of the obstacle or the support that the surface belongs to.
    pub(crate) name: String,
    /// Faces and multipliers of the surface.
    pub(crate) surface: ContactSurface,
    /// Facets of the mesh that the surface is made of.
    pub(crate) facets: Vec<u32>,
    /// Multipliers, counted within the surface, that hold nothing: other supports hold
    /// the component already.
    pub(crate) idle: Vec<u32>,
    /// What the surface meets, without its pose.
    pub(crate) role: Role,
    /// Its multipliers among those of all interfaces, ascending; obstacles on
    /// neighbouring parts of a smooth surface have common ones.
    pub(crate) multipliers: Vec<u32>,
    /// Distance of the edges of each facet from the surface that the facets stand for
    /// `[facets]`, in units of the mesh; empty where they are that surface.
    pub(crate) sagittas: Vec<f64>,
}

/// What a surface meets.
#[derive(Clone, Debug)]
pub(crate) enum Role {
    /// An obstacle, which the surface may touch from one side and leave.
    Contact(Arc<dyn Obstacle>),
    /// The support of that number, which holds the normal component.
    Support(usize),
    /// A surface of another body, which the surface may touch from one side and leave.
    Pair(Arc<PairSurface>),
    /// A surface of another body that moves along in one component.
    Tie(Arc<Tied>),
}

impl Interface {
    /// Its multipliers among all.
    pub(crate) fn places(&self) -> impl Iterator<Item = usize> + '_ {
        self.multipliers.iter().map(|&m| m as usize)
    }

    /// Its part of `all` multipliers.
    pub(crate) fn own<'a, T: Copy>(&self, all: &'a [T]) -> Cow<'a, [T]> {
        match self.multipliers[..] {
            [first, .., last] if (last - first) as usize + 1 == self.multipliers.len() => {
                Cow::Borrowed(&all[first as usize..=last as usize])
            }
            _ => self.places().map(|place| all[place]).collect(),
        }
    }

    /// Adds its part to `all` multipliers.
    pub(crate) fn add_own(&self, own: &[f64], all: &mut [f64]) {
        for (place, value) in self.places().zip(own) {
            all[place] += value;
        }
    }

    /// Coefficients of its functions, from all multipliers.
    pub(crate) fn coefficients(&self, all: &[f64]) -> Vec<f64> {
        self.surface.shares.spread(&self.own(all)).into_owned()
    }

    /// Whether an obstacle or another body meets the surface, from one side.
    pub(crate) fn is_contact(&self) -> bool {
        matches!(self.role, Role::Contact(_) | Role::Pair(_))
    }

    /// The other surface, where that is one of another body.
    pub(crate) fn pair(&self) -> Option<&PairSurface> {
        match &self.role {
            Role::Pair(pair) => Some(pair),
            Role::Contact(_) | Role::Support(_) | Role::Tie(_) => None,
        }
    }

    /// One component of a tie.
    pub(crate) fn tie(&self) -> Option<&Tied> {
        match &self.role {
            Role::Tie(tie) => Some(tie),
            Role::Contact(_) | Role::Support(_) | Role::Pair(_) => None,
        }
    }

    /// Whether what the surface meets is asked point by point, not another body as a whole.
    pub(crate) fn is_by_points(&self) -> bool {
        matches!(self.role, Role::Contact(_) | Role::Support(_))
    }

    /// Has multipliers that meet next to nothing where the linear `body` is at rest lend their functions.
    fn lend_at_rest(&mut self, body: &Deformed<'_>) {
        if let Some(pair) = self.pair() {
            let supports = pair.supports_at_rest(body, &self.surface);
            self.lend(body, &supports);
        }
    }

    /// Has multipliers lend their functions that have as little to press on as `supports` say.
    pub(super) fn lend(&mut self, body: &Deformed<'_>, supports: &[Support]) {
        if self.pair().is_some() {
            self.surface = lending(body, &self.surface, supports);
        }
    }

    /// Takes the gap to another body where the linear `body` is at rest.
    fn freeze(&mut self, body: &Deformed<'_>) {
        if let Role::Pair(pair) = &mut self.role {
            Arc::make_mut(pair).freeze(body, &self.surface);
        }
    }

    /// Takes the rows of slips on another body where the linear `body` is at rest.
    fn freeze_sliding(&mut self, body: &Deformed<'_>) {
        if let Role::Pair(pair) = &mut self.role {
            Arc::make_mut(pair).freeze_sliding(body, &self.surface);
        }
    }

    /// Whether what the surface meets has no curvature, so that its tangent needs none.
    fn is_flat(&self) -> bool {
        match &self.role {
            Role::Contact(shape) => shape.is_flat(),
            // That of a linear body is taken where it is at rest.
            Role::Support(_) | Role::Pair(_) | Role::Tie(_) => true,
        }
    }
}

/// All interfaces of a scene: of obstacles, in the order of the plan, of contacts between bodies,
/// then of supports.
#[derive(Clone, Debug)]
pub(crate) struct Interfaces {
    /// The interfaces, their multipliers one after the other.
    pub(crate) list: Vec<Interface>,
    /// Quadrature rule on the reference face, the same for all of them.
    pub(crate) rule: Rule,
    /// Where the multipliers may be, one part an interface, in their order.
    pub(crate) sets: Vec<SetPart<'static>>,
    /// What a metric takes from the undeformed surfaces.
    pub(crate) metric: SurfaceMetric,
    /// Shear modulus where each multiplier acts; empty where all cells are alike.
    pub(crate) moduli: Vec<f64>,
    /// Number of contact pressures of all obstacles and bodies, which come first.
    normals: usize,
    /// Tractions of frictional obstacles; none where there are none.
    pub(crate) friction: Option<Friction>,
}

/// Degree of the rule that all contact integrals take.
fn contact_degree(plan: &Plan) -> u32 {
    if plan
        .problem
        .obstacles
        .iter()
        .all(|one| one.shape.is_smooth())
    {
        FACE_DEGREE
    } else {
        KINKED_DEGREE
    }
}

impl Interfaces {
    /// Those of `plan`.
    pub(crate) fn new(plan: &Plan, mesh: &Mesh, space: &TaylorHood) -> Self {
        let obstacles = plan
            .problem
            .obstacles
            .iter()
            .zip(&plan.problem.contact_layouts);
        let contacts = obstacles.map(|obstacle| of_obstacle(plan, mesh, space, obstacle));
        let supports = plan.problem.resolved.supports.iter().enumerate();
        let guides = supports.flat_map(|(index, support)| {
            let patches = support.patches.iter();
            patches.map(move |patch| of_patch(plan, mesh, space, (index, patch)))
        });
        let pairs = plan.problem.pairs.iter().zip(&plan.problem.pair_layouts);
        let pairs = pairs.map(|pair| of_pair(plan, mesh, space, pair));
        let ties = plan.problem.ties.iter().flat_map(|tie| {
            let components = 0..space.components;
            components.map(move |component| of_tie(plan, mesh, space, (tie, component)))
        });
        let mut list: Vec<Interface> = contacts.chain(pairs).chain(guides).chain(ties).collect();
        number_guides(plan, &mut list);
        let rule = face_rule(plan.problem.units.dimension, contact_degree(plan));
        let at_rest = vec![0.0; space.displacement_unknowns()];
        let body = Deformed {
            mesh,
            scale: plan.problem.units.coordinate_scale,
            space,
            displacement: &at_rest,
            rule: &rule,
            measure: Measure::Undeformed,
        };
        let surfaces = list.iter().map(|one| (&one.multipliers[..], &one.surface));
        let surfaces: Vec<(&[u32], &ContactSurface)> = surfaces.collect();
        let friction = Friction::new(plan, &body, &surfaces);
        let mut moduli = contact_moduli(plan, (mesh, space), &surfaces);
        if let Some(friction) = friction.as_ref().filter(|_| !moduli.is_empty()) {
            friction.take_over(&mut moduli);
        }
        let metric = SurfaceMetric::new(plan, mesh, &surfaces);
        if !plan.problem.resolved.is_rubber() {
            at_rest_for_good(plan, &mut list, &body);
        }
        Self {
            sets: sets(plan),
            metric,
            normals: plan.normal_multipliers(),
            moduli,
            friction,
            list,
            rule,
        }
    }

    /// The same with another shape of the obstacle of that number, of the same kind.
    pub(crate) fn with_shape(&self, obstacle: usize, shape: Arc<dyn Obstacle>) -> Self {
        let mut changed = self.clone();
        let own = changed.list.get_mut(obstacle);
        if let Some(role @ Role::Contact(_)) = own.map(|one| &mut one.role) {
            *role = Role::Contact(shape);
        }
        changed
    }

    /// Number of multipliers of obstacles that are at work.
    pub(crate) fn contacts_at_work(&self, state: &State) -> usize {
        let status = state.status[..self.normals].iter();
        status.filter(|status| status.is_closed()).count()
    }

    /// Whether every gap is linear in the displacement.
    pub(crate) fn are_flat(&self) -> bool {
        self.list.iter().all(Interface::is_flat)
    }

    /// The obstacles in the poses of `drive`, non-dimensional.
    pub(crate) fn obstacles(&self, drive: &Drive, length: f64) -> Vec<Moving> {
        let shapes = self
            .list
            .iter()
            .filter_map(|interface| match &interface.role {
                Role::Contact(shape) => Some(shape),
                Role::Support(_) | Role::Pair(_) | Role::Tie(_) => None,
            });
        let poses = shapes.zip(&drive.poses);
        poses
            .map(|(shape, pose)| {
                let translation = pose.translation.map(|x| x / length);
                Moving::new(shape.clone(), translation, pose.rotation)
            })
            .collect()
    }

    /// Every surface with what it meets where `drive` has it, in the order of the
    /// multipliers; `length` is the body's.
    pub(crate) fn placed(
        &self,
        drive: &Drive,
        length: f64,
    ) -> impl Iterator<Item = (&Interface, Placed)> {
        let obstacles = self
            .obstacles(drive, length)
            .into_iter()
            .map(Placed::Obstacle);
        let others = self
            .list
            .iter()
            .filter_map(|interface| match &interface.role {
                Role::Contact(_) => None,
                Role::Support(index) => Some(Placed::Guide(guide(drive, *index, length))),
                Role::Pair(pair) => Some(Placed::Pair(pair.clone(), None)),
                Role::Tie(tie) => Some(Placed::Tie(tie.clone())),
            });
        let others: Vec<Placed> = others.collect();
        self.list.iter().zip(obstacles.chain(others))
    }
}

/// Takes what linear bodies mean to each other where they are at rest.
fn at_rest_for_good(plan: &Plan, list: &mut [Interface], body: &Deformed<'_>) {
    for one in list.iter_mut() {
        one.lend_at_rest(body);
        one.freeze(body);
    }
    let own = list.iter_mut().skip(plan.problem.obstacles.len());
    let rough = own.zip(&plan.problem.pairs);
    for (one, _) in rough.filter(|(_, pair)| pair.is_frictional()) {
        one.freeze_sliding(body);
    }
}

/// Half lines of contact, then lines of guides; what is not there is no part.
fn sets(plan: &Plan) -> Vec<SetPart<'static>> {
    let guided = plan.problem.guided_multipliers;
    let contacts = plan.normal_multipliers();
    let parts = [
        (contacts, AdmissibleSet::NonNegative),
        (guided, AdmissibleSet::Free),
    ];
    let parts = parts.into_iter().filter(|(size, _)| *size > 0);
    parts.map(|(size, set)| SetPart { size, set }).collect()
}

/// Numbers the multipliers of guides and ties after those of obstacles, in their order.
fn number_guides(plan: &Plan, list: &mut [Interface]) {
    let mut next = (plan.unknowns().contact as usize - plan.problem.guided_multipliers) as u32;
    for interface in list.iter_mut().filter(|interface| !interface.is_contact()) {
        let own = interface.surface.multipliers() as u32;
        interface.multipliers = (next..next + own).collect();
        next += own;
    }
}

/// The candidate surface of one obstacle.
fn of_obstacle(
    plan: &Plan,
    mesh: &Mesh,
    space: &TaylorHood,
    (obstacle, planned): (&ResolvedObstacle, &ContactLayout),
) -> Interface {
    let facets = obstacle.facets.iter();
    let facets: Vec<Vec<u32>> = facets.map(|&f| mesh.facet(f as usize).to_vec()).collect();
    let bare = surface(plan, mesh, space, &facets);
    let is_curved = bare.faces.iter().any(|face| face.curve.is_some());
    Interface {
        name: obstacle.name.clone(),
        surface: match plan.problem.contact_space {
            ContactSpace::Linear => bare,
            ContactSpace::Quadratic => bare.with_layout(&Bernstein, planned.layout.clone()),
        },
        sagittas: if is_curved {
            Vec::new()
        } else {
            sagittas(mesh, &obstacle.facets)
        },
        facets: obstacle.facets.clone(),
        idle: Vec::new(),
        role: Role::Contact(obstacle.shape.clone()),
        multipliers: planned.multipliers.clone(),
    }
}

/// The carrier of a contact between bodies.
fn of_pair(
    plan: &Plan,
    mesh: &Mesh,
    space: &TaylorHood,
    (pair, planned): (&PlannedPair, &ContactLayout),
) -> Interface {
    let facets = pair.carrier.iter();
    let facets: Vec<Vec<u32>> = facets.map(|&f| mesh.facet(f as usize).to_vec()).collect();
    let bare = surface(plan, mesh, space, &facets);
    let surface = bare.with_layout(&Bernstein, planned.layout.clone());
    let sides = ([&pair.carrier[..], &pair.other[..]], pair.meets);
    let section = if plan.is_axisymmetric() {
        Section::AboutAxis
    } else {
        Section::Plane
    };
    let held = &plan.problem.held;
    let is_held = |unknown: u32| {
        held.binary_search_by_key(&unknown, |(held, _)| *held)
            .is_ok()
    };
    let ground = Ground {
        mesh,
        space,
        is_held: &is_held,
    };
    let meets = PairSurface::new(ground, sides, (&surface, section));
    Interface {
        name: pair.name.clone(),
        surface,
        sagittas: Vec::new(),
        facets: pair.carrier.clone(),
        idle: Vec::new(),
        role: Role::Pair(Arc::new(meets)),
        multipliers: planned.multipliers.clone(),
    }
}

/// With quadratic multipliers: they hold every node of the displacement.
fn of_patch(
    plan: &Plan,
    mesh: &Mesh,
    space: &TaylorHood,
    (index, patch): (usize, &Vec<u32>),
) -> Interface {
    let facets: Vec<Vec<u32>> = patch.iter().map(|&f| outward(mesh, f)).collect();
    let surface = surface(plan, mesh, space, &facets).with_basis(&Bernstein);
    Interface {
        name: plan.problem.resolved.supports[index].name.clone(),
        idle: idle(plan, &surface, space.components),
        surface,
        sagittas: Vec::new(),
        facets: patch.clone(),
        role: Role::Support(index),
        multipliers: Vec::new(),
    }
}

/// One component of a tie.
fn of_tie(
    plan: &Plan,
    mesh: &Mesh,
    space: &TaylorHood,
    (tie, component): (&PlannedTie, usize),
) -> Interface {
    let facets = tie.pair.carrier.iter();
    let facets: Vec<Vec<u32>> = facets.map(|&f| mesh.facet(f as usize).to_vec()).collect();
    let layout = &tie.layouts[component];
    let bare = surface(plan, mesh, space, &facets);
    let tied = Tied::new(&tie.seam, layout, [component, space.components]);
    Interface {
        name: tie.pair.name.clone(),
        surface: bare.with_layout(&Bernstein, layout.clone()),
        sagittas: Vec::new(),
        facets: tie.pair.carrier.clone(),
        idle: Vec::new(),
        role: Role::Tie(Arc::new(tied)),
        multipliers: Vec::new(),
    }
}

/// The contact surface of those facets `[facets][vertices]`, with the measure of the
/// scene's geometry.
fn surface(plan: &Plan, mesh: &Mesh, space: &TaylorHood, facets: &[Vec<u32>]) -> ContactSurface {
    let scale = plan.problem.units.coordinate_scale;
    if plan.is_axisymmetric() {
        ContactSurface::about_axis(mesh, space, scale, facets)
    } else {
        ContactSurface::new(mesh, space, scale, facets)
    }
}

/// The guide of a support where `drive` has it, non-dimensional.
fn guide(drive: &Drive, support: usize, length: f64) -> Guide {
    let motion = drive.motions.get(support).copied().unwrap_or_default();
    let motion = RigidMotion {
        translation: motion.translation.map(|x| x / length),
        about: motion.about.map(|x| x / length),
        ..motion
    };
    let value = drive.supports.get(support).map_or(0.0, |values| values[0]);
    Guide::new(motion, value / length)
}

/// Multipliers of a patch that hold nothing: at nodes whose normals components of other
/// supports hold already.
fn idle(plan: &Plan, surface: &ContactSurface, components: usize) -> Vec<u32> {
    let is_held = |unknown: u32| {
        let held = plan
            .problem
            .held
            .binary_search_by_key(&unknown, |(unknown, _)| *unknown);
        held.is_ok()
    };
    let mut is_idle = vec![true; surface.multipliers()];
    for face in &surface.faces {
        for &multiplier in &face.functions {
            let node = surface.carriers[multiplier as usize];
            let mut along = (0..components).filter(|&i| face.normal[i].abs() > HELD_ALONG);
            is_idle[multiplier as usize] &=
                along.all(|i| is_held(node * components as u32 + i as u32));
        }
    }
    let multipliers = 0..surface.multipliers() as u32;
    multipliers.filter(|&m| is_idle[m as usize]).collect()
}
