//! Validation of uploaded arrays, in an order in which every check may rely on
//! the earlier ones: sizes, finite coordinates, index ranges, groups, shapes of
//! cells, adjacency. Each check is one pass.

use std::collections::HashSet;

use super::cell::CellKind;
use super::error::{CellFault, FacetFault, GroupFault, MeshError};
use super::{Group, GroupKind, MeshParts};
use crate::geometry::vector3::is_finite;

/// Indices travel as i32.
const LIMIT: usize = i32::MAX as usize;

/// Measure below which a cell counts as flat, relative to its longest edge
/// cubed (squared in two dimensions).
const DEGENERATE: f64 = 1e-14;

/// Distance from the plane z = 0 allowed in two dimensions, relative to the extent.
const OFF_PLANE: f64 = 1e-12;

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

fn check_rows(array: &'static str, length: usize, row: usize) -> Result<(), MeshError> {
    if length.is_multiple_of(row) {
        Ok(())
    } else {
        Err(MeshError::ArrayLength { array, length, row })
    }
}

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

fn check_finite(coordinates: &[[f64; 3]]) -> Result<(), MeshError> {
    match first_and_count(coordinates.iter().map(|&point| !is_finite(point))) {
        Some((first, count)) => Err(MeshError::NotFinite { first, count }),
        None => Ok(()),
    }
}

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

fn repeats_a_vertex(cell: &[u32]) -> bool {
    let later = |position: usize| &cell[position + 1..];
    (0..cell.len()).any(|position| later(position).contains(&cell[position]))
}

fn check_groups(groups: &[Group], cells: usize, facets: usize) -> Result<(), MeshError> {
    let mut names = HashSet::new();
    let mut seen = vec![u32::MAX; cells.max(facets)];
    for (index, (group, stamp)) in groups.iter().zip(0_u32..).enumerate() {
        let limit = match group.kind {
            GroupKind::Cells => cells,
            GroupKind::Facets => facets,
        };
        let fault = if group.name.is_empty() {
            Some(GroupFault::Unnamed)
        } else if !names.insert((group.kind, group.name.as_str())) {
            Some(GroupFault::RepeatedName)
        } else {
            member_fault(&group.members, &mut seen[..limit], stamp)
        };
        if let Some(fault) = fault {
            return Err(group_error(fault, index, group));
        }
    }
    Ok(())
}

/// Stamps each member, so that one array serves all groups.
fn member_fault(members: &[u32], seen: &mut [u32], stamp: u32) -> Option<GroupFault> {
    for &member in members {
        let Some(last) = seen.get_mut(member as usize) else {
            return Some(GroupFault::MemberOutOfRange);
        };
        if *last == stamp {
            return Some(GroupFault::RepeatedMember);
        }
        *last = stamp;
    }
    None
}

pub(crate) fn group_error(fault: GroupFault, index: usize, group: &Group) -> MeshError {
    MeshError::Group {
        fault,
        index,
        name: group.name.chars().take(64).collect(),
        kind: group.kind,
    }
}

/// Refuses triangles outside the plane and flat or inverted cells; `used` says
/// which uploaded vertex each row of `coordinates` is.
pub(crate) fn check_shapes(
    kind: CellKind,
    coordinates: &[[f64; 3]],
    used: &[u32],
    corners: impl Iterator<Item = [[f64; 3]; 4]> + Clone,
) -> Result<(), MeshError> {
    if kind == CellKind::Triangle {
        check_plane(coordinates, used)?;
    }
    let relative = corners.map(|corners| {
        let sizes = kind.scaled_measures(&corners);
        sizes.measure / sizes.longest.powi(kind.dimension() as i32)
    });
    let thick = |measure: f64| measure.abs() > DEGENERATE;
    // A measure that is not a number is not thick either.
    refuse_cells(
        CellFault::Degenerate,
        relative.clone().map(|measure| !thick(measure)),
    )?;
    refuse_cells(CellFault::Inverted, relative.map(|measure| measure < 0.0))
}

fn check_plane(coordinates: &[[f64; 3]], used: &[u32]) -> Result<(), MeshError> {
    let allowed = OFF_PLANE * extent(coordinates);
    let height = |point: &[f64; 3]| point[2].abs();
    match first_and_count(coordinates.iter().map(|point| height(point) > allowed)) {
        Some((first, count)) => Err(MeshError::OffPlane {
            first: used[first] as usize,
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

/// Refuses cells listed in ascending order.
pub(crate) fn refuse_listed(fault: CellFault, listed: &[u32]) -> Result<(), MeshError> {
    match listed.first() {
        Some(&first) => Err(MeshError::Cells {
            fault,
            first: first as usize,
            count: listed.len(),
        }),
        None => Ok(()),
    }
}

/// Position of the first `true` and the number of them; `None` without any.
pub(crate) fn first_and_count(faulty: impl Iterator<Item = bool>) -> Option<(usize, usize)> {
    let mut positions = faulty.enumerate().filter(|&(_, fault)| fault);
    let (first, _) = positions.next()?;
    Some((first, 1 + positions.count()))
}
