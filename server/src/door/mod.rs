//! Before the services: connections are accepted, each call is identified, counted, asked who
//! it is and held to its share, and what no handler shall see is refused in the words of the
//! contract. Nothing here knows a session.
//!
//! | file | what it does |
//! |---|---|
//! | `listen` | addresses: loopback TCP, a Unix socket, or TCP with transport security and tokens |
//! | `accept` | connections, with their limits in all and of one client |
//! | `client_key`, `client_name` | whom a connection and a request belong to |
//! | `layer` | a tower layer from one function around a call |
//! | `request_id` | layer: the identifier of a call |
//! | `calls` | layer: counts calls and the bytes of their messages |
//! | `access` | layer: transport security, tokens, roles, rates, audit |
//! | `open_calls` | layer: how many calls of health and reflection are open |
//! | `gates` | layer: memory of messages, plans and uploads before it exists |
//! | `transport` | layer: refusals of the transport with their reasons |
//! | `untaken` | layer: since when answers wait for their clients |
//! | `refusal` | counts and logs a refused request |

pub(crate) mod accept;
pub(crate) mod access;
pub(crate) mod calls;
pub(crate) mod client_key;
pub(crate) mod client_name;
pub(crate) mod gates;
pub(crate) mod layer;
pub(crate) mod listen;
pub(crate) mod open_calls;
pub(crate) mod refusal;
pub(crate) mod request_id;
pub(crate) mod transport;
pub(crate) mod untaken;
