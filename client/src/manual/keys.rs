//! Keys of scenes, as the reader knows them: it names all that it knows where it meets one
//! that it does not.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use signorini_client::formats::{grid, values};
use signorini_client::scene_file::{self, SceneFileError};
use signorini_client::study::{COLUMNS_AFTER, COLUMNS_BEFORE, Study};
use toml::{Table, Value};

use super::page::{self, Page};

/// A key and a word that nothing is called by.
const UNKNOWN: &str = "xxxxxxxxxxxxxxxxxxxx";
/// What the reader says before it lists.
const LISTS: [&str; 2] = ["known keys are ", "known are "];

/// A way to a value: keys, and positions in lists.
type Way = Vec<String>;

fn every_key() -> Table {
    let text = include_str!("../scene_file/every_key.toml");
    text.parse().unwrap()
}

/// Every table and every text of a value, by their ways.
fn places(value: &Value, way: &mut Way, found: &mut Vec<Way>) {
    let mut below = |key: String, value: &Value| {
        way.push(key);
        places(value, way, found);
        way.pop();
    };
    match value {
        Value::Table(table) => table.iter().for_each(|(key, one)| below(key.clone(), one)),
        Value::Array(all) => {
            let all = all.iter().enumerate();
            all.for_each(|(at, one)| below(at.to_string(), one));
        }
        Value::String(_)
        | Value::Integer(_)
        | Value::Float(_)
        | Value::Boolean(_)
        | Value::Datetime(_) => {}
    }
    if matches!(value, Value::Table(_) | Value::String(_)) {
        found.push(way.clone());
    }
}

fn at<'a>(mut value: &'a mut Value, way: &[String]) -> &'a mut Value {
    for key in way {
        value = match key.parse::<usize>() {
            Ok(position) => &mut value[position],
            Err(_) => &mut value[key.as_str()],
        };
    }
    value
}

/// What the reader lists when the value at `way` has a key, or is a word, that it does not
/// know.
fn listed(way: &[String]) -> BTreeSet<String> {
    let mut scene = Value::Table(every_key());
    let place = at(&mut scene, way);
    if let Value::Table(table) = place {
        table.insert(UNKNOWN.to_owned(), Value::Integer(1));
    } else {
        *place = Value::String(UNKNOWN.to_owned());
    }
    let text = toml::to_string(&scene).unwrap();
    let read = scene_file::read(&text, Path::new("every.toml"), &[]);
    let Err(SceneFileError::Invalid(faults)) = read else {
        return BTreeSet::new();
    };
    let lists = faults.iter().flat_map(|fault| {
        let lists = LISTS.iter();
        lists.filter_map(|before| Some(fault.message.split_once(before)?.1.to_owned()))
    });
    lists.flat_map(|list| page::words(&list)).collect()
}

/// What the reader knows in each section of a scene; of the file itself under "".
fn known() -> BTreeMap<String, [BTreeSet<String>; 2]> {
    let scene = Value::Table(every_key());
    let mut all = Vec::new();
    places(&scene, &mut Way::new(), &mut all);
    let mut known = BTreeMap::<String, [BTreeSet<String>; 2]>::new();
    for way in all {
        let is_in_section = match &scene.as_table().unwrap().get(way.first().map_or("", |s| s)) {
            Some(Value::Table(_) | Value::Array(_)) => true,
            Some(_) | None => false,
        };
        let section = if is_in_section { way[0].as_str() } else { "" };
        let [keys, words] = known.entry(section.to_owned()).or_default();
        let is_table = at(&mut scene.clone(), &way).is_table();
        let list = if is_table { keys } else { words };
        list.extend(listed(&way).into_iter().filter(|word| {
            // Words that the sentence around a list has.
            !["not", "supported", "yet"].contains(&word.as_str())
        }));
    }
    known
}

fn section(page: &Page, name: &str) -> Page {
    if name.is_empty() {
        return page.chapter("the file", |heading| heading == "The file");
    }
    page.chapter(name, |heading| {
        let inside = heading
            .split(['[', ']'])
            .find(|part| !part.trim_matches('`').is_empty());
        inside.is_some_and(|inside| page::words(inside) == [name])
    })
}

#[test]
fn every_key_and_word_of_a_scene_is_on_its_page_and_no_other() {
    let page = Page::read("scenes.md");
    let known = known();
    assert_eq!(known.len(), 18, "{:?}", known.keys());
    for (name, [keys, words]) in known {
        let section = section(&page, &name);
        assert!(!keys.is_empty(), "{name}");
        let cells = section.first_cells();
        let cells: BTreeSet<String> = cells.iter().flat_map(|cell| page::words(cell)).collect();
        let missing: Vec<&String> = keys.difference(&cells).collect();
        assert!(missing.is_empty(), "{} lacks {missing:?}", section.name);
        let quoted = section.words();
        let missing: Vec<&String> = words.difference(&quoted).collect();
        assert!(missing.is_empty(), "{} lacks {missing:?}", section.name);
        let stale: Vec<&String> = cells.difference(&keys).collect();
        let stale: Vec<&&String> = stale
            .iter()
            .filter(|word| !words.contains(**word))
            .collect();
        assert!(stale.is_empty(), "{} has {stale:?}", section.name);
    }
}

/// A scene, or a part of one, which begins without its mesh.
fn read(text: &str) -> Result<scene_file::SceneFile, SceneFileError> {
    let whole = if text.contains("mesh =") {
        text.to_owned()
    } else {
        format!("mesh = \"a.msh\"\n{text}")
    };
    scene_file::read(&whole, Path::new("snippet.toml"), &[])
}

#[test]
fn every_scene_of_the_manual_is_read() {
    let mut scenes = 0;
    for page in Page::all() {
        // Settings of a server, and studies, which other tests read.
        if ["operations.md", "studies.md"].contains(&page.name.as_str()) {
            continue;
        }
        for snippet in page.snippets().iter().filter(|one| one.language == "toml") {
            let scene = read(&snippet.text);
            assert!(scene.is_ok(), "{}: {scene:?}\n{}", page.name, snippet.text);
            scenes += 1;
        }
    }
    assert!(scenes >= 2, "{scenes}");
}

#[test]
fn every_study_of_the_manual_is_read_and_every_key_and_column_is_told() {
    let page = Page::read("studies.md");
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/studies/study.toml");
    let snippets = page.snippets();
    for snippet in snippets.iter().filter(|one| one.language == "toml") {
        let study = Study::read(&snippet.text, &beside, &[]).unwrap();
        assert_eq!(study.count(), 12);
        let example = Study::open(&beside.with_file_name("hertz.toml"), &[]).unwrap();
        assert_eq!(study.case(5).unwrap().id, example.case(5).unwrap().id);
    }
    let unknown = |text: &str| {
        let error = Study::read(text, &beside, &[]).unwrap_err().to_string();
        let lists = error.split("known keys are ").skip(1);
        lists
            .flat_map(|list| page::words(list.split(';').next().unwrap()))
            .collect::<Vec<_>>()
    };
    let text = "zzzzzzzz = 1\n[list]\nzzzzzzzz = 1\n[[grid]]\nzzzzzzzz = 1\n[[result]]\nzzzzzzzz = 1\n\
                [sobol]\nzzzzzzzz = 1\n[[sobol.range]]\nzzzzzzzz = 1\n";
    let keys: BTreeSet<String> = unknown(text).into_iter().collect();
    let told = page
        .section("keys", |heading| heading == "The study file")
        .first_cells();
    let told: BTreeSet<String> = told.iter().flat_map(|cell| page::words(cell)).collect();
    assert_eq!(told, keys);
    let columns = page
        .section("columns", |heading| heading == "The table")
        .first_cells();
    let known = COLUMNS_BEFORE.into_iter().chain(COLUMNS_AFTER);
    assert_eq!(
        columns.iter().map(String::as_str).collect::<BTreeSet<_>>(),
        known.collect()
    );
}

#[test]
fn the_tables_of_numbers_of_the_manual_are_read() {
    let page = Page::read("scenes.md");
    let text = |word: &str| {
        let mut all = page.snippets().into_iter();
        all.find(|one| one.text.contains(word)).unwrap().text
    };
    let values = values::read(text("node, x").as_bytes()).unwrap();
    assert_eq!(values.numbers, [0, 7]);
    let heights = text("counts 41 21");
    let told = heights.lines().last().unwrap().split_whitespace();
    // The dots stand for the nodes that are left.
    let left = 41 * 21 - told.filter(|word| *word != "...").count();
    let whole = heights.replace("...", &"0.1 ".repeat(left));
    assert_eq!(grid::read(whole.as_bytes()).unwrap().counts, [41, 21]);
}
