//! `init`: a commented scene for a mesh, with what its deck says beside it.

use std::fs::OpenOptions;
use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};

use signorini_client::formats::inp::OF_THE_FILE;

use crate::arguments::input;
use crate::commands::deck_draft::LEFT_OUT;
use crate::commands::scene_draft;
use crate::terminal::exit::{Exit, Failure};
use crate::terminal::stdout::print;
use crate::terminal::text::note;

pub(super) fn run(mesh: &Path, scene: Option<PathBuf>) -> Result<Exit, Failure> {
    let read = input::load_mesh(mesh)?;
    let scene = scene.unwrap_or_else(|| mesh.with_extension("toml"));
    let named = as_named_in(&scene, mesh);
    let deck = input::load_deck(mesh)?;
    let text = scene_draft::draft(&read, &named, deck.as_ref());
    write_new(&scene, &text)?;
    // What the scene takes from the deck is in it now.
    let is_news = |warning: &&String| deck.is_none() || *warning != OF_THE_FILE;
    for warning in read.warnings.iter().filter(is_news) {
        note(&format!("warning: {warning}\n"));
    }
    let path = scene.display();
    if let Some(lines) = left_out(&text) {
        note(&format!(
            "warning: {lines} of the deck not taken over: listed at the end of {path}\n"
        ));
    }
    print(&format!("{path}\n"))?;
    Ok(Exit::Ok)
}

/// How much the list of what is not taken over holds, in words.
fn left_out(text: &str) -> Option<String> {
    let (_, list) = text.split_once(LEFT_OUT)?;
    Some(match list.trim().lines().count() {
        1 => "1 line".to_owned(),
        lines => format!("{lines} lines"),
    })
}

/// The mesh as a scene in this place names it: from there where it lies below.
fn as_named_in(scene: &Path, mesh: &Path) -> String {
    let whole = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let (scene, mesh) = (whole(scene), whole(mesh));
    let below = scene
        .parent()
        .and_then(|folder| mesh.strip_prefix(folder).ok());
    let named = below.map_or_else(|| mesh.clone(), Path::to_owned);
    named.to_string_lossy().into_owned()
}

/// Never over a file that is there.
fn write_new(path: &Path, text: &str) -> Result<(), Failure> {
    let file = OpenOptions::new().write(true).create_new(true).open(path);
    let written = file.and_then(|mut file| file.write_all(text.as_bytes()));
    written.map_err(|error| {
        if error.kind() == ErrorKind::AlreadyExists {
            let path = path.display();
            let message = format!("{path} is there already; name another scene file");
            return Failure::new(Exit::Usage, message);
        }
        Failure::unwritable(path, &error)
    })
}
