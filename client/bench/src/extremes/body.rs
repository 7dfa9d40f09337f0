//! Bodies of the trials, by a few words: what the catalogue calls its meshes.
//!
//! `box 4 4 4 of 1 1 0.1` has 4 cells each way and those lengths, `plane 24 3` is a
//! rectangle, `disc 9 of 2.665 0.3` has nine rings and that radius and starts at that angle,
//! `cell` is one tetrahedron, `gmsh indent 1` is a mesh that the program carries, `file NAME` one of
//! the tests. A
//! last word changes the body: see [`Form`].

use std::f64::consts::PI;
use std::str::FromStr;

use super::draft::{Draft, Named, cuboid, disc, square};
use super::of_tests::mesh_of_tests;
use crate::workshop::shipped;

/// Where the middle of an O-ring lies.
const RING: f64 = 27.665;

/// What is done to a straight body.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Form {
    /// Nothing.
    Straight,
    /// Inner vertices moved at random by up to 30 % of a cell.
    Slivers,
    /// Two materials, left and right of the middle.
    Halves,
    /// A second material between a quarter and three quarters of the height.
    Layer,
    /// A second material in a ball about the middle.
    Ball,
    /// A column whose middle stands beside its ends by this share of its width.
    Bowed(f64),
    /// A quarter of a ring of radii 1 and 2.
    Shell,
    /// Half of a tube of radii 10 and 20, turned about the third axis.
    Bush,
    /// The upper half of a disc that starts at zero.
    Half,
    /// Cells numbered the other way.
    Turned,
    /// A vertex that no cell uses.
    Spare,
    /// Two bodies: no vertex of the upper half is one of the lower half.
    Apart,
}

/// The words.
#[derive(Clone, Copy, Debug)]
enum Kind {
    Cuboid([u32; 3]),
    Square([u32; 2]),
    Disc(u32),
    Cell,
    File(&'static [u8]),
}

/// A body.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    kind: Kind,
    sizes: [f64; 3],
    form: Form,
}

impl FromStr for Body {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let fault = || format!("body \"{text}\"");
        let (main, form) = text.split_once(", ").unwrap_or((text, ""));
        let (counts, sizes) = main.split_once(" of ").unwrap_or((main, ""));
        let words: Vec<&str> = counts.split(' ').collect();
        Ok(Self {
            kind: kind(&words).ok_or_else(fault)?,
            sizes: lengths(sizes).ok_or_else(fault)?,
            form: form_of(form).ok_or_else(fault)?,
        })
    }
}

fn kind(words: &[&str]) -> Option<Kind> {
    let count = |word: &str| word.parse::<u32>().ok().filter(|count| *count > 0);
    Some(match *words {
        ["box", x, y, z] => Kind::Cuboid([count(x)?, count(y)?, count(z)?]),
        ["plane", x, y] => Kind::Square([count(x)?, count(y)?]),
        ["disc", rings] => Kind::Disc(count(rings)?),
        ["cell"] => Kind::Cell,
        ["gmsh", prefix, level] => Kind::File(shipped(prefix, count(level)?)?),
        ["file", name] => Kind::File(mesh_of_tests(name)?),
        _ => return None,
    })
}

/// Lengths, of one where nothing is said.
fn lengths(text: &str) -> Option<[f64; 3]> {
    let mut lengths = [1.0; 3];
    for (length, word) in lengths.iter_mut().zip(text.split_whitespace()) {
        *length = word.parse().ok()?;
    }
    Some(lengths)
}

fn form_of(text: &str) -> Option<Form> {
    if let Some(bow) = text.strip_prefix("bowed ") {
        return bow.parse().ok().map(Form::Bowed);
    }
    Some(match text {
        "" => Form::Straight,
        "slivers" => Form::Slivers,
        "halves" => Form::Halves,
        "layer" => Form::Layer,
        "ball" => Form::Ball,
        "shell" => Form::Shell,
        "bush" => Form::Bush,
        "half" => Form::Half,
        "turned" => Form::Turned,
        "spare" => Form::Spare,
        "apart" => Form::Apart,
        _ => return None,
    })
}

impl Body {
    /// The mesh file.
    pub(crate) fn msh(&self) -> Vec<u8> {
        let draft = match self.kind {
            Kind::File(bytes) => return bytes.to_vec(),
            Kind::Cuboid(counts) => cuboid(counts),
            Kind::Square(counts) => square(counts),
            Kind::Disc(rings) => disc(rings, self.sizes[1]),
            Kind::Cell => cell(),
        };
        self.named(draft).msh().into_bytes()
    }

    fn named(&self, mut draft: Draft) -> Named {
        if self.form == Form::Half {
            let whole = draft.clone();
            draft.cells.retain(|cell| whole.middle(cell)[1] > 0.0);
        }
        let skin = draft.skin();
        let side = |facet: &Vec<u32>| (self.side(draft.middle(facet)), facet.clone());
        let sides: Vec<(&str, Vec<u32>)> = skin.iter().map(side).collect();
        let group = |cell: &Vec<u32>| (self.group(draft.middle(cell)), cell.clone());
        let cells: Vec<(&str, Vec<u32>)> = draft.cells.iter().map(group).collect();
        let mut named = Named {
            points: self.places(&draft),
            corners: draft.cells.first().map_or(0, Vec::len),
            elements: [sides, cells].concat(),
        };
        self.spoil(&mut named, &draft);
        named
    }

    /// The group of a facet by its middle in unit coordinates.
    fn side(&self, middle: [f64; 3]) -> &'static str {
        const NAMES: [[&str; 2]; 3] = [["x0", "x1"], ["y0", "y1"], ["z0", "z1"]];
        if matches!(self.kind, Kind::Disc(_)) {
            let is_cut = self.form == Form::Half && middle[1].abs() < 1e-9;
            return if is_cut { "y0" } else { "skin" };
        }
        let flat = matches!(self.kind, Kind::Square(_));
        let axes = if flat { 2 } else { 3 };
        for (place, [low, high]) in middle.into_iter().zip(NAMES).take(axes) {
            if place < 1e-9 {
                return low;
            }
            if place > 1.0 - 1e-9 {
                return high;
            }
        }
        "slanted"
    }

    /// The group of a cell by its middle in unit coordinates.
    fn group(&self, middle: [f64; 3]) -> &'static str {
        let [x, _, z] = middle;
        let square = |place: f64| (place - 0.5).powi(2);
        let radius = middle.map(square).iter().sum::<f64>().sqrt();
        let has = |form: Form, inside: bool| self.form == form && inside;
        if self.form == Form::Halves {
            return if x < 0.5 { "left" } else { "right" };
        }
        let is_second = has(Form::Layer, (0.25..0.75).contains(&z));
        if is_second || has(Form::Ball, radius < 0.3) {
            "inclusion"
        } else {
            "body"
        }
    }

    fn places(&self, draft: &Draft) -> Vec<[f64; 3]> {
        let cells = if let Kind::Cuboid([count, ..]) = self.kind {
            f64::from(count)
        } else {
            1.0
        };
        let points = draft.points.iter().enumerate();
        let place =
            |(index, point): (usize, &[f64; 3])| self.place(*point, index as u64 + 1, cells);
        points.map(place).collect()
    }

    fn place(&self, point: [f64; 3], number: u64, cells: f64) -> [f64; 3] {
        let [x, y, z] = point;
        let [wide, high, deep] = self.sizes;
        if matches!(self.kind, Kind::Disc(_)) {
            return [RING + wide * x, wide * y, 0.0];
        }
        match self.form {
            Form::Shell => turned(1.0 + x, 0.5 * PI * y, 0.0),
            Form::Bush => turned(10.0 + 10.0 * x, PI * y, deep * z),
            Form::Bowed(bow) => {
                let beside = bow * (0.5 - 0.5 * (2.0 * PI * y).cos());
                [wide * x + beside, high * y, 0.0]
            }
            Form::Slivers => slivers(point, number, cells),
            Form::Straight
            | Form::Halves
            | Form::Layer
            | Form::Ball
            | Form::Half
            | Form::Turned
            | Form::Spare
            | Form::Apart => [wide * x, high * y, deep * z],
        }
    }

    /// What makes the mesh a poor one.
    fn spoil(&self, named: &mut Named, draft: &Draft) {
        let corners = named.corners;
        let all = &mut named.elements;
        if self.form == Form::Turned {
            let cells = all.iter_mut().filter(|(_, cell)| cell.len() == corners);
            cells.for_each(|(_, cell)| cell.swap(0, 1));
        } else if self.form == Form::Spare {
            named.points.push([7.0; 3]);
        } else if self.form == Form::Apart {
            let count = named.points.len() as u32;
            named.points.extend_from_within(..);
            for (_, corners) in all {
                let [_, _, z] = draft.middle(corners);
                let shift = if z > 0.5 { count } else { 0 };
                corners.iter_mut().for_each(|corner| *corner += shift);
            }
        }
    }
}

fn cell() -> Draft {
    Draft {
        points: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        cells: vec![vec![0, 1, 2, 3]],
    }
}

fn turned(radius: f64, angle: f64, z: f64) -> [f64; 3] {
    [radius * angle.cos(), radius * angle.sin(), z]
}

/// Inner vertices moved by a fixed pattern.
fn slivers(point: [f64; 3], number: u64, cells: f64) -> [f64; 3] {
    let inside = |part: f64| part > 1e-9 && part < 1.0 - 1e-9;
    if !point.into_iter().all(inside) {
        return point;
    }
    let [x, y, z] = point;
    let axes = [0, 1, 2].map(|axis| 0.3 / cells * crate::shaped::noise(3 * number + axis));
    [x + axes[0], y + axes[1], z + axes[2]]
}

#[cfg(test)]
mod tests {
    use signorini_client::formats::msh;

    use super::*;

    #[test]
    fn bodies_are_read_as_the_client_reads_them() {
        for (text, cells, facets) in [
            ("box 2 2 2 of 1 1 0.1", 48, 48),
            ("box 4 4 4, halves", 384, 192),
            ("plane 3 2 of 8 1, bowed 0.1", 12, 10),
            ("disc 3 of 2.665 0.3", 54, 18),
            ("disc 3 of 2.665 0, half", 27, 15),
            ("cell", 1, 4),
            ("box 2 2 2, apart", 48, 64),
        ] {
            let body: Body = text.parse().unwrap();
            let mesh = msh::read(&body.msh()).unwrap();
            assert_eq!(mesh.cell_count(), cells, "{text}");
            assert!(mesh.facet_count() == facets || text.contains("apart"));
        }
        for text in [
            "",
            "box 2 2",
            "box 0 1 1",
            "box 1 1 1, round",
            "gmsh indent 9",
        ] {
            assert!(text.parse::<Body>().is_err(), "{text}");
        }
    }
}
