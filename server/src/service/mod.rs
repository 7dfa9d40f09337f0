//! Tonic services that decode, call and encode, and nothing else.
//!
//! | file | what it does |
//! |---|---|
//! | `mesh`, `surface`, `session`, `state` | the handlers, by kind of resource |
//! | `streams` | `Solve` and `Watch`: streams between clients and sessions |
//! | `paced`, `timeout` | uploads in the pace of memory; the time that a caller gives |

pub(crate) mod mesh;
mod paced;
pub(crate) mod session;
mod state;
mod streams;
pub(crate) mod surface;
mod timeout;

use std::future::Future;
use std::sync::Arc;

use tonic::{Response, Status};

use crate::fault::Fault;
use crate::registry::Registry;

const PAGE_DEFAULT: usize = 100;
const PAGE_MOST: usize = 1000;

/// Answers a request; a refused one is counted.
async fn respond<T>(
    registry: &Arc<Registry>,
    work: impl Future<Output = Result<T, Fault>>,
) -> Result<Response<T>, Status> {
    match work.await {
        Ok(message) => Ok(Response::new(message)),
        Err(fault) => {
            registry.refused(&fault);
            Err(fault.into())
        }
    }
}

/// Entries of one page.
fn page_size(asked: i32) -> Result<usize, Fault> {
    match usize::try_from(asked) {
        Ok(0) => Ok(PAGE_DEFAULT),
        Ok(size) if size <= PAGE_MOST => Ok(size),
        Ok(_) | Err(_) => Err(Fault::request("page_size", "must lie between 0 and 1000")),
    }
}
