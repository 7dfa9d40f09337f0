//! Who may meet whom on one body.

use super::super::choice::Role;
use super::super::fold::{Fold, Meets, creases};
use super::super::piece::point;
use super::*;
use crate::mesh::{GroupKind, Mesh, samples};
use crate::space::TaylorHood;

/// A rectangle of three by two cells with its skin.
fn block() -> (Mesh, Vec<u32>) {
    let mesh = samples::rectangle(3, 2);
    let sides = ["x0", "x1", "y0", "y1"].map(|name| {
        let side = mesh.group(name, GroupKind::Facets).expect("a side");
        side.members.clone()
    });
    let skin = sides.concat();
    (mesh, skin)
}

#[test]
fn of_two_faces_of_a_surface_the_one_that_comes_first_carries() {
    let (mesh, skin) = block();
    let space = TaylorHood::new(&mesh);
    let chain = Chain::new(&mesh, &space, &skin);
    let fold = Fold::new((&mesh, &space), [&chain, &chain], Meets::Itself).expect("one body");
    let count = chain.faces.len();
    let role = |own: usize, other: usize| fold.role([&chain, &chain], [own, other]);
    for own in 0..count {
        assert_eq!(role(own, own), None);
        for other in 0..own {
            let roles = [role(own, other), role(other, own)];
            let is_beside = |a: usize, b: usize| chain.faces[a].nodes[1] == chain.faces[b].nodes[0];
            if is_beside(own, other) || is_beside(other, own) {
                // Smooth, or round an outer corner.
                assert_eq!(roles, [None, None]);
            } else {
                let meets = roles.iter().filter(|role| **role == Some(Role::Meets));
                assert_eq!(meets.count(), 1, "{own} {other} {roles:?}");
            }
        }
    }
    assert!(creases(&mesh, [&skin, &skin]).is_empty());
}

#[test]
fn rays_look_inwards_by_half_the_wall_where_that_is_now() {
    let (mesh, skin) = block();
    let space = TaylorHood::new(&mesh);
    let chain = Chain::new(&mesh, &space, &skin);
    let fold = Fold::new((&mesh, &space), [&chain, &chain], Meets::Itself).expect("one body");
    let corners = mesh.coordinates();
    let high = corners.iter().fold(0.0_f64, |high, x| high.max(x[1]));
    let bottom = chain.faces.iter().position(|face| {
        face.nodes[..2]
            .iter()
            .all(|&vertex| corners[vertex as usize][1].abs() < 1e-12)
    });
    let bottom = bottom.expect("a face at the bottom");
    // Pressed to a tenth, and sheared by as much as it is high now.
    for (pressed, shear) in [(1.0, 0.0), (0.1, 0.0), (0.1, 1.0)] {
        let place = |node: u32| match corners.get(node as usize) {
            Some([x, y, _]) => [x + shear * pressed * y, pressed * y],
            None => [0.0; 2],
        };
        let nodes = chain.faces[bottom].nodes.map(place);
        let depths = fold.inside((bottom, nodes), &place, 10.0);
        let wall = pressed * high * f64::hypot(1.0, shear);
        for (end, depth) in depths.into_iter().enumerate() {
            let at = point(nodes, end as f64);
            assert!((depth - 0.5 * wall).abs() < 1e-12, "{at:?} {depth} {wall}");
        }
        let least = fold.inside((bottom, nodes), &place, 0.01);
        assert!(
            least.iter().all(|one| (one - 0.01).abs() < 1e-15),
            "{least:?}"
        );
    }
}
