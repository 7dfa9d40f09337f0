//! Several meshes as one, each scaled, turned and moved to its place:
//!
//! ```text
//! x -> t + R (s x),   R the rotation by a vector about the origin
//! ```
//!
//! Groups get the name of their body before their own, `BODY-GROUP`. Cost: one pass over the arrays.

use std::collections::HashMap;

use super::{CurvedEdge, MeshFile, MeshGroup};

/// Where a body is put.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Factor on the coordinates of its mesh, above zero.
    pub scale: f64,
    /// Rotation vector about the origin, radians `[3]`.
    pub rotation: [f64; 3],
    /// Translation after that, length `[3]`.
    pub translation: [f64; 3],
}

impl Default for Placement {
    fn default() -> Self {
        Self {
            scale: 1.0,
            rotation: [0.0; 3],
            translation: [0.0; 3],
        }
    }
}

/// A body on its way into a mesh of several.
#[derive(Clone, Debug)]
pub struct Body {
    /// By which its groups are called.
    pub name: String,
    /// Its own mesh.
    pub mesh: MeshFile,
    /// Where it is put.
    pub placement: Placement,
}

/// Why meshes do not become one.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum JoinFault {
    /// Triangles and tetrahedra.
    #[error("body `{0}` is a section and body `{1}` a solid: one scene has bodies of one kind")]
    Shapes(String, String),
    /// A name for two groups.
    #[error(
        "group `{name}` is `{}` of body `{}` and `{}` of body `{}`: call one body otherwise",
        first.1, first.0, second.1, second.0
    )]
    Group {
        /// The name of both.
        name: String,
        /// Body and own name of the first one.
        first: (String, String),
        /// Those of the second one.
        second: (String, String),
    },
    /// Something out of the plane of a section.
    #[error("body `{0}` leaves the plane of the scene: move it along x and y, turn it about z")]
    OutOfPlane(String),
    /// More vertices than can be numbered.
    #[error("the bodies have more than 2^31 vertices, cells or facets together")]
    TooLarge,
    /// No body.
    #[error("there is no body")]
    None,
}

/// The mesh of all bodies, in their order.
///
/// # Errors
/// [`JoinFault`].
pub fn joined(bodies: Vec<Body>) -> Result<MeshFile, JoinFault> {
    let mut bodies = bodies.into_iter();
    let first = bodies.next().ok_or(JoinFault::None)?;
    let mut names = Names::default();
    let first_name = first.name.clone();
    let mut whole = placed(first, &mut names)?;
    for body in bodies {
        let name = body.name.clone();
        let other = placed(body, &mut names)?;
        if other.vertices_per_cell != whole.vertices_per_cell {
            let (section, solid) = match other.vertices_per_cell {
                3 => (name, first_name),
                _ => (first_name, name),
            };
            return Err(JoinFault::Shapes(section, solid));
        }
        append(&mut whole, other)?;
    }
    // Facet groups come first.
    whole.groups.sort_by_key(|group| group.dimension);
    Ok(whole)
}

/// Names of groups with the bodies and groups that they stand for, by dimension.
#[derive(Default)]
struct Names(HashMap<(usize, String), (String, String)>);

/// A body where it is put, its groups with their new names.
fn placed(body: Body, names: &mut Names) -> Result<MeshFile, JoinFault> {
    let Body {
        name,
        mut mesh,
        placement,
    } = body;
    let [x, y, _] = placement.rotation;
    let is_in_plane = placement.translation[2] == 0.0 && x == 0.0 && y == 0.0;
    if mesh.vertices_per_cell == 3 && !is_in_plane {
        return Err(JoinFault::OutOfPlane(name));
    }
    let turned = |x: [f64; 3]| rotated(placement.rotation, x.map(|x| placement.scale * x));
    let [x, y, z] = placement.translation;
    for place in &mut mesh.coordinates {
        let [u, v, w] = turned(*place);
        *place = [x + u, y + v, z + w];
    }
    for edge in &mut mesh.curved {
        edge.offset = turned(edge.offset);
    }
    for group in &mut mesh.groups {
        let own = std::mem::take(&mut group.name);
        group.name = format!("{name}-{own}");
        let key = (group.dimension, group.name.clone());
        if let Some(first) = names.0.insert(key, (name.clone(), own.clone())) {
            return Err(JoinFault::Group {
                name: group.name.clone(),
                first,
                second: (name, own),
            });
        }
    }
    for warning in &mut mesh.warnings {
        *warning = format!("body `{name}`: {warning}");
    }
    Ok(mesh)
}

/// Adds the arrays of another mesh of the same shape.
fn append(whole: &mut MeshFile, other: MeshFile) -> Result<(), JoinFault> {
    let dimension = whole.vertices_per_cell - 1;
    let [vertices, cells, facets] = [
        whole.coordinates.len(),
        whole.cell_count(),
        whole.facet_count(),
    ];
    let most = i32::MAX as usize;
    let [all_vertices, all_cells, all_facets] = [
        vertices + other.coordinates.len(),
        cells + other.cell_count(),
        facets + other.facet_count(),
    ];
    if all_vertices.max(all_cells).max(all_facets) > most {
        return Err(JoinFault::TooLarge);
    }
    let vertex = |v: &u32| v + vertices as u32;
    whole.coordinates.extend(other.coordinates);
    whole.cells.extend(other.cells.iter().map(vertex));
    whole.facets.extend(other.facets.iter().map(vertex));
    whole
        .curved
        .extend(other.curved.iter().map(|edge| CurvedEdge {
            ends: edge.ends.map(|v| vertex(&v)),
            offset: edge.offset,
        }));
    whole.groups.extend(other.groups.into_iter().map(|group| {
        let by = if group.dimension == dimension {
            cells
        } else {
            facets
        };
        MeshGroup {
            members: group.members.iter().map(|m| m + by as u32).collect(),
            ..group
        }
    }));
    whole.warnings.extend(other.warnings);
    Ok(())
}

/// A vector turned by a rotation vector (O. Rodrigues, 1840).
fn rotated(by: [f64; 3], [a, b, c]: [f64; 3]) -> [f64; 3] {
    let angle = by.iter().map(|x| x * x).sum::<f64>().sqrt();
    if angle == 0.0 {
        return [a, b, c];
    }
    let [x, y, z] = by.map(|x| x / angle);
    let (sine, cosine) = angle.sin_cos();
    let along = (1.0 - cosine) * (x * a + y * b + z * c);
    [
        cosine * a + along * x + sine * (y * c - z * b),
        cosine * b + along * y + sine * (z * a - x * c),
        cosine * c + along * z + sine * (x * b - y * a),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A triangle with a group of its cell and one of its first side.
    fn triangle(cells: &str, side: &str) -> MeshFile {
        let group = |name: &str, dimension: usize| MeshGroup {
            name: name.to_owned(),
            dimension,
            members: vec![0],
        };
        MeshFile {
            vertices_per_cell: 3,
            coordinates: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            cells: vec![0, 1, 2],
            facets: vec![0, 1],
            groups: vec![group(side, 1), group(cells, 2)],
            curved: vec![CurvedEdge {
                ends: [0, 1],
                offset: [0.0, -0.1, 0.0],
            }],
            warnings: vec!["odd".to_owned()],
        }
    }

    fn body(name: &str, mesh: MeshFile) -> Body {
        Body {
            name: name.to_owned(),
            mesh,
            placement: Placement::default(),
        }
    }

    #[test]
    fn bodies_are_scaled_turned_and_moved_and_keep_their_groups() {
        let mut second = body("b", triangle("rubber", "base"));
        second.placement = Placement {
            scale: 2.0,
            rotation: [0.0, 0.0, std::f64::consts::FRAC_PI_2],
            translation: [5.0, 1.0, 0.0],
        };
        let whole = joined(vec![body("a", triangle("rubber", "base")), second]).unwrap();
        let near = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
        assert!(near(whole.coordinates[4], [5.0, 3.0, 0.0]));
        assert!(near(whole.coordinates[5], [3.0, 1.0, 0.0]));
        assert_eq!(whole.cells, [0, 1, 2, 3, 4, 5]);
        assert_eq!(whole.facets, [0, 1, 3, 4]);
        assert_eq!(whole.curved[1].ends, [3, 4]);
        assert!(near(whole.curved[1].offset, [0.2, 0.0, 0.0]));
        let groups = whole.groups.iter();
        let groups: Vec<_> = groups.map(|one| (&one.name[..], one.members[0])).collect();
        let told = [
            ("a-base", 0),
            ("b-base", 1),
            ("a-rubber", 0),
            ("b-rubber", 1),
        ];
        assert_eq!(groups, told);
        assert_eq!(whole.warnings[1], "body `b`: odd");
    }

    #[test]
    fn what_does_not_fit_is_told_by_both_names() {
        let fault = |bodies| joined(bodies).unwrap_err().to_string();
        let clash = fault(vec![
            body("a", triangle("rubber", "b-base")),
            body("a-b", triangle("steel", "base")),
        ]);
        assert_eq!(
            clash,
            "group `a-b-base` is `b-base` of body `a` and `base` of body `a-b`: call one body otherwise"
        );
        let solid = MeshFile {
            vertices_per_cell: 4,
            cells: vec![0, 1, 2, 3],
            facets: vec![0, 1, 2],
            curved: Vec::new(),
            ..triangle("rubber", "base")
        };
        let mut solid = body("ball", solid);
        solid.mesh.groups.clear();
        let other = body("ring", triangle("rubber", "base"));
        assert_eq!(
            fault(vec![solid, other.clone()]),
            "body `ring` is a section and body `ball` a solid: one scene has bodies of one kind"
        );
        let mut lifted = other;
        lifted.placement.translation[2] = 1.0;
        assert!(fault(vec![lifted]).starts_with("body `ring` leaves the plane"));
    }
}
