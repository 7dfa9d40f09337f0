//! Pictures of the scenes: the deformed body and its obstacle, drawn once by
//! `tests/benches/peers/draw_scenes.py` from results of the solver.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

const PICTURES: &[(&str, &[u8])] = &[
    ("A1m", include_bytes!("../pictures/A1m.png")),
    ("cube-bend", include_bytes!("../pictures/cube-bend.png")),
    ("cube-drag", include_bytes!("../pictures/cube-drag.png")),
    ("hertz-plane", include_bytes!("../pictures/hertz-plane.png")),
    ("hertz-press", include_bytes!("../pictures/hertz-press.png")),
    (
        "hertz-sphere",
        include_bytes!("../pictures/hertz-sphere.png"),
    ),
    ("mr-block", include_bytes!("../pictures/mr-block.png")),
    ("mr-sphere", include_bytes!("../pictures/mr-sphere.png")),
    ("mr-uniax", include_bytes!("../pictures/mr-uniax.png")),
];

/// The picture of a scene; nothing for one without.
pub(crate) fn html(scene: &str) -> String {
    let found = PICTURES.iter().find(|(name, _)| *name == scene);
    found.map_or_else(String::new, |(name, bytes)| {
        let text = STANDARD.encode(bytes);
        format!(
            "<img class=\"scene\" alt=\"{name}: the deformed body\" src=\"data:image/png;base64,{text}\">\n"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::families::FAMILIES;

    #[test]
    fn every_chapter_has_a_picture() {
        for family in FAMILIES.iter().filter(|family| !family.full.is_empty()) {
            assert!(html(family.name).contains("iVBOR"), "{}", family.name);
        }
        assert_eq!(html("chess"), "");
    }
}
