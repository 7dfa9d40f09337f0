//! What a deck says beside its mesh and a scene says in the same way: laws, held and moved sets,
//! rigid tools with analytical surfaces, friction, steps. Everything else is listed with its line.
//!
//! | in the deck | here |
//! |---|---|
//! | `*HYPERELASTIC`, `*HYPERFOAM`, `*ELASTIC` | [`Law`] |
//! | `*ELEMENT, TYPE=CPE.. / CPS.. / CAX..` | [`DeckScene::kind`] |
//! | `*BOUNDARY` before and within steps | [`Condition`] |
//! | `*SURFACE, TYPE=SEGMENTS / CYLINDER / REVOLUTION`, `*RIGID BODY` | [`Tool`] |
//! | `*CONTACT PAIR`, `*SURFACE INTERACTION`, `*FRICTION` | [`Contact`] |
//! | `*STEP`, `*STATIC` | [`Step`] |
//!
//! Whether names are groups of the mesh is for the caller to say. Cost: one pass.

mod law;
mod tool;

use std::collections::HashMap;

use super::cards::{Cards, Data, Keyword, text};
use super::error::InpError;
use super::fields::{finite, placement};
use super::frame::Frame;

pub use tool::{Profile, Tool};

/// Increments of a step, at most, where the file asks for more.
const MOST_INCREMENTS: f64 = 1000.0;
/// Increments of a step that does not say how many.
const INCREMENTS: usize = 10;

/// Beginnings of the names of elements of sections, and their `kind`.
const KINDS: [(&str, &str); 3] = [
    ("CPE", "plane-strain"),
    ("CPS", "plane-stress"),
    ("CAX", "axisymmetric"),
];

/// Keywords of the mesh, or that hold others.
const SILENT: [&str; 15] = [
    "ASSEMBLY",
    "ELSET",
    "END ASSEMBLY",
    "END PART",
    "END STEP",
    "HEADING",
    "INCLUDE",
    "MATERIAL",
    "PART",
    "PREPRINT",
    "SOLID SECTION",
    "STATIC",
    "STEP",
    "SURFACE INTERACTION",
    "SYSTEM",
];

/// A law of a material: the word of the scene and its keys.
#[derive(Clone, Debug, PartialEq)]
pub struct Law {
    /// Value of `model`.
    pub model: &'static str,
    /// Keys with their numbers; more than one is a list.
    pub numbers: Vec<(&'static str, Vec<f64>)>,
}

/// Components of a set of nodes that have a value.
#[derive(Clone, Debug, PartialEq)]
pub struct Condition {
    /// As the deck writes it.
    pub line: usize,
    /// The set, or a node by its number.
    pub set: String,
    /// First and last component, from 1; 4 to 6 are rotations.
    pub components: [usize; 2],
    /// Displacement, or angle in radians.
    pub value: f64,
}

/// A pair of surfaces that meet.
#[derive(Clone, Debug, PartialEq)]
pub struct Contact {
    /// Where it stands.
    pub line: usize,
    /// The surface of the body.
    pub slave: String,
    /// The surface that it meets.
    pub master: String,
    /// Coefficient of friction.
    pub friction: f64,
}

/// A step of a deck.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Equal parts of it.
    pub increments: usize,
    /// Values at its end.
    pub conditions: Vec<Condition>,
}

/// What a deck says beside its mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DeckScene {
    /// Value of `kind` of a section, by its first elements; none of a solid.
    pub kind: Option<&'static str>,
    /// Names of all materials, those whose law is left out too.
    pub materials: Vec<String>,
    /// Laws by the names of their materials.
    pub laws: Vec<(String, Law)>,
    /// What holds before the first step.
    pub conditions: Vec<Condition>,
    /// Rigid surfaces.
    pub tools: Vec<Tool>,
    /// Pairs.
    pub contacts: Vec<Contact>,
    /// In their order.
    pub steps: Vec<Step>,
    /// Lines and keywords that are not taken over, with the reason where there is one.
    pub left_out: Vec<(usize, String)>,
}

/// Reads on beside the mesh.
struct Reader<'a> {
    cards: Cards<'a>,
    scene: DeckScene,
    /// The instance that is being read, and where it is.
    instance: Option<(String, Frame)>,
    interaction: String,
    /// Coefficients by the names of interactions in capitals.
    frictions: HashMap<String, f64>,
    /// Interactions of the contacts, in capitals.
    of_contacts: Vec<String>,
    /// Tools' reference nodes by the names of their surfaces in capitals.
    references: HashMap<String, String>,
    /// Sets of one node.
    single: HashMap<String, Option<String>>,
}

/// What a deck says beside its mesh.
pub(super) fn scene(bytes: &[u8]) -> Result<DeckScene, InpError> {
    let mut reader = Reader {
        cards: Cards::new(bytes),
        scene: DeckScene::default(),
        instance: None,
        interaction: String::new(),
        frictions: HashMap::new(),
        of_contacts: Vec::new(),
        references: HashMap::new(),
        single: HashMap::new(),
    };
    while let Some(keyword) = reader.cards.keyword() {
        reader.take(&keyword)?;
    }
    Ok(reader.finish())
}

impl Reader<'_> {
    fn take(&mut self, keyword: &Keyword) -> Result<(), InpError> {
        let name = || keyword.value("NAME").unwrap_or_default().to_owned();
        match keyword.name.as_str() {
            "ELEMENT" => self.kind(keyword),
            "INSTANCE" => {
                let frame = placement(&mut self.cards, keyword)?;
                self.instance = Some((name(), frame));
            }
            "END INSTANCE" => self.instance = None,
            "MATERIAL" => self.scene.materials.push(name()),
            "HYPERELASTIC" | "HYPERFOAM" | "ELASTIC" => self.law(keyword)?,
            "BOUNDARY" => self.boundary(keyword)?,
            "NODE" | "NSET" => self.node_set(keyword),
            "SURFACE" => self.surface(keyword)?,
            "RIGID BODY" => self.rigid_body(keyword),
            "SURFACE INTERACTION" => self.interaction = name(),
            "FRICTION" => self.friction(keyword)?,
            "CONTACT PAIR" => self.contact_pair(keyword),
            "STEP" => self.scene.steps.push(Step {
                increments: INCREMENTS,
                conditions: Vec::new(),
            }),
            "STATIC" => self.increments(keyword)?,
            silent if SILENT.contains(&silent) => {}
            _ => self.leave_out(keyword, ""),
        }
        Ok(())
    }

    /// What the elements of a section stand for.
    fn kind(&mut self, keyword: &Keyword) {
        let element = keyword.value("TYPE").unwrap_or_default().to_uppercase();
        let kinds = KINDS.iter().find(|(start, _)| element.starts_with(start));
        let found = kinds.map(|&(_, kind)| kind);
        self.scene.kind = self.scene.kind.or(found);
    }

    fn leave_out(&mut self, keyword: &Keyword, why: &str) {
        let told = match why {
            "" => format!("*{}", keyword.name),
            why => format!("*{}: {why}", keyword.name),
        };
        self.scene.left_out.push((keyword.line, told));
    }

    /// All numbers of the data lines.
    fn numbers(&mut self, keyword: &Keyword) -> Result<Vec<f64>, InpError> {
        let mut numbers = Vec::new();
        while let Some(data) = self.cards.data() {
            for field in &data.fields {
                numbers.push(finite(keyword, data.line, field)?);
            }
        }
        Ok(numbers)
    }

    fn law(&mut self, keyword: &Keyword) -> Result<(), InpError> {
        let numbers = self.numbers(keyword)?;
        match law::law(keyword, &numbers) {
            Ok(law) => {
                let material = self.scene.materials.last().cloned().unwrap_or_default();
                self.scene.laws.push((material, law));
            }
            Err(why) => self.leave_out(keyword, &why),
        }
        Ok(())
    }

    fn boundary(&mut self, keyword: &Keyword) -> Result<(), InpError> {
        let foreign = ["AMPLITUDE", "USER", "SUBMODEL", "FIXED"];
        let kind = keyword.value("TYPE").unwrap_or("DISPLACEMENT");
        let is_plain = kind.eq_ignore_ascii_case("DISPLACEMENT")
            && foreign.iter().all(|name| !keyword.has(name));
        let is_new = keyword
            .value("OP")
            .is_some_and(|op| op.eq_ignore_ascii_case("NEW"));
        if !is_plain || is_new {
            let why = "amplitudes, types and OP=NEW are not taken over";
            self.leave_out(keyword, why);
            return Ok(());
        }
        while let Some(data) = self.cards.data() {
            match condition(keyword, &data)? {
                Some(conditions) => match self.scene.steps.last_mut() {
                    Some(step) => step.conditions.extend(conditions),
                    None => self.scene.conditions.extend(conditions),
                },
                None => self
                    .scene
                    .left_out
                    .push((data.line, "*BOUNDARY: a kind of condition".to_owned())),
            }
        }
        Ok(())
    }

    fn friction(&mut self, keyword: &Keyword) -> Result<(), InpError> {
        let numbers = self.numbers(keyword)?;
        match numbers.first() {
            Some(coefficient) if numbers.len() == 1 => {
                let interaction = self.interaction.to_ascii_uppercase();
                self.frictions.insert(interaction, *coefficient);
            }
            _ => self.leave_out(keyword, "more than one coefficient"),
        }
        Ok(())
    }

    fn contact_pair(&mut self, keyword: &Keyword) {
        let interaction = keyword.value("INTERACTION").unwrap_or_default();
        let interaction = interaction.to_ascii_uppercase();
        while let Some(data) = self.cards.data() {
            let field = |at: usize| {
                data.fields
                    .get(at)
                    .map(|field| text(field))
                    .unwrap_or_default()
            };
            self.of_contacts.push(interaction.clone());
            self.scene.contacts.push(Contact {
                line: data.line,
                slave: field(0),
                master: field(1),
                friction: 0.0,
            });
        }
    }

    /// Equal parts, from the first one and the whole time.
    fn increments(&mut self, keyword: &Keyword) -> Result<(), InpError> {
        let numbers = self.numbers(keyword)?;
        if let (Some(step), [first, whole, ..]) = (self.scene.steps.last_mut(), numbers.as_slice())
        {
            let parts = (whole / first).round();
            if parts.is_finite() && parts >= 1.0 {
                step.increments = parts.min(MOST_INCREMENTS) as usize;
            }
        }
        Ok(())
    }

    fn finish(mut self) -> DeckScene {
        for (contact, interaction) in self.scene.contacts.iter_mut().zip(&self.of_contacts) {
            contact.friction = self.frictions.get(interaction).copied().unwrap_or(0.0);
        }
        let single = std::mem::take(&mut self.single);
        let node = |name: &str| {
            let key = name.to_ascii_uppercase();
            single.get(&key).cloned().flatten().unwrap_or(key)
        };
        let references = &self.references;
        for tool in &mut self.scene.tools {
            let reference = references.get(&tool.name.to_ascii_uppercase());
            tool.reference = reference.map(|name| node(name));
        }
        let points: Vec<String> = self
            .scene
            .tools
            .iter()
            .filter_map(|tool| tool.reference.clone())
            .collect();
        let steps = self
            .scene
            .steps
            .iter_mut()
            .flat_map(|step| &mut step.conditions);
        for condition in self.scene.conditions.iter_mut().chain(steps) {
            let of = node(&condition.set);
            if points.contains(&of) {
                condition.set = of;
            }
        }
        self.scene
    }
}

/// The conditions of a data line; none of a kind that is not known.
fn condition(keyword: &Keyword, data: &Data<'_>) -> Result<Option<Vec<Condition>>, InpError> {
    let set = text(data.fields.first().copied().unwrap_or_default());
    let field = |at: usize| data.fields.get(at).copied().unwrap_or_default();
    let of = |components: [usize; 2], value: f64| Condition {
        line: data.line,
        set: set.clone(),
        components,
        value,
    };
    let word = text(field(1)).to_ascii_uppercase();
    let held: &[[usize; 2]] = match word.as_str() {
        "ENCASTRE" => &[[1, 6]],
        "PINNED" => &[[1, 3]],
        "XSYMM" => &[[1, 1], [5, 6]],
        "YSYMM" => &[[2, 2], [4, 4], [6, 6]],
        "ZSYMM" => &[[3, 3], [4, 5]],
        _ => &[],
    };
    if !held.is_empty() {
        return Ok(Some(held.iter().map(|range| of(*range, 0.0)).collect()));
    }
    let Ok(first) = word.parse() else {
        return Ok(None);
    };
    let last = text(field(2)).parse().unwrap_or(first);
    if !(1..=6).contains(&first) || !(first..=6).contains(&last) {
        return Ok(None);
    }
    let value = finite(keyword, data.line, field(3))?;
    Ok(Some(vec![of([first, last], value)]))
}

#[cfg(test)]
mod tests;
