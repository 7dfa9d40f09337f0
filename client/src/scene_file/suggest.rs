//! The known word nearest to a misspelt one, whatever their case.

/// The known word that differs least, if it is near enough to be meant.
pub(super) fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let word = word.to_lowercase();
    let candidates = known
        .into_iter()
        .map(|candidate| (distance(&word, &candidate.to_lowercase()), candidate));
    candidates
        .min_by_key(|(distance, _)| *distance)
        .filter(|(distance, candidate)| *distance <= 1 + candidate.len().min(word.len()) / 3)
        .map(|(_, candidate)| candidate)
}

/// Insertions, deletions and substitutions between two words (Levenshtein).
fn distance(from: &str, to: &str) -> usize {
    let mut row: Vec<usize> = (0..=to.chars().count()).collect();
    for (index, left) in from.chars().enumerate() {
        let mut diagonal = index;
        let mut before = index + 1;
        let mut next = vec![before];
        for (above, right) in row.iter().skip(1).zip(to.chars()) {
            let replaced = diagonal + usize::from(left != right);
            before = replaced.min(before + 1).min(above + 1);
            next.push(before);
            diagonal = *above;
        }
        row = next;
    }
    row.last().copied().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distance_counts_single_changes() {
        for (from, to, expected) in [
            ("", "abc", 3),
            ("radius", "radius", 0),
            ("raduis", "radius", 2),
            ("kitten", "sitting", 3),
        ] {
            assert_eq!(
                (distance(from, to), distance(to, from)),
                (expected, expected)
            );
        }
    }

    #[test]
    fn far_words_are_not_suggested() {
        let known = ["shear_modulus", "young_modulus", "poisson_ratio"];
        assert_eq!(nearest("shear_modul", known), Some("shear_modulus"));
        assert_eq!(nearest("poison_ratio", known), Some("poisson_ratio"));
        assert_eq!(nearest("colour", known), None);
        assert_eq!(nearest("Z1", ["x1", "y1", "z1"]), Some("z1"));
    }
}
