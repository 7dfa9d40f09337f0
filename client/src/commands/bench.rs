//! `bench`: measures families of scenes and writes table, figures and a page.

use signorini_bench::{Arguments, BenchError, End, Watched};

use crate::terminal::exit::{Exit, Failure};
use crate::terminal::stdout::print;
use crate::terminal::text::note;

pub(super) async fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let program = std::env::current_exe()
        .map_err(|error| Failure::new(Exit::Server, format!("this program: {error}")))?;
    let mut interrupts = super::Interrupts::new()?;
    let watched = Watched {
        program,
        interrupted: interrupts.next(),
        note,
    };
    let finished = signorini_bench::run(arguments, watched).await?;
    print(&format!("{}\n", finished.page.display()))?;
    Ok(match finished.end {
        End::Complete => Exit::Ok,
        End::NothingConverged => Exit::NotConverged,
        End::Interrupted => Exit::Interrupted,
    })
}

impl From<BenchError> for Failure {
    fn from(error: BenchError) -> Self {
        let exit = match &error {
            BenchError::Arguments(_) | BenchError::Unwritable { .. } => Exit::Usage,
            BenchError::Peers(_) | BenchError::NoMesh { .. } => Exit::Invalid,
            BenchError::Table(_) => Exit::Server,
        };
        Self::new(exit, error.to_string())
    }
}
