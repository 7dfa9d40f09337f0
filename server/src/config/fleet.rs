//! Settings of a server in a fleet.

use super::{Config, ConfigError, range};

impl Config {
    /// Ranges, and what belongs together.
    pub(super) fn check_fleet(&self) -> Result<(), ConfigError> {
        let is_alone = self.fleet_nats.is_empty();
        if !is_alone && (self.data.is_empty() || self.fleet_store.is_empty()) {
            return Err(range(
                "fleet_nats",
                "given beside data and fleet_store only",
            ));
        }
        if !(1..=3600).contains(&self.fleet_lease_seconds) {
            return Err(range("fleet_lease_seconds", "1 to 3600"));
        }
        if !(1..=5).contains(&self.fleet_replicas) {
            return Err(range("fleet_replicas", "1 to 5"));
        }
        Ok(())
    }
}
