//! The page of fallbacks, generated from the table below: what is tried where a direct way fails,
//! the test that fails without it, and how often it acts. A fallback that names no test, or a test
//! that is not there, does not pass. `UPDATE_RESCUES=1 cargo test -p signorini --test architecture`
//! writes the page anew; `tests/benches/rescues.py` counts.

use std::collections::BTreeMap;
use std::fs;

use super::decisions::has_item;
use super::workspace;

/// A fallback: its name, the item that holds it, what it is for, the file and the test that fails
/// without it.
#[rustfmt::skip]
const RESCUES: &[[&str; 5]] = &[
    ["smaller part", "continuation::parts", "an increment that fails as a whole", "tests/rubber/instability.rs", "a_straight_column_pressed_far_at_once_falls_to_the_buckled_equilibrium"],
    ["volume penalty", "continuation::penalty", "motions that change volumes between the vertices, which no body has", "tests/contact/critical_pressure.rs", "hats_under_a_cylinder_end_where_the_mesh_gives_way"],
    ["snap-through", "continuation::snap_through", "an equilibrium that is lost", "tests/rubber/instability.rs", "an_arch_pushed_through_snaps_to_one_equilibrium_in_one_increment_and_in_twenty"],
    ["proximal rest", "sqp::proximal_rest", "a body that contact alone holds, near the limit of friction", "tests/friction/laws.rs", "bodies_of_any_shape_stay_on_slopes_below_the_angle_of_friction_and_slide_above"],
    ["bounded parts", "continuation::longest_part", "round tools that would pass through the body", "tests/contact/passing.rs", "a_small_ball_presses_alike_from_wherever_it_comes"],
    ["tools that have left", "sqp::left_tools", "pressure that stays where a tool has lifted off", "tests/linear/lifted.rs", "a_press_behind_any_lift_equals_the_first_one"],
    ["scales that forget", "sqp::scales::forget_scales", "a body that nothing drives any more", "tests/linear/lifted.rs", "a_tool_that_comes_back_to_just_touch_leaves_a_body_at_rest"],
    ["sharper target", "sqp::increment", "a program that took no iteration", "tests/linear/lifted.rs", "a_tool_that_comes_back_to_just_touch_leaves_a_body_at_rest"],
    ["least slip", "force_control::least_slip", "free components of a tool that grips and is turned", "tests/friction/rubber.rs", "a_cylinder_that_is_turned_rolls_where_nothing_holds_it_along"],
    ["largest force", "force_control::broyden::Stall", "a push beyond what contact bears", "tests/friction/rubber.rs", "a_roller_turned_by_more_than_its_contact_holds_has_no_equilibrium"],
    ["approach to contact", "force_control::approach", "a pushed tool away from the body", "tests/contact/pushed.rs", "a_body_that_only_obstacles_hold_is_squeezed_by_any_force"],
    ["bodies led to what they meet", "force_control::meeting", "a pushed support of a body that nothing holds", "tests/pairs/pushed.rs", "bodies_that_are_pushed_from_unequal_distances_all_arrive"],
    ["solve measured by the forces at hand", "sqp::accuracy", "a stiff part that its support moves beside a soft body", "tests/rubber/loaded_supports.rs", "a_bush_is_as_stiff_by_moment_as_by_rotation"],
    ["sharper solve after a step that does not show", "force_control::Balance", "forces near full contact, which hardly change", "client/tests/tool/examples.rs", "a_wave_pushed_on_a_confined_slab_is_borne_evenly_beyond_full_contact"],
    ["metric asked for before the first step", "force_control::by_metric", "a push along a frictional surface", "tests/contact/pushed.rs", "friction_holds_a_tool_that_is_pushed_along_until_it_slides"],
    ["program without the curvature of the gaps", "sqp::program::solve", "a step with no positive stiffness", "tests/linear/doubts.rs", "a_tool_sunk_into_a_side_that_it_may_not_press_is_named"],
    ["non-monotone step", "sqp::increment", "slender bodies that turn against small forces", "tests/friction/rubber.rs", "a_factor_finds_what_iterations_find_and_sooner"],
];

/// Recorded counts: fallback, scenes, increments in which it acted, increments.
fn counts() -> BTreeMap<String, String> {
    let path = workspace().join("tests/benches/rescues.csv");
    let text = fs::read_to_string(path).expect("the counts are readable");
    let rows = text.lines().skip(1).map(|line| {
        let mut cells = line.split(',').map(str::trim);
        let mut next = || cells.next().unwrap_or_default().to_owned();
        (next(), next())
    });
    rows.collect()
}

/// The page.
fn page() -> String {
    let counts = counts();
    let mut page = String::from(
        "# Fallbacks\n\n\
        What is tried where the direct way fails. Each is kept because a test fails without it; those of a load path are decided in one\n\
        place, `continuation::strategy`, and appear in results as [`attempts`](results.md). Counts: increments of the\n\
        examples and of the kept families in which it acted, as `tests/benches/rescues.py` found them; \"-\" where results do not tell.\n\n\
        | fallback | code | for | fails without it | acts in |\n|---|---|---|---|---|\n",
    );
    for [name, item, purpose, _, test] in RESCUES {
        let count = counts.get(*name).map_or("-", String::as_str);
        page += &format!("| {name} | `{item}` | {purpose} | `{test}` | {count} |\n");
    }
    page
}

#[test]
fn every_fallback_names_its_code_and_a_test_that_is_there() {
    let mut faults = Vec::new();
    for [name, item, _, file, test] in RESCUES {
        if has_item(item) != Some(true) {
            faults.push(format!("{name}: no `{item}`"));
        }
        let text = fs::read_to_string(workspace().join(file)).unwrap_or_default();
        if !text.contains(&format!("fn {test}()")) {
            faults.push(format!("{name}: no test `{test}` in {file}"));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn the_page_of_fallbacks_is_that_of_the_table() {
    let path = workspace().join("client/manual/rescues.md");
    if std::env::var_os("UPDATE_RESCUES").is_some() {
        fs::write(&path, page()).expect("the page is written");
    }
    let found = fs::read_to_string(path).expect("the page is readable");
    assert!(found == page(), "run with UPDATE_RESCUES=1");
}

#[test]
fn the_glossary_names_what_is_there() {
    let path = workspace().join("client/manual/glossary.md");
    let text = fs::read_to_string(path).expect("the glossary is readable");
    let spans = text.split('`').skip(1).step_by(2);
    let spans = spans.filter(|span| span.contains("::"));
    let spans: Vec<&str> = spans.collect();
    assert!(spans.len() >= 30, "{}", spans.len());
    let missing: Vec<&&str> = spans
        .iter()
        .filter(|span| has_item(span) != Some(true))
        .collect();
    assert!(missing.is_empty(), "{missing:?}");
}

#[test]
fn the_table_of_where_it_is_decided_names_files_that_are_there() {
    let text = fs::read_to_string(workspace().join("src/lib.rs")).expect("lib.rs is readable");
    let table = text.split("# Where it is decided").nth(1);
    let table = table.and_then(|rest| rest.split("# Notation").next());
    let spans = table.unwrap_or_default().split('`').skip(1).step_by(2);
    let spans: Vec<&str> = spans.collect();
    assert!(spans.len() >= 20, "{}", spans.len());
    let missing: Vec<&&str> = (spans.iter())
        .filter(|path| !workspace().join(path).is_file())
        .collect();
    assert!(missing.is_empty(), "{missing:?}");
}
