//! The words of a source file: names, `::` and punctuation, without comments,
//! literals and whatever only tests compile.

/// The tokens of `text` that a build without tests sees.
pub(crate) fn production(text: &str) -> Vec<String> {
    numbered(text).0
}

/// The tokens of `text` that a build without tests sees, and the line of each, from one.
pub(crate) fn numbered(text: &str) -> (Vec<String>, Vec<usize>) {
    let (tokens, lines) = tokens(text);
    let kept = without_tests(&tokens).into_iter();
    kept.map(|at| (tokens[at].clone(), lines[at])).unzip()
}

/// Lines of `text` that a build without tests reads: all but those of items for tests.
pub(crate) fn production_lines(text: &str) -> usize {
    let (tokens, lines) = tokens(text);
    let mut kept = vec![true; text.lines().count() + 1];
    let mut next = 0;
    for at in without_tests(&tokens).into_iter().chain([tokens.len()]) {
        if at > next {
            kept[lines[next]..=lines[at - 1]].fill(false);
        }
        next = at + 1;
    }
    kept.iter().skip(1).filter(|kept| **kept).count()
}

fn tokens(text: &str) -> (Vec<String>, Vec<usize>) {
    let all: Vec<char> = text.chars().collect();
    let (mut found, mut lines, mut at) = (Vec::new(), Vec::new(), 0);
    let (mut line, mut counted) = (1, 0);
    while at < all.len() {
        let end = skipped(&all, at);
        if end > at {
            at = end;
            continue;
        }
        let end = match all[at] {
            c if is_name(c) => at + all[at..].iter().take_while(|c| is_name(**c)).count(),
            ':' if all.get(at + 1) == Some(&':') => at + 2,
            _ => at + 1,
        };
        line += all[counted..at].iter().filter(|c| **c == '\n').count();
        counted = at;
        found.push(all[at..end].iter().collect());
        lines.push(line);
        at = end;
    }
    (found, lines)
}

fn is_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Where a space, a comment or a literal that begins at `at` ends; `at` itself
/// when none does.
fn skipped(all: &[char], at: usize) -> usize {
    match (all[at], all.get(at + 1)) {
        (c, _) if c.is_whitespace() => at + 1,
        ('/', Some('/')) => past(all, at, &['\n']),
        ('/', Some('*')) => past(all, at, &['*', '/']),
        ('r', Some('"' | '#')) => raw_string(all, at),
        ('"', _) => quoted(all, at, '"'),
        // A lifetime is no literal: nothing closes it.
        ('\'', Some('\\')) => quoted(all, at, '\''),
        ('\'', Some(_)) if all.get(at + 2) == Some(&'\'') => at + 3,
        _ => at,
    }
}

/// After the next `mark`, or the end.
fn past(all: &[char], at: usize, mark: &[char]) -> usize {
    let found = all[at..].windows(mark.len()).position(|part| part == mark);
    found.map_or(all.len(), |offset| at + offset + mark.len())
}

fn quoted(all: &[char], at: usize, quote: char) -> usize {
    let mut end = at + 1;
    while end < all.len() && all[end] != quote {
        end += if all[end] == '\\' { 2 } else { 1 };
    }
    end + 1
}

/// `at` where the letter begins a name such as `r#type`.
fn raw_string(all: &[char], at: usize) -> usize {
    let marks = all[at + 1..].iter().take_while(|c| **c == '#').count();
    if all.get(at + 1 + marks) != Some(&'"') {
        return at;
    }
    let mut close = vec!['"'];
    close.extend(vec!['#'; marks]);
    past(all, at + 2 + marks, &close)
}

/// Places of the tokens outside items for tests.
fn without_tests(tokens: &[String]) -> Vec<usize> {
    const MARK: [&str; 7] = ["#", "[", "cfg", "(", "test", ")", "]"];
    let (mut kept, mut at) = (Vec::new(), 0);
    while at < tokens.len() {
        if tokens[at..].iter().take(MARK.len()).eq(MARK.iter()) {
            at = item_end(tokens, at + MARK.len());
        } else {
            kept.push(at);
            at += 1;
        }
    }
    kept
}

/// After the item that begins at `at`: its semicolon or its last brace.
fn item_end(tokens: &[String], mut at: usize) -> usize {
    let mut depth = 0;
    let (mut is_attribute, mut is_import) = (false, false);
    while at < tokens.len() {
        match tokens[at].as_str() {
            "#" if depth == 0 => is_attribute = true,
            "use" if depth == 0 => is_import = true,
            "(" | "[" | "{" => depth += 1,
            ")" | "]" if depth > 0 => depth -= 1,
            "}" if depth > 1 => depth -= 1,
            "}" if depth == 1 && is_import => depth = 0,
            "}" => return at + depth,
            ";" if depth == 0 => return at + 1,
            _ => {}
        }
        if is_attribute && depth == 0 && tokens[at] == "]" {
            is_attribute = false;
        }
        at += 1;
    }
    at
}

#[test]
fn comments_literals_and_tests_are_left_out() {
    let text = r##"
        use a::{b, c}; // use no::comment;
        #[cfg(test)]
        use only::{in_, tests};
        /* mod none; */ fn f<'a>(x: &'a str) { x == "mod no;" || x == r#"mod "no";"# || '"' == '\'' }
        #[cfg(test)]
        #[derive(Debug)]
        mod tests { fn g() { h(); } }
        mod last;
    "##;
    let words = production(text).concat();
    let expected = "usea::{b,c};fnf<'a>(x:&'astr){x==||x==||==}modlast;";
    assert_eq!(words, expected);
    assert_eq!(production_lines(text), text.lines().count() - 5);
}
