//! Reads the keywords of an Abaqus file into its deck.
//!
//! What stands in a part or an instance goes into a deck of its own, which an instance puts into
//! the deck of the file ([`super::assembly`]). A file of parts without instances has one of each.
//! Sets of the assembly hold what they name of its instances; its own nodes, reference points, are
//! left out.

use std::collections::HashMap;

use super::assembly::Instance;
use super::cards::{Cards, Keyword};
use super::deck::Deck;
use super::element;
use super::error::{InpError, InpFault};
use super::fields::{include, natural, placement, points, real};
use super::frame::{Coordinates, Frame};
use super::include::file_of;
use super::keywords::{CONSTRAINTS, MAKERS, OF_THE_FILE, OF_THE_SCENE, TIES, constraint, no_cells};
use super::sets::{Allowance, Run, Sets, Visibility};

/// A part or an instance that is being read.
struct Open {
    name: String,
    deck: Deck,
    /// Where an instance is; none of a part.
    frame: Option<Frame>,
}

/// Reads a file into its deck.
pub(super) struct Reader<'a> {
    pub(super) cards: Cards<'a>,
    /// Of the whole file.
    main: Deck,
    open: Option<Open>,
    parts: Vec<(String, Deck)>,
    /// Instances by their names in capitals.
    pub(super) instances: HashMap<String, Instance>,
    is_in_assembly: bool,
    /// Of `*SYSTEM`.
    system: Option<Frame>,
    /// What copies of parts may take.
    copies: Allowance,
    pub(super) allowance: Allowance,
    /// Whether files that keywords name are in the bytes.
    includes: Includes,
}

/// Whether files that keywords name stand in the bytes already.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Includes {
    Expanded,
    Refused,
}

/// The deck of a file.
pub(super) fn deck(bytes: &[u8], includes: Includes) -> Result<Deck, InpError> {
    let mut reader = Reader {
        cards: Cards::new(bytes),
        main: Deck::default(),
        open: None,
        parts: Vec::new(),
        instances: HashMap::new(),
        is_in_assembly: false,
        system: None,
        copies: Allowance::new(4 * bytes.len()),
        allowance: Allowance::new(bytes.len()),
        includes,
    };
    let mut last = None;
    while let Some(keyword) = reader.cards.keyword() {
        reader.take(&keyword)?;
        last = Some(keyword);
    }
    let last = last.ok_or_else(|| InpError::whole(InpFault::NotInp))?;
    reader.close(&last)?;
    reader.finish(&last)
}

impl Reader<'_> {
    fn take(&mut self, keyword: &Keyword) -> Result<(), InpError> {
        if self.includes == Includes::Refused && file_of(keyword).is_some() {
            return Err(include(keyword));
        }
        match keyword.name.as_str() {
            "INCLUDE" => drop(keyword.required("INPUT")?),
            "PART" => self.part(keyword)?,
            "ASSEMBLY" => {
                self.close(keyword)?;
                self.is_in_assembly = true;
            }
            "INSTANCE" => self.instance(keyword)?,
            "END PART" | "END INSTANCE" => self.close(keyword)?,
            "END ASSEMBLY" => {
                self.close(keyword)?;
                self.is_in_assembly = false;
            }
            "SYSTEM" => self.system(keyword)?,
            "NODE" if !self.is_of_assembly(keyword) => self.nodes(keyword)?,
            "ELEMENT" if !self.is_of_assembly(keyword) => self.elements(keyword)?,
            "NSET" => self.node_set(keyword)?,
            "ELSET" => self.element_set(keyword)?,
            "SURFACE" => self.surface(keyword)?,
            "SOLID SECTION" => self.section(keyword),
            "TIE" => self.warn(TIES.to_owned()),
            name if MAKERS.contains(&name) => {
                let what = format!("*{name} makes a mesh: write the mesh itself");
                return Err(keyword.error(InpFault::Unsupported(what)));
            }
            name if CONSTRAINTS.contains(&name) => self.warn(constraint(name)),
            name if OF_THE_SCENE.contains(&name) => self.warn(OF_THE_FILE.to_owned()),
            _ => {}
        }
        Ok(())
    }

    fn warn(&mut self, warning: String) {
        if !self.main.warnings.contains(&warning) {
            self.main.warnings.push(warning);
        }
    }

    /// The deck that keywords add to: that of the part or instance, else that of the file.
    pub(super) fn deck(&mut self) -> &mut Deck {
        self.open
            .as_mut()
            .map_or(&mut self.main, |open| &mut open.deck)
    }

    fn part(&mut self, keyword: &Keyword) -> Result<(), InpError> {
        self.close(keyword)?;
        self.system = None;
        self.open = Some(Open {
            name: keyword.value("NAME").unwrap_or_default().to_owned(),
            deck: Deck::default(),
            frame: None,
        });
        Ok(())
    }

    fn instance(&mut self, keyword: &Keyword) -> Result<(), InpError> {
        self.close(keyword)?;
        if keyword.has("LIBRARY") {
            let what = "an instance of another file: write one mesh".to_owned();
            return Err(keyword.error(InpFault::Unsupported(what)));
        }
        let name = keyword.value("NAME").unwrap_or_default().to_owned();
        if self.instances.contains_key(&name.to_ascii_uppercase()) {
            return Err(keyword.error(InpFault::DuplicateInstance(name)));
        }
        let frame = Some(placement(&mut self.cards, keyword)?);
        let deck = match keyword.value("PART") {
            Some(part) => self.copy(keyword, part)?,
            None => Deck::default(),
        };
        self.system = None;
        self.open = Some(Open { name, deck, frame });
        Ok(())
    }

    /// A copy of a part.
    fn copy(&mut self, keyword: &Keyword, part: &str) -> Result<Deck, InpError> {
        let mut parts = self.parts.iter();
        let found = parts.find(|(name, _)| name.eq_ignore_ascii_case(part));
        let (_, deck) =
            found.ok_or_else(|| keyword.error(InpFault::UnknownPart(part.to_owned())))?;
        let taken = self.copies.take(deck.size());
        taken.map_err(|fault| keyword.error(fault.copies()))?;
        Ok(deck.clone())
    }

    /// Ends the part or instance that is being read.
    fn close(&mut self, keyword: &Keyword) -> Result<(), InpError> {
        let Some(open) = self.open.take() else {
            return Ok(());
        };
        self.system = None;
        match open.frame {
            Some(frame) => self.place(keyword, &open.deck, &open.name, &frame),
            None => {
                self.parts.push((open.name, open.deck));
                Ok(())
            }
        }
    }

    fn place(
        &mut self,
        keyword: &Keyword,
        part: &Deck,
        name: &str,
        frame: &Frame,
    ) -> Result<(), InpError> {
        let placed = self.main.place(part, name, frame, &mut self.copies);
        let instance = placed.map_err(|fault| keyword.error(fault))?;
        self.instances.insert(name.to_ascii_uppercase(), instance);
        Ok(())
    }

    fn finish(mut self, keyword: &Keyword) -> Result<Deck, InpError> {
        if self.instances.is_empty() {
            for (name, part) in std::mem::take(&mut self.parts) {
                self.place(keyword, &part, &name, &Frame::default())?;
            }
        }
        self.main.qualify();
        Ok(self.main)
    }

    /// A system of coordinates of the nodes that follow.
    fn system(&mut self, keyword: &Keyword) -> Result<(), InpError> {
        self.system = None;
        let Some(data) = self.cards.data() else {
            return Ok(());
        };
        let [origin, first] = points(keyword, &data)?;
        let moved = data.fields.len() <= 3;
        let plane = match self.cards.data() {
            Some(data) => points(keyword, &data)?[0],
            None => [origin[0], origin[1] + 1.0, origin[2]],
        };
        let frame = if moved {
            Some(Frame::at(origin))
        } else {
            Frame::through(origin, first, plane)
        };
        self.system = Some(frame.ok_or_else(|| {
            let what = "a system of coordinates whose three points lie on a line".to_owned();
            keyword.error_at(data.line, InpFault::Unsupported(what))
        })?);
        Ok(())
    }

    fn nodes(&mut self, keyword: &Keyword) -> Result<(), InpError> {
        let system = keyword.value("SYSTEM").unwrap_or("R").to_ascii_uppercase();
        let coordinates = match system.as_str() {
            "R" => Coordinates::Cartesian,
            "C" => Coordinates::Cylindrical,
            _ => {
                let what = "spherical coordinates of nodes".to_owned();
                return Err(keyword.error(InpFault::Unsupported(what)));
            }
        };
        let frame = self.system;
        let set = keyword.value("NSET").map(str::to_owned);
        let set = set.map(|name| self.deck().node_sets.open(&name, Visibility::Group));
        while let Some(data) = self.cards.data() {
            let mut fields = data.fields.iter();
            let number = fields.next().copied().unwrap_or_default();
            let number = natural(keyword, data.line, number, "a node number")?;
            let mut point = [0.0; 3];
            for (slot, field) in point.iter_mut().zip(fields) {
                *slot = real(keyword, data.line, field)?;
            }
            let point = coordinates.cartesian(point);
            let point = frame.map_or(point, |frame| frame.place(point));
            self.deck().push_node(number, point);
            if let Some(set) = set {
                self.deck().node_sets.add(set, Run::one(number));
            }
        }
        Ok(())
    }

    fn elements(&mut self, keyword: &Keyword) -> Result<(), InpError> {
        let name = keyword.required("TYPE")?.to_ascii_uppercase();
        let Some(kind) = element::kind(&name) else {
            if !element::is_no_cell(&name) {
                return Err(keyword.error(InpFault::UnsupportedElement(name)));
            }
            self.warn(no_cells(&name));
            return Ok(());
        };
        if self.main.types.iter().all(|(known, _)| *known != name) {
            self.main.types.push((name.clone(), kind.dimension));
        }
        let set = keyword.value("ELSET").map(str::to_owned);
        let set = set.map(|name| self.deck().element_sets.open(&name, Visibility::Group));
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
                self.deck().push(*number, kind, nodes);
                if let Some(set) = set {
                    self.deck().element_sets.add(set, Run::one(*number));
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

    /// Whether a keyword is of the assembly itself, not of an instance of it.
    pub(super) fn is_of_assembly(&self, keyword: &Keyword) -> bool {
        self.is_in_assembly && self.open.is_none() && !keyword.has("INSTANCE")
    }

    pub(super) fn sets(&mut self, sort: Sort) -> &mut Sets {
        let deck = self.deck();
        match sort {
            Sort::Nodes => &mut deck.node_sets,
            Sort::Elements => &mut deck.element_sets,
        }
    }

    fn section(&mut self, keyword: &Keyword) {
        let set = keyword.value("ELSET").map(|name| name.replace('"', ""));
        let set = set.and_then(|name| self.deck().element_sets.find(&name));
        if let (Some(set), Some(material)) = (set, keyword.value("MATERIAL")) {
            self.deck().sections.push((set, material.to_owned()));
        }
    }
}

/// What a set is of.
#[derive(Clone, Copy)]
pub(super) enum Sort {
    Nodes,
    Elements,
}
