//! `plan`: what a scene needs, what is left out and why.

use signorini_client::{Client, result_line};
use signorini_proto::v1;

use crate::arguments::connection::Connection;
use crate::arguments::input::{self, Input};
use crate::arguments::{PlanArguments, SceneArguments};
use crate::report::table;
use crate::terminal::exit::{Exit, Failure};
use crate::terminal::stdout::print;
use crate::terminal::text::note;

pub(super) async fn run(arguments: PlanArguments) -> Result<Exit, Failure> {
    let detail = if arguments.constants {
        Detail::Constants
    } else {
        Detail::Decisions
    };
    let (plan, units) = of(&arguments.scene, detail).await?;
    if arguments.json {
        print(&format!("{}\n", result_line::plan(&plan, units.as_ref())))?;
    } else {
        print(&table::plan(&plan))?;
    }
    Ok(Exit::Ok)
}

/// What a plan shall list.
#[derive(Clone, Copy)]
pub(super) enum Detail {
    /// What is decided.
    Decisions,
    /// That, and the solver's constants.
    Constants,
}

/// The plan of a scene, after its warnings have been told, and what its units are called.
pub(super) async fn of(
    arguments: &SceneArguments,
    detail: Detail,
) -> Result<(v1::Plan, Option<v1::UnitNames>), Failure> {
    let input = input::load(arguments)?;
    let units = input.scene.units.clone();
    let mut warnings = input.mesh.warnings.clone();
    warnings.extend(first_mesh(&input.scene));
    tell(&warnings);
    let connection = Connection::open(arguments).await?;
    let plan = fetch(&connection.client, input, detail).await;
    connection.close().await;
    let mut plan = plan?;
    tell(&plan.warnings);
    warnings.append(&mut plan.warnings);
    plan.warnings = warnings;
    Ok((plan, units))
}

/// What is told of a mesh that `solve` refines.
fn first_mesh(scene: &v1::Scene) -> Option<String> {
    let accuracy = scene.accuracy.as_ref()?;
    let told = "[accuracy] has tolerances: this is the plan on the mesh of the scene, which \
                `signorini solve` refines";
    (!accuracy.targets.is_empty()).then(|| told.to_owned())
}

fn tell(warnings: &[String]) {
    for warning in warnings {
        note(&format!("warning: {warning}\n"));
    }
}

async fn fetch(client: &Client, mut input: Input, detail: Detail) -> Result<v1::Plan, Failure> {
    input.upload(client).await?;
    Ok(match detail {
        Detail::Decisions => client.plan(input.scene).await?,
        Detail::Constants => client.plan_with_constants(input.scene).await?,
    })
}
