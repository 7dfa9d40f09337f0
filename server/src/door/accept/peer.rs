//! Which user of this machine is at the other end of a connection.

use std::net::{IpAddr, SocketAddr};

use tokio::net::UnixStream;

use crate::door::client_key::{ClientIdentity, ClientKey, Strand};

/// The peer of a Unix socket, as the kernel knows it.
pub(super) fn of_unix(stream: &UnixStream) -> ClientKey {
    let Ok(peer) = stream.peer_cred() else {
        return ClientKey::UNKNOWN;
    };
    ClientKey {
        identity: ClientIdentity::User(peer.uid()),
        strand: peer.pid().map_or(Strand::Unknown, Strand::Process),
    }
}

/// The peer at `address` of a connection to `local`: its user where the table of
/// sockets has it, which is that of this network namespace.
pub(super) fn of_tcp(address: SocketAddr, local: SocketAddr) -> ClientKey {
    if !address.ip().is_loopback() {
        return by_address(address);
    }
    let table = match address {
        SocketAddr::V4(_) => "/proc/net/tcp",
        SocketAddr::V6(_) => "/proc/net/tcp6",
    };
    let table = std::fs::read_to_string(table).unwrap_or_default();
    match user(&table, address, local) {
        Some(number) => ClientKey {
            identity: ClientIdentity::User(number),
            strand: Strand::Connection(address),
        },
        None => by_address(address),
    }
}

/// A peer of which nothing is known but its address: another machine is one client.
pub(super) fn by_address(address: SocketAddr) -> ClientKey {
    let known = if address.ip().is_loopback() {
        address
    } else {
        SocketAddr::new(address.ip(), 0)
    };
    ClientKey {
        identity: ClientIdentity::Address(known),
        strand: Strand::Connection(address),
    }
}

/// The owner of the socket at `address` that is connected to `remote`.
fn user(table: &str, address: SocketAddr, remote: SocketAddr) -> Option<u32> {
    let (own, other) = (written(address), written(remote));
    table.lines().find_map(|line| {
        let mut fields = line.split_ascii_whitespace().skip(1);
        let is_it = fields.next() == Some(own.as_str()) && fields.next() == Some(other.as_str());
        if !is_it {
            return None;
        }
        // State, queues, timer, retransmissions; then the user.
        fields.nth(4)?.parse().ok()
    })
}

/// An address as the table writes it: words in the order of this machine.
fn written(address: SocketAddr) -> String {
    let hex = |octets: &[u8]| -> String {
        let words = octets.as_chunks::<4>().0.iter();
        words
            .map(|word| format!("{:08X}", u32::from_ne_bytes(*word)))
            .collect()
    };
    let host = match address.ip() {
        IpAddr::V4(ip) => hex(&ip.octets()),
        IpAddr::V6(ip) => hex(&ip.octets()),
    };
    format!("{host}:{:04X}", address.port())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_names_the_user_of_a_connection() {
        let table = "  sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid\n\
            0: 0100007F:C383 00000000:0000 0A 00000000:00000000 00:00000000 00000000  0 0 1 1\n\
            1: 0100007F:9C40 0100007F:C383 01 00000000:00000000 00:00000000 00000000  1001 0 2 1\n\
            2: 0100007F:C383 0100007F:9C40 01 00000000:00000000 00:00000000 00000000  7 0 3 1\n";
        let [client, server] =
            [40_000, 50_051].map(|port| SocketAddr::from(([127, 0, 0, 1], port)));
        if cfg!(target_endian = "little") {
            assert_eq!(user(table, client, server), Some(1001));
            assert_eq!(user(table, server, client), Some(7));
        }
        let other = SocketAddr::from(([127, 0, 0, 1], 40_001));
        assert_eq!(user(table, other, server), None);
    }

    #[tokio::test]
    async fn the_peers_of_two_connections_of_one_process_are_one_client() {
        let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
        let local = listener.local_addr().unwrap();
        let mut found = Vec::new();
        for _ in 0..2 {
            let _stream = tokio::net::TcpStream::connect(local).await.unwrap();
            let (_accepted, address) = listener.accept().await.unwrap();
            found.push(of_tcp(address, local));
        }
        assert!(
            matches!(found[0].identity, ClientIdentity::User(_)),
            "{found:?}"
        );
        assert_eq!(found[0].identity, found[1].identity);
        assert_ne!(found[0].strand, found[1].strand);
    }
}
