//! `refine`: the mesh of a scene with cells halved, as a file that the scene can name.
//!
//! The solver's library bisects; groups and curved edges of the surface are inherited. Edges inside
//! the body are lines in the file, as in every mesh file.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

use signorini::geometry::vector3::{cross, dot, sub};
use signorini::mesh::{CellKind, GroupKind, Mesh};
use signorini::refinement::{Hierarchy, Limits, RefinementError};
use signorini_client::formats::msh;
use signorini_client::formats::vtk;

use super::library_mesh::{mesh, mesh_file};
use crate::arguments::{RefineArguments, input};
use crate::terminal::exit::{Exit, Failure};
use crate::terminal::stdout::print;
use crate::terminal::text::{note, number, one_line};
use crate::terminal::whole_file;

/// Arrays of errors by cell in files of results, the first one that is there.
const ERRORS: [&str; 2] = ["error_density", "error_estimate"];
/// Share of the sum of squared errors, or of the parts of the bound of a goal, that marked cells hold.
const SHARE: f64 = 0.5;

/// What is halved.
struct Part {
    is_all: bool,
    cells: Vec<String>,
    on: Vec<String>,
    /// Centres and radii.
    near: Vec<[f64; 4]>,
    /// Whether an error asks for each cell at present; empty without one.
    by: Vec<bool>,
}

pub(super) fn run(arguments: &RefineArguments) -> Result<Exit, Failure> {
    check_out(&arguments.out)?;
    let (path, file) = input::mesh_of(&arguments.scene)?;
    if is_same(&path, &arguments.out) {
        let message = format!("{} is the mesh itself: name another file", path.display());
        return Err(Failure::new(Exit::Usage, message));
    }
    let mesh = mesh(&file).map_err(|failure| failure.about(&path))?;
    let mut part = Part::new(arguments, &mesh)?;
    let limits = Limits {
        cells: arguments.max_cells,
        ..Limits::default()
    };
    let mut present = Hierarchy::new(Arc::new(mesh.clone()));
    for _ in 0..arguments.levels {
        let marked = part.members(present.mesh());
        if marked.is_empty() {
            let message = "there are no cells where it shall be refined".to_owned();
            return Err(Failure::new(Exit::Usage, message));
        }
        let refined = present.halve(&marked, limits).map_err(refused)?;
        part.by = refined.lineage.of_cells(&part.by);
        present = refined.hierarchy;
    }
    let text = msh::write(&mesh_file(present.mesh()));
    let text = text.map_err(|error| Failure::new(Exit::Invalid, error.to_string()))?;
    let out = &arguments.out;
    whole_file::write(out, text.as_bytes()).map_err(|error| Failure::unwritable(out, &error))?;
    for warning in present.mesh().warnings() {
        note(&format!("warning: {warning}\n"));
    }
    print(&told(out, [&mesh, present.mesh()]))?;
    Ok(Exit::Ok)
}

/// What became of a mesh.
fn told(out: &Path, [before, after]: [&Mesh; 2]) -> String {
    let quality = |mesh: &Mesh| number(mesh.quality().minimum);
    format!(
        "{}: {} cells and {} vertices, of {} and {}; least mean ratio {}, of {}\n",
        one_line(&out.display().to_string()),
        after.cell_count(),
        after.vertex_count(),
        before.cell_count(),
        before.vertex_count(),
        quality(after),
        quality(before),
    )
}

/// Refuses names of other formats.
fn check_out(out: &Path) -> Result<(), Failure> {
    if out
        .extension()
        .is_some_and(|end| end.eq_ignore_ascii_case("msh"))
    {
        return Ok(());
    }
    let message = format!(
        "{}: the mesh is written as one of Gmsh: end it in .msh",
        out.display()
    );
    Err(Failure::new(Exit::Usage, message))
}

/// Whether two paths are the same file.
fn is_same(one: &Path, other: &Path) -> bool {
    match (one.canonicalize(), other.canonicalize()) {
        (Ok(one), Ok(other)) => one == other,
        _ => false,
    }
}

fn refused(error: RefinementError) -> Failure {
    let is_limit = matches!(
        error,
        RefinementError::TooManyCells { .. } | RefinementError::TooMuchMemory { .. }
    );
    let exit = if is_limit {
        Exit::Refused
    } else {
        Exit::Invalid
    };
    Failure::new(exit, error.to_string())
}

impl Part {
    fn new(arguments: &RefineArguments, mesh: &Mesh) -> Result<Self, Failure> {
        for (names, kind) in [
            (&arguments.cells, GroupKind::Cells),
            (&arguments.on, GroupKind::Facets),
        ] {
            let is_missing = |name: &&String| mesh.group(name, kind).is_none();
            if let Some(name) = names.iter().find(is_missing) {
                return Err(missing(name, kind, mesh));
            }
        }
        let near = arguments.near.as_chunks().0.to_vec();
        let by = arguments.by.as_deref().map(|path| by_error(path, mesh));
        let by = by.transpose()?.unwrap_or_default();
        let counts = [
            arguments.cells.len(),
            arguments.on.len(),
            near.len(),
            by.len(),
        ];
        let is_named = counts.iter().any(|count| *count > 0);
        Ok(Self {
            is_all: arguments.all || !is_named,
            cells: arguments.cells.clone(),
            on: arguments.on.clone(),
            near,
            by,
        })
    }

    /// The cells at present, ascending.
    fn members(&self, mesh: &Mesh) -> Vec<u32> {
        if self.is_all {
            return (0..mesh.cell_count() as u32).collect();
        }
        let mut found = BTreeSet::new();
        let of = |name: &String, kind| mesh.group(name, kind).into_iter();
        let cells = self
            .cells
            .iter()
            .flat_map(|name| of(name, GroupKind::Cells));
        found.extend(cells.flat_map(|group| group.members.iter().copied()));
        let facets = self.on.iter().flat_map(|name| of(name, GroupKind::Facets));
        let facets = facets.flat_map(|group| group.members.iter());
        found.extend(facets.map(|&facet| mesh.facet_cell(facet as usize).0 as u32));
        for &[x, y, z, radius] in &self.near {
            let is_near = |&cell: &u32| {
                let corners = mesh.corners(cell as usize);
                let mut own = corners.iter().take(mesh.cell_kind().vertices());
                own.any(|corner| distance(corner, &[x, y, z]) <= radius)
            };
            found.extend((0..mesh.cell_count() as u32).filter(is_near));
        }
        let asked = (0..).zip(&self.by).filter(|(_, asks)| **asks);
        found.extend(asked.map(|(cell, _)| cell));
        found.into_iter().collect()
    }
}

/// What each cell adds to the error: its part of the bound of a goal, or the square of its part in
/// the energy norm.
fn shares(path: &Path, mesh: &Mesh) -> Result<Vec<f64>, Failure> {
    let read =
        |names: &[&'static str]| input::read_file(path, |bytes| vtk::cell_values(bytes, names));
    let goal = read(&ERRORS[..1]);
    let is_of_goal = goal.is_ok();
    let errors = goal.or_else(|_| read(&ERRORS))?;
    if errors.len() != mesh.cell_count() {
        let (values, cells) = (errors.len(), mesh.cell_count());
        let message = format!(
            "{}: errors of {values} cells, but the mesh of the scene has {cells}",
            path.display()
        );
        return Err(Failure::new(Exit::Invalid, message));
    }
    let share = |(cell, error): (usize, f64)| {
        if is_of_goal {
            error.abs() * volume(mesh, cell)
        } else {
            error * error
        }
    };
    Ok(errors.into_iter().enumerate().map(share).collect())
}

/// Volume of a cell, in the plane its area.
fn volume(mesh: &Mesh, cell: usize) -> f64 {
    let [a, b, c, d] = mesh.corners(cell);
    let normal = cross(sub(b, a), sub(c, a));
    match mesh.cell_kind() {
        CellKind::Triangle => 0.5 * dot(normal, normal).sqrt(),
        CellKind::Tetrahedron => dot(normal, sub(d, a)).abs() / 6.0,
    }
}

/// Whether each cell is among the worst ones that hold [`SHARE`] of the error in a file of results (W. Dorfler, SIAM J. Numer. Anal. 33, 1996).
fn by_error(path: &Path, mesh: &Mesh) -> Result<Vec<bool>, Failure> {
    let shares = shares(path, mesh)?;
    let mut worst: Vec<(usize, f64)> = shares.iter().copied().enumerate().collect();
    worst.sort_by(|one, other| other.1.total_cmp(&one.1));
    let goal = SHARE * shares.iter().sum::<f64>();
    let mut asks = vec![false; shares.len()];
    let mut sum = 0.0;
    for (cell, share) in worst {
        if sum >= goal {
            break;
        }
        sum += share;
        if let Some(asks) = asks.get_mut(cell) {
            *asks = true;
        }
    }
    Ok(asks)
}

fn distance(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b));
    squares.sum::<f64>().sqrt()
}

/// A group that is not there, with those that are.
fn missing(name: &str, kind: GroupKind, mesh: &Mesh) -> Failure {
    let groups = mesh.groups().iter().filter(|group| group.kind == kind);
    let names: Vec<&str> = groups.map(|group| group.name.as_str()).collect();
    let names = names.join(", ");
    let message = format!("the mesh has no {kind} group \"{name}\"; it has: {names}");
    Failure::new(Exit::Usage, message)
}

#[cfg(test)]
mod tests {
    use signorini_client::formats::msh::{CurvedEdge, MeshFile, MeshGroup};

    use super::*;

    fn square() -> MeshFile {
        MeshFile {
            vertices_per_cell: 3,
            coordinates: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]],
            cells: vec![0, 1, 2, 1, 3, 2],
            facets: vec![0, 1, 1, 3],
            groups: vec![
                MeshGroup {
                    name: "sides".to_owned(),
                    dimension: 1,
                    members: vec![0, 1],
                },
                MeshGroup {
                    name: "body".to_owned(),
                    dimension: 2,
                    members: vec![0, 1],
                },
            ],
            curved: vec![CurvedEdge {
                ends: [0, 1],
                offset: [0.0, -0.05, 0.0],
            }],
            warnings: Vec::new(),
        }
    }

    #[test]
    fn a_refined_mesh_is_read_from_its_file_with_groups_and_arcs() {
        let start = Hierarchy::new(Arc::new(mesh(&square()).unwrap()));
        let refined = start.refine(&[0, 1], Limits::default()).unwrap().hierarchy;
        let refined = refined
            .refine(&[0, 1, 2, 3], Limits::default())
            .unwrap()
            .hierarchy;
        let file = mesh_file(refined.mesh());
        let text = msh::write(&file).unwrap();
        let read = msh::read(text.as_bytes()).unwrap();
        assert_eq!(read.groups, file.groups);
        assert_eq!(read.cells, file.cells);
        assert_eq!(read.curved.len(), 2);
        let halves = &read.groups.first().unwrap().members;
        assert_eq!(halves.len(), 4);
        assert!(mesh(&read).is_ok());
    }

    #[test]
    fn parts_are_united_and_unknown_groups_are_named() {
        let mesh = mesh(&square()).unwrap();
        let part = Part {
            is_all: false,
            cells: Vec::new(),
            on: vec!["sides".to_owned()],
            near: vec![[0.0, 0.0, 0.0, 0.1]],
            by: Vec::new(),
        };
        assert_eq!(part.members(&mesh), [0, 1]);
        let failure = missing("top", GroupKind::Facets, &mesh);
        assert!(
            failure
                .text()
                .contains("no facet group \"top\"; it has: sides")
        );
    }
}
