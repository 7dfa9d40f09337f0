//! Reads the keywords of an Abaqus file into its deck.
//!
//! A flat file and a file of one part with one instance are the same here: the sets of
//! the assembly are those of its only instance, and reference points of the assembly are
//! left out.

use super::cards::{Cards, Keyword, text};
use super::deck::{Deck, Entry, Face, Surface};
use super::element;
use super::error::{InpError, InpFault};
use super::fields::{face_number, include, natural, real, run};
use super::sets::{Allowance, Run, Sets, Visibility};

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
        if numbers.is_empty() {
            Ok(())
        } else {
            Err(keyword.error_at(line, count(&numbers)))
        }
    }

    /// Who sees a set; sets of the assembly that are of no instance are of its own points.
    fn visibility(&self, keyword: &Keyword) -> Visibility {
        if keyword.has("INTERNAL") || self.is_of_assembly(keyword) {
            Visibility::Internal
        } else {
            Visibility::Group
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
