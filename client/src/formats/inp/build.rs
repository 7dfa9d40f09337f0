//! Makes a mesh of a deck: sets and surfaces become groups.

use std::collections::{HashMap, HashSet};

use super::deck::{Deck, Element, Entry, Face};
use super::element::face;
use super::error::{InpError, InpFault};
use super::gather::{Facets, Lists, OfCells, sorted};
use super::keywords::no_cells;
use super::sets::{Allowance, Order, Visibility};
use crate::formats::mesh::raw::{ElementKind, Owner, RawMesh};
use crate::formats::mesh::split::{picked, triangles};
use crate::formats::mesh::{self, BODY, BOUNDARY, MeshFault, MeshFile, outer_facets};

/// The mesh of a deck whose sets may have `members` members in all.
pub(super) fn mesh(deck: Deck, members: usize) -> Result<MeshFile, InpError> {
    let mut builder = Builder::new(deck, members).map_err(InpError::whole)?;
    let raw = builder.raw().map_err(InpError::whole)?;
    let built = mesh::build(&raw).map_err(|fault| InpError::whole(builder.explained(fault)));
    let mut mesh = built?;
    let left_out = builder.left_out();
    mesh.warnings.extend(builder.deck.warnings);
    mesh.warnings.extend(left_out);
    Ok(mesh)
}

/// A deck on its way to a mesh.
pub(super) struct Builder {
    pub(super) deck: Deck,
    /// Of the cells.
    pub(super) dimension: usize,
    /// Positions of the elements by number.
    order: Order,
    pub(super) allowance: Allowance,
    pub(super) lists: Lists,
    /// The list of groups of each element.
    of_elements: Vec<u32>,
    pub(super) facets: Facets,
    /// Faces of cells; empty where no element of the surface asks for them.
    of_cells: OfCells,
    /// Dimension and name of each group; its number is its position and one.
    groups: Vec<(usize, String)>,
    /// The same, to look them up.
    known: HashSet<(usize, String)>,
    /// Where nodes are, if lines of three nodes ask for it.
    places: HashMap<u64, [f64; 3]>,
    raw: RawMesh,
}

impl Builder {
    fn new(deck: Deck, members: usize) -> Result<Self, InpFault> {
        let dimensions = deck.elements.iter().map(|element| element.kind.dimension);
        let dimension = dimensions.max().filter(|dimension| *dimension >= 2);
        let order = Order::new(deck.elements.iter().map(|element| element.number));
        if let Some(number) = order.repeated() {
            return Err(InpFault::DuplicateElement(number));
        }
        let dimension = dimension.ok_or(InpFault::Mesh(MeshFault::NoCells))?;
        Ok(Self {
            dimension,
            of_cells: faces_of_cells(&deck, dimension),
            order,
            allowance: Allowance::new(members),
            lists: Lists::default(),
            of_elements: vec![0; deck.elements.len()],
            facets: Facets::default(),
            groups: Vec::new(),
            known: HashSet::new(),
            places: places(&deck),
            raw: RawMesh::default(),
            deck,
        })
    }

    fn raw(&mut self) -> Result<RawMesh, InpFault> {
        self.surfaces()?;
        self.element_sets()?;
        self.materials()?;
        self.node_sets()?;
        self.name_the_rest();
        self.emit();
        Ok(std::mem::take(&mut self.raw))
    }

    pub(super) fn has_group(&self, dimension: usize, name: &str) -> bool {
        self.known.contains(&(dimension, name.to_owned()))
    }

    /// The number of a new group.
    pub(super) fn group(&mut self, dimension: usize, name: &str) -> i64 {
        self.groups.push((dimension, name.to_owned()));
        self.known.insert((dimension, name.to_owned()));
        self.groups.len() as i64
    }

    fn surfaces(&mut self) -> Result<(), InpFault> {
        let surfaces = std::mem::take(&mut self.deck.surfaces);
        let outer = self.outer_of(surfaces.iter().flat_map(|surface| &surface.entries));
        for surface in &surfaces {
            let group = self.group(self.dimension - 1, &surface.name);
            for entry in &surface.entries {
                for element in self.elements_of(entry)? {
                    self.add_faces(element, entry.face, group, &outer)?;
                }
            }
        }
        Ok(())
    }

    /// Sorted nodes of the outer facets, where some entry asks for them.
    fn outer_of<'a>(&self, mut entries: impl Iterator<Item = &'a Entry>) -> HashSet<[u64; 3]> {
        if !entries.any(|entry| entry.face == Face::Outer) {
            return HashSet::new();
        }
        let facets = self.outer_facets();
        let keyed = facets.chunks_exact(self.dimension).map(sorted);
        keyed.collect()
    }

    /// Outer facets, flat.
    pub(super) fn outer_facets(&self) -> Vec<u64> {
        let mut cells = RawMesh::default();
        let elements = self.deck.elements.iter();
        for element in elements.filter(|element| element.kind.dimension == self.dimension) {
            let nodes = self.deck.nodes_of(element);
            cells.push(element.kind, Owner::Physical(0), nodes);
        }
        outer_facets(&cells.blocks, self.dimension)
    }

    pub(super) fn elements_of(&mut self, entry: &Entry) -> Result<Vec<Element>, InpFault> {
        let positions = match entry.of {
            Ok(set) => match self.deck.element_sets.all.get(set) {
                Some(set) => self.order.members(set, &mut self.allowance)?,
                None => Vec::new(),
            },
            Err(number) => {
                let found = self.order.position(number);
                vec![found.ok_or(InpFault::UnknownElement(number))?]
            }
        };
        let found = positions
            .iter()
            .filter_map(|at| self.deck.elements.get(*at as usize));
        Ok(found.copied().collect())
    }

    fn add_faces(
        &mut self,
        element: Element,
        which: Face,
        group: i64,
        outer: &HashSet<[u64; 3]>,
    ) -> Result<(), InpFault> {
        let nodes = self.deck.nodes_of(&element);
        let (kind, dimension) = (element.kind, element.kind.dimension);
        let (lists, facets) = (&mut self.lists, &mut self.facets);
        match which {
            Face::Number(number) if dimension == self.dimension => {
                let local = face(kind, number).ok_or_else(|| InpFault::UnknownFace {
                    element: element.number,
                    face: format!("S{number}"),
                })?;
                for facet in parts(picked(nodes, local), dimension) {
                    facets.add(&facet, group, lists);
                }
            }
            Face::Outer if dimension == self.dimension => {
                for local in kind.faces() {
                    let all = parts(picked(nodes, local), dimension);
                    for facet in all.filter(|facet| outer.contains(&sorted(facet))) {
                        facets.add(&facet, group, lists);
                    }
                }
            }
            Face::Outer | Face::Number(1 | 2) if dimension + 1 == self.dimension => {
                let corners = corners_of(nodes, kind);
                for facet in parts(corners, self.dimension) {
                    if self.of_cells.has(&facet) {
                        facets.add(&facet, group, lists);
                    }
                }
            }
            Face::Outer | Face::Number(_) => {}
        }
        Ok(())
    }

    fn element_sets(&mut self) -> Result<(), InpFault> {
        let sets = self.deck.element_sets.clone();
        for set in sets
            .all
            .iter()
            .filter(|set| set.visibility == Visibility::Group)
        {
            let members = self.order.members(set, &mut self.allowance)?;
            self.add_group(&set.name, &members);
        }
        Ok(())
    }

    fn materials(&mut self) -> Result<(), InpFault> {
        let sections = std::mem::take(&mut self.deck.sections);
        let mut by_material: Vec<(String, Vec<u32>)> = Vec::new();
        for (set, material) in sections {
            let Some(set) = self.deck.element_sets.all.get(set) else {
                continue;
            };
            let members = self.order.members(set, &mut self.allowance)?;
            match by_material.iter_mut().find(|(known, _)| *known == material) {
                Some((_, all)) => all.extend(members),
                None => by_material.push((material, members)),
            }
        }
        for (material, mut members) in by_material {
            if self.has_group(self.dimension, &material) {
                continue;
            }
            members.sort_unstable();
            members.dedup();
            self.add_group(&material, &members);
        }
        Ok(())
    }

    /// Groups of the cells and of the facets among some elements.
    fn add_group(&mut self, name: &str, members: &[u32]) {
        let mut of_cells = None;
        let mut of_facets = None;
        for at in members {
            let Some(element) = self.deck.elements.get(*at as usize).copied() else {
                continue;
            };
            let dimension = element.kind.dimension;
            if dimension == self.dimension {
                let group = of_cells.unwrap_or_else(|| self.group(dimension, name));
                of_cells = Some(group);
                if let Some(list) = self.of_elements.get_mut(*at as usize) {
                    *list = self.lists.with(*list, group);
                }
            } else if dimension + 1 == self.dimension {
                let group = of_facets.unwrap_or_else(|| self.group(dimension, name));
                of_facets = Some(group);
                for facet in parts(self.corners(&element), self.dimension) {
                    if self.of_cells.has(&facet) {
                        self.facets.add(&facet, group, &mut self.lists);
                    }
                }
            }
        }
    }

    /// Vertices of an element of the surface. Programs do not agree on where a line of three
    /// nodes has its middle: it is the one that no other line ends at.
    fn corners(&self, element: &Element) -> [u64; 4] {
        let nodes = self.deck.nodes_of(element);
        match (element.kind.dimension, nodes) {
            (1, &[a, b, c]) if self.is_middle(b, [a, c]) => corners_of(&[a, c], element.kind),
            _ => corners_of(nodes, element.kind),
        }
    }

    /// Whether a node is nearer to two others than they are to each other.
    fn is_middle(&self, node: u64, ends: [u64; 2]) -> bool {
        let place = |number: u64| self.places.get(&number).copied().unwrap_or_default();
        let [a, b] = ends.map(place);
        let at = place(node);
        let far = |from: [f64; 3], to: [f64; 3]| {
            let squares = from.iter().zip(to).map(|(x, y)| (x - y) * (x - y));
            squares.sum::<f64>()
        };
        far(a, at).max(far(b, at)) < far(a, b)
    }

    /// Groups for cells and facets that nothing names.
    fn name_the_rest(&mut self) {
        if !self.groups.iter().any(|(of, _)| *of == self.dimension) {
            let group = self.group(self.dimension, BODY);
            for list in &mut self.of_elements {
                *list = self.lists.with(*list, group);
            }
        }
        if !self.groups.iter().any(|(of, _)| *of + 1 == self.dimension) {
            let group = self.group(self.dimension - 1, BOUNDARY);
            for facet in self.outer_facets().chunks_exact(self.dimension) {
                self.facets.add(facet, group, &mut self.lists);
            }
        }
    }

    fn emit(&mut self) {
        let raw = &mut self.raw;
        raw.nodes = std::mem::take(&mut self.deck.nodes);
        let facet_kind = ElementKind {
            dimension: self.dimension - 1,
            nodes: self.dimension,
        };
        let mut used = HashSet::new();
        for (nodes, list) in self.facets.nodes.iter().zip(&self.facets.lists) {
            let nodes = nodes.get(..self.dimension).unwrap_or_default();
            raw.push(facet_kind, Owner::Entity(i64::from(*list)), nodes);
            used.insert((facet_kind.dimension, *list));
        }
        for (element, list) in self.deck.elements.iter().zip(&self.of_elements) {
            if element.kind.dimension == self.dimension {
                let mut nodes = self.deck.nodes_of(element).to_vec();
                if let [.., a, b] = nodes.as_mut_slice()
                    && element.kind.nodes == 10
                {
                    std::mem::swap(a, b);
                }
                raw.push(element.kind, Owner::Entity(i64::from(*list)), &nodes);
                used.insert((self.dimension, *list));
            }
        }
        for (dimension, list) in used {
            raw.entities
                .insert((dimension, i64::from(list)), self.lists.groups(list));
        }
        for (number, (dimension, name)) in (1..).zip(&self.groups) {
            raw.names.insert((*dimension, number), name.clone());
        }
    }

    /// What is told of elements that are neither cells nor faces of cells.
    fn left_out(&self) -> Vec<String> {
        let of = |below: usize| {
            let types = self.deck.types.iter();
            let own = types.filter(move |(_, dimension)| dimension + below == self.dimension);
            own.map(|(name, _)| name.as_str())
        };
        let lines = (2..=self.dimension).flat_map(of).map(no_cells);
        let apart = self.of_cells.apart();
        let faces = (apart > 0).then(|| {
            let names: Vec<&str> = of(1).collect();
            format!(
                "{apart} facets of surface elements ({}) are no faces of cells, and are left out: shells and meshed tools are no part of the body; a tool is an [[obstacle]]",
                names.join(", ")
            )
        });
        lines.chain(faces).collect()
    }

    /// A fault in the words of this format.
    fn explained(&self, fault: MeshFault) -> InpFault {
        if let MeshFault::UnknownNode(node) = fault {
            let mut elements = self.deck.elements.iter();
            let found = elements.find(|element| self.deck.nodes_of(element).contains(&node));
            if let Some(element) = found {
                let element = element.number;
                return InpFault::UnknownNode { element, node };
            }
        }
        InpFault::Mesh(fault)
    }
}

/// Corners of an element of the surface; fewer than four fill up with the largest number.
fn corners_of(nodes: &[u64], kind: ElementKind) -> [u64; 4] {
    let mut corners = [u64::MAX; 4];
    for (slot, node) in corners.iter_mut().zip(nodes).take(kind.vertices()) {
        *slot = *node;
    }
    corners
}

/// The facets of a face: triangles of the space, the segment itself in the plane.
pub(super) fn parts(face: [u64; 4], dimension: usize) -> impl Iterator<Item = [u64; 3]> {
    let [a, b, c, _] = face;
    let segment = (dimension == 2 && a != b).then_some([a, b, c]);
    let in_space = (dimension == 3).then(|| triangles(face));
    segment.into_iter().chain(in_space.into_iter().flatten())
}

/// Faces of all cells, if the file has elements of the surface.
fn faces_of_cells(deck: &Deck, dimension: usize) -> OfCells {
    let mut all = OfCells::default();
    let of = |below: usize| move |one: &&Element| one.kind.dimension + below == dimension;
    if !deck.elements.iter().any(|one| of(1)(&one)) {
        return all;
    }
    for cell in deck.elements.iter().filter(of(0)) {
        for local in cell.kind.faces() {
            let faces = parts(picked(deck.nodes_of(cell), local), dimension);
            faces.for_each(|face| all.add(&face));
        }
    }
    all
}

/// Where nodes are, if the file has lines of three nodes.
fn places(deck: &Deck) -> HashMap<u64, [f64; 3]> {
    let is_line = |element: &Element| (element.kind.dimension, element.kind.nodes) == (1, 3);
    if deck.elements.iter().any(is_line) {
        deck.nodes.iter().copied().collect()
    } else {
        HashMap::new()
    }
}
