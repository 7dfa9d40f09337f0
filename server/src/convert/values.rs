//! Values of other codes: bytes into rows.

use signorini::scene::{ValuePlace, Values};
use signorini_proto::array;
use signorini_proto::v1 as wire;

use super::Faults;

/// Converts values, if there are any; `path` is their key.
pub(crate) fn values(
    message: Option<&wire::Values>,
    path: &str,
    faults: &mut Faults,
) -> Option<Values> {
    let message = message?;
    let place = match wire::ValuePlace::try_from(message.place) {
        Ok(wire::ValuePlace::Unspecified | wire::ValuePlace::Nodes) => ValuePlace::Nodes,
        Ok(wire::ValuePlace::Facets) => ValuePlace::Facets,
        Ok(wire::ValuePlace::Cells) => ValuePlace::Cells,
        Err(_) => {
            let number = message.place;
            faults.later(path, format!("place number {number} is not known here"));
            ValuePlace::Nodes
        }
    };
    Some(Values {
        place,
        numbers: numbers(&message.numbers, path, faults),
        rows: rows(&message.rows, path, faults),
    })
}

fn numbers(bytes: &[u8], path: &str, faults: &mut Faults) -> Vec<u32> {
    let numbers: Vec<i32> = array::decode(bytes).unwrap_or_else(|error| {
        faults.add(path, format!("numbers: {error}"));
        Vec::new()
    });
    let signed = numbers.into_iter().map(u32::try_from);
    signed.collect::<Result<_, _>>().unwrap_or_else(|_| {
        faults.add(path, "has a negative number");
        Vec::new()
    })
}

fn rows(bytes: &[u8], path: &str, faults: &mut Faults) -> Vec<[f64; 3]> {
    let values: Vec<f64> = array::decode(bytes).unwrap_or_else(|error| {
        faults.add(path, format!("rows: {error}"));
        Vec::new()
    });
    let (rows, rest) = values.as_chunks();
    if !rest.is_empty() {
        let count = values.len();
        faults.add(path, format!("has {count} values, which are no rows of 3"));
    }
    rows.to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fault::Fault;

    /// A change of good values, and the words that refuse it.
    type Change = (fn(&mut wire::Values), &'static str);

    #[test]
    fn a_support_with_values_alone_holds_every_component() {
        let given = wire::Support {
            name: "base".into(),
            on: vec!["z0".into()],
            values: Some(wire::Values::default()),
            ..Default::default()
        };
        let only_x = wire::Components {
            x: Some(0.5),
            ..Default::default()
        };
        let some = wire::Support {
            displacement: Some(only_x),
            ..given.clone()
        };
        let message = wire::Scene {
            mesh: format!("meshes/{}", "0".repeat(64)),
            supports: vec![given, some],
            tractions: vec![wire::Traction {
                name: "wind".into(),
                on: vec!["z1".into()],
                values: Some(wire::Values::default()),
                ..Default::default()
            }],
            ..Default::default()
        };
        let request = super::super::scene::scene(message, &Default::default());
        let scene = request.expect("a well-formed scene").scene;
        let held = |index: usize| scene.supports[index].displacement.map(|one| one.is_some());
        assert_eq!((held(0), held(1)), ([true; 3], [true, false, false]));
        let wind = &scene.tractions[0];
        assert_eq!(wind.name.as_deref(), Some("wind"));
        assert!(wind.values.is_some() && wind.value.iter().all(|&value| value == 0.0));
    }

    fn converted(message: &wire::Values) -> Result<Option<Values>, Fault> {
        let mut faults = Faults::default();
        let found = values(Some(message), "support.base.values", &mut faults);
        faults.outcome().map(|()| found)
    }

    #[test]
    fn rows_arrive_and_bytes_that_are_none_are_refused() {
        let good = wire::Values {
            place: wire::ValuePlace::Facets.into(),
            numbers: array::encode(&[7_i32, 0]),
            rows: array::encode(&[1.0, 2.0, 3.0, 4.0, 5.0, f64::NAN]),
        };
        let found = converted(&good).expect("rows").expect("values");
        assert_eq!(
            (found.place, &found.numbers[..]),
            (ValuePlace::Facets, &[7, 0][..])
        );
        assert_eq!(
            found.rows[0].map(f64::to_bits),
            [1.0, 2.0, 3.0].map(f64::to_bits)
        );
        let faults: [Change; 4] = [
            (|one| one.numbers = array::encode(&[-1_i32]), "negative"),
            (
                |one| one.numbers = array::encode(&[1.0_f32, 2.0]).slice(1..),
                "numbers",
            ),
            (|one| one.rows = one.rows.slice(..8), "no rows of 3"),
            (|one| one.rows = one.rows.slice(..9), "whole number"),
        ];
        for (change, expected) in faults {
            let mut message = good.clone();
            change(&mut message);
            match converted(&message) {
                Err(Fault::SceneInvalid(all)) => {
                    assert_eq!(all[0].path, "support.base.values");
                    assert!(all[0].message.contains(expected), "{}", all[0].message);
                }
                other => panic!("{expected}: {other:?}"),
            }
        }
        let later = wire::Values { place: 9, ..good };
        assert!(matches!(converted(&later), Err(Fault::Unsupported(_))));
        assert_eq!(values(None, "values", &mut Faults::default()), None);
    }
}
