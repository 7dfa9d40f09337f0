//! Writes to stdout.

use std::io::{ErrorKind, Write};

use crate::terminal::exit::{Exit, Failure};
use crate::terminal::text::visible;

/// Writes to stdout. A reader that has gone away ends the output, not the work.
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    let mut stdout = std::io::stdout().lock();
    match stdout
        .write_all(visible(text).as_bytes())
        .and_then(|()| stdout.flush())
    {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::new(Exit::Usage, format!("stdout: {error}")))
        }
        _ => Ok(()),
    }
}
