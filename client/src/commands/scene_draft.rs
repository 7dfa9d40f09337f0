//! A commented scene for a mesh: held where its lowest group is flat, pressed by a plate
//! from above. A body with one skin lies between two plates.

use std::fmt::Write as _;

use signorini_client::formats::inp::scene::DeckScene;
use signorini_client::formats::msh::{MeshFile, MeshGroup};
use toml::Value;

use crate::commands::deck_draft::Deck;
use crate::commands::mesh_shape::{Shape, group_box};

/// Of the body's height: what still counts as a plane.
const FLAT: f64 = 1e-6;

/// A mesh as the draft sees it.
struct Body<'a> {
    mesh: &'a MeshFile,
    shape: Shape,
    /// Index of the axis that points up: z of a solid, y of a section.
    up: usize,
}

/// The text of a scene whose mesh is called `named`, and comes from a deck that says more.
pub(crate) fn draft(mesh: &MeshFile, named: &str, deck: Option<&DeckScene>) -> String {
    let mut deck = deck.map(|deck| Deck::new(mesh, deck));
    let up = mesh.vertices_per_cell - 2;
    let shape = Shape::of(mesh);
    let body = Body { mesh, shape, up };
    let mut text = format!(
        "# Units are yours, one set throughout; named here they stand beside the numbers.\n\
         # units = {{ length = \"mm\", force = \"N\", stress = \"MPa\" }}\nmesh = {}\n",
        quoted(named)
    );
    let section = deck.as_ref().filter(|_| mesh.vertices_per_cell == 3);
    let kind = section.and_then(Deck::kind);
    text.push_str(kind.as_deref().unwrap_or(body.kind()));
    text.push_str(&body.materials(deck.as_ref()));
    let conditions = deck.as_mut().and_then(Deck::conditions);
    text.push_str(&conditions.unwrap_or_else(|| body.surfaces()));
    text.push_str(LAST);
    text.push_str(&deck.map(|deck| deck.list()).unwrap_or_default());
    text
}

const LAST: &str = "
# Displacement and pressure at a point of the undeformed body.
# [[probe]]
# name = \"tip\"
# point = [0.0, 0.0, 0.0]

# Fields of the files for ParaView; left out: the first five.
# [output]
# fields = [\"displacement\", \"pressure\", \"contact_pressure\", \"gap\", \"contact_state\", \"stress\"]
";

impl Body<'_> {
    fn kind(&self) -> &'static str {
        let [left, _, _] = self.shape.low;
        match (self.mesh.vertices_per_cell, left > 0.0) {
            (3, true) => {
                "kind = \"axisymmetric\"  # turned about the axis x = 0; or \"plane-strain\"\n"
            }
            (3, false) => {
                "kind = \"plane-strain\"  # per unit thickness; \"axisymmetric\" turns x >= 0 about x = 0\n"
            }
            _ => "",
        }
    }

    fn cell_groups(&self) -> impl Iterator<Item = &MeshGroup> {
        let groups = self.mesh.groups.iter();
        groups.filter(|group| group.dimension + 1 == self.mesh.vertices_per_cell)
    }

    fn facet_groups(&self) -> impl Iterator<Item = &MeshGroup> {
        let groups = self.mesh.groups.iter();
        groups.filter(|group| group.dimension + 1 < self.mesh.vertices_per_cell)
    }

    fn materials(&self, deck: Option<&Deck<'_>>) -> String {
        let law = |group: &str| deck.and_then(|deck| deck.law(group));
        let mut text = String::from("\n# Each cell needs a material, by its group.\n");
        let mut groups: Vec<&MeshGroup> = self.cell_groups().collect();
        // Writers of decks make groups of their own beside those that somebody has named.
        groups.sort_by_key(|group| (law(&group.name).is_none(), is_made_up(&group.name)));
        let mut is_covered = vec![false; self.mesh.cell_count()];
        for group in &groups {
            let mut cells = group.members.iter().map(|&cell| cell as usize);
            if cells.any(|cell| is_covered.get(cell).copied().unwrap_or(true)) {
                text.push_str(&overlapping(&group.name))
            } else {
                text.push_str(&material(&group.name, law(&group.name)))
            }
            for &cell in &group.members {
                if let Some(covered) = is_covered.get_mut(cell as usize) {
                    *covered = true;
                }
            }
        }
        if groups.is_empty() {
            text.push_str("# The mesh has no group of cells: name one, body, say.\n");
            text.push_str(&material("body", None));
        }
        text
    }

    /// What holds the body, what presses it, and how far.
    fn surfaces(&self) -> String {
        let height = self.extent();
        let reaches = |group: &&MeshGroup, end: f64, side: usize| {
            let (low, high) = group_box(self.mesh, group);
            let ends = [at(low, self.up), at(high, self.up)];
            (ends.get(side).copied().unwrap_or_default() - end).abs() <= FLAT * height
        };
        let (bottom, top) = (at(self.shape.low, self.up), at(self.shape.high, self.up));
        let base = self.facet_groups().find(|group| reaches(group, bottom, 1));
        // Sides of a box reach its top and its bottom, too: the flattest group is meant.
        let height_of = |group: &&MeshGroup| {
            let (low, high) = group_box(self.mesh, group);
            at(high, self.up) - at(low, self.up)
        };
        let flattest = |end: f64, side: usize| {
            let groups = self
                .facet_groups()
                .filter(|group| reaches(group, end, side));
            groups.min_by(|a, b| height_of(a).total_cmp(&height_of(b)))
        };
        let floor = flattest(bottom, 0);
        let is_base = |group: &MeshGroup| base.is_some_and(|base| base.name == group.name);
        let lid = flattest(top, 1).filter(|lid| !is_base(lid));
        let mut text = match (base, floor) {
            (Some(base), _) => self.support(&base.name),
            (None, Some(floor)) => self.plate("floor", &floor.name, bottom, 1.0),
            (None, None) => format!(
                "\n# What holds the body.\n{}",
                hidden(&self.support("bottom"))
            ),
        };
        match lid {
            Some(lid) => {
                text.push_str(&self.plate("plate", &lid.name, top, -1.0));
                text.push_str(&self.step(height));
            }
            None => {
                text.push_str("\n# No group of the surface lies on top: name one to press on.\n");
                text.push_str(&hidden(&self.plate("plate", "top", top, -1.0)));
                text.push_str(&hidden(&self.step(height)));
            }
        }
        text
    }

    fn extent(&self) -> f64 {
        at(self.shape.high, self.up) - at(self.shape.low, self.up)
    }

    fn support(&self, on: &str) -> String {
        let axes = if self.up == 1 {
            "x = 0.0, y = 0.0"
        } else {
            "x = 0.0, y = 0.0, z = 0.0"
        };
        format!(
            "\n# Held; a component that is left out may slide.\n[[support]]\nname = \"base\"\non = {}\n\
             displacement = {{ {axes} }}\n",
            quoted(on)
        )
    }

    /// A plate that touches the body at a height; `side` is where the body lies.
    fn plate(&self, name: &str, on: &str, height: f64, side: f64) -> String {
        let (point, normal) = (
            self.along_up(rounded_at(height, self.extent())),
            self.along_up(side),
        );
        format!(
            "\n# A rigid tool; its normal points to the body. Others: sphere, cylinder.\n[[obstacle]]\n\
             name = \"{name}\"\non = {}\nshape = {{ kind = \"half-space\", point = {point}, normal = {normal} }}\n\
             # friction = 0.3\n",
            quoted(on)
        )
    }

    fn step(&self, height: f64) -> String {
        let travel = self.along_up(rounded(-0.1 * height));
        format!(
            "\n# Each increment is a result.\n[[step]]\nincrements = 10\n\
             obstacle.plate = {{ translation = {travel} }}  # a tenth of the height\n"
        )
    }

    fn along_up(&self, value: f64) -> String {
        let mut vector = [0.0; 3];
        if let Some(x) = vector.get_mut(self.up) {
            *x = value;
        }
        format!("{vector:?}")
    }
}

/// Whether a group has a name as programs give them: a word and a number.
fn is_made_up(name: &str) -> bool {
    let word = name.trim_end_matches(|c: char| c.is_ascii_digit());
    let word = word.trim_end_matches(['-', '_']).to_ascii_lowercase();
    word.len() < name.len()
        && ["surface", "volume", "line", "set", "part", "elset"].contains(&word.as_str())
}

/// A group whose cells have a material by another group already.
fn overlapping(group: &str) -> String {
    format!(
        "# Group {} has cells that have their material above.\n",
        quoted(group)
    )
}

fn material(group: &str, law: Option<String>) -> String {
    let key = quoted(group);
    let bare = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_');
    let key = if !group.is_empty() && group.chars().all(bare) {
        group
    } else {
        &key
    };
    if let Some(law) = law {
        return format!("[material.{key}]\n{law}");
    }
    format!(
        "[material.{key}]\n\
         model = \"neo-hookean\"  # or mooney-rivlin, yeoh, polynomial, gent, arruda-boyce, van-der-waals, ogden, hyperfoam, blatz-ko, linear-elastic\n\
         shear_modulus = 1.0\n\
         # bulk_modulus = 1000.0  # left out: the volume cannot change\n"
    )
}

/// The lines as comments.
fn hidden(text: &str) -> String {
    let mut hidden = String::new();
    for line in text.trim_start().lines() {
        // Writing to a string cannot fail.
        let _infallible = if line.starts_with('#') {
            writeln!(hidden, "{line}")
        } else {
            writeln!(hidden, "# {line}")
        };
    }
    hidden
}

/// A TOML string.
fn quoted(text: &str) -> String {
    Value::String(text.to_owned()).to_string()
}

/// Four digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

/// To a millionth of a millionth of a length: what is shorter is rounding.
fn rounded_at(value: f64, length: f64) -> f64 {
    let digits = 12 - length.log10().floor() as i32;
    format!("{value:.*}", digits.clamp(0, 17) as usize)
        .parse()
        .unwrap_or(value)
}

fn at(point: [f64; 3], axis: usize) -> f64 {
    point.get(axis).copied().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use signorini_client::scene_file;
    use signorini_proto::v1;

    use super::*;

    fn group(name: &str, dimension: usize, members: Vec<u32>) -> MeshGroup {
        MeshGroup {
            name: name.to_owned(),
            dimension,
            members,
        }
    }

    /// A square of two triangles, its corners counted around.
    fn square(groups: Vec<MeshGroup>) -> MeshFile {
        MeshFile {
            vertices_per_cell: 3,
            coordinates: vec![
                [1.0, 0.0, 0.0],
                [2.0, 0.0, 0.0],
                [2.0, 0.5, 0.0],
                [1.0, 0.5, 0.0],
            ],
            cells: vec![0, 1, 2, 0, 2, 3],
            facets: vec![0, 1, 1, 2, 2, 3, 3, 0],
            groups,
            curved: Vec::new(),
            warnings: Vec::new(),
        }
    }

    fn read(mesh: &MeshFile) -> v1::Scene {
        let text = draft(mesh, "a \"b\".msh", None);
        let scene = scene_file::read(&text, Path::new("draft.toml"), &[]);
        let scene = scene.unwrap_or_else(|error| unreachable!("{error}\n{text}"));
        assert_eq!(scene.mesh, Path::new("a \"b\".msh"));
        scene.scene
    }

    #[test]
    fn a_flat_group_below_is_held_and_one_above_is_pressed() {
        let scene = read(&square(vec![
            group("below", 1, vec![0]),
            group("above", 1, vec![2]),
            group("rubber part", 2, vec![0, 1]),
        ]));
        assert_eq!(scene.materials[0].group, "rubber part");
        assert_eq!(
            (&*scene.supports[0].on[0], &*scene.obstacles[0].on[0]),
            ("below", "above")
        );
        assert_eq!(scene.steps[0].obstacles[0].translation, [0.0, -0.05, 0.0]);
        assert_eq!(scene.kind(), v1::SceneKind::Axisymmetric);
    }

    #[test]
    fn sides_that_reach_the_top_are_not_pressed() {
        let scene = read(&square(vec![
            group("side", 1, vec![1]),
            group("above", 1, vec![2]),
            group("below", 1, vec![0]),
            group("rubber", 2, vec![0, 1]),
        ]));
        assert_eq!(
            (&*scene.supports[0].on[0], &*scene.obstacles[0].on[0]),
            ("below", "above")
        );
    }

    #[test]
    fn cells_of_two_groups_get_the_material_of_the_named_one() {
        let scene = read(&square(vec![
            group("above", 1, vec![2]),
            group("Surface1", 2, vec![0, 1]),
            group("rubber", 2, vec![0, 1]),
        ]));
        let groups: Vec<&str> = scene.materials.iter().map(|one| &*one.group).collect();
        assert_eq!(groups, ["rubber"]);
    }

    #[test]
    fn numbers_of_a_draft_are_not_those_of_rounding() {
        assert_eq!(rounded(-0.100_000_000_000_001_89).to_string(), "-0.1");
        assert_eq!(rounded_at(-100.000_000_000_000_04, 3.0).to_string(), "-100");
    }

    #[test]
    fn a_skin_lies_between_two_plates() {
        let scene = read(&square(vec![
            group("skin", 1, vec![0, 1, 2, 3]),
            group("rubber", 2, vec![0, 1]),
        ]));
        assert_eq!((scene.supports.len(), scene.obstacles.len()), (0, 2));
    }

    #[test]
    fn a_mesh_without_groups_gets_its_parts_as_comments() {
        let scene = read(&square(Vec::new()));
        assert_eq!(
            (
                scene.materials.len(),
                scene.obstacles.len(),
                scene.steps.len()
            ),
            (1, 0, 0)
        );
    }
}
