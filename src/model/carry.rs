//! Bodies carried along by what holds them, before anything is solved:
//!
//! ```text
//! m_i = the motion of all that is held of a body in component i, where it is one
//! m   = P m of the nodes that are not held,   P: along planes that hold nodes
//! ```
//!
//! Translations cost a body no energy: a body that is carried begins an increment with what contact
//! asks for alone. Without, the cells beside its supports bear the motion, and a stiff body has
//! forces beside which those of its contact with a soft one are rounding. Linear bodies are all
//! carried, of rubber the stiff ones beside softer ones (decision 21). Bodies are the connected
//! parts of the mesh, tied ones being one. Shapes `[displacement]`, non-dimensional. Cost: a pass
//! over the edges of the mesh.

use super::Model;
use crate::linalg::vector::add_scaled;
use crate::model::held::mask;
use crate::plan::pairs::ALIKE;
use crate::scene::validate::joined_parts;

/// Share of a motion by which parts of it differ that are the same, without unit: rounding.
const SAME: f64 = 1e-12;

/// Least and greatest motion of what is held.
type Range = [f64; 2];
const NOTHING: Range = [f64::INFINITY, f64::NEG_INFINITY];

/// Moves the free entries of `displacement` along where supports carry them, which have moved on
/// from `before`.
pub(crate) fn carry(model: &Model<'_>, before: &[f64], displacement: &mut [f64]) {
    let ways = displacement.iter().zip(before);
    let motion: Vec<f64> = ways.map(|(to, from)| to - from).collect();
    let body_of = joined_parts(model.mesh, &model.plan.problem.resolved.ties);
    let translations = translations(model, &body_of, &motion);
    if let Some(carried) = carried(model, &body_of, &translations, motion.len()) {
        add_scaled(displacement, 1.0, &carried);
    }
}

/// What stiff bodies are carried by where `motion` has that of the held entries; none where none is.
pub(crate) fn carried_stiff(model: &Model<'_>, motion: &[f64]) -> Option<Vec<f64>> {
    if model.plan.problem.resolved.pairs.is_empty() {
        return None;
    }
    let body_of = joined_parts(model.mesh, &model.plan.problem.resolved.ties);
    let mut translations = translations(model, &body_of, motion);
    let moduli = moduli(model, &body_of, translations.len());
    let softest = moduli.iter().copied().fold(f64::INFINITY, f64::min);
    for (translation, modulus) in translations.iter_mut().zip(moduli) {
        if modulus <= ALIKE * softest {
            *translation = [0.0; 3];
        }
    }
    carried(model, &body_of, &translations, motion.len())
}

/// Least shear modulus of each body, the caller's stress.
fn moduli(model: &Model<'_>, body_of: &[u32], count: usize) -> Vec<f64> {
    let resolved = &model.plan.problem.resolved;
    let mut moduli = vec![f64::INFINITY; count];
    for (cell, &material) in resolved.cell_material.iter().enumerate() {
        let Some(&corner) = model.mesh.cell(cell).first() else {
            continue;
        };
        let own = &mut moduli[body_of[corner as usize] as usize];
        *own = own.min(resolved.materials[usize::from(material)].law.shear_modulus);
    }
    moduli
}

/// The motion `[size]` of all nodes that are not held by the translations of their bodies; none where these
/// are zero.
fn carried(
    model: &Model<'_>,
    body_of: &[u32],
    translations: &[[f64; 3]],
    size: usize,
) -> Option<Vec<f64>> {
    let space = &model.prepared.space;
    let c = space.components;
    translations.iter().flatten().find(|size| **size != 0.0)?;
    let mut moved = vec![0.0; size];
    for (node, body) in moved.chunks_exact_mut(c).zip(body_of) {
        node.copy_from_slice(&translations[*body as usize][..c]);
    }
    mask(&model.prepared.held, &mut moved);
    Some(moved)
}

/// Translation of each body; zero in components in which what is held of it does not move as one.
fn translations(model: &Model<'_>, body_of: &[u32], motion: &[f64]) -> Vec<[f64; 3]> {
    let c = model.prepared.space.components;
    let count = body_of.iter().max().map_or(0, |&last| last as usize + 1);
    let mut ranges = vec![[NOTHING; 3]; count];
    for &entry in model.prepared.held.entries.iter() {
        let (node, i) = (entry as usize / c, entry as usize % c);
        if let Some(&body) = body_of.get(node) {
            let [least, most] = &mut ranges[body as usize][i];
            *least = least.min(motion[entry as usize]);
            *most = most.max(motion[entry as usize]);
        }
    }
    // Nothing carries a body away from its axis.
    let radial = usize::from(model.plan.is_axisymmetric());
    let own = |ranges: &[Range; 3]| -> [f64; 3] {
        std::array::from_fn(|i| if i < radial { 0.0 } else { common(ranges[i]) })
    };
    ranges.iter().map(own).collect()
}

/// What all of a range is, to rounding; zero where it differs, or nothing is in it.
fn common([least, most]: Range) -> f64 {
    let size = least.abs().max(most.abs());
    let is_one = size.is_finite() && most - least <= SAME * size;
    if is_one { least } else { 0.0 }
}
