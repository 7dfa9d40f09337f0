//! Commands, flags and settings; every command line of the manual is understood.

use std::collections::BTreeSet;

use clap::{Command, CommandFactory as _};
use signorini_server::Config;

use super::page::{Page, words};
use crate::arguments::Arguments;

fn program() -> Command {
    let mut program = Arguments::command();
    program.build();
    program
}

/// Paths of the commands that people see, and their flags.
fn commands(command: &Command, path: &str, paths: &mut Vec<String>, flags: &mut BTreeSet<String>) {
    let own = command.get_arguments().filter(|flag| !flag.is_hide_set());
    let long = own.filter_map(|flag| flag.get_long());
    flags.extend(
        long.filter(|long| !["help", "version"].contains(long))
            .map(str::to_owned),
    );
    for below in command.get_subcommands() {
        if below.is_hide_set() || below.get_name() == "help" {
            continue;
        }
        let path = format!("{path} {}", below.get_name());
        if below.get_subcommands().next().is_none() {
            paths.push(path.clone());
        }
        commands(below, &path, paths, flags);
    }
}

/// Flags in the first cells of the tables of a page.
fn flags_of(page: &Page) -> BTreeSet<String> {
    let cells = page.first_cells();
    let flags = cells.iter().filter_map(|cell| cell.strip_prefix("--"));
    flags
        .filter_map(|flag| words(flag).into_iter().next())
        .collect()
}

#[test]
fn every_command_and_flag_is_on_its_page_and_no_other() {
    let (mut paths, mut flags) = (Vec::new(), BTreeSet::new());
    commands(&program(), "signorini", &mut paths, &mut flags);
    let page = Page::read("command-line.md");
    for path in paths {
        let told = page.first_cells();
        assert!(told.iter().any(|cell| is_of(cell, &path)), "{path}");
    }
    assert_eq!(flags_of(&page), flags);
}

/// Whether a span is a command with no more than its arguments after it.
fn is_of(span: &str, path: &str) -> bool {
    let rest = span.strip_prefix(path);
    rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(' '))
}

#[test]
fn every_setting_and_flag_of_the_server_is_on_its_page_and_no_other() {
    let page = Page::read("operations.md");
    let section = page.section("settings", |heading| heading == "Settings");
    let unknown = Config::from_toml("unknown_setting = 1")
        .unwrap_err()
        .to_string();
    let (_, list) = unknown.split_once("expected one of").unwrap();
    let keys: BTreeSet<String> = list
        .split('`')
        .skip(1)
        .step_by(2)
        .map(str::to_owned)
        .collect();
    let cells = section.first_cells();
    let is_key = |cell: &&String| !cell.starts_with('-') && !cell.contains("SIGNORINI");
    let told: BTreeSet<String> = cells.iter().filter(is_key).cloned().collect();
    assert_eq!(told, keys);
    let program = program();
    let serve = program.find_subcommand("serve").unwrap();
    let (mut paths, mut flags) = (Vec::new(), BTreeSet::new());
    commands(serve, "", &mut paths, &mut flags);
    assert_eq!(flags_of(&section), flags);
    for flag in serve.get_arguments().filter_map(clap::Arg::get_env) {
        assert!(section.text.contains(flag.to_str().unwrap()), "{flag:?}");
    }
    for snippet in page.snippets().iter().filter(|one| one.language == "toml") {
        let config = Config::from_toml(&snippet.text);
        assert!(config.is_ok(), "{config:?}");
    }
}

/// Arguments after `signorini` on a line of a shell, if it runs that.
fn arguments(line: &str) -> Option<Vec<String>> {
    let line = line
        .split(" #")
        .next()?
        .split([';', '|', '>', '&'])
        .next()?;
    let line = match line.split_once("--bin signorini -- ") {
        Some((_, rest)) if line.contains("cargo run") => format!("signorini {rest}"),
        _ => line.trim().to_owned(),
    };
    let arguments = line.split_whitespace();
    let arguments: Vec<String> = arguments
        .skip_while(|word| word.contains('=') && word.starts_with(|c: char| c.is_ascii_uppercase()))
        .map(|word| word.trim_matches(['\'', '"']).to_owned())
        .collect();
    (arguments.first()? == "signorini").then_some(arguments)
}

/// A command line that stands for one: `signorini mesh info FILE`.
fn is_understood(arguments: &[String]) -> Result<(), clap::Error> {
    // Numbers stand for what has to be one.
    let given = arguments.iter().map(|word| match word.as_str() {
        "SECONDS" | "N" => "1".to_owned(),
        "SHELL" => "bash".to_owned(),
        "PATH=VALUE" => "mesh=VALUE".to_owned(),
        "URL" => "unix:PATH".to_owned(),
        other => other.trim_matches(['[', ']']).to_owned(),
    });
    let mut given: Vec<String> = given.collect();
    let remote = ["watch", "fetch", "cancel", "session"];
    let is_remote = match given.get(1).map(String::as_str) {
        Some("mesh") => given.get(2).is_some_and(|word| word != "info"),
        Some(other) => remote.contains(&other),
        None => false,
    };
    // Said by SIGNORINI_SERVER, or elsewhere on the page.
    if is_remote && !given.iter().any(|word| word == "--server") {
        given.extend(["--server".to_owned(), "unix:PATH".to_owned()]);
    }
    program().try_get_matches_from(given).map(|_| ())
}

/// Whether a line names a command, or stands for all of them, and gives it nothing.
fn is_name(arguments: &[String]) -> bool {
    let mut command = program();
    for word in arguments.iter().skip(1) {
        match command.find_subcommand(word) {
            Some(below) => command = below.clone(),
            None => return word == "COMMAND",
        }
    }
    true
}

#[test]
fn every_command_line_of_the_manual_is_understood() {
    let mut lines = 0;
    for page in Page::all() {
        let is_shell = |language: &str| ["", "sh", "bash", "console"].contains(&language);
        let shell = page
            .snippets()
            .into_iter()
            .filter(|one| is_shell(&one.language));
        let shell: Vec<String> = shell.map(|one| one.text).collect();
        let snippets = shell
            .iter()
            .flat_map(|text| text.lines().map(str::to_owned));
        let spans = page.spans().into_iter().filter(|span| span.contains(' '));
        for line in snippets.chain(spans) {
            let Some(arguments) = arguments(&line) else {
                continue;
            };
            if is_name(&arguments) {
                continue;
            }
            if let Err(error) = is_understood(&arguments) {
                let is_help = error.exit_code() == 0;
                assert!(is_help, "{}: {line}: {error}", page.name);
            }
            lines += 1;
        }
    }
    assert!(lines >= 30, "{lines}");
}
