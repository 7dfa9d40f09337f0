//! A tree of boxes: which of many small faces may lie in a region.
//!
//! Boxes are halved at the median along the longest side of what they fill, ties by their numbers, so
//! that the same boxes make the same tree. What is found comes in ascending order. Cost: n log n to
//! make, log n and what is found to ask.

/// Boxes of a leaf at most.
const LEAF: usize = 4;

/// Lower and upper corner, coordinates beyond the dimension zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Least coordinates.
    pub low: [f64; 3],
    /// Largest coordinates.
    pub high: [f64; 3],
}

impl Bounds {
    /// Nothing.
    pub const NONE: Self = Self {
        low: [f64::INFINITY; 3],
        high: [f64::NEG_INFINITY; 3],
    };

    /// Those of some points.
    pub fn of(points: impl IntoIterator<Item = [f64; 3]>) -> Self {
        let point = |x| Self { low: x, high: x };
        let points = points.into_iter().map(point);
        points.fold(Self::NONE, |all, one| all.with(&one))
    }

    /// Those of both.
    pub fn with(&self, other: &Self) -> Self {
        Self {
            low: std::array::from_fn(|i| self.low[i].min(other.low[i])),
            high: std::array::from_fn(|i| self.high[i].max(other.high[i])),
        }
    }

    /// Whether both have a point in common; never where a coordinate is not a number.
    pub fn meets(&self, other: &Self) -> bool {
        (0..3).all(|i| self.low[i] <= other.high[i] && other.low[i] <= self.high[i])
    }

    /// Distance of the corners; zero of nothing.
    pub fn diagonal(&self) -> f64 {
        let sides = (0..3).map(|i| (self.high[i] - self.low[i]).max(0.0));
        sides.map(|side| side * side).sum::<f64>().sqrt()
    }

    /// Their centre.
    pub fn centre(&self) -> [f64; 3] {
        std::array::from_fn(|axis| self.middle(axis))
    }

    fn middle(&self, axis: usize) -> f64 {
        0.5 * (self.low[axis] + self.high[axis])
    }

    fn longest(&self) -> usize {
        let side = |axis: usize| self.high[axis] - self.low[axis];
        (0..3).fold(
            0,
            |best, axis| if side(axis) > side(best) { axis } else { best },
        )
    }
}

/// A node: what it fills, and its part of the order or its two halves.
#[derive(Clone, Debug)]
struct Node {
    bounds: Bounds,
    content: Content,
}

#[derive(Clone, Debug)]
enum Content {
    Boxes(Vec<u32>),
    Halves([usize; 2]),
}

/// The tree of some boxes.
#[derive(Clone, Debug)]
pub struct BoxTree {
    boxes: Vec<Bounds>,
    /// The root is the last one.
    nodes: Vec<Node>,
}

impl BoxTree {
    /// Of `boxes`, known by their places.
    pub fn new(boxes: Vec<Bounds>) -> Self {
        let mut tree = Self {
            nodes: Vec::with_capacity(boxes.len()),
            boxes,
        };
        let all = (0..tree.boxes.len() as u32).collect();
        tree.add(all);
        tree
    }

    /// Adds the node of some boxes; its place.
    fn add(&mut self, mut own: Vec<u32>) -> usize {
        let filled = own.iter().map(|&one| self.boxes[one as usize]);
        let bounds = filled.fold(Bounds::NONE, |all, one| all.with(&one));
        let content = if own.len() <= LEAF {
            Content::Boxes(own)
        } else {
            let axis = bounds.longest();
            let middle = |one: &u32| self.boxes[*one as usize].middle(axis);
            own.sort_by(|a, b| middle(a).total_cmp(&middle(b)).then(a.cmp(b)));
            let upper = own.split_off(own.len() / 2);
            Content::Halves([self.add(own), self.add(upper)])
        };
        self.nodes.push(Node { bounds, content });
        self.nodes.len() - 1
    }

    /// The boxes that meet `region`, ascending.
    pub fn meeting(&self, region: &Bounds) -> Vec<u32> {
        self.meeting_where(&|bounds| bounds.meets(region))
    }

    /// The boxes that meet a region, ascending: whether bounds do is told for single boxes and for what
    /// encloses some.
    pub fn meeting_where(&self, meets: &dyn Fn(&Bounds) -> bool) -> Vec<u32> {
        let mut found = Vec::new();
        let mut open = vec![self.nodes.len() - 1];
        while let Some(node) = open.pop() {
            let node = &self.nodes[node];
            if !meets(&node.bounds) {
                continue;
            }
            match &node.content {
                Content::Halves(halves) => open.extend(halves),
                Content::Boxes(own) => {
                    let own = own.iter();
                    found.extend(own.filter(|&&one| meets(&self.boxes[one as usize])));
                }
            }
        }
        found.sort_unstable();
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers in \[0, 1) that follow each other without order.
    fn scattered(count: usize) -> Vec<f64> {
        let step = |k: usize| (k as f64 * 0.754_877_666_246_693).fract();
        (1..=count).map(step).collect()
    }

    fn some_boxes(count: usize) -> Vec<Bounds> {
        let numbers = scattered(6 * count);
        let own = numbers.chunks_exact(6);
        own.map(|x| {
            let low = [x[0], x[1], 0.0];
            Bounds {
                low,
                high: [x[0] + 0.1 * x[2], x[1] + 0.1 * x[3], 0.0],
            }
        })
        .collect()
    }

    #[test]
    fn a_tree_finds_what_looking_at_all_boxes_finds() {
        for count in [0, 1, 4, 5, 9, 200] {
            let boxes = some_boxes(count);
            let tree = BoxTree::new(boxes.clone());
            for region in some_boxes(30) {
                let all = (0..count as u32).filter(|&one| boxes[one as usize].meets(&region));
                assert_eq!(tree.meeting(&region), all.collect::<Vec<u32>>());
            }
        }
    }

    #[test]
    fn equal_boxes_and_numbers_that_are_none_do_no_harm() {
        let one = Bounds::of([[0.5; 3], [0.6; 3]]);
        let tree = BoxTree::new(vec![one; 20]);
        assert_eq!(tree.meeting(&one).len(), 20);
        let none = Bounds::of([[f64::NAN; 3]]);
        assert!(BoxTree::new(vec![none; 9]).meeting(&one).is_empty());
    }
}
