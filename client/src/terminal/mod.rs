//! What the tool shows and how it ends: text, progress, lines of results, exit codes, files that
//! are whole or not there.
//!
//! | file | what it does |
//! |---|---|
//! | `text` | stderr, and text and numbers for people |
//! | `stdout` | stdout, and a reader that has left |
//! | `exit` | exit codes and the failures that lead to them |
//! | `output` | where result lines go |
//! | `progress` | a progress line, on terminals only |
//! | `whole_file` | a file under another name until it is whole |

pub(crate) mod exit;
pub(crate) mod output;
pub(crate) mod progress;
pub(crate) mod stdout;
pub(crate) mod text;
pub(crate) mod whole_file;
