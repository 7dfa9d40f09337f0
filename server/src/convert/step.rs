//! Load steps and obstacle updates into the library's steps.

use std::time::Duration;

use bytes::Bytes;
use signorini::scene::{
    FluidLoad, FluidTarget, ObstacleTarget, Step, SupportTarget, TractionTarget,
};
use signorini_proto::v1 as wire;
use signorini_proto::v1::fluid_target::Load;

use super::values::values;
use super::{Faults, components, named};
use crate::config::LONGEST_SECONDS;
use crate::fault::Fault;

const MAXIMUM_INCREMENTS: i32 = 100_000;
const MAXIMUM_TARGETS: usize = 1000;
const MAXIMUM_FLUIDS: usize = 64;

/// One update of a session: converted, and as it came.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Update {
    pub(crate) sequence: i64,
    pub(crate) step: Step,
    pub(crate) max_wall_time: Option<Duration>,
    /// The `SolveRequest` that brought it, encoded.
    pub(crate) encoded: Bytes,
}

/// Converts a `load_step` that came as `encoded`.
///
/// # Errors
/// Paths of malformed keys.
pub(crate) fn load_step(message: &wire::LoadStepUpdate, encoded: Bytes) -> Result<Update, Fault> {
    let mut faults = Faults::default();
    let default = wire::LoadStep::default();
    let step = step(
        message.step.as_ref().unwrap_or(&default),
        "step",
        &mut faults,
    );
    faults.outcome()?;
    Ok(Update {
        sequence: message.sequence,
        step,
        max_wall_time: duration(message.max_wall_time.as_ref(), "max_wall_time")?,
        encoded,
    })
}

/// Converts an `obstacle_update` that came as `encoded`: a step that keeps the load.
///
/// # Errors
/// Paths of malformed keys.
pub(crate) fn obstacle_update(
    message: wire::ObstacleUpdate,
    encoded: Bytes,
) -> Result<Update, Fault> {
    if message.obstacles.is_empty() {
        return Err(Fault::request(
            "obstacle_update.obstacles",
            "names no obstacle",
        ));
    }
    let step = wire::LoadStep {
        increments: message.increments,
        obstacles: message.obstacles,
        ..wire::LoadStep::default()
    };
    let update = wire::LoadStepUpdate {
        sequence: message.sequence,
        step: Some(step),
        max_wall_time: message.max_wall_time,
    };
    load_step(&update, encoded)
}

/// Converts a step; `path` is its key.
pub(crate) fn step(message: &wire::LoadStep, path: &str, faults: &mut Faults) -> Step {
    faults.at_most(
        &message.obstacles,
        MAXIMUM_TARGETS,
        &format!("{path}.obstacle"),
    );
    faults.at_most(
        &message.supports,
        MAXIMUM_TARGETS,
        &format!("{path}.support"),
    );
    let most = MAXIMUM_TARGETS;
    let mut obstacles = Vec::new();
    for (index, target) in message.obstacles.iter().take(most).enumerate() {
        let path = format!("{path}.{}", named("obstacle", &target.name, index));
        obstacles.push(obstacle(target, &path, faults));
    }
    let mut supports = Vec::new();
    for (index, target) in message.supports.iter().take(most).enumerate() {
        let path = format!("{path}.{}", named("support", &target.name, index));
        supports.push(support(target, &path, faults));
    }
    Step {
        increments: increments(message.increments, path, faults),
        load: message.load,
        obstacles,
        supports,
        tractions: tractions(&message.tractions, path, faults),
        fluids: fluids(&message.fluids, path, faults),
        body_force: values(
            message.body_force.as_ref(),
            &format!("{path}.body_force.values"),
            faults,
        ),
    }
}

fn tractions(
    targets: &[wire::TractionTarget],
    path: &str,
    faults: &mut Faults,
) -> Vec<TractionTarget> {
    faults.at_most(targets, MAXIMUM_TARGETS, &format!("{path}.traction"));
    let mut tractions = Vec::new();
    for (index, target) in targets.iter().take(MAXIMUM_TARGETS).enumerate() {
        let path = format!("{path}.{}", named("traction", &target.name, index));
        let key = format!("{path}.values");
        let given = values(target.values.as_ref(), &key, faults);
        if given.is_none() {
            faults.add(key, "is required");
        }
        tractions.push(TractionTarget {
            name: faults.name(&target.name, &path),
            values: given.unwrap_or_default(),
        });
    }
    tractions
}

fn fluids(targets: &[wire::FluidTarget], path: &str, faults: &mut Faults) -> Vec<FluidTarget> {
    faults.at_most(targets, MAXIMUM_FLUIDS, &format!("{path}.fluid"));
    let mut fluids = Vec::new();
    for (index, target) in targets.iter().take(MAXIMUM_FLUIDS).enumerate() {
        let path = format!("{path}.{}", named("fluid", &target.name, index));
        let load = match target.load {
            Some(Load::Pressure(pressure)) => FluidLoad::To(pressure),
            Some(Load::ToBlowOff(most)) => FluidLoad::ToBlowOff(most),
            None => {
                faults.add(format!("{path}.pressure"), "is required");
                FluidLoad::To(0.0)
            }
        };
        fluids.push(FluidTarget {
            name: faults.name(&target.name, &path),
            load,
        });
    }
    fluids
}

fn increments(number: Option<i32>, path: &str, faults: &mut Faults) -> u32 {
    let number = number.unwrap_or(1);
    if !(1..=MAXIMUM_INCREMENTS).contains(&number) {
        let message = format!("must lie between 1 and {MAXIMUM_INCREMENTS}, not {number}");
        faults.add(format!("{path}.increments"), message);
    }
    u32::try_from(number).unwrap_or(1)
}

fn obstacle(target: &wire::ObstacleTarget, path: &str, faults: &mut Faults) -> ObstacleTarget {
    ObstacleTarget {
        name: faults.name(&target.name, path),
        translation: faults.optional_vector(&target.translation, &format!("{path}.translation")),
        rotation: faults.optional_vector(&target.rotation, &format!("{path}.rotation")),
        force: components(target.force),
        moment: components(target.moment),
        friction: faults.not_negative(target.friction, &format!("{path}.friction")),
    }
}

fn support(target: &wire::SupportTarget, path: &str, faults: &mut Faults) -> SupportTarget {
    SupportTarget {
        name: faults.name(&target.name, path),
        displacement: components(target.displacement),
        translation: faults.optional_vector(&target.translation, &format!("{path}.translation")),
        rotation: faults.optional_vector(&target.rotation, &format!("{path}.rotation")),
        about: faults.optional_vector(&target.about, &format!("{path}.about")),
        values: values(target.values.as_ref(), &format!("{path}.values"), faults),
        force: components(target.force),
        moment: components(target.moment),
    }
}

/// A duration above zero and of at most [`LONGEST_SECONDS`].
///
/// # Errors
/// For any other.
pub(crate) fn duration(
    message: Option<&prost_types::Duration>,
    path: &str,
) -> Result<Option<Duration>, Fault> {
    let Some(message) = message else {
        return Ok(None);
    };
    let longest = Duration::from_secs(LONGEST_SECONDS);
    match Duration::try_from(*message) {
        Ok(duration) if !duration.is_zero() && duration <= longest => Ok(Some(duration)),
        Ok(_) | Err(_) => {
            let rule = format!("must be above zero and at most {LONGEST_SECONDS} seconds");
            Err(Fault::request(path, rule))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_end_at_thirty_days() {
        let asked = |seconds, nanos| {
            let message = prost_types::Duration { seconds, nanos };
            duration(Some(&message), "ttl")
        };
        let longest = LONGEST_SECONDS.cast_signed();
        let expected = Duration::from_secs(LONGEST_SECONDS);
        assert_eq!(asked(longest, 0), Ok(Some(expected)));
        for (seconds, nanos) in [(longest, 1), (i64::MAX, 0), (0, 0), (-1, 0)] {
            let fault = asked(seconds, nanos).unwrap_err();
            assert!(matches!(fault, Fault::RequestInvalid(one) if one.path == "ttl"));
        }
    }

    #[test]
    fn pressures_of_fluids_reach_the_library_and_one_without_is_refused_by_its_key() {
        let target = |name: &str, load| wire::FluidTarget {
            name: name.into(),
            load,
        };
        let mut message = wire::LoadStep {
            fluids: vec![
                target("water", Some(Load::Pressure(3.0))),
                target("oil", Some(Load::ToBlowOff(50.0))),
            ],
            ..Default::default()
        };
        let mut faults = Faults::default();
        let found = step(&message, "step", &mut faults).fluids;
        assert_eq!(faults.outcome(), Ok(()));
        let loads: Vec<FluidLoad> = found.iter().map(|one| one.load).collect();
        assert_eq!(loads, [FluidLoad::To(3.0), FluidLoad::ToBlowOff(50.0)]);
        message.fluids[1].load = None;
        message.fluids.extend(vec![target("more", None); 63]);
        let mut faults = Faults::default();
        let found = step(&message, "step", &mut faults).fluids;
        assert_eq!(found.len(), 64);
        match faults.outcome() {
            Err(Fault::SceneInvalid(all)) => {
                let paths: Vec<&str> = all.iter().map(|one| one.path.as_str()).collect();
                assert_eq!(paths[..2], ["step.fluid", "step.fluid.oil.pressure"]);
            }
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn the_rigid_motion_of_a_support_reaches_the_library() {
        let mut message = wire::LoadStep {
            supports: vec![wire::SupportTarget {
                name: "base".into(),
                rotation: vec![0.0, 0.0, 20.0],
                about: vec![1.0, 2.0, 3.0],
                ..Default::default()
            }],
            ..Default::default()
        };
        let mut faults = Faults::default();
        let found = step(&message, "step", &mut faults);
        let expected = SupportTarget {
            name: "base".into(),
            rotation: Some([0.0, 0.0, 20.0]),
            about: Some([1.0, 2.0, 3.0]),
            ..SupportTarget::default()
        };
        assert_eq!((found.supports, faults.outcome()), (vec![expected], Ok(())));
        message.supports[0].about.pop();
        let mut faults = Faults::default();
        step(&message, "step", &mut faults);
        match faults.outcome() {
            Err(Fault::SceneInvalid(all)) => assert_eq!(all[0].path, "step.support.base.about"),
            other => panic!("{other:?}"),
        }
    }
}
