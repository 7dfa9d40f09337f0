//! What acts on the surface of the body: supports, loads, obstacles.

use signorini::scene::{
    ContactPair, Obstacle, PenetrationPolicy, Pressure, Profile, Support, SupportLoad, Tie,
    Traction,
};
use signorini_proto::v1 as wire;

use super::super::uploaded::SurfacesByName;
use super::super::values::values;
use super::super::{Faults, components, named, shape};

const MAXIMUM_GROUPS: usize = 1000;

fn surfaces(groups: Vec<String>, path: &str, faults: &mut Faults) -> Vec<String> {
    let path = format!("{path}.on");
    if groups.is_empty() {
        faults.add(&path, "names no surface group");
    }
    names(groups, path, faults)
}

/// Names of groups, possibly none; `path` is their key.
pub(super) fn names(groups: Vec<String>, path: String, faults: &mut Faults) -> Vec<String> {
    faults.at_most(&groups, MAXIMUM_GROUPS, &path);
    let names = groups.into_iter().take(MAXIMUM_GROUPS);
    names.map(|name| faults.name(&name, &path)).collect()
}

pub(super) fn contact(
    message: wire::BodyContact,
    index: usize,
    faults: &mut Faults,
) -> ContactPair {
    let path = named("contact", &message.name, index);
    ContactPair {
        name: faults.name(&message.name, &path),
        between: if message.itself {
            of_one(message.between, &path, faults)
        } else {
            of_two(message.between, &path, faults)
        },
        carries: carries(&message.carries, &path, faults),
        friction: faults
            .not_negative(message.friction, &format!("{path}.friction"))
            .unwrap_or(0.0),
        tresca: faults.not_negative(message.tresca, &format!("{path}.tresca")),
    }
}

pub(super) fn tie(message: wire::Tie, index: usize, faults: &mut Faults) -> Tie {
    let path = named("tie", &message.name, index);
    Tie {
        name: faults.name(&message.name, &path),
        between: between(message.between, &path, faults),
        carries: carries(&message.carries, &path, faults),
    }
}

/// The two groups of the item at `path`.
fn between(groups: Vec<String>, path: &str, faults: &mut Faults) -> [String; 2] {
    let key = format!("{path}.between");
    let count = groups.len();
    if count != 2 {
        faults.add(
            &key,
            format!("names {count} surface groups in the place of two"),
        );
    }
    let mut groups = names(groups, key, faults).into_iter();
    [0, 1].map(|_| groups.next().unwrap_or_default())
}

/// Two different groups of the contact at `path`.
fn of_two(groups: Vec<String>, path: &str, faults: &mut Faults) -> [String; 2] {
    let found = between(groups, path, faults);
    if found[0] == found[1] && !found[0].is_empty() {
        let message = "names the same group twice: a surface that may touch itself is named once, with `self = true`";
        faults.add(format!("{path}.between"), message);
    }
    found
}

/// The group of the contact at `path` whose surface may touch itself, twice.
fn of_one(groups: Vec<String>, path: &str, faults: &mut Faults) -> [String; 2] {
    let key = format!("{path}.between");
    let count = groups.len();
    if count != 1 {
        let message =
            format!("names {count} surface groups beside `self = true` in the place of one");
        faults.add(&key, message);
    }
    let name = names(groups, key, faults).into_iter().next();
    let name = name.unwrap_or_default();
    [name.clone(), name]
}

/// The group that carries; none where the item leaves that open.
fn carries(group: &str, path: &str, faults: &mut Faults) -> Option<String> {
    (!group.is_empty()).then(|| faults.name(group, &format!("{path}.carries")))
}

pub(super) fn support(message: wire::Support, index: usize, faults: &mut Faults) -> Support {
    let path = named("support", &message.name, index);
    let values = values(message.values.as_ref(), &format!("{path}.values"), faults);
    let all = [Some(0.0); 3];
    Support {
        name: faults.name(&message.name, &path),
        on: surfaces(message.on, &path, faults),
        displacement: match (&values, message.displacement, message.normal) {
            (Some(_), None, None) => all,
            (_, displacement, _) => components(displacement),
        },
        normal: message.normal,
        profile: profile(message.profile, &path, faults),
        values,
        load: load(message.load.unwrap_or_default(), &path, faults),
    }
}

fn load(message: wire::SupportLoad, path: &str, faults: &mut Faults) -> SupportLoad {
    SupportLoad {
        force: components(message.force),
        moment: components(message.moment),
        stiffness: components(message.stiffness),
        rotational_stiffness: components(message.rotational_stiffness),
        about: faults.optional_vector(&message.about, &format!("{path}.about")),
    }
}

fn profile(number: i32, path: &str, faults: &mut Faults) -> Profile {
    match wire::SupportProfile::try_from(number) {
        Ok(wire::SupportProfile::Unspecified) => Profile::Constant,
        Ok(wire::SupportProfile::Parabolic) => Profile::Parabolic,
        Err(_) => {
            faults.later(
                format!("{path}.profile"),
                format!("number {number} is not known here"),
            );
            Profile::Constant
        }
    }
}

pub(super) fn traction(message: wire::Traction, index: usize, faults: &mut Faults) -> Traction {
    let path = named("traction", &message.name, index);
    let values = values(message.values.as_ref(), &format!("{path}.values"), faults);
    let key = format!("{path}.value");
    let value = match &values {
        Some(_) => faults.optional_vector(&message.value, &key),
        None => Some(faults.vector(&message.value, &key)),
    };
    Traction {
        name: (!message.name.is_empty()).then(|| faults.name(&message.name, &path)),
        on: surfaces(message.on, &path, faults),
        value: value.unwrap_or_default(),
        values,
    }
}

pub(super) fn pressure(message: wire::Pressure, index: usize, faults: &mut Faults) -> Pressure {
    let path = format!("pressure[{index}]");
    Pressure {
        on: surfaces(message.on, &path, faults),
        value: faults.required(message.value, &format!("{path}.value")),
    }
}

pub(super) fn obstacle(
    message: wire::Obstacle,
    index: usize,
    (named_surfaces, faults): (&SurfacesByName, &mut Faults),
) -> Obstacle {
    let path = named("obstacle", &message.name, index);
    Obstacle {
        name: faults.name(&message.name, &path),
        on: surfaces(message.on, &path, faults),
        shape: shape::shape(
            message.shape,
            &format!("{path}.shape"),
            (named_surfaces, faults),
        ),
        surface: shape::surface(message.surface, &path, faults),
        friction: faults
            .not_negative(message.friction, &format!("{path}.friction"))
            .unwrap_or(0.0),
        tresca: faults.not_negative(message.tresca, &format!("{path}.tresca")),
        initial_penetration: penetration(message.initial_penetration, &path, faults),
    }
}

/// What follows where an obstacle begins inside the body.
fn penetration(number: i32, path: &str, faults: &mut Faults) -> PenetrationPolicy {
    match wire::InitialPenetration::try_from(number) {
        Ok(wire::InitialPenetration::Unspecified | wire::InitialPenetration::Resolve) => {
            PenetrationPolicy::Resolve
        }
        Ok(wire::InitialPenetration::Reject) => PenetrationPolicy::Reject,
        Err(_) => {
            faults.later(
                format!("{path}.initial_penetration"),
                format!("number {number} is not known here"),
            );
            PenetrationPolicy::Resolve
        }
    }
}
