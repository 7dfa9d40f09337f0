//! Bodies with mesh files of their own, and where they are put.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::body::name_of;
use super::keys::Keys;
use crate::formats::mesh::Placement;

/// A body of a scene with several mesh files.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyFile {
    /// By which its groups are called.
    pub name: String,
    /// Path of its mesh file.
    pub mesh: PathBuf,
    /// Where it is put.
    pub placement: Placement,
}

/// Bodies of a scene at most.
const MOST_BODIES: usize = 256;

/// The bodies, whose files are relative to `folder`; none of a scene with one mesh.
pub(super) fn bodies(scene: &Keys<'_>, folder: &Path) -> Vec<BodyFile> {
    let known = ["name", "mesh", "translation", "rotation", "mesh_scale"];
    let tables = scene.tables("body", &known);
    if tables.len() > MOST_BODIES {
        let message = format!("are {}; at most {MOST_BODIES} are allowed", tables.len());
        scene.fault("body", message);
    }
    for key in ["mesh", "mesh_scale"] {
        if !tables.is_empty() && scene.has(key) {
            scene.fault(key, "each [[body]] has its own: leave this out");
        }
    }
    let mut taken = BTreeSet::new();
    let tables = tables.iter().take(MOST_BODIES).enumerate();
    let body = |(index, keys): (usize, &Keys<'_>)| {
        let name = name_of(keys, "body", index);
        if name.is_empty() {
            keys.fault(
                "name",
                "must not be empty: groups are called by it".to_owned(),
            );
        }
        if !taken.insert(name.clone()) {
            keys.fault("name", format!("`{name}` is that of two bodies"));
        }
        let three = |key: &str| {
            let given = keys.vector(key);
            <[f64; 3]>::try_from(given).unwrap_or_default()
        };
        let scale = keys.number("mesh_scale").unwrap_or(1.0);
        if !(scale > 0.0 && scale.is_finite()) {
            keys.fault(
                "mesh_scale",
                format!("must be above zero and finite, not {scale}"),
            );
        }
        BodyFile {
            name,
            mesh: folder.join(keys.required_text("mesh")),
            placement: Placement {
                scale,
                rotation: three("rotation"),
                translation: three("translation"),
            },
        }
    };
    tables.map(body).collect()
}
