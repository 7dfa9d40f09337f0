//! `contact_path.csv`: contact pressure along the surface in the plane and about an axis, one row
//! a point, for plots.
//!
//! What an increment writes is its field `contact_path` with the names of obstacles in place of
//! their numbers. A run without that field leaves no file. Cost: the rows; the reader keeps those
//! of one increment.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use csv::Writer;
use serde::{Deserialize, Serialize};
use signorini_client::solve::Increment;
use signorini_proto::v1;

use crate::terminal::exit::Failure;
use crate::terminal::whole_file;

/// Name of the file in a folder of results.
pub(crate) const FILE: &str = "contact_path.csv";

/// Numbers of a point in the field.
const NUMBERS: usize = 6;

/// The file under construction.
pub(crate) struct PathCsv {
    path: PathBuf,
    /// Obstacles, then contacts between bodies, in the order of the scene.
    obstacles: Vec<String>,
    writer: Option<Writer<File>>,
}

/// One row.
#[derive(Clone, Debug, Default, Serialize, Deserialize, PartialEq)]
pub(crate) struct Row {
    pub(crate) step: i32,
    pub(crate) increment: i32,
    pub(crate) time: f64,
    pub(crate) obstacle: String,
    pub(crate) interval: usize,
    pub(crate) arc_length: f64,
    pub(crate) pressure: f64,
    pub(crate) x: f64,
    pub(crate) y: f64,
}

impl PathCsv {
    /// Of a run of `scene` into a folder; what an earlier one has left there goes.
    pub(crate) fn new(folder: &Path, scene: &v1::Scene) -> Result<Self, Failure> {
        let path = folder.join(FILE);
        match std::fs::remove_file(&path) {
            Err(error) if error.kind() != ErrorKind::NotFound => {
                return Err(Failure::unwritable(&path, &error));
            }
            Ok(()) | Err(_) => {}
        }
        let obstacles = scene.obstacles.iter().map(|one| &one.name);
        let names = obstacles.chain(scene.contacts.iter().map(|one| &one.name));
        Ok(Self {
            path,
            obstacles: names.cloned().collect(),
            writer: None,
        })
    }

    /// Adds the points of an increment that came with them.
    pub(crate) fn add(&mut self, increment: &Increment) -> Result<(), Failure> {
        let mut fields = increment.fields.iter();
        let Some(field) = fields.find(|field| field.name == v1::FieldName::ContactPath) else {
            return Ok(());
        };
        let report = &increment.report;
        let (rows, _) = field.values.as_chunks::<NUMBERS>();
        let rows = rows.iter().map(|row| self.row(report, *row));
        let rows: Vec<Row> = rows.collect();
        let written = self.write(&rows);
        written.map_err(|error| Failure::unwritable(&self.path, &error.into()))
    }

    fn row(&self, report: &v1::StepReport, row: [f64; NUMBERS]) -> Row {
        let [obstacle, interval, arc_length, pressure, x, y] = row;
        Row {
            step: report.step,
            increment: report.increment,
            time: report.time,
            obstacle: self
                .obstacles
                .get(obstacle as usize)
                .cloned()
                .unwrap_or_default(),
            interval: interval as usize,
            arc_length,
            pressure,
            x,
            y,
        }
    }

    fn write(&mut self, rows: &[Row]) -> csv::Result<()> {
        if rows.is_empty() {
            return Ok(());
        }
        let writer = match &mut self.writer {
            Some(writer) => writer,
            empty => empty.insert(Writer::from_writer(whole_file::create(&self.path)?)),
        };
        for row in rows {
            writer.serialize(row)?;
        }
        Ok(writer.flush()?)
    }
}

/// Rows of the increment that was written last in a folder, by obstacle and interval; none where
/// there is no such file, and what is none of its rows ends them.
pub(crate) fn last(folder: &Path) -> BTreeMap<(String, usize), Vec<Row>> {
    let mut last: Vec<Row> = Vec::new();
    let rows = csv::Reader::from_path(folder.join(FILE)).into_iter();
    for row in rows.flat_map(csv::Reader::into_deserialize::<Row>) {
        let Ok(row) = row else {
            break;
        };
        if last.first().is_some_and(|known| known.time < row.time) {
            last.clear();
        }
        last.push(row);
    }
    let mut paths: BTreeMap<_, Vec<Row>> = BTreeMap::new();
    for row in last {
        let own = paths.entry((row.obstacle.clone(), row.interval));
        own.or_default().push(row);
    }
    paths
}

#[cfg(test)]
mod tests {
    use signorini_client::solve::Field;

    use super::*;

    fn increment(time: f64, values: &[f64]) -> Increment {
        let field = Field {
            name: v1::FieldName::ContactPath,
            components: NUMBERS,
            values: values.to_vec(),
        };
        let report = v1::StepReport {
            time,
            ..Default::default()
        };
        Increment {
            sequence: 1,
            event: 1,
            report,
            last: true,
            fields: vec![field],
            fields_dropped: false,
        }
    }

    #[test]
    fn the_points_of_the_last_increment_come_back_by_obstacle_and_interval() {
        let name = format!("signorini-contact-path-{}", std::process::id());
        let folder = std::env::temp_dir().join(name);
        std::fs::create_dir_all(&folder).unwrap();
        let named = |name: &str| v1::Obstacle {
            name: name.to_owned(),
            ..Default::default()
        };
        let scene = v1::Scene {
            obstacles: vec![named("a"), named("b, c")],
            ..Default::default()
        };
        let mut file = PathCsv::new(&folder, &scene).unwrap();
        let third = 1.0 / 3.0;
        let row = |obstacle: f64, interval: f64| [obstacle, interval, 0.5, third, 1.0, -2.0];
        file.add(&increment(1.0, &row(0.0, 0.0))).unwrap();
        file.add(&increment(2.0, &[row(1.0, 0.0), row(1.0, 1.0)].concat()))
            .unwrap();
        let paths = last(&folder);
        let keys: Vec<_> = paths.keys().cloned().collect();
        assert_eq!(keys, [("b, c".to_owned(), 0), ("b, c".to_owned(), 1)]);
        assert_eq!(paths[&keys[0]][0].pressure.to_bits(), third.to_bits());
        // A row that is cut off is none.
        let text = std::fs::read(folder.join(FILE)).unwrap();
        for length in 0..text.len() {
            std::fs::write(folder.join(FILE), &text[..length]).unwrap();
            let _found = last(&folder);
        }
        // Another run has no sections.
        PathCsv::new(&folder, &scene).unwrap();
        assert!(!folder.join(FILE).exists() && last(&folder).is_empty());
        std::fs::remove_dir_all(folder).unwrap();
    }
}
