//! The folder of `--out`: a PVD series of VTU files (the body) and VTP files
//! (the obstacles), beside the result lines.

use std::path::{Path, PathBuf};

use signorini_client::formats::msh::MeshFile;
use signorini_client::formats::pvd::{self, PvdEntry};
use signorini_client::formats::vtp::{self, BoundingBox, Outline, Pose};
use signorini_client::formats::vtu::{Grid, GridField};
use signorini_client::scene_file::outline;
use signorini_client::solve::{Field, Increment};
use signorini_proto::{v1, words};

use crate::exit::{Exit, Failure};

/// Name of the result lines in the folder.
pub(crate) const LINES: &str = "results.jsonl";

/// Writes the results of one run.
pub(crate) struct ResultFolder {
    folder: PathBuf,
    stem: String,
    grid: Grid,
    obstacles: Vec<(String, Outline)>,
    entries: Vec<PvdEntry>,
    written: usize,
}

impl ResultFolder {
    /// Makes the folder.
    pub(crate) fn new(folder: &Path, scene: &v1::Scene, mesh: &MeshFile) -> Result<Self, Failure> {
        std::fs::create_dir_all(folder).map_err(|error| Failure::unwritable(folder, &error))?;
        let scale = scene.mesh_scale.unwrap_or(1.0);
        let points: Vec<[f64; 3]> = mesh
            .coordinates
            .iter()
            .map(|point| point.map(|x| x * scale))
            .collect();
        let mut grid = Grid::new(mesh.vertices_per_cell, &points, &mesh.cells)
            .map_err(|error| Failure::new(Exit::Invalid, error.to_string()))?;
        let curved = mesh.curved.iter();
        grid.bend(curved.map(|edge| (edge.ends, edge.offset.map(|x| x * scale))));
        let body = BoundingBox::of(&points);
        let drawn = |obstacle: &v1::Obstacle| {
            let outline = outline(obstacle.shape.as_ref()?, &body)?;
            Some((obstacle.name.clone(), outline))
        };
        Ok(Self {
            folder: folder.to_owned(),
            stem: file_stem(&scene.name),
            grid,
            obstacles: scene.obstacles.iter().filter_map(drawn).collect(),
            entries: Vec::new(),
            written: 0,
        })
    }

    /// The folder itself.
    pub(crate) fn path(&self) -> &Path {
        &self.folder
    }

    /// Path of the result lines.
    pub(crate) fn lines(&self) -> PathBuf {
        self.folder.join(LINES)
    }

    /// Path of the series.
    pub(crate) fn series(&self) -> PathBuf {
        self.folder.join(format!("{}.pvd", self.stem))
    }

    /// Writes the files of an increment that came with fields.
    pub(crate) fn add(&mut self, increment: &Increment) -> Result<(), Failure> {
        if increment.fields.is_empty() {
            return Ok(());
        }
        self.written += 1;
        let number = self.written;
        let body = self.body_file(&increment.fields)?;
        let name = format!("{}_{number:04}.vtu", self.stem);
        self.put(increment.report.time, 0, name, &body)?;
        for part in 0..self.obstacles.len() {
            self.add_obstacle(part, &increment.report, number)?;
        }
        // Rewritten each time, so that an interrupted run leaves a whole series.
        let series = self.series();
        write(&series, pvd::write(&self.entries).as_bytes())
    }

    fn body_file(&self, fields: &[Field]) -> Result<Vec<u8>, Failure> {
        let names: Vec<String> = fields
            .iter()
            .map(|field| words::field(field.name))
            .collect();
        let fields: Vec<GridField<'_>> = names
            .iter()
            .zip(fields)
            .map(|(name, field)| GridField {
                name,
                components: field.components,
                values: &field.values,
            })
            .collect();
        let written = self.grid.write(&fields);
        written.map_err(|error| Failure::new(Exit::Server, error.to_string()))
    }

    fn add_obstacle(
        &mut self,
        part: usize,
        report: &v1::StepReport,
        number: usize,
    ) -> Result<(), Failure> {
        let Some((name, outline)) = self.obstacles.get(part) else {
            return Ok(());
        };
        let pose = report.obstacle_poses.iter().find(|pose| pose.name == *name);
        let pose = pose.map(pose_of).unwrap_or_default();
        let drawn = vtp::write(outline, &pose);
        let file = format!("{}_{}_{number:04}.vtp", self.stem, file_stem(name));
        self.put(report.time, part + 1, file, &drawn)
    }

    fn put(&mut self, time: f64, part: usize, file: String, bytes: &[u8]) -> Result<(), Failure> {
        write(&self.folder.join(&file), bytes)?;
        self.entries.push(PvdEntry { time, part, file });
        Ok(())
    }
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    std::fs::write(path, bytes).map_err(|error| Failure::unwritable(path, &error))
}

fn three(values: &[f64]) -> [f64; 3] {
    values.try_into().unwrap_or_default()
}

fn pose_of(pose: &v1::ObstaclePose) -> Pose {
    Pose {
        translation: three(&pose.translation),
        rotation: three(&pose.rotation),
    }
}

/// A name as part of a file name.
fn file_stem(name: &str) -> String {
    let safe = |c: char| {
        if c.is_alphanumeric() || matches!(c, '-' | '_' | '.') {
            c
        } else {
            '_'
        }
    };
    let stem: String = name.chars().map(safe).collect();
    let stem = stem.trim_start_matches('.');
    if stem.is_empty() {
        "scene".to_owned()
    } else {
        stem.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_become_safe_parts_of_file_names() {
        assert_eq!(file_stem("hertz-sphere 2/3"), "hertz-sphere_2_3");
        assert_eq!(file_stem("../../etc"), "_.._etc");
        assert_eq!(file_stem(""), "scene");
    }
}
