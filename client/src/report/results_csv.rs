//! `results.csv`: one row an increment, for spreadsheets.
//!
//! The columns are those of the first result - what runs, then each obstacle, support, probe and
//! fluid by name - and of the goals of the scene, which are told where it asks for them. A number
//! that a result does not have is left empty.

use std::fs::File;
use std::path::Path;

use csv::Writer;
use signorini_client::study::asked;
use signorini_proto::{v1, words};

use crate::report::travel::Travels;
use crate::terminal::exit::Failure;
use crate::terminal::whole_file;

/// Name of the file in a folder of results.
pub(crate) const FILE: &str = "results.csv";

/// What is told of a contact between bodies after its force.
/// Numbers of a tie.
const OF_TIE: [&str; 3] = ["area", "gap", "peak_traction"];
const OF_CONTACT: [&str; 4] = [
    "contact_area",
    "contact_width",
    "mean_pressure",
    "peak_pressure",
];

/// What is told of a fluid before its force.
const OF_FLUID: [&str; 10] = [
    "pressure",
    "tightness",
    "blow_off_low",
    "blow_off_high",
    "margin",
    "margin_over_pressure",
    "sealed_width",
    "wet_area",
    "conductance",
    "flow_rate",
];

/// What is told of the error of a goal.
const OF_BOUND: [&str; 2] = ["bound", "estimate"];

const AXES: [&str; 3] = ["x", "y", "z"];

/// The file under construction.
pub(crate) struct ResultsCsv {
    path: std::path::PathBuf,
    writer: Writer<File>,
    columns: Option<Columns>,
    /// What the scene asks of goals.
    goals: Goals,
}

/// Goals, whether their error is bounded, and what they are differentiated by.
type Goals = Vec<(String, bool, Vec<String>)>;

/// Names with columns of their own.
struct Columns {
    obstacles: Vec<String>,
    supports: Vec<String>,
    probes: Vec<String>,
    fluids: Vec<String>,
    goals: Goals,
    contacts: Vec<String>,
    ties: Vec<String>,
}

impl ResultsCsv {
    /// Begins the file of the results of a scene in a folder.
    pub(crate) fn create(folder: &Path, scene: &v1::Scene) -> Result<Self, Failure> {
        let path = folder.join(FILE);
        let file = whole_file::create(&path).map_err(|error| Failure::unwritable(&path, &error))?;
        Ok(Self {
            writer: Writer::from_writer(file),
            path,
            columns: None,
            goals: asked::goals(scene).iter().map(of_goal).collect(),
        })
    }

    /// Adds the row of an increment.
    pub(crate) fn add(
        &mut self,
        report: &v1::StepReport,
        travels: &Travels,
    ) -> Result<(), Failure> {
        let written = self.write(report, travels);
        written.map_err(|error| Failure::unwritable(&self.path, &error.into()))
    }

    fn write(&mut self, report: &v1::StepReport, travels: &Travels) -> csv::Result<()> {
        let columns = match self.columns.take() {
            Some(columns) => columns,
            None => {
                let columns = Columns::of(report, self.goals.clone());
                self.writer.write_record(columns.header())?;
                columns
            }
        };
        let row = columns.row(report, travels);
        self.columns = Some(columns);
        self.writer.write_record(row)?;
        Ok(self.writer.flush()?)
    }
}

impl Columns {
    fn of(report: &v1::StepReport, goals: Goals) -> Self {
        Self {
            obstacles: report.obstacles.keys().cloned().collect(),
            supports: report.supports.keys().cloned().collect(),
            probes: report.probes.keys().cloned().collect(),
            fluids: report.fluids.keys().cloned().collect(),
            goals,
            contacts: report.contacts.keys().cloned().collect(),
            ties: report.ties.keys().cloned().collect(),
        }
    }

    fn header(&self) -> Vec<String> {
        let fixed = [
            "step",
            "increment",
            "time",
            "load",
            "termination",
            "cause",
            "error_estimate",
            "strain_energy",
            "volume_ratio",
            "min_jacobian",
            "max_penetration",
            "seconds",
        ];
        let mut header: Vec<String> = fixed.map(str::to_owned).to_vec();
        for name in &self.obstacles {
            let scalars = ["travel", "force_along_travel", "force_error"];
            header.extend(scalars.map(|column| format!("{name}.{column}")));
            header.extend(AXES.map(|axis| format!("{name}.force_{axis}")));
            let scalars = [
                "contact_area",
                "max_pressure",
                "deformed_contact_area",
                "contact_width",
                "mean_pressure",
                "peak_pressure",
            ];
            header.extend(scalars.map(|column| format!("{name}.{column}")));
            header.extend(AXES.map(|axis| format!("{name}.peak_pressure_{axis}")));
        }
        for name in &self.supports {
            header.extend(AXES.map(|axis| format!("{name}.force_{axis}")));
            header.extend(AXES.map(|axis| format!("{name}.moment_{axis}")));
            header.extend(AXES.map(|axis| format!("{name}.translation_{axis}")));
            header.extend(AXES.map(|axis| format!("{name}.rotation_{axis}")));
        }
        for name in &self.probes {
            header.extend(AXES.map(|axis| format!("{name}.displacement_{axis}")));
            header.push(format!("{name}.pressure"));
        }
        for name in &self.fluids {
            header.extend(OF_FLUID.map(|column| format!("fluid.{name}.{column}")));
            header.extend(AXES.map(|axis| format!("fluid.{name}.force_{axis}")));
        }
        for (name, has_bound, parameters) in &self.goals {
            header.push(format!("goal.{name}"));
            if *has_bound {
                header.extend(OF_BOUND.map(|column| format!("goal.{name}.{column}")));
            }
            let parameters = parameters.iter();
            header.extend(parameters.map(|parameter| format!("goal.{name} by {parameter}")));
        }
        for name in &self.contacts {
            header.extend(AXES.map(|axis| format!("contact.{name}.force_{axis}")));
            header.extend(AXES.map(|axis| format!("contact.{name}.moment_{axis}")));
            header.extend(OF_CONTACT.map(|column| format!("contact.{name}.{column}")));
            header.extend(AXES.map(|axis| format!("contact.{name}.peak_pressure_{axis}")));
        }
        for name in &self.ties {
            header.extend(AXES.map(|axis| format!("tie.{name}.force_{axis}")));
            header.extend(AXES.map(|axis| format!("tie.{name}.moment_{axis}")));
            header.extend(OF_TIE.map(|column| format!("tie.{name}.{column}")));
            header.extend(AXES.map(|axis| format!("tie.{name}.peak_traction_{axis}")));
        }
        header
    }

    fn row(&self, report: &v1::StepReport, travels: &Travels) -> Vec<String> {
        let mut row = vec![
            report.step.to_string(),
            report.increment.to_string(),
            report.time.to_string(),
            report.load.to_string(),
            words::termination(report.termination()),
            words::cause(report.cause()).unwrap_or_default(),
        ];
        let numbers = [
            report.error_estimate,
            Some(report.strain_energy).filter(|value| !value.is_nan()),
            Some(report.volume_ratio).filter(|value| !value.is_nan()),
            report.min_jacobian,
            Some(report.max_penetration),
            Some(report.seconds.unwrap_or_default().total),
        ];
        row.extend(numbers.map(cell));
        for name in &self.obstacles {
            let obstacle = report.obstacles.get(name);
            row.push(cell(travels.distance(name, report)));
            row.push(cell(obstacle.map(|result| travels.force(name, result))));
            row.push(cell(obstacle.and_then(|result| result.force_error)));
            row.extend(three(obstacle.map(|result| result.force.as_slice())));
            row.extend(contact(obstacle));
        }
        for name in &self.supports {
            let support = report.supports.get(name);
            row.extend(three(support.map(|result| result.force.as_slice())));
            row.extend(three(support.map(|result| result.moment.as_slice())));
            row.extend(three(support.map(|result| result.translation.as_slice())));
            row.extend(three(support.map(|result| result.rotation.as_slice())));
        }
        for name in &self.probes {
            let probe = report.probes.get(name);
            row.extend(three(probe.map(|result| result.displacement.as_slice())));
            row.push(cell(probe.and_then(|result| result.pressure)));
        }
        for name in &self.fluids {
            row.extend(wet(report.fluids.get(name)));
        }
        for columns in &self.goals {
            row.extend(answered(columns, report.goals.get(&columns.0)));
        }
        for name in &self.contacts {
            row.extend(between_bodies(report.contacts.get(name)));
        }
        for name in &self.ties {
            row.extend(tied(report.ties.get(name)));
        }
        row
    }
}

/// The columns of a goal.
fn of_goal((name, goal): (&String, &v1::GoalResult)) -> (String, bool, Vec<String>) {
    let parameters = goal.derivatives.keys().cloned().collect();
    (name.clone(), goal.bound.is_some(), parameters)
}

/// A goal, its bound and its derivatives.
fn answered(
    (_, has_bound, parameters): &(String, bool, Vec<String>),
    goal: Option<&v1::GoalResult>,
) -> Vec<String> {
    let mut row = vec![cell(goal.map(|goal| goal.value))];
    let bound = goal.and_then(|goal| goal.bound);
    if *has_bound {
        let columns = [
            bound.map(|bound| bound.total),
            bound.map(|bound| bound.estimate),
        ];
        row.extend(columns.map(cell));
    }
    let derivative = |name| goal.and_then(|goal| goal.derivatives.get(name).copied());
    row.extend(parameters.iter().map(|name| cell(derivative(name))));
    row
}

/// How far contact extends on an obstacle, and its pressures.
fn contact(obstacle: Option<&v1::ObstacleResult>) -> Vec<String> {
    let numbers = [
        obstacle.map(|result| result.contact_area),
        obstacle.map(|result| result.max_pressure),
        obstacle.map(|result| result.deformed_contact_area),
        obstacle.and_then(|result| result.contact_width),
        obstacle.and_then(|result| result.mean_pressure),
        obstacle.map(|result| result.peak_pressure),
    ];
    let place = obstacle.map(|result| result.peak_pressure_place.as_slice());
    numbers.map(cell).into_iter().chain(three(place)).collect()
}

/// A contact between bodies, in the order of its columns.
fn between_bodies(contact: Option<&v1::BodyContactResult>) -> Vec<String> {
    let numbers = [
        contact.map(|result| result.contact_area),
        contact.map(|result| result.contact_width),
        contact.and_then(|result| result.mean_pressure),
        contact.map(|result| result.peak_pressure),
    ];
    let mut row = three(contact.map(|result| result.force.as_slice())).to_vec();
    row.extend(three(contact.map(|result| result.moment.as_slice())));
    row.extend(numbers.map(cell));
    row.extend(three(
        contact.map(|result| result.peak_pressure_place.as_slice()),
    ));
    row
}

/// A tie, in the order of its columns.
fn tied(tie: Option<&v1::TieResult>) -> Vec<String> {
    let numbers = [
        tie.map(|result| result.area),
        tie.map(|result| result.gap),
        tie.map(|result| result.peak_traction),
    ];
    let mut row = three(tie.map(|result| result.force.as_slice())).to_vec();
    row.extend(three(tie.map(|result| result.moment.as_slice())));
    row.extend(numbers.map(cell));
    row.extend(three(
        tie.map(|result| result.peak_traction_place.as_slice()),
    ));
    row
}

/// A fluid, in the order of its columns.
fn wet(fluid: Option<&v1::FluidResult>) -> Vec<String> {
    let path = fluid.and_then(|result| result.leak_path.as_ref());
    let numbers = [
        fluid.and_then(|result| result.blow_off_low),
        fluid.and_then(|result| result.blow_off_high),
        path.map(|path| path.margin),
        path.map(|path| path.margin_over_pressure),
        path.map(|path| path.sealed_width),
        fluid.map(|result| result.wet_area),
        fluid.and_then(|result| result.conductance),
        fluid.and_then(|result| result.flow_rate),
    ];
    let tightness = fluid.map(|result| words::tightness(result.tightness()));
    let mut row = vec![
        cell(fluid.map(|result| result.pressure)),
        tightness.unwrap_or_default(),
    ];
    row.extend(numbers.map(cell));
    row.extend(three(fluid.map(|result| result.force.as_slice())));
    row
}

/// As many digits as the double has.
fn cell(value: Option<f64>) -> String {
    value.map(|value| value.to_string()).unwrap_or_default()
}

fn three(values: Option<&[f64]>) -> [String; 3] {
    let values = values.unwrap_or_default();
    [0, 1, 2].map(|axis| cell(values.get(axis).copied()))
}

/// The columns that a first result makes.
#[cfg(test)]
pub(crate) fn header(report: &v1::StepReport) -> Vec<String> {
    let goals = report.goals.iter().map(of_goal).collect();
    Columns::of(report, goals).header()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    fn leaking() -> v1::FluidResult {
        v1::FluidResult {
            pressure: 3.0,
            tightness: v1::Tightness::Leaks.into(),
            blow_off_low: Some(3.0),
            blow_off_high: Some(3.03),
            wet_area: 0.5,
            force: vec![0.0, 0.0, -1.0],
            leak_path: Some(v1::LeakPath {
                margin: 3.25,
                margin_over_pressure: 0.25,
                ..Default::default()
            }),
            ..Default::default()
        }
    }

    #[test]
    fn a_row_has_a_cell_for_every_column_and_numbers_keep_their_digits() {
        let obstacle = v1::ObstacleResult {
            force: vec![0.1, 0.0, -2.0],
            ..Default::default()
        };
        let report = v1::StepReport {
            step: 1,
            obstacles: BTreeMap::from([("top".to_owned(), obstacle)]),
            supports: BTreeMap::from([("base".to_owned(), v1::SupportResult::default())]),
            probes: BTreeMap::from([("tip".to_owned(), v1::ProbeResult::default())]),
            fluids: BTreeMap::from([("water".to_owned(), leaking())]),
            strain_energy: 0.1 + 0.2,
            ..Default::default()
        };
        let columns = Columns::of(&report, Vec::new());
        let (header, row) = (columns.header(), columns.row(&report, &Travels::default()));
        assert_eq!(header.len(), row.len());
        let of = |name: &str| {
            let index = header.iter().position(|column| column == name).unwrap();
            row[index].as_str()
        };
        assert_eq!(of("strain_energy"), "0.30000000000000004");
        assert_eq!((of("top.force_z"), of("top.travel")), ("-2", ""));
        assert_eq!(of("fluid.water.tightness"), "leaks");
        let bracket = ["blow_off_low", "blow_off_high"].map(|end| format!("fluid.water.{end}"));
        assert_eq!(bracket.map(|end| of(&end).to_owned()), ["3", "3.03"]);
        assert_eq!(of("fluid.water.margin_over_pressure"), "0.25");
        assert_eq!(
            (of("fluid.water.force_z"), of("fluid.water.wet_area")),
            ("-1", "0.5")
        );
        assert_eq!((of("base.force_x"), of("tip.pressure")), ("", ""));
        let other = v1::StepReport::default();
        assert_eq!(columns.row(&other, &Travels::default()).len(), row.len());
    }
}
