//! Tokens that are taken, refused and never told apart by time.

use super::*;

fn name(text: &str) -> ClientName {
    text.parse().unwrap()
}

#[test]
fn a_token_is_found_by_its_digest_until_it_is_revoked() {
    let mut file = TokenFile::default();
    let mut add = |who, role| {
        file.add(name(who), role, NewToken::Bearer)
            .unwrap()
            .unwrap()
    };
    let (first, second) = (add("line-1", Role::Solve), add("line-1", Role::Read));
    let none = file.add(name("cell"), Role::Admin, NewToken::Certificate);
    assert_eq!(none, Ok(None));
    let text = toml::to_string(&WrittenFile {
        token: file.entries.iter().map(Entry::written).collect(),
    });
    let mut file = TokenFile::parse(&text.unwrap()).unwrap();
    let role = |file: &TokenFile, token: &str| file.of_token(token).map(Entry::role);
    assert_eq!(role(&file, &first), Some(Role::Solve));
    assert_eq!(role(&file, &second), Some(Role::Read));
    assert_eq!(file.of_certificate(name("line-1")), None);
    assert_eq!(
        file.of_certificate(name("cell")).unwrap().role(),
        Role::Admin
    );
    let id = file.of_token(&first).unwrap().id();
    assert_eq!(file.revoke(name("line-1"), Some(&id)), 1);
    assert_eq!(
        (role(&file, &first), role(&file, &second)),
        (None, Some(Role::Read))
    );
    assert_eq!(file.revoke(name("line-1"), None), 1);
    assert_eq!(role(&file, &second), None);
}

#[test]
fn what_is_no_token_is_nobodys() {
    let mut file = TokenFile::default();
    file.add(name("cell"), Role::Admin, NewToken::Certificate)
        .unwrap();
    let token = file
        .add(name("a"), Role::Read, NewToken::Bearer)
        .unwrap()
        .unwrap();
    let digest = hexadecimal(&file.entries[1].digest.unwrap());
    let changed = token.replace(PREFIX, "Signorini_");
    let long = token.repeat(100);
    let mut random = fastrand::Rng::with_seed(17);
    for text in [
        "",
        PREFIX,
        &digest,
        &changed,
        &long,
        &token[1..],
        "\0",
        "cell",
    ] {
        assert_eq!(file.of_token(text), None, "{text}");
    }
    for _ in 0..5000 {
        let mut bytes = token.clone().into_bytes();
        for _ in 0..=random.usize(..3) {
            let place = random.usize(..bytes.len());
            bytes[place] = random.u8(..);
        }
        let text = String::from_utf8_lossy(&bytes);
        assert_eq!(file.of_token(&text).is_some(), text == token);
    }
}

#[test]
fn the_first_token_the_last_and_none_take_the_same_time() {
    let mut file = TokenFile::default();
    let mut tokens = Vec::new();
    for _ in 0..500 {
        let token = file.add(name("a"), Role::Read, NewToken::Bearer);
        tokens.push(token.unwrap().unwrap());
    }
    let (first, last) = (&tokens[0], &tokens[499]);
    let changed = |place: usize| {
        let mut token = first.clone();
        let digit = if token[place..].starts_with('0') {
            "1"
        } else {
            "0"
        };
        token.replace_range(place..=place, digit);
        token
    };
    let none = [changed(PREFIX.len()), changed(first.len() - 1)];
    let shown = [first, last, &none[0], &none[1]];
    // The shortest of many is what no other process has held up.
    let mut least = [std::time::Duration::MAX; 4];
    for _ in 0..400 {
        for (token, least) in shown.iter().zip(&mut least) {
            let begun = std::time::Instant::now();
            std::hint::black_box(file.of_token(token));
            *least = begun.elapsed().min(*least);
        }
    }
    let (shortest, longest) = (least.iter().min().unwrap(), least.iter().max().unwrap());
    assert!(
        longest.as_secs_f64() < 1.3 * shortest.as_secs_f64(),
        "{least:?}"
    );
}

#[test]
fn a_faulty_file_is_refused_with_the_entry() {
    for (text, said) in [
        ("[[token]]\nname = \"a b\"\nrole = \"read\"", "a b"),
        ("[[token]]\nname = \"a\"\nrole = \"root\"", "root"),
        (
            "[[token]]\nname = \"a\"\nrole = \"read\"\nsha256 = \"12\"",
            "64 hexadecimal",
        ),
        (
            "[[token]]\nname = \"a\"\nrole = \"read\"\nsecret = \"12\"",
            "secret",
        ),
        ("token = 3", "token"),
    ] {
        let why = TokenFile::parse(text).unwrap_err();
        assert!(why.contains(said), "{why}");
    }
}

#[test]
fn mutated_files_are_read_or_refused_and_never_more() {
    let mut file = TokenFile::default();
    for who in ["line-1", "line-2"] {
        file.add(name(who), Role::Solve, NewToken::Bearer).unwrap();
    }
    let text = toml::to_string(&WrittenFile {
        token: file.entries.iter().map(Entry::written).collect(),
    });
    let text = text.unwrap();
    let mut random = fastrand::Rng::with_seed(39);
    let (mut read, mut refused) = (0, 0);
    for _ in 0..4000 {
        let mut bytes = text.clone().into_bytes();
        for _ in 0..=random.usize(..4) {
            let place = random.usize(..bytes.len());
            match random.usize(..3) {
                0 => bytes[place] = random.u8(..),
                1 => bytes.truncate(place.max(1)),
                _ => bytes.insert(
                    place,
                    random.choice(b"\"[]=\n\\#{}".iter()).copied().unwrap(),
                ),
            }
        }
        match TokenFile::parse(&String::from_utf8_lossy(&bytes)) {
            Ok(found) => {
                assert!(found.entries.len() <= 2);
                read += 1;
            }
            Err(_) => refused += 1,
        }
    }
    assert!(
        read > 100 && refused > 100,
        "{read} read, {refused} refused"
    );
}
