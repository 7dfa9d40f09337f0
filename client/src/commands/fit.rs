//! `fit`: the constants of a law of rubber from test curves.
//!
//! Test curves of the material in closed form, or curves that the scene itself gives ([`through`]). What goes to
//! stdout is TOML: the fit as comments, then the material for the scene.

mod laws;
mod through;

use std::path::Path;

use serde_json::{Value, json};
use signorini::calibration::{Calibrated, Fitted, Test, TestKind, Weighting, calibrate, stress};
use signorini::scene::RubberModel;
use signorini_client::bounded_file;

use crate::arguments::{FitArguments, input};
use crate::report::curve_plot::{Plot, Series};
use crate::report::{goal_curves, test_curves};
use crate::terminal::exit::{Exit, Failure};
use crate::terminal::stdout::print;
use crate::terminal::text::{note, number, one_line, percent, with_error};
use crate::terminal::whole_file;
use laws::{by_name, is_list, keys, of_message};

/// Bytes of a file of test curves.
const MOST_BYTES: u64 = 16 << 20;
/// Mean error over the stress from which on a law does not follow tests: scatter of one sample to the next
/// is below it; chosen.
const POOR: f64 = 0.2;
/// Points of a drawn curve.
const DRAWN: u32 = 120;

/// A law with what is not fitted.
struct Law {
    group: String,
    model: RubberModel,
    bulk_modulus: Option<f64>,
}

pub(super) async fn run(arguments: FitArguments) -> Result<Exit, Failure> {
    let (law, steps) = law(&arguments)?;
    let bytes = bounded_file::read(&arguments.data, MOST_BYTES);
    let bytes = bytes.map_err(|error| Failure::unreadable(&arguments.data, &error))?;
    if goal_curves::has_tests(&bytes) {
        of_tests(&arguments, &law, &bytes)
    } else {
        Box::pin(of_scene(&arguments, &law, (&bytes, steps))).await
    }
}

/// From curves of the scene.
async fn of_scene(
    arguments: &FitArguments,
    law: &Law,
    (bytes, steps): (&[u8], usize),
) -> Result<Exit, Failure> {
    if arguments.model.is_some() {
        let message = "--model is for test curves of the material: put the law into the scene, with constants to \
                       begin from";
        return Err(Failure::new(Exit::Usage, message));
    }
    let curves = goal_curves::read(bytes, steps)
        .map_err(|error| Failure::new(Exit::Invalid, error.to_string()).about(&arguments.data))?;
    let through = through::fit(arguments, law, &curves).await?;
    let fit = &through.fit;
    let poor = (!arguments.absolute && fit.misfit > POOR).then(|| poor(fit));
    for warning in unstable(fit, &[]).chain(loose(fit)).chain(poor) {
        note(&format!("warning: {warning}\n"));
    }
    if let Some(path) = &arguments.plot {
        write(path, &through::plot(&through, &curves))?;
    }
    let text = if arguments.json {
        let mut object = object(fit, &[]);
        if let Some(keys) = object.as_object_mut() {
            keys.insert("points".to_owned(), curves.points.len().into());
            keys.insert("solves".to_owned(), through.solves.into());
        }
        format!("{object}\n")
    } else {
        through::table(&through, &curves) + &snippet(law, &fit.model)
    };
    print(&text)?;
    Ok(Exit::Ok)
}

/// From test curves of the material.
fn of_tests(arguments: &FitArguments, law: &Law, bytes: &[u8]) -> Result<Exit, Failure> {
    let tests = read(bytes).map_err(|failure| failure.about(&arguments.data))?;
    let weighting = if arguments.absolute {
        Weighting::Absolute
    } else {
        Weighting::Relative
    };
    let fit = calibrate(&law.model, &tests, weighting);
    let fit = fit.map_err(|error| Failure::new(Exit::Invalid, error.to_string()))?;
    let poor = (!arguments.absolute && fit.misfit > POOR).then(|| poor(&fit));
    for warning in warnings(&fit, &tests).into_iter().chain(poor) {
        note(&format!("warning: {warning}\n"));
    }
    if let Some(path) = &arguments.plot {
        write(path, &plot(&fit, &tests))?;
    }
    let text = if arguments.json {
        format!("{}\n", object(&fit, &tests))
    } else {
        table(&fit, &tests, weighting) + &snippet(law, &fit.model)
    };
    print(&text)?;
    Ok(Exit::Ok)
}

fn write(path: &Path, plot: &Plot) -> Result<(), Failure> {
    let written = whole_file::write(path, plot.svg().as_bytes());
    written.map_err(|error| Failure::unwritable(path, &error))
}

/// The law that the arguments name, or the scene, and the number of steps of that.
fn law(arguments: &FitArguments) -> Result<(Law, usize), Failure> {
    let scene = input::changed_scene(&arguments.scene)?;
    let names: Vec<&str> = scene
        .materials
        .iter()
        .map(|one| one.group.as_str())
        .collect();
    let usage = |message: String| Failure::new(Exit::Usage, message);
    let steps = scene.steps.len().max(1);
    let material = match (&arguments.group, &scene.materials[..]) {
        (None, [material]) => material,
        (None, _) => {
            let names = names.join(", ");
            return Err(usage(format!("name the material by --group: {names}")));
        }
        (Some(name), all) => all.iter().find(|one| one.group == *name).ok_or_else(|| {
            let names = names.join(", ");
            usage(format!("no material \"{name}\"; the scene has: {names}"))
        })?,
    };
    let (own, bulk_modulus) = of_message(material);
    let named = arguments.model.as_deref();
    let named = named.and_then(|name| by_name(name, usize::from(arguments.terms)));
    let model = named.or(own).ok_or_else(|| {
        usage(format!(
            "material \"{}\" has no law of rubber that is fitted: name one by --model",
            material.group
        ))
    })?;
    let law = Law {
        group: material.group.clone(),
        model,
        bulk_modulus,
    };
    Ok((law, steps))
}

/// The points of a table.
fn read(bytes: &[u8]) -> Result<Vec<Test>, Failure> {
    let points = test_curves::read(bytes);
    let points = points.map_err(|error| Failure::new(Exit::Invalid, error.to_string()))?;
    let kind = |name: &str| TestKind::ALL.into_iter().find(|kind| kind.name() == name);
    let tests = points.iter().filter_map(|point| {
        Some(Test {
            kind: kind(point.test)?,
            stretch: point.stretch,
            stress: point.stress,
        })
    });
    Ok(tests.collect())
}

/// Points of a kind, and the least and largest stretch of them; none without points.
fn range(tests: &[Test], kind: TestKind) -> Option<(usize, [f64; 2])> {
    let own = tests.iter().filter(|test| test.kind == kind);
    let count = own.clone().count();
    let [least, most] = own.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], test| {
        [least.min(test.stretch), most.max(test.stretch)]
    });
    (count > 0).then_some((count, [least, most]))
}

/// Whether a stretch on a way lies among the tests.
fn is_tested(way: &str, stretch: f64, tests: &[Test]) -> bool {
    let kind = match way {
        "uniaxial tension" | "uniaxial compression" => TestKind::Uniaxial,
        "planar tension" => TestKind::Planar,
        _ => TestKind::Equibiaxial,
    };
    range(tests, kind).is_some_and(|(_, [least, most])| (least..=most).contains(&stretch))
}

/// What a user should know of a fit.
fn warnings(fit: &Calibrated, tests: &[Test]) -> Vec<String> {
    let kinds = TestKind::ALL
        .into_iter()
        .filter(|kind| range(tests, *kind).is_some());
    let alone = (kinds.count() == 1).then(|| {
        "tests of one kind say little about other deformations: add planar or equibiaxial ones"
            .to_owned()
    });
    unstable(fit, tests)
        .chain(loose(fit))
        .chain(alone)
        .collect()
}

/// Where the law is not stable.
fn unstable<'a>(fit: &'a Calibrated, tests: &'a [Test]) -> impl Iterator<Item = String> + 'a {
    fit.unstable.iter().map(|one| {
        let place = if is_tested(one.way, one.stretch, tests) {
            ", which the tests reach"
        } else {
            ""
        };
        let (way, stretch) = (one.way, number(one.stretch));
        format!("the law is not stable (Drucker) in {way} from a stretch of {stretch} on{place}")
    })
}

/// Which constants are not determined.
fn loose(fit: &Calibrated) -> Option<String> {
    let loose = fit.constants.iter().filter(|one| one.half_width.is_none());
    let loose: Vec<&str> = loose.map(|one| one.name.as_str()).collect();
    (!loose.is_empty()).then(|| {
        let names = loose.join(", ");
        format!("the tests do not determine {names}: fewer constants, or more kinds of tests, do")
    })
}

/// What is told of a law that does not follow the tests.
fn poor(fit: &Calibrated) -> String {
    format!(
        "the law misses the points by {} in the mean: look at the picture (--plot); another law, or \
         other points, may be needed",
        percent(fit.misfit)
    )
}

/// The fit as comments.
fn table(fit: &Calibrated, tests: &[Test], weighting: Weighting) -> String {
    let counts = TestKind::ALL.into_iter().filter_map(|kind| {
        let (count, _) = range(tests, kind)?;
        Some(format!("{count} {kind}"))
    });
    let counts: Vec<String> = counts.collect();
    let size = |value: f64| match weighting {
        Weighting::Relative => percent(value),
        Weighting::Absolute => number(value),
    };
    let mut text = format!(
        "# {} to {} points: {}\n# error {}, {} at most\n",
        fit.model.name(),
        tests.len(),
        counts.join(", "),
        size(fit.misfit),
        size(fit.largest),
    );
    text.push_str(&constants(fit));
    text
}

/// The constants with their intervals, as comments.
fn constants(fit: &Calibrated) -> String {
    let mut text = String::new();
    for Fitted {
        name,
        value,
        half_width,
    } in &fit.constants
    {
        let value = with_error(*value, *half_width);
        text.push_str(&format!("# {name:<16} {value}\n"));
    }
    text
}

/// The material for a scene.
fn snippet(law: &Law, model: &RubberModel) -> String {
    let group = toml::Value::String(law.group.clone());
    let mut text = format!("[material.{group}]\nmodel = \"{}\"\n", model.name());
    let is_list = is_list(model);
    for (key, values) in keys(model) {
        let values: Vec<String> = values.iter().map(|value| format!("{value:?}")).collect();
        let values = values.join(", ");
        let line = if is_list {
            format!("{key} = [{values}]\n")
        } else {
            format!("{key} = {values}\n")
        };
        text.push_str(&line);
    }
    if let Some(bulk_modulus) = law.bulk_modulus {
        text.push_str(&format!("bulk_modulus = {bulk_modulus:?}\n"));
    }
    text
}

fn object(fit: &Calibrated, tests: &[Test]) -> Value {
    let constants = fit
        .constants
        .iter()
        .map(|one| json!({ "name": one.name, "value": one.value, "half_width": one.half_width }));
    let unstable = fit.unstable.iter().map(|one| {
        let is_tested = is_tested(one.way, one.stretch, tests);
        json!({ "way": one.way, "stretch": one.stretch, "is_tested": is_tested })
    });
    json!({
        "model": fit.model.name(),
        "points": tests.len(),
        "error": fit.misfit,
        "largest_error": fit.largest,
        "constants": constants.collect::<Vec<_>>(),
        "unstable": unstable.collect::<Vec<_>>(),
    })
}

/// Points and curves of each kind of test.
fn plot(fit: &Calibrated, tests: &[Test]) -> Plot {
    let series = TestKind::ALL.into_iter().filter_map(|kind| {
        let (_, [least, most]) = range(tests, kind)?;
        let [least, most] = [least.min(1.0), most.max(1.0)];
        let at = |step: u32| least + (most - least) * f64::from(step) / f64::from(DRAWN);
        let curve = (0..=DRAWN).filter_map(|step| {
            let stress = stress(&fit.model, kind, at(step)).ok()?;
            Some([at(step), stress])
        });
        let own = tests.iter().filter(|test| test.kind == kind);
        Some(Series {
            name: kind.name().into(),
            points: own.map(|test| [test.stretch, test.stress]).collect(),
            curve: curve.collect(),
        })
    });
    Plot {
        title: one_line(fit.model.name()).into_owned(),
        axes: ["stretch", "nominal stress"],
        series: series.collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn yeoh() -> RubberModel {
        RubberModel::Yeoh {
            c10: 0.2,
            c20: -0.001,
            c30: 0.00005,
        }
    }

    #[test]
    fn the_snippet_is_a_material_of_a_scene() {
        let law = Law {
            group: "soft part".to_owned(),
            model: yeoh(),
            bulk_modulus: Some(1e3),
        };
        let text = snippet(&law, &yeoh());
        let table: toml::Table = text.parse().unwrap();
        let material = table["material"]["soft part"].as_table().unwrap();
        assert_eq!(material["model"].as_str(), Some("yeoh"));
        assert_eq!(material["c30"].as_float(), Some(0.00005));
        assert_eq!(material["bulk_modulus"].as_float(), Some(1e3));
    }

    #[test]
    fn laws_are_found_by_the_names_of_scenes() {
        let names = [
            "neo-hookean",
            "mooney-rivlin",
            "yeoh",
            "ogden",
            "polynomial",
            "gent",
            "arruda-boyce",
            "van-der-waals",
        ];
        for name in names {
            assert_eq!(by_name(name, 3).unwrap().name(), name);
        }
    }
}
