//! Scene and mesh files of the runs, in a temporary folder that goes with them.

use std::path::{Path, PathBuf};

use crate::cube;
use crate::error::BenchError;
use crate::family::{Family, Level, MeshSource};
use crate::shaped::shaped;

/// Gmsh meshes that the program carries: prefix, level, bytes.
const SHIPPED: &[(&str, u32, &[u8])] = &[
    (
        "cylinder",
        1,
        include_bytes!("../examples/meshes/cylinder_l1.msh"),
    ),
    (
        "cylinder",
        2,
        include_bytes!("../examples/meshes/cylinder_l2.msh"),
    ),
    ("ball", 1, include_bytes!("../examples/meshes/ball_l1.msh")),
    ("hemi", 1, include_bytes!("../examples/meshes/hemi_l1.msh")),
    ("hemi", 2, include_bytes!("../examples/meshes/hemi_l2.msh")),
    ("hemi", 3, include_bytes!("../examples/meshes/hemi_l3.msh")),
    ("hemi", 4, include_bytes!("../examples/meshes/hemi_l4.msh")),
    ("hemi", 5, include_bytes!("../examples/meshes/hemi_l5.msh")),
    (
        "indent",
        1,
        include_bytes!("../examples/meshes/indent_l1.msh"),
    ),
    (
        "indent",
        2,
        include_bytes!("../examples/meshes/indent_l2.msh"),
    ),
    (
        "indent",
        3,
        include_bytes!("../examples/meshes/indent_l3.msh"),
    ),
    (
        "indent",
        4,
        include_bytes!("../examples/meshes/indent_l4.msh"),
    ),
    (
        "indent",
        5,
        include_bytes!("../examples/meshes/indent_l5.msh"),
    ),
];

/// The bytes of a mesh that the program carries.
pub(crate) fn shipped(prefix: &str, level: u32) -> Option<&'static [u8]> {
    let mut meshes = SHIPPED.iter();
    let found = meshes.find(|mesh| (mesh.0, mesh.1) == (prefix, level));
    found.map(|mesh| mesh.2)
}

/// A folder of files that runs read.
#[derive(Debug)]
pub(crate) struct Workshop {
    folder: PathBuf,
    meshes: Option<PathBuf>,
}

impl Drop for Workshop {
    fn drop(&mut self) {
        // What stays behind lies among temporary files.
        let _gone = std::fs::remove_dir_all(&self.folder);
    }
}

impl Workshop {
    /// An empty folder; `meshes` is looked at before the meshes of the program.
    ///
    /// # Errors
    /// [`BenchError::Unwritable`].
    pub(crate) fn open(meshes: Option<PathBuf>) -> Result<Self, BenchError> {
        let name = format!("signorini-bench-{}", std::process::id());
        let folder = std::env::temp_dir().join(name);
        std::fs::create_dir_all(&folder).map_err(BenchError::unwritable(&folder))?;
        Ok(Self { folder, meshes })
    }

    /// The scene file of a family.
    ///
    /// # Errors
    /// [`BenchError::Unwritable`].
    pub(crate) fn scene(&self, family: &Family) -> Result<PathBuf, BenchError> {
        self.file(&format!("{}.toml", family.name), || {
            family.scene.as_bytes().to_vec()
        })
    }

    /// The mesh of a level.
    ///
    /// # Errors
    /// [`BenchError`].
    pub(crate) fn mesh(&self, family: &Family, level: Level) -> Result<PathBuf, BenchError> {
        let prefix = match family.source {
            MeshSource::Cube(shape) => {
                let name = format!("cube_{shape:?}_{level}.msh").replace(['(', ')'], "");
                let text = || shaped(&cube::msh(level.number), level.number, shape);
                return self.file(&name, || text().into_bytes());
            }
            MeshSource::Gmsh(prefix) => prefix,
        };
        let name = format!("{prefix}_{level}.msh");
        let given = self.meshes.as_ref().map(|folder| folder.join(&name));
        if let Some(path) = given.filter(|path| path.exists()) {
            return Ok(path);
        }
        match shipped(prefix, level.number) {
            Some(bytes) => self.file(&name, || bytes.to_vec()),
            None => Err(self.missing(name)),
        }
    }

    fn missing(&self, file: String) -> BenchError {
        let folder = self.meshes.as_deref().map(Path::display);
        let folder = folder.map_or_else(
            || "--meshes, which is not given".to_owned(),
            |folder| folder.to_string(),
        );
        BenchError::NoMesh { file, folder }
    }

    fn file(&self, name: &str, content: impl FnOnce() -> Vec<u8>) -> Result<PathBuf, BenchError> {
        let path = self.folder.join(name);
        if !path.exists() {
            std::fs::write(&path, content()).map_err(BenchError::unwritable(&path))?;
        }
        Ok(path)
    }
}
