//! Fluids that creep in between the body and its obstacles.

use signorini::scene::{Film, Fluid, FluidThreshold};
use signorini_proto::v1 as wire;

use super::super::{Faults, named};
use super::boundary::names;

pub(super) fn fluid(message: wire::Fluid, index: usize, faults: &mut Faults) -> Fluid {
    let path = named("fluid", &message.name, index);
    let at = |key: &str| format!("{path}.{key}");
    let film = film(message.film, at("film"), faults);
    let mut groups = |key: &str, given: Vec<String>| {
        if given.is_empty() {
            faults.add(at(key), "names no surface group");
        }
        names(given, at(key), faults)
    };
    Fluid {
        on: groups("on", message.on),
        from: groups("from", message.from),
        dry: names(message.dry, at("dry"), faults),
        name: faults.name(&message.name, &path),
        pressure: faults
            .not_negative(message.pressure, &at("pressure"))
            .unwrap_or(0.0),
        threshold: faults
            .not_negative(message.threshold, &at("threshold"))
            .map_or(FluidThreshold::Fluid, FluidThreshold::Pressure),
        film,
        blow_off_tolerance: message
            .blow_off_tolerance
            .unwrap_or(Fluid::BLOW_OFF_TOLERANCE),
        viscosity: message.viscosity,
    }
}

fn film(number: i32, path: String, faults: &mut Faults) -> Film {
    match wire::Film::try_from(number) {
        Ok(wire::Film::Unspecified | wire::Film::Stays) => Film::Stays,
        Ok(wire::Film::SqueezedOut) => Film::SqueezedOut,
        Err(_) => {
            faults.later(path, format!("number {number} is not known here"));
            Film::Stays
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fault::Fault;

    fn water() -> wire::Fluid {
        wire::Fluid {
            name: "water".into(),
            on: vec!["seal".into(), "flank".into()],
            from: vec!["left".into()],
            dry: vec!["right".into()],
            pressure: Some(2.0),
            threshold: Some(0.5),
            film: wire::Film::SqueezedOut.into(),
            blow_off_tolerance: Some(0.02),
            viscosity: Some(1e-3),
        }
    }

    fn converted(message: wire::Fluid) -> Result<Fluid, Fault> {
        let mut faults = Faults::default();
        let fluid = fluid(message, 0, &mut faults);
        faults.outcome().map(|()| fluid)
    }

    #[test]
    fn a_fluid_reaches_the_library_with_all_it_says() {
        let expected = Fluid {
            name: "water".into(),
            on: vec!["seal".into(), "flank".into()],
            from: vec!["left".into()],
            dry: vec!["right".into()],
            pressure: 2.0,
            threshold: FluidThreshold::Pressure(0.5),
            film: Film::SqueezedOut,
            blow_off_tolerance: 0.02,
            viscosity: Some(1e-3),
        };
        assert_eq!(converted(water()), Ok(expected));
        let bare = wire::Fluid {
            name: "water".into(),
            on: vec!["seal".into()],
            from: vec!["left".into()],
            ..Default::default()
        };
        let expected = Fluid {
            name: "water".into(),
            on: vec!["seal".into()],
            from: vec!["left".into()],
            ..Fluid::default()
        };
        assert_eq!(converted(bare), Ok(expected));
    }

    #[test]
    fn a_fluid_without_its_surface_or_of_a_later_contract_is_refused_by_its_key() {
        let mut message = water();
        message.from.clear();
        let Err(Fault::SceneInvalid(faults)) = converted(message) else {
            unreachable!();
        };
        assert_eq!(faults[0].path, "fluid.water.from");
        let mut message = water();
        message.film = 9;
        match converted(message) {
            Err(Fault::Unsupported(one)) => assert_eq!(one.path, "fluid.water.film"),
            other => panic!("{other:?}"),
        }
    }
}
