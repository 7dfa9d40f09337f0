//! The user's side of a stream.

use std::collections::VecDeque;

use tokio::sync::mpsc;

use super::events::Event;
use super::journal::Order;
use crate::error::ClientError;

/// Orders in, events out.
#[derive(Debug)]
pub(super) struct Desk {
    orders: mpsc::Receiver<Order>,
    events: mpsc::Sender<Result<Event, ClientError>>,
    /// Whether orders may follow.
    pub(super) open: bool,
    /// Events that are not taken yet.
    pub(super) ready: VecDeque<Event>,
}

/// What happened at the desk.
pub(super) enum Turn {
    Order(Order),
    /// No order follows.
    Closed,
    Delivered,
    /// Nobody takes events any more.
    Left,
}

impl Desk {
    pub(super) fn new(
        orders: mpsc::Receiver<Order>,
        events: mpsc::Sender<Result<Event, ClientError>>,
    ) -> Self {
        Self {
            orders,
            events,
            open: true,
            ready: VecDeque::new(),
        }
    }

    /// Waits for the user; nothing is lost when the future is dropped.
    pub(super) async fn turn(&mut self) -> Turn {
        tokio::select! {
            order = self.orders.recv(), if self.open => match order {
                Some(order) => Turn::Order(order),
                None => {
                    self.open = false;
                    Turn::Closed
                }
            },
            permit = self.events.reserve(), if !self.ready.is_empty() => {
                if let (Ok(permit), Some(event)) = (permit, self.ready.pop_front()) {
                    permit.send(Ok(event));
                }
                Turn::Delivered
            }
            () = self.events.closed() => Turn::Left,
        }
    }

    /// Gives the rest and the error that ends the stream.
    pub(super) async fn fail(&mut self, error: ClientError) {
        self.finish().await;
        // Nobody may be there any more.
        let _left = self.events.send(Err(error)).await;
    }

    /// Gives the rest of a stream that has ended well.
    pub(super) async fn finish(&mut self) {
        while let Some(event) = self.ready.pop_front() {
            if self.events.send(Ok(event)).await.is_err() {
                return;
            }
        }
    }
}
