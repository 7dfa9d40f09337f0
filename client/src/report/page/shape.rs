//! A surface before it is written down: nodes, their numbers, triangles and rim.

pub(super) type Vector = [f64; 3];

/// A surface before it is written down.
#[derive(Debug, Default)]
pub(super) struct Surface {
    pub(super) points: Vec<Vector>,
    pub(super) displacement: Option<Vec<Vector>>,
    pub(super) fields: Vec<(String, Vec<f64>)>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) rim: Vec<[u32; 2]>,
}
