//! What one has to hold in mind to read a function: its lines, the values that it takes, and
//! how it branches on a boolean.

use super::{production, tokens};

/// Lines of the longest function.
const LONGEST: usize = 60;

/// Values that a function takes at most, `self` apart and tuples opened.
const VALUES: usize = 5;

/// A function of the text.
struct Function {
    name: String,
    lines: usize,
    values: usize,
}

fn functions(text: &str) -> Vec<Function> {
    let (words, lines) = tokens::numbered(text);
    let is_name = |at: usize| words[at].starts_with(|c: char| c.is_alphabetic() || c == '_');
    let starts = (1..words.len()).filter(|at| words[at - 1] == "fn" && is_name(*at));
    starts
        .filter_map(|at| {
            let open = arguments(&words, at + 1)?;
            let close = closing(&words, open);
            // A declaration without a body ends with its semicolon.
            let start =
                (close..words.len()).find(|at| ["{", ";"].contains(&words[*at].as_str()))?;
            let end = closing(&words, start);
            Some(Function {
                name: words[at].clone(),
                lines: lines[end] - lines[at] + 1,
                values: values(&words[open + 1..close]),
            })
        })
        .collect()
}

/// The parenthesis after the generic parameters that begin at `at`.
fn arguments(words: &[String], at: usize) -> Option<usize> {
    let mut depth = 0_usize;
    for here in at..words.len() {
        match words[here].as_str() {
            "<" => depth += 1,
            ">" if words[here - 1] != "-" => depth -= 1,
            "(" if depth == 0 => return Some(here),
            _ => {}
        }
    }
    None
}

/// Where the bracket at `open` is closed; `open` itself where it is none.
fn closing(words: &[String], open: usize) -> usize {
    let mut depth = 0_usize;
    for (at, word) in words.iter().enumerate().skip(open) {
        match word.as_str() {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" | "}" => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return at;
        }
    }
    words.len() - 1
}

/// Values of an argument list: a tuple counts as what stands in its pattern, `self` not at all.
fn values(list: &[String]) -> usize {
    split(list)
        .map(|argument| match argument {
            [first, .., last] if first == "(" && last == ")" => {
                values(&argument[1..argument.len() - 1])
            }
            [first, ..] if first == "(" => values(&argument[1..closing(argument, 0)]),
            _ if argument.iter().any(|word| word == "self") => 0,
            _ => 1,
        })
        .sum()
}

/// The parts of `list` between its commas.
fn split(list: &[String]) -> impl Iterator<Item = &[String]> {
    let mut depth = 0_usize;
    let parts = list.split(move |word| {
        match word.as_str() {
            "(" | "[" | "{" | "<" => depth += 1,
            ")" | "]" | "}" | ">" => depth = depth.saturating_sub(1),
            _ => {}
        }
        depth == 0 && word == ","
    });
    parts.filter(|part| !part.is_empty())
}

/// How many `match`es have an arm for `true` or `false` alone.
fn boolean_matches(text: &str) -> usize {
    let words = tokens::production(text);
    let arm = |at: usize| {
        let is_first = at > 0 && words[at - 1] == "{";
        let is_value = ["true", "false"].contains(&words[at].as_str());
        let leads = words.get(at + 1).is_some_and(|next| next == "=");
        is_first && is_value && leads
    };
    (0..words.len()).filter(|at| arm(*at)).count()
}

#[test]
fn functions_fit_on_a_page() {
    let mut faults = Vec::new();
    for (_, path, text) in production() {
        let long = functions(&text).into_iter();
        for long in long.filter(|one| one.lines > LONGEST) {
            let (file, lines) = (path.display(), long.lines);
            faults.push(format!("{file}: {} has {lines} lines", long.name));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn argument_lists_are_short_and_branches_on_booleans_plain() {
    let mut faults = Vec::new();
    for (_, path, text) in production() {
        let file = path.display();
        let matches = boolean_matches(&text);
        if matches > 0 {
            faults.push(format!("{file}: {matches} matches on a boolean"));
        }
        for long in functions(&text).iter().filter(|one| one.values > VALUES) {
            faults.push(format!("{file}: {} takes {}", long.name, long.values));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn tuples_of_argument_lists_are_opened() {
    let text = "impl A { fn f<T: Fn(u8) -> u8, const N: usize>(&mut self, (a, (b, c)): (X, (Y, [u8; 2])), d: &[T]) -> Z where T: U {\n
        match d { true => 1, false => 2 }\n
    } } trait B { fn g(&self, x: HashMap<u8, u8>); }";
    let found = functions(text);
    let seen: Vec<(&str, usize, usize)> = found
        .iter()
        .map(|one| (one.name.as_str(), one.lines, one.values))
        .collect();
    assert_eq!(seen, [("f", 5, 4), ("g", 1, 1)]);
    assert_eq!(boolean_matches(text), 1);
}
