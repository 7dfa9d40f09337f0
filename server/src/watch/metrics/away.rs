//! Why connections are turned away, by the names in metrics and the log.

/// Why a connection was turned away.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Away {
    /// There are as many as may be.
    All,
    /// The client has as many as it may have.
    Client,
    /// It did not speak HTTP/2 in time.
    Silent,
    /// The system gave no descriptor.
    Descriptors,
    /// Its handshake of transport security failed.
    Handshake,
    /// Its client took no answer.
    Unread,
}

impl Away {
    pub(crate) const ALL: [Self; 6] = [
        Self::All,
        Self::Client,
        Self::Silent,
        Self::Descriptors,
        Self::Handshake,
        Self::Unread,
    ];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::All => "all",
            Self::Client => "client",
            Self::Silent => "silent",
            Self::Descriptors => "descriptors",
            Self::Handshake => "handshake",
            Self::Unread => "unread",
        }
    }
}
