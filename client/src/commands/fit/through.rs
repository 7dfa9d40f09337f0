//! The constants of a law from measured curves of a scene: forces of its tools, reactions, displacements. Each
//! trial is one solve of the scene, with the derivatives of the goals by the constants.

use std::collections::BTreeMap;

use signorini::calibration::{Calibrated, Measured, Modelled, Progress, Search, Weighting};
use signorini::scene::RubberModel;
use signorini_client::scene_file::Override;
use signorini_client::solve::{Attach, Event, Solve};
use signorini_client::{Client, NewSession};
use signorini_proto::v1;

use super::Law;
use super::laws::{is_list, keys};
use crate::arguments::connection::Connection;
use crate::arguments::{FitArguments, SceneArguments, input};
use crate::report::curve_plot::{Plot, Series};
use crate::report::goal_curves::{GoalCurves, Point};
use crate::terminal::exit::{Exit, Failure};
use crate::terminal::text::{note, number, percent};

/// How many times larger a measured curve may be than that of the first constants: units differ by a
/// thousand, first guesses of a modulus by less.
const UNITS: f64 = 300.0;

/// A fit with the solves that it took.
pub(super) struct Through {
    pub(super) fit: Calibrated,
    pub(super) solves: u32,
    /// What the scene gives with the constants, in the order of the points.
    pub(super) values: Vec<f64>,
}

/// Finds the constants.
pub(super) async fn fit(
    arguments: &FitArguments,
    law: &Law,
    curves: &GoalCurves,
) -> Result<Through, Failure> {
    let measured = curves.points.iter().map(|point| Measured {
        curve: point.goal,
        value: point.value,
    });
    let measured: Vec<Measured> = measured.collect();
    let weighting = if arguments.absolute {
        Weighting::Absolute
    } else {
        Weighting::Relative
    };
    let refused = |error: signorini::calibration::CalibrationError| {
        Failure::new(Exit::Invalid, error.to_string())
    };
    let mut search = Search::new(&law.model, &measured, weighting).map_err(refused)?;
    let names: Vec<String> = search.names().map(str::to_owned).collect();
    let trial = Trial {
        arguments: &arguments.scene,
        law,
        curves,
        names: &names,
    };
    let connection = Connection::open(&arguments.scene).await?;
    let searched = trial.search(&connection.client, &mut search).await;
    connection.close().await;
    let values = searched?;
    Ok(Through {
        solves: search.trials(),
        fit: search.finish().map_err(refused)?,
        values,
    })
}

/// What all trials share.
struct Trial<'a> {
    arguments: &'a SceneArguments,
    law: &'a Law,
    curves: &'a GoalCurves,
    /// Keys of the constants.
    names: &'a [String],
}

impl Trial<'_> {
    /// Solves trial after trial; the values of the best one.
    async fn search(&self, client: &Client, search: &mut Search) -> Result<Vec<f64>, Failure> {
        let (mut best, mut least) = (Vec::new(), f64::INFINITY);
        loop {
            let modelled = self.solved(client, &search.trial()).await?;
            if modelled.is_none() && search.trials() == 0 {
                let message =
                    "the steps do not converge with the constants of the scene: begin from others";
                return Err(Failure::new(Exit::NotConverged, message));
            }
            let error = modelled.as_ref().map(|modelled| self.error(modelled));
            let told = error.map_or_else(
                || "the steps do not converge".to_owned(),
                |error| format!("mean error {}", percent(error)),
            );
            note(&format!("solve {}: {told}\n", search.trials() + 1));
            if let Some(modelled) = modelled.as_ref().filter(|_| search.trials() == 0) {
                self.check_signs(modelled)?;
            }
            if let (Some(error), Some(modelled)) = (error, &modelled)
                && error < least
            {
                (best, least) = (modelled.values.clone(), error);
            }
            match search.take(modelled) {
                Progress::Again => {}
                Progress::Found => return Ok(best),
                Progress::Stuck => {
                    note(
                        "warning: no other constants come nearer: the last change was not small\n",
                    );
                    return Ok(best);
                }
            }
        }
    }

    /// Refuses forces that point the other way than those of the scene, which no constants of a stable
    /// law turn, and says where sizes are so far apart that units may be.
    fn check_signs(&self, modelled: &Modelled) -> Result<(), Failure> {
        for (goal, name) in self.curves.goals.iter().enumerate() {
            let pairs = self.curves.points.iter().zip(&modelled.values);
            let own = pairs.filter(|(point, _)| point.goal == goal);
            let [mut along, mut measured] = [0.0; 2];
            let mut found = 0.0;
            for (point, value) in own {
                along += point.value * value;
                measured += point.value * point.value;
                found += value * value;
            }
            let sizes = [measured, found].map(f64::sqrt);
            let is_force = name.starts_with("force.") || name.starts_with("reaction.");
            if is_force && points_the_other_way(along, sizes) {
                let message = format!(
                    "{name} of the table has the other sign than that of the scene: a force is what the \
                     tool or the support exerts on the body, so that a lid that moves down has one below \
                     zero"
                );
                return Err(Failure::new(Exit::Invalid, message));
            }
            if let Some(times) = far_apart(sizes) {
                note(&format!(
                    "warning: {name} of the table is {} times that of the scene with its first constants: \
                     are the units those of the mesh and the constants, and does a model of a quarter \
                     have a quarter of the force?\n",
                    number(times)
                ));
            }
        }
        Ok(())
    }

    /// Root of the mean square of the errors over the largest value of their curves.
    fn error(&self, modelled: &Modelled) -> f64 {
        let points = &self.curves.points;
        let largest = |goal: usize| {
            let own = points.iter().filter(|point| point.goal == goal);
            own.fold(f64::MIN_POSITIVE, |most, point| most.max(point.value.abs()))
        };
        let errors = points.iter().zip(&modelled.values);
        let squares =
            errors.map(|(point, value)| ((value - point.value) / largest(point.goal)).powi(2));
        (squares.sum::<f64>() / points.len().max(1) as f64).sqrt()
    }

    /// What the scene gives with a law; none where its steps do not converge.
    async fn solved(
        &self,
        client: &Client,
        model: &RubberModel,
    ) -> Result<Option<Modelled>, Failure> {
        let mut arguments = self.arguments.clone();
        for (key, values) in keys(model) {
            let path = format!("material.\"{}\".{key}", self.law.group);
            let value = match (&values[..], is_list(model)) {
                ([value], false) => toml::Value::Float(*value),
                (values, _) => {
                    let all = values.iter().copied().map(toml::Value::Float);
                    toml::Value::Array(all.collect())
                }
            };
            let change = Override::new(&path, value);
            arguments
                .overrides
                .push(change.map_err(|error| Failure::new(Exit::Usage, error))?);
        }
        let mut input = input::load(&arguments)?;
        input.scene.accuracy = None;
        input.scene.output.get_or_insert_default().fields.clear();
        let parameter = |name: &String| {
            let key = name.replace('[', ".").replace(']', "");
            format!("material.{}.{key}", self.law.group)
        };
        input.scene.gradients = vec![v1::Gradient {
            of: self.curves.goals.clone(),
            to: self.names.iter().map(parameter).collect(),
            // Points lie between increments.
            at: v1::AskedAt::Increments.into(),
        }];
        if input.scene.steps.is_empty() {
            input.scene.steps.push(v1::LoadStep::default());
        }
        input.upload(client).await?;
        let parameters = input.scene.gradients.iter().flat_map(|one| one.to.clone());
        let parameters: Vec<String> = parameters.collect();
        let Some(reports) = reports(client, input.scene).await? else {
            return Ok(None);
        };
        self.modelled(&reports, &parameters).map(Some)
    }

    /// Values and derivatives at the times of the points, between increments along lines.
    fn modelled(
        &self,
        reports: &[v1::StepReport],
        parameters: &[String],
    ) -> Result<Modelled, Failure> {
        let mut known: Vec<(f64, BTreeMap<&str, Vec<f64>>)> = vec![(0.0, BTreeMap::new())];
        for report in reports {
            if let Some(cause) = &report.goals_refused {
                let message = format!("the goals have no derivatives: {cause}");
                return Err(Failure::new(Exit::Invalid, message));
            }
            let own = report.goals.iter().map(|(name, goal)| {
                let slopes = parameters.iter();
                let slopes =
                    slopes.map(|one| goal.derivatives.get(one).copied().unwrap_or_default());
                let row: Vec<f64> = std::iter::once(goal.value).chain(slopes).collect();
                (name.as_str(), row)
            });
            known.push((report.time, own.collect()));
        }
        let rows = self.curves.points.iter();
        let rows: Vec<Vec<f64>> = rows
            .map(|point| self.at(&known, point, parameters.len()))
            .collect();
        let column = |place: usize| {
            rows.iter()
                .map(|row| row.get(place).copied().unwrap_or_default())
                .collect()
        };
        Ok(Modelled {
            values: column(0),
            slopes: (1..=parameters.len()).map(column).collect(),
        })
    }

    /// The row of a goal at a time.
    fn at(
        &self,
        known: &[(f64, BTreeMap<&str, Vec<f64>>)],
        point: &Point,
        parameters: usize,
    ) -> Vec<f64> {
        let name = self.curves.goals.get(point.goal).map_or("", String::as_str);
        let rest = vec![0.0; parameters + 1];
        let row = |place: usize| {
            known
                .get(place)
                .and_then(|one| one.1.get(name))
                .unwrap_or(&rest)
        };
        let after = known.iter().position(|one| one.0 >= point.time - 1e-12);
        let after = after.unwrap_or(known.len() - 1).max(1);
        let ends = [after - 1, after].map(|place| known.get(place).map_or(0.0, |one| one.0));
        let share = ((point.time - ends[0]) / (ends[1] - ends[0])).clamp(0.0, 1.0);
        let pairs = row(after - 1).iter().zip(row(after));
        pairs.map(|(a, b)| a + share * (b - a)).collect()
    }
}

/// Whether a measured curve and that of the scene are opposite, from their product and their sizes.
fn points_the_other_way(along: f64, [measured, found]: [f64; 2]) -> bool {
    along < -0.5 * measured * found
}

/// How many times larger a measured curve is than that of the scene; none where they are alike.
fn far_apart([measured, found]: [f64; 2]) -> Option<f64> {
    (measured > UNITS * found || found > UNITS * measured).then(|| measured / found)
}

/// All increments of a scene; none where they do not converge.
async fn reports(
    client: &Client,
    scene: v1::Scene,
) -> Result<Option<Vec<v1::StepReport>>, Failure> {
    let steps = scene.steps.clone();
    let new = NewSession {
        scene,
        on_disconnect: v1::DisconnectPolicy::CancelStep,
        ..Default::default()
    };
    let (session, _) = client.create_session(new).await?;
    let outcome = driven(client, &session.name, steps).await;
    // What is wanted of it is here; one that is gone is no fault.
    let _gone = client.delete_session(&session.name).await;
    outcome
}

async fn driven(
    client: &Client,
    session: &str,
    steps: Vec<v1::LoadStep>,
) -> Result<Option<Vec<v1::StepReport>>, Failure> {
    let Solve {
        mut updates,
        mut events,
        ..
    } = client.solve(session, Attach::default()).await?;
    let mut reports = Vec::new();
    for step in steps {
        updates.load_step(step).await?;
        loop {
            match events.next().await? {
                Some(Event::Increment(increment)) => {
                    let is_last = increment.last;
                    if increment.report.termination() != v1::Termination::Converged {
                        return Ok(None);
                    }
                    reports.push(increment.report);
                    if is_last {
                        break;
                    }
                }
                Some(Event::Rejected { refusal, .. }) => {
                    return Err(signorini_client::ClientError::Refused(refusal).into());
                }
                Some(_) => {}
                None => return Err(signorini_client::ClientError::Closed.into()),
            }
        }
    }
    Ok(Some(reports))
}

/// The fit as comments.
pub(super) fn table(through: &Through, curves: &GoalCurves) -> String {
    let count = |goal: usize| {
        curves
            .points
            .iter()
            .filter(|point| point.goal == goal)
            .count()
    };
    let counts = curves.goals.iter().enumerate();
    let counts = counts.map(|(goal, name)| format!("{} of {name}", count(goal)));
    let counts: Vec<String> = counts.collect();
    let mut text = format!(
        "# {} to {} points: {}, {} solves\n# error {}, {} at most, each over its value\n",
        through.fit.model.name(),
        curves.points.len(),
        counts.join(", "),
        through.solves,
        number(through.fit.misfit),
        number(through.fit.largest),
    );
    text.push_str(&super::constants(&through.fit));
    text
}

/// Points of each goal and the scene with the constants, over the time.
pub(super) fn plot(through: &Through, curves: &GoalCurves) -> Plot {
    let all = || curves.points.iter().zip(&through.values);
    let series = curves.goals.iter().enumerate().map(|(goal, name)| {
        let own = || all().filter(move |(point, _)| point.goal == goal);
        Series {
            name: name.clone().into(),
            points: own().map(|(point, _)| [point.time, point.value]).collect(),
            curve: own().map(|(point, value)| [point.time, *value]).collect(),
        }
    });
    Plot {
        title: through.fit.model.name().to_owned(),
        axes: ["time", "goal"],
        series: series.collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_of_the_other_sign_and_of_other_units_are_told_apart() {
        assert!(points_the_other_way(-2.0, [1.0, 2.0]) && !points_the_other_way(2.0, [1.0, 2.0]));
        assert!(!points_the_other_way(0.0, [0.0, 2.0]));
        assert_eq!(far_apart([1000.0, 1.0]), Some(1000.0));
        assert_eq!(far_apart([1.0, 20.0]), None);
    }
}
