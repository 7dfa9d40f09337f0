//! How stiff the body is where each multiplier acts, so that methods may weigh gaps beside
//! forces:
//!
//! ```text
//! mu_i = the largest shear modulus of the cells around the nodes that carry i
//! ```
//!
//! In units of the least modulus of the body. Cost: one pass over the cells.

use crate::contact::ContactSurface;
use crate::mesh::Mesh;
use crate::plan::Plan;
use crate::space::TaylorHood;

/// Of all multipliers of `surfaces`, which number them, `[multipliers]`; empty where all
/// cells are alike.
pub(crate) fn contact_moduli(
    plan: &Plan,
    (mesh, space): (&Mesh, &TaylorHood),
    surfaces: &[(&[u32], &ContactSurface)],
) -> Vec<f64> {
    let materials = plan.problem.resolved.materials.iter();
    let shear: Vec<f64> = materials
        .map(|material| material.law.shear_modulus / plan.problem.units.stress)
        .collect();
    let are_alike = shear
        .windows(2)
        .all(|pair| pair[0].total_cmp(&pair[1]).is_eq());
    if are_alike {
        return Vec::new();
    }
    let at_node = at_nodes(plan, (mesh, space), &shear);
    let mut moduli = vec![0.0_f64; plan.unknowns().contact as usize];
    for (numbers, surface) in surfaces {
        for (function, &node) in (0..).zip(&surface.carriers) {
            for (own, _) in surface.shares.of(function) {
                let place = numbers[own as usize] as usize;
                moduli[place] = moduli[place].max(at_node[node as usize]);
            }
        }
    }
    moduli
}

/// The largest modulus of the cells around each displacement node `[nodes]`.
fn at_nodes(plan: &Plan, (mesh, space): (&Mesh, &TaylorHood), shear: &[f64]) -> Vec<f64> {
    let mut at_node = vec![0.0_f64; space.nodes()];
    let per_cell = mesh.cell_kind().edges().len();
    for (cell, edges) in mesh.cell_edges().chunks_exact(per_cell).enumerate() {
        let own = shear[usize::from(plan.problem.resolved.cell_material[cell])];
        let middles = edges.iter().map(|&edge| space.vertices + edge as usize);
        let corners = mesh.cell(cell).iter().map(|&vertex| vertex as usize);
        for node in corners.chain(middles) {
            at_node[node] = at_node[node].max(own);
        }
    }
    at_node
}
