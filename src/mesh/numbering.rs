//! The used numbering: uploaded vertices without those that no cell has, in the
//! same order. Two arrays, two passes.

/// Which uploaded vertices cells use.
pub(super) struct Numbering {
    /// Uploaded number of each used vertex, ascending.
    pub(super) used: Vec<u32>,
    /// Used number of each uploaded vertex; an unused one has `u32::MAX`, which
    /// no cell has and so no facet lookup finds.
    numbers: Vec<u32>,
}

impl Numbering {
    pub(super) fn new(cells: &[u32], vertex_count: usize) -> Self {
        let mut numbers = vec![u32::MAX; vertex_count];
        for &vertex in cells {
            numbers[vertex as usize] = 0;
        }
        let mut used = Vec::with_capacity(vertex_count);
        for (number, uploaded) in numbers.iter_mut().zip(0_u32..) {
            if *number == 0 {
                *number = used.len() as u32;
                used.push(uploaded);
            }
        }
        Self { used, numbers }
    }

    pub(super) fn select(&self, coordinates: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let used = self.used.iter();
        used.map(|&vertex| coordinates[vertex as usize]).collect()
    }

    pub(super) fn renumber(&self, mut vertices: Vec<u32>) -> Vec<u32> {
        for vertex in &mut vertices {
            *vertex = self.numbers[*vertex as usize];
        }
        vertices
    }

    pub(super) fn warnings(&self, uploaded: usize) -> Vec<String> {
        match uploaded - self.used.len() {
            0 => Vec::new(),
            1 => vec!["1 vertex belongs to no cell and is dropped".to_owned()],
            dropped => vec![format!(
                "{dropped} vertices belong to no cell and are dropped"
            )],
        }
    }
}
