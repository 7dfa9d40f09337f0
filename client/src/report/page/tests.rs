use std::collections::BTreeMap;

use signorini_client::formats::Notes;
use signorini_client::formats::vtu::{Grid, GridField};
use signorini_client::result_line;
use signorini_proto::v1;

use super::*;

fn report(name: &str) -> v1::StepReport {
    let obstacle = v1::ObstacleResult {
        force: vec![0.0, 0.0, -2.0],
        moment: vec![0.0; 3],
        centre_of_pressure: vec![0.0; 3],
        tangential_force: vec![0.0; 3],
        contact_area: 0.5,
        force_error: Some(0.1),
        ..Default::default()
    };
    let pose = v1::ObstaclePose {
        name: name.to_owned(),
        translation: vec![0.0, 0.0, -0.25],
        rotation: vec![0.0; 3],
    };
    v1::StepReport {
        step: 1,
        increment: 1,
        time: 1.0,
        termination: v1::Termination::NotConverged.into(),
        cause: v1::Cause::LimitPoint.into(),
        obstacles: BTreeMap::from([(name.to_owned(), obstacle)]),
        obstacle_poses: vec![pose],
        ..Default::default()
    }
}

/// An empty folder of its own.
fn folder(test: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("signorini-page-{test}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn write_results(folder: &Path, name: &str, plan: &str) {
    let plan = v1::Plan {
        name: plan.to_owned(),
        ..Default::default()
    };
    let lines = [
        result_line::plan(&plan, None),
        result_line::step(&report(name)),
    ];
    let text: String = lines.iter().map(|line| format!("{line}\n")).collect();
    std::fs::write(folder.join(LINES), text + "{\"event\":\"step\",\"st").unwrap();
}

fn write_series(folder: &Path) {
    let corners = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
    ];
    let grid = Grid::new(4, &corners, &[0, 1, 2, 3]).unwrap();
    let pressures = GridField {
        name: "contact_pressure",
        components: 1,
        values: &[0.0, 1.0, 2.0, 3.0],
    };
    std::fs::write(
        folder.join("a_0001.vtu"),
        grid.write(&[pressures], &Notes::default()).unwrap(),
    )
    .unwrap();
    let series = "<DataSet timestep=\"1\" part=\"0\" file=\"a_0001.vtu\"/>";
    std::fs::write(folder.join("a.pvd"), series).unwrap();
}

/// The data that a page holds.
fn data(page: &str) -> serde_json::Value {
    let (_, rest) = page.split_once("id=\"data\">").unwrap();
    let (data, _) = rest.split_once("</script>").unwrap();
    serde_json::from_str(data).unwrap()
}

#[test]
fn a_page_holds_the_numbers_and_the_surface_of_its_folder() {
    let folder = folder("numbers");
    write_results(&folder, "ball", "block");
    write_series(&folder);
    let page = std::fs::read_to_string(write(&folder).unwrap()).unwrap();
    let data = data(&page);
    let last = &data["steps"][0];
    assert_eq!(last["obstacles"]["ball"]["along"], 2.0);
    assert_eq!(last["obstacles"]["ball"]["travel"], 0.25);
    assert!(last["why"].as_str().unwrap().contains("no equilibrium"));
    let picture = &data["picture"];
    assert_eq!(
        (&picture["dimension"], &picture["nodes"][0]),
        (&3.into(), &10.into())
    );
    assert_eq!(picture["fields"][0]["name"], "contact_pressure");
    // Four faces of four triangles, three indices of two bytes.
    let bytes = picture["triangles"].as_str().unwrap().len() / 4 * 3;
    assert_eq!(bytes, 4 * 4 * 3 * 2);
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn a_page_has_the_pressures_along_the_surface_of_the_increment_that_it_shows() {
    let folder = folder("paths");
    write_results(&folder, "ball", "block");
    let head = "step,increment,time,obstacle,interval,arc_length,pressure,x,y\n";
    let shown = "1,1,1.0,ball,0,0.5,2.0,3.0,4.0\n1,1,1.0,ball,0,0.75,1.0,3.25,4.0\n";
    for (rows, count) in [(shown, 1), ("1,1,0.5,ball,0,0.5,2.0,3.0,4.0\n", 0)] {
        std::fs::write(folder.join(path_csv::FILE), format!("{head}{rows}")).unwrap();
        let page = std::fs::read_to_string(write(&folder).unwrap()).unwrap();
        let paths = data(&page)["paths"].clone();
        assert_eq!(paths.as_array().unwrap().len(), count, "{paths}");
        if count == 1 {
            assert_eq!(
                (&paths[0]["obstacle"], &paths[0]["length"]),
                (&"ball".into(), &0.25.into())
            );
            assert_eq!(
                paths[0]["points"][1],
                serde_json::json!([0.75, 1.0, 3.25, 4.0])
            );
        }
    }
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn a_page_says_whether_a_fluid_leaks_and_where() {
    let folder = folder("fluids");
    let mut tight = report("ball");
    tight.termination = v1::Termination::Converged.into();
    let path = v1::LeakPath {
        margin: 3.5,
        margin_over_pressure: 1.5,
        sealed_width: 0.25,
        points: vec![0.0, 0.0, 0.0, 1.0, 2.0, 0.0],
        pressures: vec![0.0, 3.5],
    };
    let water = v1::FluidResult {
        pressure: 2.0,
        tightness: v1::Tightness::Tight.into(),
        force: vec![0.0, -1.0, 0.0],
        leak_path: Some(path),
        ..Default::default()
    };
    tight.fluids = BTreeMap::from([("water".to_owned(), water)]);
    let mut leaks = tight.clone();
    (leaks.increment, leaks.time) = (2, 2.0);
    let water = leaks.fluids.get_mut("water").unwrap();
    water.tightness = v1::Tightness::Leaks.into();
    (water.blow_off_low, water.blow_off_high) = (Some(3.0), Some(3.03));
    let lines = [&tight, &leaks].map(|report| format!("{}\n", result_line::step(report)));
    std::fs::write(folder.join(LINES), lines.concat()).unwrap();
    let page = std::fs::read_to_string(write(&folder).unwrap()).unwrap();
    let data = data(&page);
    let water = |step: usize| &data["steps"][step]["fluids"]["water"];
    assert_eq!(
        (&water(0)["leaks"], &water(0)["margin"]),
        (&false.into(), &3.5.into())
    );
    assert_eq!(water(1)["bracket"], serde_json::json!([3.0, 3.03]));
    let leak = &data["leaks"][0];
    let points = serde_json::json!([[0.0, 0.0, 0.0], [1.0, 2.0, 0.0]]);
    assert_eq!(
        (&leak["fluid"], &leak["points"]),
        (&"water".into(), &points)
    );
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn a_page_says_what_bodies_do_to_each_other() {
    let folder = folder("contacts");
    let seat = v1::BodyContactResult {
        force: vec![0.0, 2.5, 0.0],
        contact_width: 0.5,
        mean_pressure: Some(5.0),
        peak_pressure: 7.0,
        ..Default::default()
    };
    let bond = v1::TieResult {
        force: vec![1.0, 0.0, 0.0],
        peak_traction: 3.0,
        ..Default::default()
    };
    let pressed = v1::StepReport {
        contacts: BTreeMap::from([("seat".to_owned(), seat)]),
        ties: BTreeMap::from([("bond".to_owned(), bond)]),
        ..report("ball")
    };
    let line = format!("{}\n", result_line::step(&pressed));
    std::fs::write(folder.join(LINES), line).unwrap();
    let page = std::fs::read_to_string(write(&folder).unwrap()).unwrap();
    let seat = &data(&page)["steps"][0]["contacts"]["seat"];
    assert_eq!(seat["force"], serde_json::json!([0.0, 2.5, 0.0]));
    assert_eq!(
        (&seat["mean_pressure"], &seat["peak_pressure"]),
        (&5.0.into(), &7.0.into())
    );
    let bond = &data(&page)["steps"][0]["ties"]["bond"];
    assert_eq!(bond["force"], serde_json::json!([1.0, 0.0, 0.0]));
    assert_eq!(bond["peak_traction"], 3.0);
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn a_page_asks_for_nothing_and_no_name_ends_its_data() {
    let folder = folder("names");
    write_results(&folder, "</script><script>alert(1)", "{{script}}<b>");
    let page = std::fs::read_to_string(write(&folder).unwrap()).unwrap();
    for outside in ["http://", "https://", "src=", "@import", "url("] {
        let own = page.replace("http://www.w3.org/2000/svg", "");
        assert!(!own.contains(outside), "{outside}");
    }
    assert_eq!(page.matches("</script>").count(), 2);
    let data = data(&page);
    assert_eq!(data["plan"]["name"], "{{script}}<b>");
    assert!(data["picture"].is_null());
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn folders_without_results_are_named() {
    let folder = folder("nothing");
    assert!(write(&folder).is_err());
    std::fs::write(folder.join(LINES), "no line\n").unwrap();
    let failure = format!("{:?}", write(&folder).unwrap_err());
    assert!(failure.contains("line 1 is no result line"), "{failure}");
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn files_that_are_cut_off_give_no_picture_and_no_panic() {
    let folder = folder("cut");
    write_series(&folder);
    let body = folder.join("a_0001.vtu");
    let whole = std::fs::read(&body).unwrap();
    for length in (0..whole.len()).step_by(7) {
        std::fs::write(&body, &whole[..length]).unwrap();
        // Text after the last array does not matter.
        if length + 60 < whole.len() {
            assert!(surface::last_picture(&folder).is_none(), "{length}");
        }
    }
    std::fs::remove_dir_all(folder).unwrap();
}
