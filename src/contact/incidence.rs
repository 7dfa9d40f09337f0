//! Which faces meet at each multiplier or node of a surface, so that sums over faces
//! run row by row, in parallel, each in the order of the faces.
//!
//! Cost: some words a face, once per surface.

/// A row's place on a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Place {
    /// Position of the face in the list of the surface.
    pub(super) face: u32,
    /// Position of the row among the rows of the face itself.
    pub(super) slot: u32,
}

/// The places of every row, faces ascending.
#[derive(Clone, Debug, Default)]
pub(super) struct Incidence {
    /// Start of each row in `places` `[rows + 1]`.
    starts: Vec<usize>,
    /// Places of all rows one after the other; within a row faces ascend, so that sums
    /// keep one order.
    places: Vec<Place>,
}

impl Incidence {
    /// Of `rows` rows; `faces` gives the rows of each face.
    pub(super) fn new<'a>(rows: usize, faces: impl Iterator<Item = &'a [u32]> + Clone) -> Self {
        let mut starts = vec![0; rows + 1];
        for &row in faces.clone().flatten() {
            starts[row as usize + 1] += 1;
        }
        for row in 0..rows {
            starts[row + 1] += starts[row];
        }
        let mut next = starts.clone();
        let mut places = vec![Place { face: 0, slot: 0 }; starts[rows]];
        for (face, own) in faces.enumerate() {
            for (slot, &row) in own.iter().enumerate() {
                places[next[row as usize]] = Place {
                    face: face as u32,
                    slot: slot as u32,
                };
                next[row as usize] += 1;
            }
        }
        Self { starts, places }
    }

    /// Places of one row.
    pub(super) fn of(&self, row: usize) -> &[Place] {
        &self.places[self.starts[row]..self.starts[row + 1]]
    }
}

/// The nodes that each row couples to, and where the nodes of its faces are among them.
#[derive(Clone, Debug, Default)]
pub(super) struct Couplings {
    /// Start of each row in `nodes` `[rows + 1]`.
    starts: Vec<usize>,
    /// Displacement nodes of each row, ascending.
    nodes: Vec<u32>,
    /// Start of each row in `positions` `[rows + 1]`.
    position_starts: Vec<usize>,
    /// Position within the row of every node of every face at the row, place after
    /// place `[nodes of a face]`: sums go to their entry without a search.
    positions: Vec<u32>,
}

impl Couplings {
    /// Of `rows` rows with their faces; `nodes` gives the nodes of a face.
    pub(super) fn new<'a>(
        rows: usize,
        incidence: &Incidence,
        nodes: impl Fn(u32) -> &'a [u32],
    ) -> Self {
        let mut out = Self {
            starts: vec![0],
            position_starts: vec![0],
            ..Self::default()
        };
        let mut own = Vec::new();
        for row in 0..rows {
            own.clear();
            let places = incidence.of(row);
            own.extend(places.iter().flat_map(|place| nodes(place.face)));
            own.sort_unstable();
            own.dedup();
            for node in places.iter().flat_map(|place| nodes(place.face)) {
                let position = own.partition_point(|other| other < node);
                out.positions.push(position as u32);
            }
            out.nodes.extend_from_slice(&own);
            out.starts.push(out.nodes.len());
            out.position_starts.push(out.positions.len());
        }
        out
    }

    /// Nodes of a row, ascending.
    pub(super) fn nodes(&self, row: usize) -> &[u32] {
        &self.nodes[self.starts[row]..self.starts[row + 1]]
    }

    /// Positions among them, place by place `[nodes of a face]`.
    pub(super) fn positions(&self, row: usize) -> &[u32] {
        &self.positions[self.position_starts[row]..self.position_starts[row + 1]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FACES: [[u32; 3]; 3] = [[0, 2, 1], [3, 1, 2], [4, 3, 2]];

    #[test]
    fn a_row_knows_its_faces_in_their_order() {
        let incidence = Incidence::new(6, FACES.iter().map(|face| &face[..]));
        let of = |row: usize| -> Vec<(u32, u32)> {
            let places = incidence.of(row).iter();
            places.map(|place| (place.face, place.slot)).collect()
        };
        assert_eq!(of(0), [(0, 0)]);
        assert_eq!(of(2), [(0, 1), (1, 2), (2, 2)]);
        assert_eq!(of(3), [(1, 0), (2, 1)]);
        assert_eq!(of(5), []);
    }

    #[test]
    fn a_row_couples_to_the_nodes_of_its_faces_once() {
        let incidence = Incidence::new(6, FACES.iter().map(|face| &face[..]));
        let couplings = Couplings::new(6, &incidence, |face| &FACES[face as usize]);
        assert_eq!(couplings.nodes(1), [0, 1, 2, 3]);
        assert_eq!(couplings.positions(1), [0, 2, 1, 3, 1, 2]);
        assert!(couplings.nodes(5).is_empty());
    }
}
