//! The nearest name for a misspelt one, whatever its case, by Levenshtein distance. Cost: letters
//! squared per candidate, at most a thousand candidates of 64 letters.

/// Names that a hint looks at, and of these the ones that it lists.
const HINT_CANDIDATES: usize = 1000;
/// Names that a message lists before it counts the rest.
const HINT_LISTED: usize = 20;
/// Longest name that is compared letter by letter, bytes.
const HINT_BYTES: usize = 64;

/// `; did you mean ...` for the nearest of `known`, or the first of them.
pub(crate) fn hint<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> String {
    let known: Vec<&str> = known.take(HINT_CANDIDATES).collect();
    let short = |candidate: &&&str| name.len().max(candidate.len()) <= HINT_BYTES;
    let nearest = known
        .iter()
        .filter(short)
        .map(|candidate| {
            (
                distance(&name.to_lowercase(), &candidate.to_lowercase()),
                candidate,
            )
        })
        .filter(|(distance, candidate)| 2 * distance <= name.len().max(candidate.len()))
        .min();
    match nearest {
        Some((_, candidate)) => format!("; did you mean `{candidate}`?"),
        None if known.is_empty() => "; there are none".to_owned(),
        None => format!("; known: {}", listed(&known)),
    }
}

/// The names as a list for a message, cut where there are many.
fn listed(known: &[&str]) -> String {
    let (listed, rest) = known.split_at(known.len().min(HINT_LISTED));
    match rest.len() {
        0 => listed.join(", "),
        count => format!("{} and {count} more", listed.join(", ")),
    }
}

/// Levenshtein distance.
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let replace = diagonal + usize::from(x != *y);
            diagonal = row[j + 1];
            row[j + 1] = replace.min(row[j] + 1).min(row[j + 1] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_misspelt_name_gets_the_nearest_one() {
        let known = ["contact", "top", "body"];
        assert_eq!(
            hint("contct", known.into_iter()),
            "; did you mean `contact`?"
        );
        let sides = ["x1", "z1"].into_iter();
        assert_eq!(hint("Z1", sides), "; did you mean `z1`?");
        assert_eq!(
            hint("zzz", known.into_iter()),
            "; known: contact, top, body"
        );
    }

    #[test]
    fn long_lists_and_long_names_are_cut_short() {
        let known: Vec<String> = (0..500).map(|index| format!("group-{index}")).collect();
        let hint = hint("zzz", known.iter().map(String::as_str));
        assert!(hint.ends_with("group-19 and 480 more"), "{hint}");
        let long = "z".repeat(HINT_BYTES + 1);
        assert_eq!(
            super::hint(&long, [long.as_str()].into_iter()),
            format!("; known: {long}")
        );
    }
}
