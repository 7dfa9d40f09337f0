//! `check`: every fault of a scene and its mesh, without solving it.

use super::plan;
use crate::arguments::CheckArguments;
use crate::terminal::exit::{Exit, Failure};
use crate::terminal::stdout::print;

pub(super) async fn run(arguments: CheckArguments) -> Result<Exit, Failure> {
    let (plan, _) = plan::of(&arguments.scene, plan::Detail::Decisions).await?;
    let scene = arguments.scene.scene.display();
    let verdict = match plan.warnings.len() {
        0 => "no faults".to_owned(),
        1 => "no faults, 1 warning".to_owned(),
        count => format!("no faults, {count} warnings"),
    };
    print(&format!("{scene}: {verdict}\n"))?;
    Ok(Exit::Ok)
}
