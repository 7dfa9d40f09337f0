//! Arguments of what is asked of several servers.

use clap::Subcommand;

#[derive(Subcommand, Debug)]
pub(crate) enum FleetCommand {
    /// Every session that a server holds, with the server and the epoch, which grows at each change
    Status {
        /// NATS server of the fleet (feature `fleet`)
        #[arg(long, value_name = "URL", env = "SIGNORINI_FLEET_NATS")]
        nats: String,
        /// Print result lines: one JSON object a session
        #[arg(long)]
        json: bool,
    },
}
