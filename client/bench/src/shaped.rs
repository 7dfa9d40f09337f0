//! Cubes with poor cells, and with a second material.
//!
//! [`shaped`] changes the text of [`crate::cube::msh`]: the place of each vertex, and
//! the group of each cell. Nothing else depends on them.

/// What is done to the unit cube.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shape {
    /// Nothing.
    Plain,
    /// Heights divided by this: flat cells.
    Flat(u32),
    /// Heights multiplied by this: tall cells.
    Tall(u32),
    /// Inner vertices moved by up to 30 % of a cell along each axis, by a fixed
    /// pattern: with 8 cells an edge the thinnest cell keeps 7 % of its volume.
    Slivers,
    /// A second material between a quarter and three quarters of the height, along
    /// the cells where their number is a multiple of four.
    Layer,
    /// A second material in a ball about the middle, across the cells.
    Ball,
}

/// Largest move of a vertex of slivers, in cell sizes.
const MOVE: f64 = 0.3;

/// The cube of `count`^3 cells in another shape; `text` is that of the plain one.
pub(crate) fn shaped(text: &str, count: u32, shape: Shape) -> String {
    if shape == Shape::Plain {
        return text.to_owned();
    }
    let mut places: Vec<[f64; 3]> = Vec::new();
    let mut section = "";
    let mut changed = String::with_capacity(text.len() + 64);
    for line in text.lines() {
        if line.starts_with('$') {
            section = line;
        }
        let line = match section {
            "$PhysicalNames" => name(line, shape),
            "$Nodes" => vertex(line, count, shape, &mut places),
            "$Elements" => cell(line, shape, &places),
            _ => line.to_owned(),
        };
        changed.push_str(&line);
        changed.push('\n');
    }
    changed
}

fn has_two_materials(shape: Shape) -> bool {
    match shape {
        Shape::Plain | Shape::Flat(_) | Shape::Tall(_) | Shape::Slivers => false,
        Shape::Layer | Shape::Ball => true,
    }
}

/// The group of the second material stands behind that of the first.
fn name(line: &str, shape: Shape) -> String {
    match line {
        "7" if has_two_materials(shape) => "8".to_owned(),
        "3 1 \"body\"" if has_two_materials(shape) => format!("{line}\n3 2 \"inclusion\""),
        line => line.to_owned(),
    }
}

fn vertex(line: &str, count: u32, shape: Shape, places: &mut Vec<[f64; 3]>) -> String {
    let words: Vec<&str> = line.split(' ').collect();
    let [number, x, y, z] = words.as_slice() else {
        return line.to_owned();
    };
    let place = [x, y, z].map(|word| word.parse().unwrap_or_default());
    let place = moved(place, number.parse().unwrap_or_default(), count, shape);
    places.push(place);
    let [x, y, z] = place;
    format!("{number} {x} {y} {z}")
}

fn moved(place: [f64; 3], number: u64, count: u32, shape: Shape) -> [f64; 3] {
    let [x, y, z] = place;
    match shape {
        Shape::Plain | Shape::Layer | Shape::Ball => place,
        Shape::Flat(ratio) => [x, y, z / f64::from(ratio)],
        Shape::Tall(ratio) => [x, y, z * f64::from(ratio)],
        Shape::Slivers => {
            let inside = |component: f64| component > 1e-9 && component < 1.0 - 1e-9;
            if !place.into_iter().all(inside) {
                return place;
            }
            let step = MOVE / f64::from(count);
            let axes = [0, 1, 2].map(|axis| step * noise(3 * number + axis));
            [x + axes[0], y + axes[1], z + axes[2]]
        }
    }
}

/// A number between -1 and 1 that follows from another one alone.
pub(crate) fn noise(number: u64) -> f64 {
    let mut bits = number.wrapping_mul(0x9E37_79B9_7F4A_7C15);
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    bits ^= bits >> 27;
    (bits >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// A tetrahedron whose centre lies in the second material changes its group.
fn cell(line: &str, shape: Shape, places: &[[f64; 3]]) -> String {
    let words: Vec<&str> = line.split(' ').collect();
    let [number, "4", "2", "1", "1", corners @ ..] = words.as_slice() else {
        return line.to_owned();
    };
    let mut centre = [0.0; 3];
    for corner in corners {
        let index: usize = corner.parse().unwrap_or(1);
        let place = places.get(index.saturating_sub(1)).copied();
        for (sum, part) in centre.iter_mut().zip(place.unwrap_or_default()) {
            *sum += 0.25 * part;
        }
    }
    if is_second(centre, shape) {
        format!("{number} 4 2 2 2 {}", corners.join(" "))
    } else {
        line.to_owned()
    }
}

fn is_second([x, y, z]: [f64; 3], shape: Shape) -> bool {
    match shape {
        Shape::Plain | Shape::Flat(_) | Shape::Tall(_) | Shape::Slivers => false,
        Shape::Layer => (0.25..0.75).contains(&z),
        Shape::Ball => {
            let square = |a: f64| (a - 0.5).powi(2);
            square(x) + square(y) + square(z) < 0.3_f64.powi(2)
        }
    }
}

#[cfg(test)]
mod tests {
    use signorini_client::formats::msh::{self, MeshFile};

    use super::*;
    use crate::cube;

    fn read(shape: Shape) -> MeshFile {
        msh::read(shaped(&cube::msh(8), 8, shape).as_bytes()).unwrap()
    }

    fn volumes(mesh: &MeshFile) -> Vec<f64> {
        let corner = |vertex: u32| mesh.coordinates[vertex as usize];
        let volume = |cell: &[u32]| {
            let origin = corner(cell[0]);
            let edge = |local: usize| {
                let end = corner(cell[local]);
                [0, 1, 2].map(|i| end[i] - origin[i])
            };
            let [u, v, w] = [edge(1), edge(2), edge(3)];
            let minor = |i: usize, j: usize| v[i] * w[j] - v[j] * w[i];
            (u[0] * minor(1, 2) - u[1] * minor(0, 2) + u[2] * minor(0, 1)) / 6.0
        };
        mesh.cells.chunks(4).map(volume).collect()
    }

    #[test]
    fn flat_and_tall_cubes_have_their_volume() {
        for (shape, volume) in [
            (Shape::Plain, 1.0),
            (Shape::Flat(100), 0.01),
            (Shape::Tall(10), 10.0),
        ] {
            let total: f64 = volumes(&read(shape)).iter().sum();
            assert!((total - volume).abs() < 1e-9 * volume, "{shape:?} {total}");
        }
    }

    #[test]
    fn slivers_are_thin_but_not_turned_over() {
        let volumes = volumes(&read(Shape::Slivers));
        let least = volumes.iter().copied().fold(f64::INFINITY, f64::min);
        let mean = volumes.iter().sum::<f64>() / volumes.len() as f64;
        assert!(least > 0.0 && least < 0.1 * mean, "{least} {mean}");
    }

    #[test]
    fn a_second_material_takes_a_part_of_the_cells() {
        for (shape, share) in [(Shape::Layer, 0.5), (Shape::Ball, 0.113)] {
            let mesh = read(shape);
            let cells = |name: &str| {
                let group = mesh.groups.iter().find(|group| group.name == name);
                group.map_or(0, |group| group.members.len()) as f64
            };
            let found = cells("inclusion") / (cells("inclusion") + cells("body"));
            assert!((found - share).abs() < 0.02, "{shape:?} {found}");
        }
    }
}
