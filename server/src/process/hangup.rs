//! SIGHUP: one listener of a program, which all hear that read their files again.

use tokio::signal::unix::{SignalKind, signal};
use tokio::sync::watch;

/// The hangups that come from when this was made.
#[derive(Clone)]
pub struct Hangups(watch::Receiver<u64>);

impl Hangups {
    /// Those that the system sends to this process, inside a runtime; from here on one ends the
    /// process no more, as it does by default.
    pub fn of_process() -> Self {
        let (sender, receiver) = watch::channel(0);
        let hangup = signal(SignalKind::hangup());
        tokio::spawn(async move {
            let Ok(mut hangup) = hangup else {
                return;
            };
            while hangup.recv().await.is_some() {
                sender.send_modify(|count| *count += 1);
            }
        });
        Self(receiver)
    }

    /// None, for a server inside a program that may have other uses for the signal.
    pub fn none() -> Self {
        Self(watch::channel(0).1)
    }

    /// Returns at the next one; several that came before are one.
    pub(crate) async fn next(&mut self) {
        if self.0.changed().await.is_err() {
            // No other can come.
            std::future::pending().await
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use tokio::time::timeout;

    use super::*;

    fn hang_up() {
        let own = std::process::id().to_string();
        let mut kill = std::process::Command::new("kill");
        assert!(kill.args(["-HUP", &own]).status().unwrap().success());
    }

    #[tokio::test]
    async fn everybody_hears_each_hangup_and_nobody_where_there_are_none() {
        let (mut one, mut silent) = (Hangups::of_process(), Hangups::none());
        let mut other = one.clone();
        for _ in 0..2 {
            hang_up();
            let both = async { tokio::join!(one.next(), other.next()) };
            timeout(Duration::from_secs(20), both).await.unwrap();
        }
        let never = timeout(Duration::from_millis(20), silent.next()).await;
        assert!(never.is_err());
    }
}
