//! STL as text, in any case and spacing:
//!
//! ```text
//! solid NAME?  ( facet normal n n n  outer loop  vertex x y z (3)  endloop  endfacet )*  endsolid NAME?
//! ```
//!
//! and any number of solids. Normals are not read. A name may be anything up to the end of its
//! line.

use super::{StlError, pick};
use crate::formats::vtp::{cross, dot};

/// The words of a file with the numbers of their lines.
struct Words<'a> {
    lines: std::iter::Enumerate<std::str::Lines<'a>>,
    words: std::str::SplitWhitespace<'a>,
    /// Of the present words, from 1.
    line: usize,
    /// Facets that were read.
    facets: usize,
}

/// The corners of all facets of all solids, in the order of the file.
pub(super) fn corners(text: &str) -> Result<Vec<[[f64; 3]; 3]>, StlError> {
    let mut words = Words {
        lines: text.lines().enumerate(),
        words: "".split_whitespace(),
        line: 0,
        facets: 0,
    };
    let mut corners = Vec::new();
    while let Some(word) = words.next() {
        words.is(word, "solid")?;
        words.skip_line();
        loop {
            let word = words.some("facet or endsolid")?;
            if word.eq_ignore_ascii_case("endsolid") {
                break;
            }
            words.is(word, "facet")?;
            corners.push(words.facet()?);
            words.facets += 1;
        }
        words.skip_line();
    }
    Ok(corners)
}

/// One solid of facets given by their corners.
pub(super) fn write(facets: impl Iterator<Item = [[f64; 3]; 3]>) -> String {
    let mut text = "solid\n".to_owned();
    for facet in facets {
        let [x, y, z] = normal(facet);
        text += &format!("facet normal {x:.6} {y:.6} {z:.6}\nouter loop\n");
        for [x, y, z] in facet {
            text += &format!("vertex {x} {y} {z}\n");
        }
        text += "endloop\nendfacet\n";
    }
    text + "endsolid\n"
}

/// Unit normal of a facet; that of one without a size is zero.
fn normal([a, b, c]: [[f64; 3]; 3]) -> [f64; 3] {
    let side = |to: [f64; 3]| pick(to, a, |to, from| to - from);
    let across = cross(side(b), side(c));
    let length = dot(across, across).sqrt();
    let is_flat = length > 0.0;
    across.map(|x| if is_flat { x / length } else { 0.0 })
}

impl<'a> Words<'a> {
    fn next(&mut self) -> Option<&'a str> {
        loop {
            if let Some(word) = self.words.next() {
                return Some(word);
            }
            let (index, line) = self.lines.next()?;
            (self.line, self.words) = (index + 1, line.split_whitespace());
        }
    }

    /// Leaves the rest of the line.
    fn skip_line(&mut self) {
        self.words = "".split_whitespace();
    }

    /// What follows `facet`.
    fn facet(&mut self) -> Result<[[f64; 3]; 3], StlError> {
        self.expect("normal")?;
        for _ in 0..3 {
            self.some("a component of the normal")?;
        }
        self.expect("outer")?;
        self.expect("loop")?;
        let mut facet = [[0.0; 3]; 3];
        for corner in &mut facet {
            self.expect("vertex")?;
            for x in corner {
                *x = self.number()?;
            }
        }
        self.expect("endloop")?;
        self.expect("endfacet")?;
        Ok(facet)
    }

    fn number(&mut self) -> Result<f64, StlError> {
        let word = self.some("a coordinate")?;
        word.parse()
            .map_err(|_| self.wrong(&format!("a coordinate is expected, not `{}`", short(word))))
    }

    fn expect(&mut self, expected: &str) -> Result<(), StlError> {
        let word = self.some(expected)?;
        self.is(word, expected)
    }

    fn is(&self, word: &str, expected: &str) -> Result<(), StlError> {
        if word.eq_ignore_ascii_case(expected) {
            Ok(())
        } else {
            Err(self.wrong(&format!("`{expected}` is expected, not `{}`", short(word))))
        }
    }

    fn some(&mut self, expected: &str) -> Result<&'a str, StlError> {
        self.next()
            .ok_or_else(|| self.wrong(&format!("the file ends where `{expected}` is expected")))
    }

    fn wrong(&self, said: &str) -> StlError {
        StlError::Unreadable {
            facet: self.facets,
            said: format!("line {}: {said}", self.line),
        }
    }
}

/// As much of a word as a message holds.
fn short(word: &str) -> String {
    word.chars().take(20).collect()
}
