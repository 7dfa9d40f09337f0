//! Rooms of the server, of the client's library and of its tool: each imports only what the
//! tables allow. A room stands below those that may import it, so that there is no circle.

use crate::modules::Tree;
use crate::workspace;

/// A room, and the others that it may import.
type Room = (&'static str, &'static [&'static str]);

const SERVER: &[Room] = &[
    ("process", &[]),
    ("fault", &[]),
    ("config", &["process"]),
    ("watch", &["config", "fault", "process"]),
    ("door", &["config", "fault", "process", "watch"]),
    ("convert", &["config", "fault"]),
    ("compute", &["config", "door", "watch"]),
    ("journal", &["config", "watch"]),
    ("results", &["convert", "fault"]),
    ("uploads", &["convert", "door", "fault", "watch"]),
    ("fleet", &["config", "fault", "journal", "watch"]),
    (
        "session",
        &[
            "compute", "config", "convert", "door", "fault", "fleet", "journal", "process",
            "results", "uploads", "watch",
        ],
    ),
    (
        "registry",
        &[
            "compute", "config", "convert", "door", "fault", "fleet", "journal", "process",
            "session", "uploads", "watch",
        ],
    ),
    (
        "data",
        &[
            "convert", "door", "fault", "journal", "registry", "session", "uploads",
        ],
    ),
    (
        "service",
        &[
            "convert", "data", "door", "fault", "fleet", "journal", "registry", "results",
            "session", "uploads", "watch",
        ],
    ),
    (
        "serve",
        &[
            "compute", "config", "data", "door", "fleet", "journal", "process", "registry",
            "service", "session", "uploads", "watch",
        ],
    ),
];

const CLIENT: &[Room] = &[
    ("formats", &[]),
    ("library", &["formats"]),
    ("scene_file", &["formats", "library"]),
    ("study", &["library", "scene_file"]),
];

const TOOL: &[Room] = &[
    ("terminal", &[]),
    ("report", &["terminal"]),
    ("arguments", &["report", "terminal"]),
    ("studies", &["arguments", "report", "terminal"]),
    ("commands", &["arguments", "report", "studies", "terminal"]),
];

/// Imports of `tree` that `table` does not allow, and rooms that it does not list.
fn faults(tree: &Tree, table: &[Room]) -> Vec<String> {
    let (rooms, edges) = tree.rooms();
    let mut faults = Vec::new();
    for (room, used) in rooms.iter().zip(edges) {
        let Some((_, allowed)) = table.iter().find(|(name, _)| name == room) else {
            faults.push(format!("{room} is in no table"));
            continue;
        };
        let used = used.into_iter().map(|used| rooms[used].as_str());
        let refused = used.filter(|used| !allowed.contains(used));
        faults.extend(refused.map(|used| format!("{room} imports {used}")));
    }
    faults
}

#[test]
fn rooms_of_server_and_client_import_only_what_the_tables_allow() {
    for (root, table) in [
        ("server/src/lib.rs", SERVER),
        ("client/src/lib.rs", CLIENT),
        ("client/src/main.rs", TOOL),
    ] {
        let found = faults(&Tree::read(&workspace().join(root)), table);
        assert!(found.is_empty(), "{root}: {found:?}");
    }
}

#[test]
fn tables_list_each_room_after_those_that_it_may_import() {
    for table in [SERVER, CLIENT, TOOL] {
        for (at, (room, allowed)) in table.iter().enumerate() {
            let earlier = |name: &&str| table[..at].iter().any(|(earlier, _)| earlier == name);
            assert!(allowed.iter().all(earlier), "{room}");
        }
    }
}
