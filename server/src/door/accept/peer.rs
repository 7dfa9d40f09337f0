//! Which user of this machine is at the other end of a connection.

use std::net::{IpAddr, Ipv6Addr, SocketAddr, UdpSocket};

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

/// The peer at `address` of a connection to `local`: its user where a table of sockets has
/// it, which are those of this network namespace. A socket of IPv6 that talks to an address of
/// IPv4 stands in the table of IPv6, as clients on gRPC's C core open them.
pub(super) fn of_tcp(address: SocketAddr, local: SocketAddr) -> ClientKey {
    if !is_of_this_machine(address.ip().to_canonical(), local.ip().to_canonical()) {
        return by_address(address);
    }
    let ends = [address, local].map(canonical);
    match TABLES.iter().find_map(|table| table.user(ends)) {
        Some(number) => ClientKey {
            identity: ClientIdentity::User(number),
            strand: Strand::Connection(address),
        },
        None => by_address(address),
    }
}

/// A peer of which nothing is known but its address: another machine is one client. So is all
/// of this machine that no table knows, as a socket that its owner has closed already: else
/// whoever leaves at once would be somebody new each time.
pub(super) fn by_address(address: SocketAddr) -> ClientKey {
    let machine = machine(address.ip().to_canonical());
    ClientKey {
        identity: ClientIdentity::Address(SocketAddr::new(machine, 0)),
        strand: Strand::Connection(address),
    }
}

/// Of the global addresses of IPv6 the first half, the network: a machine has all those of the
/// second half to choose from (RFC 4291, 2.5.4).
fn machine(ip: IpAddr) -> IpAddr {
    match ip {
        IpAddr::V6(ip) if !ip.is_loopback() && !ip.is_unicast_link_local() => {
            IpAddr::V6(Ipv6Addr::from_bits(ip.to_bits() >> 64 << 64))
        }
        IpAddr::V4(_) | IpAddr::V6(_) => ip,
    }
}

/// Whether an address is one of this machine: only such can be bound.
fn is_of_this_machine(ip: IpAddr, local: IpAddr) -> bool {
    ip.is_loopback() || ip == local || UdpSocket::bind((ip, 0)).is_ok()
}

fn canonical(address: SocketAddr) -> SocketAddr {
    SocketAddr::new(address.ip().to_canonical(), address.port())
}

/// A table of sockets of Linux.
struct Table {
    path: &'static str,
    /// An address as it stands there, if it can.
    written: fn(SocketAddr) -> Option<String>,
}

const TABLES: [Table; 2] = [
    Table {
        path: "/proc/net/tcp",
        written: |address| match address.ip() {
            IpAddr::V4(ip) => Some(written(&ip.octets(), address.port())),
            IpAddr::V6(_) => None,
        },
    },
    Table {
        path: "/proc/net/tcp6",
        written: |address| {
            let ip = match address.ip() {
                IpAddr::V4(ip) => ip.to_ipv6_mapped(),
                IpAddr::V6(ip) => ip,
            };
            Some(written(&ip.octets(), address.port()))
        },
    },
];

impl Table {
    /// The owner of the socket at the first of two addresses that is connected to the second.
    fn user(&self, [address, remote]: [SocketAddr; 2]) -> Option<u32> {
        let ends = [(self.written)(address)?, (self.written)(remote)?];
        user(&std::fs::read_to_string(self.path).ok()?, &ends)
    }
}

/// The owner of the socket between two addresses, its own first.
fn user(table: &str, ends: &[String; 2]) -> Option<u32> {
    let [own, other] = ends.each_ref().map(String::as_str);
    table.lines().find_map(|line| {
        let mut fields = line.split_ascii_whitespace().skip(1);
        if fields.next() != Some(own) || fields.next() != Some(other) {
            return None;
        }
        // State, queues, timer, retransmissions; then the user, timeout, file.
        let number = fields.nth(4)?.parse().ok()?;
        // A socket that its owner has closed has no file, and the user 0.
        (fields.nth(1)? != "0").then_some(number)
    })
}

/// An address as the tables write it: words in the order of this machine.
fn written(octets: &[u8], port: u16) -> String {
    let words = octets.as_chunks::<4>().0.iter();
    let host: String = words
        .map(|word| format!("{:08X}", u32::from_ne_bytes(*word)))
        .collect();
    format!("{host}:{port:04X}")
}

#[cfg(test)]
mod tests {
    use tokio::net::{TcpListener, TcpStream};

    use super::*;

    const TABLE: &str = "  sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout inode\n\
        0: 0100007F:C383 00000000:0000 0A 00000000:00000000 00:00000000 00000000  0 0 1 1\n\
        1: 0100007F:9C40 0100007F:C383 01 00000000:00000000 00:00000000 00000000  1001 0 2 1\n\
        2: 0100007F:C383 0100007F:9C40 01 00000000:00000000 00:00000000 00000000  7 0 3 1\n\
        3: 0100007F:9C42 0100007F:C383 04 00000000:00000000 00:00000000 00000000  0 0 0 1\n";

    #[test]
    fn the_table_names_the_user_of_a_connection_that_is_still_held() {
        let end = |port: u16| written(&[127, 0, 0, 1], port);
        let found = |own, other| user(TABLE, &[end(own), end(other)]);
        if cfg!(target_endian = "little") {
            assert_eq!(found(40_000, 50_051), Some(1001));
            assert_eq!(found(50_051, 40_000), Some(7));
        }
        assert_eq!(found(40_001, 50_051), None);
        assert_eq!(found(40_002, 50_051), None, "closed by its owner");
    }

    #[test]
    fn no_table_makes_the_reader_fail() {
        let mut random = fastrand::Rng::with_seed(7);
        let ends = [40_000, 50_051].map(|port| written(&[127, 0, 0, 1], port));
        for _ in 0..2000 {
            let mut table = TABLE.as_bytes().to_vec();
            let place = random.usize(..table.len());
            match random.u8(..3) {
                0 => table.truncate(place),
                1 => table[place] = random.u8(..128),
                _ => drop(table.drain(place..)),
            }
            let table = String::from_utf8_lossy(&table);
            let _user: Option<u32> = user(&table, &ends);
        }
    }

    /// Who comes when `to` is connected to, a server that listens on `at`; the connection is
    /// held until it is dropped.
    async fn comes(at: &str, to: &str) -> std::io::Result<(ClientKey, TcpStream)> {
        let listener = TcpListener::bind(at).await?;
        let port = listener.local_addr()?.port();
        let stream = TcpStream::connect(format!("{to}:{port}")).await?;
        let (accepted, address) = listener.accept().await?;
        Ok((of_tcp(address, accepted.local_addr()?), stream))
    }

    #[tokio::test]
    async fn a_user_is_one_client_over_every_address_of_this_machine() {
        let (one, _other) = UnixStream::pair().unwrap();
        let expected = of_unix(&one).identity;
        assert!(matches!(expected, ClientIdentity::User(_)), "{expected:?}");
        let mut asked = 0;
        for (at, to) in [
            ("127.0.0.1:0", "127.0.0.1"),
            ("127.0.0.1:0", "[::ffff:127.0.0.1]"),
            ("127.0.0.1:0", "[::ffff:127.0.0.1]"),
            ("[::1]:0", "[::1]"),
            ("[::]:0", "[::1]"),
            ("[::]:0", "127.0.0.1"),
            ("[::]:0", "[::ffff:127.0.0.1]"),
        ] {
            // A machine may have no IPv6.
            let Ok((found, _held)) = comes(at, to).await else {
                continue;
            };
            assert_eq!(found.identity, expected, "{at} {to}");
            asked += 1;
        }
        assert!(asked >= 1);
    }

    #[tokio::test]
    async fn a_user_who_comes_by_another_address_of_this_machine_is_known() {
        // The address by which this machine would reach another; nothing is sent.
        let probe = UdpSocket::bind("0.0.0.0:0").unwrap();
        let Ok(()) = probe.connect("192.0.2.1:9") else {
            return;
        };
        let own = probe.local_addr().unwrap().ip().to_string();
        let (found, _held) = comes("0.0.0.0:0", &own).await.unwrap();
        assert!(matches!(found.identity, ClientIdentity::User(_)), "{own}");
    }

    #[tokio::test]
    async fn connections_of_one_process_are_one_client_with_two_strands() {
        let [one, other] = [
            comes("127.0.0.1:0", "127.0.0.1").await,
            comes("127.0.0.1:0", "127.0.0.1").await,
        ];
        let [(one, _held), (other, _too)] = [one.unwrap(), other.unwrap()];
        assert_eq!(one.identity, other.identity);
        assert_ne!(one.strand, other.strand);
    }

    #[test]
    fn a_machine_is_one_client_however_its_address_is_written() {
        let identity = |address: &str| by_address(address.parse().unwrap()).identity;
        let same = [
            ["192.0.2.7:1", "[::ffff:192.0.2.7]:2"],
            ["[2001:db8::1]:1", "[2001:db8::ffff:1]:2"],
            ["127.0.0.1:1", "127.0.0.1:2"],
        ];
        for [one, other] in same {
            assert_eq!(identity(one), identity(other), "{one} {other}");
        }
        let differ = [
            ["192.0.2.7:1", "192.0.2.8:1"],
            ["[2001:db8::1]:1", "[2001:db8:0:1::1]:1"],
            ["[fe80::1]:1", "[fe80::2]:1"],
        ];
        for [one, other] in differ {
            assert_ne!(identity(one), identity(other), "{one} {other}");
        }
    }
}
