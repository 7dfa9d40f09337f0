//! What a deck says beside its mesh as a scene: laws, supports, rigid tools, steps, and a list of
//! what is not taken over. Sets and surfaces count where the mesh has their facets as a group.

use std::fmt::Write as _;

use signorini_client::formats::inp::scene::{Condition, DeckScene, Law, Profile, Tool};
use signorini_client::formats::msh::MeshFile;
use toml::Value;

use crate::commands::mesh_shape::Shape;

/// Lines of the list of what is not taken over.
const LISTED: usize = 200;
/// In the place of a law that is not taken over: the scene is refused until somebody names one.
const UNREAD_LAW: &str = "# The law of the deck is not taken over, see the end of this file: name one here.\n\
    # model = \"neo-hookean\"\n# shear_modulus = 1.0\n";
/// Head of the list of what is not taken over.
pub(crate) const LEFT_OUT: &str = "# Not taken over of the deck:";
const AXES: [&str; 3] = ["x", "y", "z"];

/// A deck with its mesh.
pub(crate) struct Deck<'a> {
    mesh: &'a MeshFile,
    scene: &'a DeckScene,
    supports: Vec<Support>,
    obstacles: Vec<Obstacle<'a>>,
    left_out: Vec<(usize, String)>,
}

/// A group with the components that it holds.
struct Support {
    group: String,
    values: [Option<f64>; 3],
}

/// A tool with what may touch it.
struct Obstacle<'a> {
    tool: &'a Tool,
    on: Vec<String>,
    friction: f64,
    translation: [f64; 3],
}

impl<'a> Deck<'a> {
    pub(crate) fn new(mesh: &'a MeshFile, scene: &'a DeckScene) -> Self {
        let mut deck = Self {
            mesh,
            scene,
            supports: Vec::new(),
            obstacles: Vec::new(),
            left_out: scene.left_out.clone(),
        };
        deck.hold();
        deck.meet();
        deck
    }

    /// What the section stands for, as the line of its key.
    pub(crate) fn kind(&self) -> Option<String> {
        let kind = self.scene.kind?;
        Some(format!("kind = \"{kind}\"\n"))
    }

    /// The law of a group of cells, as the lines of its table; of a material whose law is not
    /// taken over, a comment.
    pub(crate) fn law(&self, group: &str) -> Option<String> {
        let mut laws = self.scene.laws.iter();
        let law = laws.find(|(name, _)| name.eq_ignore_ascii_case(group));
        let mut materials = self.scene.materials.iter();
        let is_material = materials.any(|name| name.eq_ignore_ascii_case(group));
        match law {
            Some((_, law)) => Some(law_text(law)),
            // A law of our own choice would be solved with unseen.
            None => is_material.then(|| UNREAD_LAW.to_owned()),
        }
    }

    /// Supports, tools and steps; none where the deck has no supports and no tools.
    pub(crate) fn conditions(&mut self) -> Option<String> {
        if self.supports.is_empty() && self.obstacles.is_empty() {
            return None;
        }
        let mut text = String::new();
        for support in &self.supports {
            text.push_str(&self.support(support));
        }
        for obstacle in &self.obstacles {
            text.push_str(&self.obstacle(obstacle));
        }
        let scene = self.scene;
        for (number, step) in (1..).zip(&scene.steps) {
            let changed = self.step(number, &step.conditions);
            // Writing to a string cannot fail.
            let _infallible = write!(
                text,
                "\n[[step]]\nincrements = {}\n{changed}",
                step.increments
            );
        }
        Some(text.trim_end().to_owned() + "\n")
    }

    /// What is not taken over, as comments.
    pub(crate) fn list(&self) -> String {
        if self.left_out.is_empty() {
            return String::new();
        }
        let mut text = format!("\n{LEFT_OUT}\n");
        let mut left_out = self.left_out.clone();
        left_out.sort();
        for (line, told) in left_out.iter().take(LISTED) {
            let told = told.replace(char::is_control, " ");
            let _infallible = writeln!(text, "# line {line}: {told}");
        }
        if let Some(more) = left_out.len().checked_sub(LISTED).filter(|more| *more > 0) {
            let _infallible = writeln!(text, "# and {more} more");
        }
        text
    }

    fn dimension(&self) -> usize {
        self.mesh.vertices_per_cell - 1
    }

    /// The group of facets of a set or surface, which may be named with its instance.
    fn facets(&self, name: &str) -> Option<String> {
        let bare = name.replace('"', "");
        let own = bare.split_once('.').map(|(_, own)| own.to_owned());
        let names = [Some(bare), own];
        names.into_iter().flatten().find_map(|name| {
            let mut groups = self.mesh.groups.iter();
            let found = groups.find(|group| {
                group.dimension + 1 == self.dimension() && group.name.eq_ignore_ascii_case(&name)
            });
            found.map(|group| group.name.clone())
        })
    }

    fn is_tool(&self, set: &str) -> bool {
        let mut references = self
            .scene
            .tools
            .iter()
            .filter_map(|tool| tool.reference.as_deref());
        references.any(|reference| reference == set)
    }

    /// Supports of what holds at first, and of what the first step holds or moves.
    fn hold(&mut self) {
        let scene = self.scene;
        let first = scene.steps.first().map(|step| &step.conditions);
        let later = first.into_iter().flatten().map(|one| (one, 0.0));
        let own = scene.conditions.iter().map(|one| (one, one.value));
        for (condition, value) in own.chain(later) {
            if self.is_tool(&condition.set) {
                continue;
            }
            let Some(group) = self.facets(&condition.set) else {
                let told = format!("*BOUNDARY: {} is no group of facets", condition.set);
                self.left_out.push((condition.line, told));
                continue;
            };
            let known = self.supports.iter().position(|one| one.group == group);
            let at = known.unwrap_or_else(|| {
                let values = [None; 3];
                self.supports.push(Support { group, values });
                self.supports.len() - 1
            });
            let dimension = self.dimension();
            if let Some(support) = self.supports.get_mut(at) {
                let values = support.values.iter_mut().take(dimension);
                for (axis, slot) in (1..).zip(values) {
                    if is_among(axis, condition) && slot.is_none() {
                        *slot = Some(value);
                    }
                }
            }
        }
        self.supports
            .retain(|support| support.values.iter().any(Option::is_some));
    }

    /// Tools of contact pairs.
    fn meet(&mut self) {
        for contact in &self.scene.contacts {
            let named = |name: &str| {
                let mut tools = self.scene.tools.iter();
                tools.find(|tool| tool.name.eq_ignore_ascii_case(name))
            };
            let tool = named(&contact.master);
            let Some((tool, group)) = tool.zip(self.facets(&contact.slave)) else {
                let pair = format!("{}, {}", contact.slave, contact.master);
                let told =
                    format!("*CONTACT PAIR: {pair}: no group of facets against a tool above");
                self.left_out.push((contact.line, told));
                continue;
            };
            let known = self
                .obstacles
                .iter_mut()
                .find(|one| one.tool.name == tool.name);
            match known {
                Some(known) => known.on.push(group),
                None => self.obstacles.push(Obstacle {
                    tool,
                    on: vec![group],
                    friction: contact.friction,
                    translation: [0.0; 3],
                }),
            }
        }
    }

    fn support(&self, support: &Support) -> String {
        let values = AXES.iter().zip(support.values);
        let values = values.filter_map(|(axis, value)| Some(format!("{axis} = {:?}", value?)));
        let values: Vec<String> = values.collect();
        let group = quoted(&support.group);
        format!(
            "\n[[support]]\nname = {group}\non = {group}\ndisplacement = {{ {} }}\n",
            values.join(", ")
        )
    }

    fn obstacle(&self, obstacle: &Obstacle<'_>) -> String {
        let on: Vec<String> = obstacle.on.iter().map(|group| quoted(group)).collect();
        let mut text = format!(
            "\n[[obstacle]]\nname = {}\non = [{}]\nshape = {}\n",
            quoted(&obstacle.tool.name),
            on.join(", "),
            self.shape(&obstacle.tool.profile)
        );
        if obstacle.friction != 0.0 {
            let _infallible = writeln!(text, "friction = {:?}", obstacle.friction);
        }
        text
    }

    fn shape(&self, profile: &Profile) -> String {
        match *profile {
            Profile::Plane { point, normal } => {
                let Shape { low, high, .. } = Shape::of(self.mesh);
                let mut side = 0.0;
                for ((low, high), (at, across)) in
                    low.iter().zip(high).zip(point.iter().zip(normal))
                {
                    side += (0.5 * (low + high) - at) * across;
                }
                let normal = normal.map(|x| if side < 0.0 { 0.0 - x } else { x });
                format!("{{ kind = \"half-space\", point = {point:?}, normal = {normal:?} }}")
            }
            Profile::Cylinder {
                point,
                axis,
                radius,
            } => format!(
                "{{ kind = \"cylinder\", point = {point:?}, axis = {axis:?}, radius = {radius:?} }}"
            ),
            Profile::Sphere { centre, radius } => {
                format!("{{ kind = \"sphere\", centre = {centre:?}, radius = {radius:?} }}")
            }
        }
    }

    /// What a step changes.
    fn step(&mut self, number: usize, conditions: &[Condition]) -> String {
        let mut moved: Vec<usize> = Vec::new();
        let mut text = String::new();
        for condition in conditions {
            let reference =
                |one: &Obstacle<'_>| one.tool.reference.as_deref() == Some(&condition.set);
            let tool = self.obstacles.iter().position(reference);
            if let Some((at, obstacle)) =
                tool.and_then(|at| Some((at, self.obstacles.get_mut(at)?)))
            {
                for (axis, slot) in (1..).zip(&mut obstacle.translation) {
                    if is_among(axis, condition) {
                        *slot = condition.value;
                    }
                }
                moved.push(at);
            }
            let is_turned = condition.components[1] > 3 && condition.value != 0.0;
            let held = self.changed(number, condition);
            if is_turned || (tool.is_none() && held.is_none()) {
                let told = format!("*BOUNDARY in step {number}: {}", condition.set);
                self.left_out.push((condition.line, told));
            }
            text.push_str(&held.unwrap_or_default());
        }
        moved.sort_unstable();
        moved.dedup();
        for obstacle in moved.iter().filter_map(|at| self.obstacles.get(*at)) {
            let (name, by) = (key(&obstacle.tool.name), obstacle.translation);
            let _infallible = writeln!(text, "obstacle.{name} = {{ translation = {by:?} }}");
        }
        text
    }

    /// New values of a support; nothing where they are zero from the first step on, none where
    /// it does not hold them.
    fn changed(&self, number: usize, condition: &Condition) -> Option<String> {
        let group = self.facets(&condition.set)?;
        let support = self.supports.iter().find(|one| one.group == group)?;
        let values = (1_usize..)
            .zip(AXES)
            .zip(support.values)
            .take(self.dimension());
        let mut changed = Vec::new();
        for ((_, word), value) in values.filter(|((axis, _), _)| is_among(*axis, condition)) {
            let before = value?;
            if number > 1 || (before - condition.value).abs() > 0.0 {
                changed.push(format!("{word} = {:?}", condition.value));
            }
        }
        if changed.is_empty() {
            return Some(String::new());
        }
        let changed = changed.join(", ");
        Some(format!(
            "support.{} = {{ displacement = {{ {changed} }} }}\n",
            key(&group)
        ))
    }
}

/// Whether a condition is on an axis, from 1.
fn is_among(axis: usize, condition: &Condition) -> bool {
    let [first, last] = condition.components;
    (first..=last).contains(&axis)
}

fn law_text(law: &Law) -> String {
    let mut text = format!("model = \"{}\"\n", law.model);
    for (key, numbers) in &law.numbers {
        let is_list = matches!(law.model, "ogden" | "hyperfoam") && *key != "bulk_modulus";
        let _infallible = match numbers.as_slice() {
            [one] if !is_list => writeln!(text, "{key} = {one:?}"),
            many => writeln!(text, "{key} = {many:?}"),
        };
    }
    text
}

/// A TOML string.
fn quoted(text: &str) -> String {
    Value::String(text.to_owned()).to_string()
}

/// A TOML key.
fn key(name: &str) -> String {
    let bare = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_');
    if !name.is_empty() && name.chars().all(bare) {
        name.to_owned()
    } else {
        quoted(name)
    }
}

#[cfg(test)]
mod tests;
