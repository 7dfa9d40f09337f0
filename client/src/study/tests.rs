//! Studies as files and cases.

use proptest::prelude::*;

use super::*;

const SCENE: &str = include_str!("../../examples/hertz-sphere.toml");

/// A folder with the scene, a table and whatever else a study needs; gone with the test.
struct Folder(PathBuf);

impl Drop for Folder {
    fn drop(&mut self) {
        // A folder that stays is no fault of what is tested.
        let _left = std::fs::remove_dir_all(&self.0);
    }
}

impl Folder {
    fn new(test: &str) -> Self {
        let name = format!("signorini-study-{test}-{}", std::process::id());
        let folder = std::env::temp_dir().join(name);
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join("scene.toml"), SCENE).unwrap();
        Self(folder)
    }

    fn study(&self, text: &str) -> Result<Study, StudyError> {
        let text = format!("scene = \"scene.toml\"\n{text}");
        Study::read(&text, &self.0.join("study.toml"), &[])
    }

    fn put(&self, name: &str, text: &str) {
        std::fs::write(self.0.join(name), text).unwrap();
    }
}

const RADII: &str = "[[grid]]\nkey = \"obstacle.ball.shape.radius\"\nvalues = [1.0, 2.0]\n";
const DEPTHS: &str = "[[grid]]\nkey = \"step.0.obstacle.ball.translation.2\"\n\
                      from = -0.03\nto = -0.01\ncount = 3\n";

fn radius(study: &Study, index: u64) -> f64 {
    let file = study.scene(&study.case(index).unwrap()).unwrap();
    let shape = file.scene.obstacles[0].shape.clone().unwrap();
    match shape.kind {
        Some(signorini_proto::v1::shape::Kind::Sphere(sphere)) => sphere.radius.unwrap(),
        other => unreachable!("{other:?}"),
    }
}

#[test]
fn a_grid_has_every_combination_once_the_first_key_varying_slowest() {
    let folder = Folder::new("grid");
    let study = folder.study(&format!("{RADII}{DEPTHS}")).unwrap();
    assert_eq!(study.count(), 6);
    let values = (0..6).map(|index| study.case(index).unwrap().values);
    let cells: Vec<String> = values
        .map(|values| {
            values
                .iter()
                .flatten()
                .map(cell)
                .collect::<Vec<_>>()
                .join(" ")
        })
        .collect();
    let expected = [
        "1.0 -0.03",
        "1.0 -0.02",
        "1.0 -0.01",
        "2.0 -0.03",
        "2.0 -0.02",
        "2.0 -0.01",
    ];
    assert_eq!(cells, expected);
    assert!(study.case(6).is_none());
    assert!((radius(&study, 0) - 1.0).abs() < 1e-15 && (radius(&study, 5) - 2.0).abs() < 1e-15);
    let file = study.scene(&study.case(4).unwrap()).unwrap();
    assert_eq!(
        file.scene.steps[0].obstacles[0].translation,
        [0.0, 0.0, -0.02]
    );
    assert_eq!(study.wanted()[2].of, "obstacles.ball.force.z");
}

#[test]
fn identifiers_tell_the_number_and_what_is_set_and_stay_the_same() {
    let folder = Folder::new("ids");
    let first = folder.study(&format!("{RADII}{DEPTHS}")).unwrap();
    let again = folder
        .study(&format!("# said otherwise\n{RADII}{DEPTHS}"))
        .unwrap();
    let ids = |study: &Study| {
        (0..6)
            .map(|i| study.case(i).unwrap().id)
            .collect::<Vec<_>>()
    };
    assert_eq!(ids(&first), ids(&again));
    assert_eq!(first.digest(), again.digest());
    assert!(ids(&first)[3].starts_with("3-"), "{:?}", ids(&first));
    let other = folder.study(&RADII.replace("2.0", "3.0")).unwrap();
    assert_ne!(other.digest(), first.digest());
    assert_ne!(
        other.case(1).unwrap().id,
        folder.study(RADII).unwrap().case(1).unwrap().id
    );
}

#[test]
fn tables_points_and_lists_go_together() {
    let folder = Folder::new("together");
    folder.put(
        "cases.csv",
        "material.body.shear_modulus,name\n1,\n2.5,soft\n",
    );
    let sobol = "[sobol]\npoints = 8\nseed = 1\n[[sobol.range]]\nkey = \"obstacle.ball.shape.radius\"\n\
                 from = 0.5\nto = 2.0\nspacing = \"logarithmic\"\n";
    let study = folder
        .study(&format!("{DEPTHS}[list]\nfile = \"cases.csv\"\n{sobol}"))
        .unwrap();
    assert_eq!(study.count(), 2 * 3 * 8);
    assert_eq!(study.keys().len(), 4);
    assert_eq!(study.numeric(), [true, false, true, true]);
    let scene = |index| study.scene(&study.case(index).unwrap()).unwrap().scene;
    // The file's own value where a cell is empty.
    assert_eq!(
        (scene(0).name.as_str(), scene(24).name.as_str()),
        ("hertz-sphere", "soft")
    );
    for index in 0..study.count() {
        assert!((0.5..2.0).contains(&radius(&study, index)), "{index}");
    }
}

#[test]
fn a_mesh_may_vary_and_begins_where_the_study_is() {
    let folder = Folder::new("mesh");
    let text =
        "set = [\"mesh=a.msh\"]\n[[grid]]\nkey = \"mesh\"\nvalues = [\"b.msh\", \"c.msh\"]\n";
    let study = folder.study(text).unwrap();
    let mesh = |index| study.scene(&study.case(index).unwrap()).unwrap().mesh;
    assert_eq!(mesh(0), folder.0.join("b.msh"));
    assert_eq!(mesh(1), folder.0.join("c.msh"));
}

#[test]
fn wrong_keys_columns_and_lines_are_named() {
    let folder = Folder::new("wrong");
    folder.put("short.csv", "mesh_scale,name\n1,a\n2\n");
    folder.put("unknown.csv", "mesh_scal\n1\n");
    folder.put("twice.csv", "obstacle.0.shape.radius\n1\n");
    for (text, said) in [
        ("", "nothing varies"),
        ("[grid]\nkey = \"a\"", "grid: an array of tables ([[grid]]"),
        (
            "[[grid]]\nvalues = [1]\n",
            "grid[0].key: required key is missing",
        ),
        (
            "[[grid]]\nkey = \"mesh_scale\"\nvalue = [1]\n",
            "grid[0].value: unknown key; did you mean \"values\"?",
        ),
        (
            "[[grid]]\nkey = \"mesh_scale\"\n",
            "grid[0]: \"values\", or",
        ),
        (
            "[[grid]]\nkey = \"mesh_scale\"\nvalues = []\n",
            "grid[0].values: is empty",
        ),
        (
            "[[grid]]\nkey = \"mesh_scale\"\nfrom = 1\nto = 2\ncount = 0\n",
            "grid[0].count: 0: at least 1",
        ),
        (
            "[[grid]]\nkey = \"mesh_scale\"\nfrom = \"a\"\nto = 2\ncount = 2\n",
            "grid[0].from: a finite number",
        ),
        (
            "[[grid]]\nkey = \"mesh_scal\"\nvalues = [1]\n",
            "mesh_scal: unknown key; did you mean \"mesh_scale\"?",
        ),
        (
            "[[grid]]\nkey = \"obstacle.bell.shape.radius\"\nvalues = [1]\n",
            "there are ball",
        ),
        (
            "[[grid]]\nkey = \"a..b\"\nvalues = [1]\n",
            "a..b: the path has an empty part",
        ),
        (
            "set = [\"mesh\"]\n[[grid]]\nkey = \"mesh_scale\"\nvalues = [1]\n",
            "set: \"mesh\": PATH=VALUE",
        ),
        ("[list]\nfile = \"none.csv\"\n", "none.csv: "),
        (
            "[list]\nfile = \"short.csv\"\n",
            "short.csv: line 3: has 1 cells below 2 keys",
        ),
        ("[list]\nfile = \"unknown.csv\"\n", "mesh_scal: unknown key"),
        (
            "[sobol]\npoints = 8\n",
            "sobol.range: [[sobol.range]] is missing",
        ),
        (
            "[sobol]\npoints = 3000000000\n[[sobol.range]]\nkey = \"mesh_scale\"\nfrom = 1\nto = 2\n",
            "sobol.points: at most",
        ),
    ] {
        let error = folder.study(text).unwrap_err().to_string();
        assert!(error.contains(said), "{text}: {error}");
    }
    let twice = format!("{RADII}[list]\nfile = \"twice.csv\"\n");
    // The same key in other words is found where its path is the same.
    assert!(folder.study(&twice).is_ok());
    let twice = RADII.replace("[[grid]]", "[[grid]]\n").repeat(2);
    let error = folder.study(&twice).unwrap_err().to_string();
    assert!(
        error.contains("obstacle.ball.shape.radius: varies twice"),
        "{error}"
    );
    let many = "[[grid]]\nkey = \"mesh_scale\"\nfrom = 1\nto = 2\ncount = 200000000\n";
    let error = folder.study(many).unwrap_err().to_string();
    assert!(error.contains("more than 100000000 cases"), "{error}");
}

#[test]
fn wanted_values_that_are_not_there_or_called_alike_are_named() {
    let folder = Folder::new("wanted");
    let wanted = |text: &str| folder.study(&format!("{RADII}{text}"));
    for (text, said) in [
        (
            "[[result]]\nof = \"obstacles.bell.force.z\"\n",
            "there are ball",
        ),
        (
            "[[result]]\nof = \"strain_energi\"\n",
            "there is no \"strain_energi\"",
        ),
        (
            "[[result]]\nof = \"strain_energy\"\nat = \"most\"\n",
            "known are last, every, max, min, sum",
        ),
        (
            "[[result]]\nname = \"case\"\nof = \"strain_energy\"\n",
            "another column",
        ),
    ] {
        let error = wanted(text).unwrap_err().to_string();
        assert!(error.contains(said), "{text}: {error}");
    }
    let two =
        "[[result]]\nof = \"strain_energy\"\n[[result]]\nof = \"strain_energy\"\nat = \"max\"\n";
    let names = wanted(two).unwrap();
    let names: Vec<&str> = names.wanted().iter().map(|one| one.name.as_str()).collect();
    assert_eq!(names, ["strain_energy", "max strain_energy"]);
}

#[test]
fn a_column_is_computed_from_keys_results_and_those_before_it() {
    let folder = Folder::new("derived");
    let study = folder.study(&format!(
        "{RADII}{DEPTHS}[[result]]\nname = \"force\"\nof = \"obstacles.ball.force.z\"\n\
         [[result]]\nname = \"stiffness\"\n\
         expression = \"force / step.0.obstacle.ball.translation.2\"\n\
         [[result]]\nname = \"per radius\"\nexpression = \"stiffness / obstacle.ball.shape.radius\"\n"
    ));
    let study = study.unwrap();
    let names: Vec<&str> = study
        .derived()
        .iter()
        .map(|one| one.name.as_str())
        .collect();
    assert_eq!(names, ["stiffness", "per radius"]);
    let case = study.case(3).unwrap();
    let values = study.derive(&case, &[serde_json::json!(0.6)]);
    let expected = [0.6 / -0.03, 0.6 / -0.03 / 2.0];
    for (value, expected) in values.into_iter().zip(expected) {
        assert!((value.unwrap() - expected).abs() < 1e-12);
    }
    let without = study.derive(&case, &[serde_json::Value::Null]);
    assert_eq!(without, [None, None]);
}

#[test]
fn expressions_that_cannot_be_computed_name_their_key_and_the_column() {
    let folder = Folder::new("underived");
    let said = |result: &str| {
        let text = format!("{RADII}[[result]]\nof = \"cause\"\nat = \"every\"\n{result}");
        folder.study(&text).unwrap_err().to_string()
    };
    for (result, expected) in [
        (
            "[[result]]\nname = \"k\"\nexpression = \"1 / forse\"\n",
            "result.k.expression: there is no column \"forse\" before it; there are \
             obstacle.ball.shape.radius, every cause",
        ),
        (
            "[[result]]\nname = \"k\"\nexpression = \"2 * {every cause}\"\n",
            "result.k.expression: the column \"every cause\" has no numbers",
        ),
        (
            "[[result]]\nname = \"id\"\nexpression = \"1\"\n",
            "result.id: there is another column",
        ),
        (
            "[[result]]\nname = \"k\"\nexpression = \"1\"\nof = \"cause\"\n",
            "result.k.of: stands beside \"expression\"",
        ),
        ("[[result]]\nexpression = \"1\"\n", "result[1].name"),
    ] {
        let said = said(result);
        assert!(said.contains(expected), "{said}");
    }
}

#[test]
fn a_value_that_only_one_case_cannot_have_does_not_stop_the_study() {
    let folder = Folder::new("one");
    let text = "[[grid]]\nkey = \"mesh_scale\"\nvalues = [\"wide\", 1.0]\n";
    let study = folder.study(text).unwrap();
    let error = study
        .scene(&study.case(0).unwrap())
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("mesh_scale: a number is expected"),
        "{error}"
    );
    assert!(study.scene(&study.case(1).unwrap()).is_ok());
}

proptest! {
    #[test]
    fn any_number_of_values_and_steps_multiplies(values in 1_usize..9, steps in 1_u64..9, points in 1_u64..9) {
        let folder = Folder::new(&format!("any-{values}-{steps}-{points}"));
        let list: Vec<String> = (1..=values).map(|value| value.to_string()).collect();
        let text = format!(
            "[[grid]]\nkey = \"mesh_scale\"\nvalues = [{}]\n\
             [[grid]]\nkey = \"material.body.shear_modulus\"\nfrom = 1\nto = 2\ncount = {steps}\n\
             [sobol]\npoints = {points}\n[[sobol.range]]\nkey = \"obstacle.ball.shape.radius\"\nfrom = 1\nto = 2\n",
            list.join(", ")
        );
        let study = folder.study(&text).unwrap();
        prop_assert_eq!(study.count(), values as u64 * steps * points);
        let ids: std::collections::HashSet<String> =
            (0..study.count()).map(|index| study.case(index).unwrap().id).collect();
        prop_assert_eq!(ids.len() as u64, study.count());
    }
}
