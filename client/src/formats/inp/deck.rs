//! What an Abaqus file holds: nodes, elements, sets and surfaces of one part.
//!
//! A flat file and a file of one part with one instance are the same here: the sets of
//! the assembly are those of its only instance, and reference points of the assembly are
//! left out.

use super::cards::{Cards, Data, Keyword, excerpt, text};
use super::element;
use super::error::{InpError, InpFault};
use super::sets::{Allowance, Run, Sets, Visibility};
use crate::formats::mesh::raw::ElementKind;

/// Keywords that make a mesh instead of holding it.
const MAKERS: [&str; 9] = [
    "ELCOPY",
    "ELGEN",
    "IMPORT",
    "NCOPY",
    "NFILL",
    "NGEN",
    "NMAP",
    "PARAMETER",
    "SYSTEM",
];
/// Keywords that a mesh does not have, and a scene says in its own way.
const OF_THE_SCENE: [&str; 8] = [
    "BOUNDARY",
    "CLOAD",
    "CONTACT PAIR",
    "DLOAD",
    "DSLOAD",
    "EQUATION",
    "MATERIAL",
    "STEP",
];

/// An element of any dimension.
#[derive(Clone, Copy, Debug)]
pub(super) struct Element {
    pub(super) number: u64,
    pub(super) kind: ElementKind,
    /// Where its nodes begin in [`Deck::element_nodes`].
    first: usize,
}

/// Faces of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Face {
    /// `S1` to `S4` of cells.
    Number(usize),
    /// The faces of cells that are on the surface of the body, or elements of the surface.
    Outer,
}

/// One line of a surface.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    /// A set of elements, or one element by its number.
    pub(super) of: Result<usize, u64>,
    pub(super) face: Face,
}

/// A surface made of faces of elements.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    pub(super) name: String,
    pub(super) entries: Vec<Entry>,
}

/// The content of a file.
#[derive(Default)]
pub(super) struct Deck {
    pub(super) nodes: Vec<(u64, [f64; 3])>,
    pub(super) elements: Vec<Element>,
    element_nodes: Vec<u64>,
    pub(super) node_sets: Sets,
    pub(super) element_sets: Sets,
    /// Sets of nodes that hold the nodes of sets of elements.
    pub(super) nodes_of_elements: Vec<(usize, usize)>,
    pub(super) surfaces: Vec<Surface>,
    /// Sets of elements with the name of their material.
    pub(super) sections: Vec<(usize, String)>,
    /// Added to all nodes.
    pub(super) translation: [f64; 3],
    pub(super) warnings: Vec<String>,
}

impl Deck {
    /// Node numbers of an element.
    pub(super) fn nodes_of(&self, element: &Element) -> &[u64] {
        let range = element.first..element.first + element.kind.nodes;
        self.element_nodes.get(range).unwrap_or_default()
    }
}

/// Where a keyword stands.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Scope {
    Model,
    Part(usize),
    Assembly,
}

/// Reads a file into its deck.
struct Reader<'a> {
    cards: Cards<'a>,
    deck: Deck,
    scope: Scope,
    parts: usize,
    /// The scope that has the mesh.
    mesh: Option<Scope>,
    instance: Option<String>,
    allowance: Allowance,
    keywords: usize,
}

/// The deck of a file.
pub(super) fn deck(bytes: &[u8]) -> Result<Deck, InpError> {
    let mut reader = Reader {
        cards: Cards::new(bytes),
        deck: Deck::default(),
        scope: Scope::Model,
        parts: 0,
        mesh: None,
        instance: None,
        allowance: Allowance::new(bytes.len()),
        keywords: 0,
    };
    while let Some(keyword) = reader.cards.keyword() {
        reader.keywords += 1;
        reader.take(&keyword)?;
    }
    match reader.keywords {
        0 => Err(InpError::whole(InpFault::NotInp)),
        _ => Ok(reader.deck),
    }
}

impl Reader<'_> {
    fn take(&mut self, keyword: &Keyword) -> Result<(), InpError> {
        match keyword.name.as_str() {
            "INCLUDE" => return Err(include(keyword)),
            "PART" => {
                self.parts += 1;
                self.scope = Scope::Part(self.parts);
            }
            "ASSEMBLY" => self.scope = Scope::Assembly,
            "INSTANCE" => self.instance(keyword)?,
            "END PART" | "END ASSEMBLY" => self.scope = Scope::Model,
            "END INSTANCE" => self.scope = Scope::Assembly,
            "NODE" if self.is_mesh(keyword)? => self.nodes(keyword)?,
            "ELEMENT" if self.is_mesh(keyword)? => self.elements(keyword)?,
            "NSET" => self.node_set(keyword)?,
            "ELSET" => self.element_set(keyword)?,
            "SURFACE" => self.surface(keyword)?,
            "SOLID SECTION" => self.section(keyword),
            name if MAKERS.contains(&name) => {
                let what = format!("*{name} makes a mesh: write the mesh itself");
                return Err(keyword.error(InpFault::Unsupported(what)));
            }
            name if OF_THE_SCENE.contains(&name) => self.warn_of_scene(),
            _ => {}
        }
        Ok(())
    }

    fn warn_of_scene(&mut self) {
        let warning =
            "materials, supports, loads and steps of the file are not read: the scene says them";
        if self.deck.warnings.iter().all(|known| known != warning) {
            self.deck.warnings.push(warning.to_owned());
        }
    }

    /// Whether nodes or elements belong to the mesh.
    ///
    /// # Errors
    /// For those of a second part.
    fn is_mesh(&mut self, keyword: &Keyword) -> Result<bool, InpError> {
        if keyword.has("INPUT") {
            return Err(include(keyword));
        }
        if self.scope == Scope::Assembly {
            return Ok(false);
        }
        if *self.mesh.get_or_insert(self.scope) != self.scope {
            let what = "several parts with a mesh: write one";
            return Err(keyword.error(InpFault::Unsupported(what.to_owned())));
        }
        Ok(true)
    }

    fn instance(&mut self, keyword: &Keyword) -> Result<(), InpError> {
        let unsupported = |what: &str| InpFault::Unsupported(what.to_owned());
        if self.instance.is_some() || keyword.has("LIBRARY") {
            let what = "several instances, or one of another file: write one mesh";
            return Err(keyword.error(unsupported(what)));
        }
        self.instance = Some(keyword.value("NAME").unwrap_or_default().to_owned());
        if let Some(data) = self.cards.data() {
            for (slot, field) in self.deck.translation.iter_mut().zip(&data.fields) {
                *slot = real(keyword, data.line, field)?;
            }
        }
        if let Some(data) = self.cards.data() {
            let fault = unsupported("a rotated instance: write the mesh where it is");
            return Err(keyword.error_at(data.line, fault));
        }
        // Nodes of the instance itself are those of a part.
        self.parts += 1;
        self.scope = match self.mesh {
            Some(scope @ Scope::Part(_)) => scope,
            _ => Scope::Part(self.parts),
        };
        Ok(())
    }

    fn nodes(&mut self, keyword: &Keyword) -> Result<(), InpError> {
        if keyword
            .value("SYSTEM")
            .is_some_and(|system| !system.eq_ignore_ascii_case("R"))
        {
            let what = "cylindrical or spherical coordinates".to_owned();
            return Err(keyword.error(InpFault::Unsupported(what)));
        }
        let set = keyword.value("NSET").map(str::to_owned);
        let set = set.map(|name| self.deck.node_sets.open(&name, Visibility::Group));
        while let Some(data) = self.cards.data() {
            let mut fields = data.fields.iter();
            let number = fields.next().copied().unwrap_or_default();
            let number = natural(keyword, data.line, number, "a node number")?;
            let mut point = [0.0; 3];
            for (slot, field) in point.iter_mut().zip(fields) {
                *slot = real(keyword, data.line, field)?;
            }
            self.deck.nodes.push((number, point));
            if let Some(set) = set {
                self.deck.node_sets.add(set, Run::one(number));
            }
        }
        Ok(())
    }

    fn elements(&mut self, keyword: &Keyword) -> Result<(), InpError> {
        let name = keyword.required("TYPE")?.to_ascii_uppercase();
        let Some(kind) = element::kind(&name) else {
            return Err(keyword.error(InpFault::UnsupportedElement(name)));
        };
        let set = keyword.value("ELSET").map(str::to_owned);
        let set = set.map(|name| self.deck.element_sets.open(&name, Visibility::Group));
        let count = |numbers: &[u64]| InpFault::NodeCount {
            element: numbers.first().copied().unwrap_or_default(),
            kind: name.clone(),
            expected: kind.nodes,
            found: numbers.len().saturating_sub(1),
        };
        // An element goes on in the next line until it has its nodes.
        let mut numbers = Vec::with_capacity(1 + kind.nodes);
        let mut line = keyword.line;
        while let Some(data) = self.cards.data() {
            line = data.line;
            for field in &data.fields {
                numbers.push(natural(keyword, line, field, "an element or node number")?);
            }
            if numbers.len() > kind.nodes + 1 {
                return Err(keyword.error_at(line, count(&numbers)));
            }
            if let Some((number, nodes)) = numbers
                .split_first()
                .filter(|(_, nodes)| nodes.len() == kind.nodes)
            {
                self.deck.push(*number, kind, nodes);
                if let Some(set) = set {
                    self.deck.element_sets.add(set, Run::one(*number));
                }
                numbers.clear();
            }
        }
        match numbers.is_empty() {
            true => Ok(()),
            false => Err(keyword.error_at(line, count(&numbers))),
        }
    }

    /// Who sees a set; sets of the assembly that are of no instance are of its own points.
    fn visibility(&self, keyword: &Keyword) -> Visibility {
        match keyword.has("INTERNAL") || self.is_of_assembly(keyword) {
            true => Visibility::Internal,
            false => Visibility::Group,
        }
    }

    fn is_of_assembly(&self, keyword: &Keyword) -> bool {
        self.scope == Scope::Assembly && !keyword.has("INSTANCE")
    }

    fn node_set(&mut self, keyword: &Keyword) -> Result<(), InpError> {
        let name = keyword.required("NSET")?;
        let set = self.deck.node_sets.open(name, self.visibility(keyword));
        if self.is_of_assembly(keyword) {
            return Ok(());
        }
        if let Some(elements) = keyword.value("ELSET") {
            let of = self.find(keyword, keyword.line, Sort::Elements, elements)?;
            self.deck.nodes_of_elements.push((set, of));
        }
        self.members(keyword, Sort::Nodes, set)
    }

    fn element_set(&mut self, keyword: &Keyword) -> Result<(), InpError> {
        let name = keyword.required("ELSET")?;
        let set = self.deck.element_sets.open(name, self.visibility(keyword));
        if self.is_of_assembly(keyword) {
            return Ok(());
        }
        self.members(keyword, Sort::Elements, set)
    }

    /// The data lines of a set.
    fn members(&mut self, keyword: &Keyword, sort: Sort, set: usize) -> Result<(), InpError> {
        while let Some(data) = self.cards.data() {
            if keyword.has("GENERATE") {
                let run = run(keyword, &data)?;
                self.sets(sort).add(set, run);
                continue;
            }
            for field in &data.fields {
                let name = self.own(&text(field));
                if let Ok(number) = name.parse() {
                    self.sets(sort).add(set, Run::one(number));
                    continue;
                }
                let other = self.find(keyword, data.line, sort, &name)?;
                let mut allowance = self.allowance;
                let added = self.sets(sort).add_set(set, other, &mut allowance);
                self.allowance = allowance;
                added.map_err(|fault| keyword.error_at(data.line, fault))?;
            }
        }
        Ok(())
    }

    fn sets(&mut self, sort: Sort) -> &mut Sets {
        match sort {
            Sort::Nodes => &mut self.deck.node_sets,
            Sort::Elements => &mut self.deck.element_sets,
        }
    }

    /// A name without the instance that it belongs to.
    fn own(&self, name: &str) -> String {
        let of_instance = self.instance.as_deref().and_then(|instance| {
            let (before, after) = name.split_once('.')?;
            before.eq_ignore_ascii_case(instance).then_some(after)
        });
        of_instance.unwrap_or(name).trim_matches('"').to_owned()
    }

    fn find(
        &mut self,
        keyword: &Keyword,
        line: usize,
        sort: Sort,
        name: &str,
    ) -> Result<usize, InpError> {
        let own = self.own(name);
        let found = self.sets(sort).find(&own);
        found.ok_or_else(|| keyword.error_at(line, InpFault::UnknownSet(name.to_owned())))
    }

    fn surface(&mut self, keyword: &Keyword) -> Result<(), InpError> {
        let name = keyword.required("NAME")?.to_owned();
        let kind = keyword
            .value("TYPE")
            .unwrap_or("ELEMENT")
            .to_ascii_uppercase();
        match kind.as_str() {
            "ELEMENT" if !keyword.has("COMBINE") => self.faces(keyword, name),
            "NODE" => {
                let set = self.deck.node_sets.open(&name, Visibility::Group);
                self.node_surface(keyword, set)
            }
            // Analytic surfaces are obstacles, not parts of the body.
            "SEGMENTS" | "CYLINDER" | "REVOLUTION" => Ok(()),
            _ => {
                let what = format!("surfaces of type {kind}, or combined ones");
                Err(keyword.error(InpFault::Unsupported(what)))
            }
        }
    }

    /// Lines of a node or set and a weight.
    fn node_surface(&mut self, keyword: &Keyword, set: usize) -> Result<(), InpError> {
        while let Some(data) = self.cards.data() {
            let name = self.own(&text(data.fields.first().copied().unwrap_or_default()));
            if let Ok(number) = name.parse() {
                self.deck.node_sets.add(set, Run::one(number));
                continue;
            }
            let other = self.find(keyword, data.line, Sort::Nodes, &name)?;
            let added = self.deck.node_sets.add_set(set, other, &mut self.allowance);
            added.map_err(|fault| keyword.error_at(data.line, fault))?;
        }
        Ok(())
    }

    fn faces(&mut self, keyword: &Keyword, name: String) -> Result<(), InpError> {
        let mut entries = Vec::new();
        while let Some(data) = self.cards.data() {
            let mut fields = data.fields.iter().map(|field| text(field));
            let of = self.own(&fields.next().unwrap_or_default());
            let of = match of.parse() {
                Ok(number) => Err(number),
                Err(_) => Ok(self.find(keyword, data.line, Sort::Elements, &of)?),
            };
            let face = match fields
                .next()
                .unwrap_or_default()
                .to_ascii_uppercase()
                .as_str()
            {
                "" | "SPOS" | "SNEG" => Face::Outer,
                other => Face::Number(face_number(keyword, data.line, other)?),
            };
            entries.push(Entry { of, face });
        }
        self.deck.surfaces.push(Surface { name, entries });
        Ok(())
    }

    fn section(&mut self, keyword: &Keyword) {
        let set = keyword.value("ELSET").map(|name| self.own(name));
        let set = set.and_then(|name| self.deck.element_sets.find(&name));
        if let (Some(set), Some(material)) = (set, keyword.value("MATERIAL")) {
            self.deck.sections.push((set, material.to_owned()));
        }
    }
}

/// What a set is of.
#[derive(Clone, Copy)]
enum Sort {
    Nodes,
    Elements,
}

impl Deck {
    fn push(&mut self, number: u64, kind: ElementKind, nodes: &[u64]) {
        let first = self.element_nodes.len();
        self.element_nodes.extend(nodes);
        self.elements.push(Element {
            number,
            kind,
            first,
        });
    }
}

fn include(keyword: &Keyword) -> InpError {
    let file = keyword.value("INPUT").unwrap_or_default().to_owned();
    keyword.error(InpFault::Include(file))
}

fn unexpected(keyword: &Keyword, line: usize, expected: &'static str, field: &[u8]) -> InpError {
    let found = excerpt(field);
    keyword.error_at(line, InpFault::Unexpected { expected, found })
}

fn natural(
    keyword: &Keyword,
    line: usize,
    field: &[u8],
    expected: &'static str,
) -> Result<u64, InpError> {
    let number = std::str::from_utf8(field)
        .ok()
        .and_then(|field| field.parse().ok());
    number.ok_or_else(|| unexpected(keyword, line, expected, field))
}

/// A number, with the exponents of Fortran too; nothing is zero.
fn real(keyword: &Keyword, line: usize, field: &[u8]) -> Result<f64, InpError> {
    if field.is_empty() {
        return Ok(0.0);
    }
    let wrong = || unexpected(keyword, line, "a coordinate", field);
    let field = std::str::from_utf8(field).map_err(|_| wrong())?;
    let parsed = field
        .parse()
        .or_else(|_| field.replace(['d', 'D'], "e").parse());
    parsed.map_err(|_| wrong())
}

/// First, last and step of a line of `GENERATE`.
fn run(keyword: &Keyword, data: &Data<'_>) -> Result<Run, InpError> {
    let number = |at: usize| {
        let field = data.fields.get(at).copied().unwrap_or_default();
        natural(keyword, data.line, field, "a number of the set")
    };
    let (first, last) = (number(0)?, number(1)?);
    let step = match data.fields.len() {
        0..=2 => 1,
        _ => number(2)?.max(1),
    };
    Ok(Run { first, last, step })
}

fn face_number(keyword: &Keyword, line: usize, name: &str) -> Result<usize, InpError> {
    let number = name
        .strip_prefix('S')
        .and_then(|number| number.parse().ok());
    number.ok_or_else(|| unexpected(keyword, line, "a face (S1 to S4)", name.as_bytes()))
}
