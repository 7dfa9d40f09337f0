//! What a room may weigh: its production lines and its numeric constants.

use std::path::Path;

use super::{SOLVER, production, tokens};

/// Room, its lines as they were recorded, and its numeric constants. A room may outgrow the
/// lines by [`GROWTH`] per cent; the constants are a ceiling.
#[rustfmt::skip]
const BUDGETS: &[(&str, usize, usize)] = &[
    ("adapted", 950, 5),
    ("assembly", 8068, 33),
    ("calibration", 1066, 17),
    ("comparisons", 92, 0),
    ("constants", 35, 0),
    ("contact", 4375, 18),
    ("continuation", 1620, 32),
    ("diagnosis", 554, 10),
    ("element", 735, 2),
    ("fluid", 790, 1),
    ("force_control", 1520, 33),
    ("geometry", 497, 1),
    ("goals", 3560, 14),
    ("inequality", 5393, 52),
    ("krylov", 892, 13),
    ("lib", 286, 0),
    ("linalg", 2828, 15),
    ("material", 2200, 17),
    ("mesh", 2643, 11),
    ("model", 5820, 18),
    ("obstacle", 5869, 51),
    ("pairs", 9880, 76),
    ("parallel", 124, 1),
    ("plan", 4786, 73),
    ("precond", 4984, 46),
    ("prepare", 1710, 10),
    ("proximity", 571, 15),
    ("refinement", 1330, 1),
    ("report", 1050, 3),
    ("results", 3172, 24),
    ("saddle", 1190, 6),
    ("scene", 5890, 28),
    ("session", 2400, 13),
    ("space", 190, 0),
    ("sqp", 7526, 91),
    ("stability", 275, 5),
    ("ties", 687, 8),
    ("verify", 1520, 11),
];

/// Per cent by which a room may outgrow its recorded lines.
const GROWTH: usize = 5;

/// Types of the constants that count: a number, or numbers side by side.
const NUMBERS: [&str; 14] = [
    "f64", "f32", "usize", "u8", "u16", "u32", "u64", "u128", "i8", "i16", "i32", "i64", "isize",
    "i128",
];

/// Constants of `text` whose type is a number.
fn numeric_constants(text: &str) -> usize {
    let words = tokens::production(text);
    let constant = |part: &&[String]| {
        let is_one = NUMBERS.contains(&part[3].as_str()) && part[4] == "=";
        let are_many = part[3] == "[" && NUMBERS.contains(&part[4].as_str());
        part[0] == "const" && part[2] == ":" && (is_one || are_many)
    };
    // A parameter such as `const N: usize = 8` is none.
    let is_parameter = |at: usize| at > 0 && ["<", ","].contains(&words[at - 1].as_str());
    let parts = words.windows(5).enumerate();
    parts
        .filter(|(at, part)| constant(part) && !is_parameter(*at))
        .count()
}

#[test]
fn rooms_stay_within_their_budgets() {
    let files = production();
    let mut rooms: Vec<&str> = files.iter().map(|file| file.0.as_str()).collect();
    rooms.dedup();
    let mut faults = Vec::new();
    for room in rooms {
        let own = files.iter().filter(|file| file.0 == room);
        let (lines, constants) = own.fold((0, 0), |sum, (_, _, text)| {
            let lines = tokens::production_lines(text);
            (sum.0 + lines, sum.1 + numeric_constants(text))
        });
        let budget = BUDGETS.iter().find(|row| row.0 == room);
        let fits = |row: &(&str, usize, usize)| {
            lines <= row.1 + row.1 * GROWTH / 100 && constants <= row.2
        };
        if !budget.is_some_and(fits) {
            faults.push(format!("(\"{room}\", {lines}, {constants}),"));
        }
    }
    assert!(faults.is_empty(), "outgrown:\n{}", faults.join("\n"));
}

#[test]
fn a_plan_lists_every_number_of_the_rooms_that_search_and_decide() {
    let listed = signorini::constants();
    let files = production();
    let solver = files
        .iter()
        .filter(|(room, ..)| SOLVER.contains(&room.as_str()));
    for (_, path, text) in solver {
        let path = Path::new("src").join(path);
        let own = listed.iter().filter(|one| Path::new(one.file) == path);
        assert_eq!(own.count(), numeric_constants(text), "{}", path.display());
    }
    for one in &listed {
        assert!(one.meaning.len() > 10, "{one:?}");
    }
}

#[test]
fn constants_of_other_types_and_parameters_do_not_count() {
    let text = "const A: f64 = 1.0; struct S<const N: usize = 8>; impl S { const B: usize = 2; }
        const C: [f64; 2] = [1.0, 2.0]; const fn d() { const E: u32 = 3; }";
    assert_eq!(numeric_constants(text), 4);
}
