//! Points and cells of a file, before they are made into a mesh.

use super::error::{Place, VtkError, VtkFault};
use crate::formats::mesh::raw::{ElementKind, Owner, RawMesh};
use crate::formats::mesh::{self, BODY, BOUNDARY, MeshFile, outer_facets};

/// Integer cell arrays that say the group of a cell; the first one found does.
pub(super) const GROUP_ARRAYS: [&str; 3] = ["group", "gmsh:physical", "medit:ref"];

/// A quadrangle with its corners row by row.
const PIXEL: i64 = 8;
/// A hexahedron with its corners row by row.
const VOXEL: i64 = 11;

/// Owner of what is in no group.
const NONE: i64 = i64::MIN;

/// The name of a group.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct GroupName {
    pub(super) name: String,
    pub(super) number: i64,
    pub(super) dimension: i64,
}

/// The content of a file.
#[derive(Clone, Debug, Default)]
pub(super) struct Dataset {
    /// Flat [points, 3].
    pub(super) points: Vec<f64>,
    /// Points of all cells.
    pub(super) connectivity: Vec<i64>,
    /// Where the points of each cell end.
    pub(super) ends: Vec<i64>,
    /// Shape of each cell, by the numbers of VTK.
    pub(super) types: Vec<i64>,
    /// Name and values of the array of groups.
    pub(super) groups: Option<(&'static str, Vec<i64>)>,
    pub(super) names: Vec<GroupName>,
    pub(super) warnings: Vec<String>,
}

impl Dataset {
    pub(super) fn warn_of_reals(&mut self, array: &str) {
        self.warnings.push(format!(
            "the cell array {array} is not of whole numbers and names no groups"
        ));
    }

    /// The mesh.
    pub(super) fn mesh(self) -> Result<MeshFile, VtkError> {
        self.check()?;
        let mut raw = RawMesh::default();
        let (points, _) = self.points.as_chunks::<3>();
        raw.nodes = (0..).zip(points.iter().copied()).collect();
        self.cells(&mut raw)?;
        self.name_groups(&mut raw);
        let mut mesh = mesh::build(&raw).map_err(|fault| VtkFault::from(fault).whole())?;
        mesh.warnings.extend(self.warnings);
        Ok(mesh)
    }

    fn check(&self) -> Result<(), VtkError> {
        let length = |array: &str, found: usize, expected: usize| {
            if found == expected {
                Ok(())
            } else {
                Err(VtkFault::Length { expected, found }.in_array(array))
            }
        };
        let points = self.points.len();
        length("Points", points, points / 3 * 3)?;
        length("types", self.types.len(), self.ends.len())?;
        match &self.groups {
            Some((name, groups)) => length(name, groups.len(), self.ends.len()),
            None => Ok(()),
        }
    }

    fn cells(&self, raw: &mut RawMesh) -> Result<(), VtkError> {
        let mut start = 0;
        for (cell, (end, shape)) in self.ends.iter().zip(&self.types).enumerate() {
            let at = |fault: VtkFault| fault.at(Place::Cell(cell));
            let end = usize::try_from(*end).unwrap_or(usize::MAX);
            let points = self.connectivity.get(start..end);
            let points = points
                .ok_or(VtkFault::Truncated("the points of a cell"))
                .map_err(at)?;
            start = end;
            let Some(kind) = kind(*shape, points.len()).map_err(at)? else {
                continue;
            };
            let mut nodes = self.nodes(points).map_err(at)?;
            match (nodes.as_mut_slice(), kind.nodes) {
                ([.., a, b], 10) => std::mem::swap(a, b),
                ([_, _, c, d], 4) if *shape == PIXEL => std::mem::swap(c, d),
                ([_, _, c, d, _, _, g, h], 8) if *shape == VOXEL => {
                    std::mem::swap(c, d);
                    std::mem::swap(g, h);
                }
                _ => {}
            }
            raw.push(kind, Owner::Entity(self.group_of(cell)), &nodes);
        }
        Ok(())
    }

    /// Gmsh counts groups from 1 and writes 0 for none.
    fn group_of(&self, cell: usize) -> i64 {
        let Some((name, groups)) = &self.groups else {
            return NONE;
        };
        let group = groups.get(cell).copied().unwrap_or(NONE);
        match (*name, group) {
            ("gmsh:physical", 0) => NONE,
            (_, group) => group,
        }
    }

    fn nodes(&self, points: &[i64]) -> Result<Vec<u64>, VtkFault> {
        let count = self.points.len() / 3;
        let nodes = points.iter().map(|&point| {
            let node = u64::try_from(point)
                .ok()
                .filter(|node| *node < count as u64);
            node.ok_or(VtkFault::UnknownPoint { point, count })
        });
        nodes.collect()
    }

    /// Groups of cells and facets, and for those that have none, the names that stand
    /// for all of them.
    fn name_groups(&self, raw: &mut RawMesh) {
        let dimensions = raw.blocks.iter().map(|block| block.kind.dimension);
        let dimension = dimensions.max().unwrap_or_default();
        if dimension < 2 {
            return;
        }
        for block in &raw.blocks {
            if let Owner::Entity(number) = block.owner
                && number != NONE
            {
                let key = (block.kind.dimension, number);
                raw.entities.entry(key).or_insert_with(|| vec![number]);
            }
        }
        for one in &self.names {
            if let Ok(dimension) = usize::try_from(one.dimension) {
                raw.names.insert((dimension, one.number), one.name.clone());
            }
        }
        if !raw.entities.keys().any(|(of, _)| *of == dimension) {
            raw.entities.insert((dimension, NONE), vec![0]);
            raw.names.insert((dimension, 0), BODY.to_owned());
        }
        if !raw.entities.keys().any(|(of, _)| *of + 1 == dimension) {
            let facets = outer_facets(&raw.blocks, dimension);
            let kind = ElementKind {
                dimension: dimension - 1,
                nodes: dimension,
            };
            // Facets without a group go: the whole surface takes their place.
            raw.blocks
                .retain(|block| block.kind.dimension + 1 != dimension);
            for facet in facets.chunks_exact(dimension) {
                raw.push(kind, Owner::Entity(0), facet);
            }
            raw.entities.insert((dimension - 1, 0), vec![0]);
            raw.names.insert((dimension - 1, 0), BOUNDARY.to_owned());
        }
    }
}

/// The kind of a cell by the number of its shape; none of points and broken lines.
fn kind(shape: i64, points: usize) -> Result<Option<ElementKind>, VtkFault> {
    let (dimension, nodes): (usize, &[usize]) = match shape {
        1 | 2 | 4 => return Ok(None),
        3 => (1, &[2]),
        21 => (1, &[3]),
        68 => (1, &[2, 3]),
        5 => (2, &[3]),
        22 => (2, &[6]),
        69 => (2, &[3, 6]),
        10 => (3, &[4]),
        24 => (3, &[10]),
        71 => (3, &[4, 10]),
        PIXEL | 9 => (2, &[4]),
        23 => (2, &[8]),
        28 => (2, &[9]),
        70 => (2, &[4]),
        VOXEL | 12 | 72 => (3, &[8]),
        25 => (3, &[20]),
        29 => (3, &[27]),
        13 | 73 => (3, &[6]),
        26 => (3, &[15]),
        32 => (3, &[18]),
        14 | 74 => (3, &[5]),
        27 => (3, &[13]),
        other => return Err(VtkFault::UnsupportedCell(describe(other))),
    };
    if nodes.contains(&points) {
        Ok(Some(ElementKind {
            dimension,
            nodes: points,
        }))
    } else {
        let shape = format!("{} of {points} points", describe(shape));
        Err(VtkFault::UnsupportedCell(shape))
    }
}

fn describe(shape: i64) -> String {
    let name = match shape {
        5 | 22 | 34 | 69 => "triangle",
        3 | 21 | 35 | 68 => "line",
        6 => "triangle strip",
        7 => "polygon",
        PIXEL | 9 | 23 | 28 | 30 | 70 => "quadrangle",
        10 | 24 | 71 => "tetrahedron",
        VOXEL | 12 | 25 | 29 | 33 | 72 => "hexahedron",
        13 | 26 | 31 | 32 | 73 => "wedge",
        14 | 27 | 37 | 74 => "pyramid",
        41 | 42 => "polyhedron",
        _ => return format!("cell type {shape}"),
    };
    format!("{name} (cell type {shape})")
}
