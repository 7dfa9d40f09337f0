//! `version`: what many type in place of `--version`.

use crate::terminal::exit::{Exit, Failure};
use crate::terminal::stdout::print;

pub(super) fn run() -> Result<Exit, Failure> {
    print(concat!("signorini ", env!("CARGO_PKG_VERSION"), "\n"))?;
    Ok(Exit::Ok)
}
