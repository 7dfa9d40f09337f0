//! Validation of uploaded arrays, in an order in which every check may rely on
//! the earlier ones: sizes, finite coordinates, index ranges, groups, shapes of
//! cells, adjacency. Each check is one pass and holds a few bits per entry.

use std::collections::HashSet;

use super::bits::Bits;
use super::cell::CellKind;
use super::error::{CellFault, FacetFault, GroupFault, MeshError};
use super::facets::FacetParent;
use super::numbering::Numbering;
use super::quality::{Mean, Quality};
use super::{Group, GroupKind, MeshParts, corners_of};
use crate::geometry::vector3::is_finite;

/// Indices travel as i32.
const LIMIT: usize = i32::MAX as usize;

/// Measure below which a cell counts as flat, relative to its longest edge
/// cubed (squared in two dimensions).
const DEGENERATE: f64 = 1e-14;

/// Distance from the plane z = 0 allowed in two dimensions, relative to the extent.
pub(super) const OFF_PLANE: f64 = 1e-12;

/// Sizes, ranges and groups: afterwards every index may be followed.
pub(crate) fn check_arrays(parts: &MeshParts) -> Result<(), MeshError> {
    let kind = parts.cell_kind;
    check_rows("cells", parts.cells.len(), kind.vertices())?;
    check_rows("facets", parts.facets.len(), kind.facet_vertices())?;
    if parts.cells.is_empty() {
        return Err(MeshError::NoCells);
    }
    let cell_count = parts.cells.len() / kind.vertices();
    let facet_count = parts.facets.len() / kind.facet_vertices();
    check_count("vertices", parts.coordinates.len())?;
    check_count("cells", cell_count)?;
    check_count("facets", facet_count)?;
    check_count("groups", parts.groups.len())?;
    // Each cell brings at most one new entry per local edge.
    check_count("cell edges", cell_count.saturating_mul(kind.edges().len()))?;
    check_finite(&parts.coordinates)?;
    check_ranges(parts)?;
    check_groups(&parts.groups, cell_count, facet_count)
}

/// Refuses an array whose length is no multiple of its row.
fn check_rows(array: &'static str, length: usize, row: usize) -> Result<(), MeshError> {
    if length.is_multiple_of(row) {
        Ok(())
    } else {
        Err(MeshError::ArrayLength { array, length, row })
    }
}

/// Refuses more entities than indices of 31 bits can name.
fn check_count(what: &'static str, count: usize) -> Result<(), MeshError> {
    if count > LIMIT {
        return Err(MeshError::TooLarge {
            what,
            count,
            limit: LIMIT,
        });
    }
    Ok(())
}

/// Refuses coordinates that are not finite, with the first vertex and how many there
/// are.
fn check_finite(coordinates: &[[f64; 3]]) -> Result<(), MeshError> {
    match first_and_count(coordinates.iter().map(|&point| !is_finite(point))) {
        Some((first, count)) => Err(MeshError::NotFinite { first, count }),
        None => Ok(()),
    }
}

/// Refuses cells and facets that name vertices which do not exist.
fn check_ranges(parts: &MeshParts) -> Result<(), MeshError> {
    let kind = parts.cell_kind;
    let outside = |row: &[u32]| {
        row.iter()
            .any(|&vertex| vertex as usize >= parts.coordinates.len())
    };
    let cells = || parts.cells.chunks_exact(kind.vertices());
    let facets = parts.facets.chunks_exact(kind.facet_vertices());
    refuse_cells(CellFault::VertexOutOfRange, cells().map(outside))?;
    refuse_cells(CellFault::RepeatedVertex, cells().map(repeats_a_vertex))?;
    match first_and_count(facets.map(outside)) {
        Some((first, count)) => Err(MeshError::Facets {
            fault: FacetFault::VertexOutOfRange,
            first,
            count,
        }),
        None => Ok(()),
    }
}

/// Whether a cell names one vertex more than once.
fn repeats_a_vertex(cell: &[u32]) -> bool {
    let later = |position: usize| &cell[position + 1..];
    (0..cell.len()).any(|position| later(position).contains(&cell[position]))
}

/// Refuses groups without a name, with a name twice, or with members that do not exist
/// or repeat.
fn check_groups(groups: &[Group], cells: usize, facets: usize) -> Result<(), MeshError> {
    let mut names = HashSet::new();
    let mut seen = Bits::new(cells.max(facets));
    for (index, group) in groups.iter().enumerate() {
        let limit = match group.kind {
            GroupKind::Cells => cells,
            GroupKind::Facets => facets,
        };
        let fault = if group.name.is_empty() {
            Some(GroupFault::Unnamed)
        } else if !names.insert((group.kind, group.name.as_str())) {
            Some(GroupFault::RepeatedName)
        } else {
            member_fault(&group.members, limit, &mut seen)
        };
        if let Some(fault) = fault {
            return Err(group_error(fault, index, group));
        }
    }
    Ok(())
}

/// `seen` is empty before, and again after a faultless group.
fn member_fault(members: &[u32], limit: usize, seen: &mut Bits) -> Option<GroupFault> {
    for &member in members {
        if member as usize >= limit {
            return Some(GroupFault::MemberOutOfRange);
        }
        if !seen.insert(member as usize) {
            return Some(GroupFault::RepeatedMember);
        }
    }
    for &member in members {
        seen.remove(member as usize);
    }
    None
}

/// The error of a group, with as much of its name as fits into a message.
pub(crate) fn group_error(fault: GroupFault, index: usize, group: &Group) -> MeshError {
    MeshError::Group {
        fault,
        index,
        name: group.name.chars().take(64).collect(),
        kind: group.kind,
    }
}

/// Refuses triangles outside the plane and flat cells; measures the quality of the others.
pub(crate) fn check_shapes(
    kind: CellKind,
    coordinates: &[[f64; 3]],
    cells: &[u32],
    numbering: &Numbering,
) -> Result<Quality, MeshError> {
    if kind == CellKind::Triangle {
        check_plane(coordinates, numbering)?;
    }
    let mut degenerate = Found::default();
    let mut quality = Mean::default();
    for (index, cell) in cells.chunks_exact(kind.vertices()).enumerate() {
        let sizes = kind.scaled_measures(&corners_of(coordinates, cell));
        let relative = sizes.measure / sizes.longest.powi(kind.dimension() as i32);
        // A measure that is not a number is not thick either.
        let is_thick = relative.abs() > DEGENERATE;
        degenerate.note_if(!is_thick, index);
        quality.add(kind, &sizes);
    }
    degenerate.refuse(CellFault::Degenerate)?;
    Ok(quality.finish())
}

/// Faulty cells met on a pass.
#[derive(Default)]
struct Found {
    /// First faulty cell, 0-based.
    first: usize,
    /// Number of faulty cells so far.
    count: usize,
}

impl Found {
    /// Counts a cell if it is faulty.
    fn note_if(&mut self, is_faulty: bool, cell: usize) {
        if is_faulty {
            if self.count == 0 {
                self.first = cell;
            }
            self.count += 1;
        }
    }

    /// The error of the cells counted, if there are any.
    fn refuse(&self, fault: CellFault) -> Result<(), MeshError> {
        match (self.first, self.count) {
            (_, 0) => Ok(()),
            (first, count) => Err(MeshError::Cells {
                fault,
                first,
                count,
            }),
        }
    }
}

/// Refuses triangles that leave the plane z = 0 by more than rounding of the body's
/// size.
fn check_plane(coordinates: &[[f64; 3]], numbering: &Numbering) -> Result<(), MeshError> {
    let allowed = OFF_PLANE * extent(coordinates);
    let height = |point: &[f64; 3]| point[2].abs();
    match first_and_count(coordinates.iter().map(|point| height(point) > allowed)) {
        Some((first, count)) => Err(MeshError::OffPlane {
            first: numbering.uploaded(first).unwrap_or(first),
            count,
        }),
        None => Ok(()),
    }
}

/// Longest side of the bounding box.
pub(crate) fn extent(coordinates: &[[f64; 3]]) -> f64 {
    let mut low = [f64::INFINITY; 3];
    let mut high = [f64::NEG_INFINITY; 3];
    for point in coordinates {
        for axis in 0..3 {
            low[axis] = low[axis].min(point[axis]);
            high[axis] = high[axis].max(point[axis]);
        }
    }
    (0..3)
        .map(|axis| high[axis] - low[axis])
        .fold(0.0, f64::max)
}

/// The error of the cells that the iterator calls faulty, if there are any; one entry a
/// cell, in order.
pub(crate) fn refuse_cells(
    fault: CellFault,
    faulty: impl Iterator<Item = bool>,
) -> Result<(), MeshError> {
    match first_and_count(faulty) {
        Some((first, count)) => Err(MeshError::Cells {
            fault,
            first,
            count,
        }),
        None => Ok(()),
    }
}

/// Refuses the cells in `listed`.
pub(crate) fn refuse_listed(fault: CellFault, listed: &Bits) -> Result<(), MeshError> {
    match listed.iter().next() {
        Some(first) => Err(MeshError::Cells {
            fault,
            first,
            count: listed.count(),
        }),
        None => Ok(()),
    }
}

/// Refuses facets of no cell.
pub(crate) fn attached(parents: Vec<Option<FacetParent>>) -> Result<Vec<FacetParent>, MeshError> {
    match first_and_count(parents.iter().map(Option::is_none)) {
        Some((first, count)) => Err(MeshError::Facets {
            fault: FacetFault::Detached,
            first,
            count,
        }),
        None => Ok(parents.into_iter().flatten().collect()),
    }
}

/// Refuses groups in which one facet stands under two indices: its load would count
/// twice. `places` is the number of entries of the cells.
pub(crate) fn check_repeated_facets(
    kind: CellKind,
    groups: &[Group],
    parents: &[FacetParent],
    places: usize,
) -> Result<(), MeshError> {
    let mut seen = Bits::new(places);
    let place = |&member: &u32| {
        let parent = parents[member as usize];
        parent.cell as usize * kind.vertices() + usize::from(parent.opposite)
    };
    for (index, group) in groups.iter().enumerate() {
        if group.kind != GroupKind::Facets {
            continue;
        }
        for place in group.members.iter().map(place) {
            if !seen.insert(place) {
                return Err(group_error(GroupFault::RepeatedMember, index, group));
            }
        }
        for place in group.members.iter().map(place) {
            seen.remove(place);
        }
    }
    Ok(())
}

/// Position of the first `true` and the number of them; `None` without any.
pub(crate) fn first_and_count(faulty: impl Iterator<Item = bool>) -> Option<(usize, usize)> {
    let mut positions = faulty.enumerate().filter(|&(_, fault)| fault);
    let (first, _) = positions.next()?;
    Some((first, 1 + positions.count()))
}
