//! Reads sets and surfaces: what their lines name, in a part or of the instances of an assembly.

use super::cards::{Keyword, text};
use super::deck::{Entry, Face, Surface};
use super::error::{InpError, InpFault};
use super::fields::{face_number, run};
use super::reader::{Reader, Sort};
use super::sets::{Numbers, Run, Visibility};

/// What a field of a set or a surface names.
enum Member {
    Number(u64),
    Set(usize),
    /// A node or element of the assembly itself, which the mesh does not have.
    OfAssembly,
}

impl Reader<'_> {
    fn visibility(keyword: &Keyword) -> Visibility {
        if keyword.has("INTERNAL") {
            Visibility::Internal
        } else {
            Visibility::Group
        }
    }

    /// The numbers of the instance that a keyword is of.
    fn numbers(&self, keyword: &Keyword, sort: Sort) -> Option<Numbers> {
        self.numbers_of(keyword.value("INSTANCE")?, sort)
    }

    /// Whether numbers are those of reference points of the assembly.
    fn is_of_points(&self, keyword: &Keyword) -> bool {
        self.is_of_assembly(keyword) && !self.instances.is_empty()
    }

    /// Makes sure that the instance that a keyword is of is there.
    fn check_instance(&self, keyword: &Keyword) -> Result<(), InpError> {
        match keyword.value("INSTANCE") {
            Some(name)
                if !self.instances.is_empty() && self.numbers_of(name, Sort::Nodes).is_none() =>
            {
                Err(keyword.error(InpFault::UnknownInstance(name.to_owned())))
            }
            _ => Ok(()),
        }
    }

    fn numbers_of(&self, instance: &str, sort: Sort) -> Option<Numbers> {
        let instance = self.instances.get(&instance.to_ascii_uppercase())?;
        Some(match sort {
            Sort::Nodes => instance.nodes,
            Sort::Elements => instance.elements,
        })
    }

    /// What a field names: a number or a set, those of an instance as `INSTANCE.NAME`.
    fn member(
        &mut self,
        keyword: &Keyword,
        line: usize,
        sort: Sort,
        field: &[u8],
    ) -> Result<Member, InpError> {
        let name = text(field).replace('"', "");
        if let Ok(number) = name.parse() {
            let numbers = self.numbers(keyword, sort);
            let is_own = self.is_of_points(keyword);
            return Ok(match numbers {
                _ if is_own => Member::OfAssembly,
                Some(numbers) => Member::Number(numbers.of(number)),
                None => Member::Number(number),
            });
        }
        if let Some((instance, number)) = name.split_once('.')
            && let Some(numbers) = self.numbers_of(instance, sort)
            && let Ok(number) = number.parse()
        {
            return Ok(Member::Number(numbers.of(number)));
        }
        // A set of the assembly that is of an instance may be named as if it were of its part.
        let own = name
            .split_once('.')
            .filter(|(of, _)| self.numbers_of(of, sort).is_some());
        let own = own.map(|(_, own)| own.to_owned());
        let instance = keyword.value("INSTANCE").map(|of| format!("{of}.{name}"));
        let sets = self.sets(sort);
        let found = instance.and_then(|name| sets.find(&name));
        let found = found.or_else(|| sets.find(&name));
        let found = found.or_else(|| sets.find(&own?));
        let unknown = || keyword.error_at(line, InpFault::UnknownSet(name.clone()));
        found.map(Member::Set).ok_or_else(unknown)
    }

    pub(super) fn node_set(&mut self, keyword: &Keyword) -> Result<(), InpError> {
        let name = keyword.required("NSET")?;
        self.check_instance(keyword)?;
        let visibility = Self::visibility(keyword);
        let set = self.deck().node_sets.open(name, visibility);
        if let Some(elements) = keyword.value("ELSET") {
            let of = elements.as_bytes();
            if let Member::Set(of) = self.member(keyword, keyword.line, Sort::Elements, of)? {
                self.deck().nodes_of_elements.push((set, of));
            }
        }
        self.members(keyword, Sort::Nodes, set)
    }

    pub(super) fn element_set(&mut self, keyword: &Keyword) -> Result<(), InpError> {
        let name = keyword.required("ELSET")?;
        self.check_instance(keyword)?;
        let visibility = Self::visibility(keyword);
        let set = self.deck().element_sets.open(name, visibility);
        self.members(keyword, Sort::Elements, set)
    }

    /// The data lines of a set.
    fn members(&mut self, keyword: &Keyword, sort: Sort, set: usize) -> Result<(), InpError> {
        let numbers = self.numbers(keyword, sort);
        let is_own = self.is_of_points(keyword);
        while let Some(data) = self.cards.data() {
            if keyword.has("GENERATE") {
                let run = run(keyword, &data)?;
                let run = match numbers {
                    Some(numbers) => numbers.run(run),
                    None => Some(run).filter(|_| !is_own),
                };
                if let Some(run) = run {
                    self.sets(sort).add(set, run);
                }
                continue;
            }
            for field in &data.fields {
                self.add_member(keyword, data.line, (sort, set), field)?;
            }
        }
        Ok(())
    }

    fn add_member(
        &mut self,
        keyword: &Keyword,
        line: usize,
        (sort, set): (Sort, usize),
        field: &[u8],
    ) -> Result<(), InpError> {
        match self.member(keyword, line, sort, field)? {
            Member::Number(number) => self.sets(sort).add(set, Run::one(number)),
            Member::Set(other) => {
                let mut allowance = self.allowance;
                let added = self.sets(sort).add_set(set, other, &mut allowance);
                self.allowance = allowance;
                added.map_err(|fault| keyword.error_at(line, fault))?;
            }
            Member::OfAssembly => {}
        }
        Ok(())
    }

    pub(super) fn surface(&mut self, keyword: &Keyword) -> Result<(), InpError> {
        let name = keyword.required("NAME")?.to_owned();
        let kind = keyword
            .value("TYPE")
            .unwrap_or("ELEMENT")
            .to_ascii_uppercase();
        match kind.as_str() {
            "ELEMENT" if !keyword.has("COMBINE") => self.faces(keyword, name),
            "NODE" => {
                let set = self.deck().node_sets.open(&name, Visibility::Group);
                // A node or set, and a weight.
                while let Some(data) = self.cards.data() {
                    let field = data.fields.first().copied().unwrap_or_default();
                    self.add_member(keyword, data.line, (Sort::Nodes, set), field)?;
                }
                Ok(())
            }
            // Analytic surfaces are obstacles, not parts of the body.
            "SEGMENTS" | "CYLINDER" | "REVOLUTION" => Ok(()),
            "ELEMENT" => {
                let what = "combined surfaces: list the faces of all in one *SURFACE".to_owned();
                Err(keyword.error(InpFault::Unsupported(what)))
            }
            _ => {
                let what = format!("surfaces of type {kind}: use TYPE=ELEMENT or NODE");
                Err(keyword.error(InpFault::Unsupported(what)))
            }
        }
    }

    fn faces(&mut self, keyword: &Keyword, name: String) -> Result<(), InpError> {
        let mut entries = Vec::new();
        while let Some(data) = self.cards.data() {
            let mut fields = data.fields.iter().copied();
            let of = fields.next().unwrap_or_default();
            let of = match self.member(keyword, data.line, Sort::Elements, of)? {
                Member::Number(number) => Err(number),
                Member::Set(set) => Ok(set),
                Member::OfAssembly => continue,
            };
            let face = text(fields.next().unwrap_or_default()).to_ascii_uppercase();
            let face = match face.as_str() {
                "" | "SPOS" | "SNEG" => Face::Outer,
                other => Face::Number(face_number(keyword, data.line, other)?),
            };
            entries.push(Entry { of, face });
        }
        let owner = String::new();
        self.deck().surfaces.push(Surface {
            name,
            owner,
            entries,
        });
        Ok(())
    }
}
