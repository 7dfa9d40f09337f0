//! Makes a mesh of what a file holds: the highest dimension present gives the
//! cells, the one below it the facets, their groups become named groups.
//!
//! Vertices are ordered by node number, so that every version and encoding of
//! one mesh gives the same mesh. Facets in no group are dropped: no key of a
//! scene can name them.

use std::collections::{BTreeMap, HashMap, HashSet};

use super::curved::Source;
use super::fault::MeshFault;
use super::plane::{PLANE_TOLERANCE, extent};
use super::raw::{Block, ElementKind, Owner, RawMesh};
use super::split::Simplices;
use super::{CurvedEdge, MeshFile, MeshGroup};

/// Indices on the wire are signed 32-bit numbers.
const LARGEST: u64 = i32::MAX as u64;

/// The mesh of a file.
///
/// # Errors
/// The first [`MeshFault`] found.
pub(crate) fn mesh(raw: &RawMesh) -> Result<MeshFile, MeshFault> {
    let (nodes, blocks) = (&raw.nodes, &raw.blocks);
    let dimension = cell_dimension(blocks)?;
    let numbering = Numbering::new(nodes, blocks)?;
    let coordinates = coordinates(&numbering, dimension)?;
    let cells = collect(raw, dimension, Part::Cells, &numbering)?;
    let source = Source {
        nodes,
        blocks,
        dimension,
        coordinates: &coordinates,
        cells: &cells.vertices,
    };
    let curved = source.edges(|tag| numbering.index(tag), |vertex| numbering.tag(vertex))?;
    let mut warnings = warnings(raw, blocks, dimension, &curved);
    let facets = collect(raw, dimension - 1, Part::Facets, &numbering)?;
    let mut groups = named(raw, dimension - 1, facets.groups, &mut warnings);
    groups.extend(named(raw, dimension, cells.groups, &mut warnings));
    Ok(MeshFile {
        vertices_per_cell: dimension + 1,
        coordinates,
        cells: cells.vertices,
        facets: facets.vertices,
        groups,
        curved,
        warnings,
    })
}

fn cell_dimension(blocks: &[Block]) -> Result<usize, MeshFault> {
    let filled = blocks.iter().filter(|block| !block.nodes.is_empty());
    filled
        .map(|block| block.kind.dimension)
        .max()
        .filter(|dimension| *dimension >= 2)
        .ok_or(MeshFault::NoCells)
}

/// Vertices in the order of their node numbers.
struct Numbering {
    sorted: Vec<(u64, [f64; 3])>,
}

impl Numbering {
    fn new(nodes: &[(u64, [f64; 3])], blocks: &[Block]) -> Result<Self, MeshFault> {
        let dropped = edge_nodes(blocks);
        let kept = nodes.iter().filter(|(tag, _)| !dropped.contains(tag));
        let mut sorted: Vec<_> = kept.copied().collect();
        sorted.sort_by_key(|(tag, _)| *tag);
        let neighbours = sorted.iter().zip(sorted.iter().skip(1));
        if let Some((twice, _)) = neighbours.into_iter().find(|(a, b)| a.0 == b.0) {
            return Err(MeshFault::DuplicateNode(twice.0));
        }
        let infinite = |(_, point): &&(u64, [f64; 3])| point.iter().any(|x| !x.is_finite());
        if let Some((tag, _)) = sorted.iter().find(infinite) {
            return Err(MeshFault::NotFinite(*tag));
        }
        if sorted.len() as u64 > LARGEST {
            return Err(MeshFault::TooLarge(LARGEST));
        }
        Ok(Self { sorted })
    }

    /// Node number of a vertex.
    fn tag(&self, vertex: u32) -> u64 {
        let found = self.sorted.get(vertex as usize);
        found.map_or(u64::MAX, |(tag, _)| *tag)
    }

    /// Where a node is; of one that is not there, the origin.
    fn place(&self, tag: u64) -> [f64; 3] {
        let found = self.index(tag).ok();
        let found = found.and_then(|index| self.sorted.get(index as usize));
        found.map(|(_, place)| *place).unwrap_or_default()
    }

    fn index(&self, tag: u64) -> Result<u32, MeshFault> {
        // Nodes are numbered without gaps in nearly every file.
        let first = self.sorted.first().map_or(0, |(tag, _)| *tag);
        let guess = usize::try_from(tag.wrapping_sub(first)).unwrap_or(usize::MAX);
        let hit = self
            .sorted
            .get(guess)
            .is_some_and(|(found, _)| *found == tag);
        let index = if hit {
            Some(guess)
        } else {
            self.sorted.binary_search_by_key(&tag, |(tag, _)| *tag).ok()
        };
        index
            .and_then(|index| u32::try_from(index).ok())
            .ok_or(MeshFault::UnknownNode(tag))
    }
}

/// Nodes that second-order elements have beside their vertices.
fn edge_nodes(blocks: &[Block]) -> HashSet<u64> {
    let mut middle = HashSet::new();
    for block in blocks {
        let vertices = block.kind.vertices();
        for element in block.nodes.chunks_exact(block.kind.nodes) {
            middle.extend(element.iter().skip(vertices));
        }
    }
    if middle.is_empty() {
        return middle;
    }
    for block in blocks {
        for element in block.nodes.chunks_exact(block.kind.nodes) {
            for vertex in element.iter().take(block.kind.vertices()) {
                middle.remove(vertex);
            }
        }
    }
    middle
}

fn coordinates(numbering: &Numbering, dimension: usize) -> Result<Vec<[f64; 3]>, MeshFault> {
    let points = numbering.sorted.iter();
    if dimension == 3 {
        return Ok(points.map(|(_, point)| *point).collect());
    }
    let extent = extent(points.clone().map(|(_, point)| point));
    let flat = |(node, [x, y, z]): &(u64, [f64; 3])| {
        if z.abs() <= PLANE_TOLERANCE * extent {
            return Ok([*x, *y, 0.0]);
        }
        let (node, z) = (*node, z.to_string());
        Err(MeshFault::NotPlanar { node, z })
    };
    points.map(flat).collect()
}

/// Elements of one dimension.
#[derive(Default)]
struct Elements {
    vertices: Vec<u32>,
    /// Members by group number.
    groups: BTreeMap<i64, Vec<u32>>,
    /// Elements by vertices, with the groups each was seen in (MSH 2.2 only).
    seen: HashMap<[u32; 4], (u32, Vec<i64>)>,
}

/// What elements of one dimension are in a mesh.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Part {
    Cells,
    Facets,
}

fn collect(
    raw: &RawMesh,
    dimension: usize,
    part: Part,
    numbering: &Numbering,
) -> Result<Elements, MeshFault> {
    let mut elements = Elements::default();
    let blocks = raw.blocks.iter();
    for block in blocks.filter(|block| block.kind.dimension == dimension) {
        let groups = groups_of(raw, block);
        if groups.is_empty() && part == Part::Facets {
            continue;
        }
        for element in block.nodes.chunks_exact(block.kind.nodes) {
            for simplex in simplices(block.kind, element, part, numbering)?.iter() {
                let mut vertices = [u32::MAX; 4];
                for (slot, tag) in vertices.iter_mut().zip(simplex).take(dimension + 1) {
                    *slot = numbering.index(*tag)?;
                }
                let vertices = vertices.get(..=dimension).unwrap_or_default();
                match block.owner {
                    Owner::Physical(group) => elements.add_copy(vertices, group)?,
                    Owner::Entity(_) => elements.add(vertices, &groups)?,
                }
            }
        }
    }
    Ok(elements)
}

/// The simplices of an element; those of a cell turned alike.
fn simplices(
    kind: ElementKind,
    element: &[u64],
    part: Part,
    numbering: &Numbering,
) -> Result<Simplices, MeshFault> {
    if part == Part::Facets || kind.composite().is_none() {
        return Ok(Simplices::of(kind, element));
    }
    let corners = element.get(..kind.vertices()).unwrap_or(element);
    for corner in corners {
        numbering.index(*corner)?;
    }
    let placed = Simplices::placed(kind, element, |tag| numbering.place(tag));
    placed.ok_or_else(|| {
        let numbers: Vec<String> = corners.iter().map(u64::to_string).collect();
        MeshFault::Folded(numbers.join(", "))
    })
}

fn groups_of(raw: &RawMesh, block: &Block) -> Vec<i64> {
    match block.owner {
        Owner::Physical(0) => Vec::new(),
        Owner::Physical(tag) => vec![tag],
        Owner::Entity(tag) => raw
            .entities
            .get(&(block.kind.dimension, tag))
            .cloned()
            .unwrap_or_default(),
    }
}

impl Elements {
    /// Adds an element to its groups.
    fn add(&mut self, vertices: &[u32], groups: &[i64]) -> Result<(), MeshFault> {
        let next = self.next(vertices)?;
        self.vertices.extend(vertices);
        for group in groups {
            self.groups.entry(*group).or_default().push(next);
        }
        Ok(())
    }

    fn next(&self, vertices: &[u32]) -> Result<u32, MeshFault> {
        let next = self.vertices.len() / vertices.len().max(1);
        let next = u32::try_from(next).ok();
        next.filter(|next| u64::from(*next) < LARGEST)
            .ok_or(MeshFault::TooLarge(LARGEST))
    }

    /// Adds an element of MSH 2.2, which writes an element once for each of its
    /// groups: the copies are one element. A copy in the *same* group is a
    /// fault of the mesh and is kept for the solver's check to find.
    fn add_copy(&mut self, vertices: &[u32], group: i64) -> Result<(), MeshFault> {
        let next = self.next(vertices)?;
        let mut key = [u32::MAX; 4];
        for (slot, vertex) in key.iter_mut().zip(vertices) {
            *slot = *vertex;
        }
        let (first, groups) = self.seen.entry(key).or_insert_with(|| (next, Vec::new()));
        if *first == next || groups.contains(&group) {
            groups.push(group);
            let groups: &[i64] = if group == 0 { &[] } else { &[group] };
            return self.add(vertices, groups);
        }
        groups.push(group);
        if group != 0 {
            self.groups.entry(group).or_default().push(*first);
        }
        Ok(())
    }
}

/// Groups in the order of their numbers; groups of one name become one.
fn named(
    raw: &RawMesh,
    dimension: usize,
    members: BTreeMap<i64, Vec<u32>>,
    warnings: &mut Vec<String>,
) -> Vec<MeshGroup> {
    let mut groups: Vec<MeshGroup> = Vec::new();
    for (tag, members) in members {
        let name = raw.names.get(&(dimension, tag));
        let name = name.cloned().unwrap_or_else(|| tag.to_string());
        match groups.iter_mut().find(|group| group.name == name) {
            Some(group) => {
                warnings.push(format!(
                    "groups of the same name \"{name}\" are taken as one"
                ));
                group.members.extend(members);
            }
            None => groups.push(MeshGroup {
                name,
                dimension,
                members,
            }),
        }
    }
    for group in &mut groups {
        group.members.sort_unstable();
        group.members.dedup();
    }
    groups
}

fn warnings(
    raw: &RawMesh,
    blocks: &[Block],
    dimension: usize,
    curved: &[CurvedEdge],
) -> Vec<String> {
    let mut warnings = Vec::new();
    let second_order = |block: &&Block| block.kind.nodes > block.kind.vertices();
    let cells: usize = blocks
        .iter()
        .filter(second_order)
        .filter(|block| block.kind.dimension == dimension)
        .map(|block| block.nodes.len() / block.kind.nodes)
        .sum();
    if cells > 0 && curved.is_empty() {
        warnings.push(format!(
            "{cells} cells are of second order, but every edge of the surface is a straight line"
        ));
    }
    warnings.extend(split(blocks, dimension));
    let ignored = raw.names.iter().filter(|((of, _), _)| *of + 1 < dimension);
    warnings.extend(ignored.map(|((of, _), name)| {
        format!("group \"{name}\" of dimension {of} is ignored: only cells and facets have groups")
    }));
    warnings
}

/// What is told of cells that are no simplices.
fn split(blocks: &[Block], dimension: usize) -> Option<String> {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for block in blocks.iter().filter(|b| b.kind.dimension == dimension) {
        if let Some(name) = block.kind.composite() {
            *counts.entry(name).or_default() += block.nodes.len() / block.kind.nodes;
        }
    }
    let counts: Vec<String> = counts
        .into_iter()
        .filter(|(_, count)| *count > 0)
        .map(|(name, count)| format!("{count} {name}"))
        .collect();
    let (parts, of) = match dimension {
        2 => ("triangles", "each"),
        _ => ("tetrahedra", "each face"),
    };
    (!counts.is_empty()).then(|| {
        let counts = counts.join(", ");
        format!("{counts} are split into {parts}, {of} along the diagonal through its smallest node number")
    })
}
