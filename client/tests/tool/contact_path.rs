//! Contact pressure along the surface among the files of a run.
#![cfg(feature = "embedded")]

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::Path;

use crate::common::{example, folder, run};

/// A point: arc length, pressure and radius.
type Point = [f64; 3];

/// Points of the last increment by obstacle and interval.
fn paths(folder: &Path) -> BTreeMap<(String, usize), Vec<Point>> {
    let mut table = csv::Reader::from_path(folder.join("contact_path.csv")).unwrap();
    let header = "step,increment,time,obstacle,interval,arc_length,pressure,x,y";
    assert_eq!(
        table
            .headers()
            .unwrap()
            .iter()
            .collect::<Vec<_>>()
            .join(","),
        header
    );
    let mut paths: BTreeMap<_, Vec<Point>> = BTreeMap::new();
    let mut now = String::new();
    for row in table.records().map(Result::unwrap) {
        if row[2] != now {
            now = row[2].to_owned();
            paths.clear();
        }
        let number = |column: usize| row[column].parse::<f64>().unwrap();
        let key = (row[3].to_owned(), number(4) as usize);
        paths.entry(key).or_default().push([5, 6, 7].map(number));
    }
    paths
}

/// int 2 pi r p ds by Simpson's rule over the facets.
fn force(path: &[Point]) -> f64 {
    let value = |[_, pressure, radius]: Point| TAU * radius * pressure;
    let facets = path.windows(3).step_by(2);
    let parts = facets.map(|facet| {
        let sum = value(facet[0]) + 4.0 * value(facet[1]) + value(facet[2]);
        (facet[2][0] - facet[0][0]) / 6.0 * sum
    });
    parts.sum()
}

#[test]
fn the_pressure_along_a_section_sums_up_to_the_normal_force_of_each_obstacle() {
    let scene = example("o-ring.toml");
    let out = folder("contact_path");
    let arguments = ["solve", scene.to_str().unwrap(), "--quiet", "--json"];
    let few = [
        "--set",
        "step.1.increments=4",
        "--out",
        out.to_str().unwrap(),
    ];
    let solved = run(arguments.into_iter().chain(few));
    assert_eq!(solved.code, Some(0), "{}", solved.stderr);
    let last = solved.events("step").pop().unwrap();
    let paths = paths(&out);
    for (name, obstacle) in last["obstacles"].as_object().unwrap() {
        let number = |key: &str| obstacle[key].as_f64().unwrap();
        let known = number("mean_pressure") * number("deformed_contact_area");
        let own = paths.iter().filter(|((of, _), _)| of == name);
        let own: Vec<_> = own.map(|(_, path)| path).collect();
        assert!(own.iter().all(|path| path.is_sorted_by(|a, b| a[0] < b[0])));
        let found: f64 = own.iter().map(|path| force(path)).sum();
        // Contact ends within a facet, where the pressure has a kink that the rule does not see.
        assert!((found / known - 1.0).abs() < 1e-2, "{name} {found} {known}");
        assert_eq!(
            own.len(),
            obstacle["contact_intervals"].as_array().unwrap().len()
        );
    }
    assert!(paths.len() >= 3, "{:?}", paths.keys());
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(
        page.contains("\"paths\":[{\"obstacle\":"),
        "no path on the page"
    );
}
