//! The user's side of a stream: orders come in, events go out.

use std::collections::VecDeque;

use tokio::sync::mpsc;

use super::events::Event;
use super::journal::Order;
use crate::library::error::ClientError;

/// The channels between a stream and its user.
#[derive(Debug)]
pub(super) struct UserChannels {
    orders: mpsc::Receiver<Order>,
    events: mpsc::Sender<Result<Event, ClientError>>,
    /// Whether orders may follow.
    pub(super) open: bool,
    /// Events that are not taken yet.
    pub(super) ready: VecDeque<Event>,
}

/// What the user did.
pub(super) enum Activity {
    /// Gave an order.
    Order(Box<Order>),
    /// Will give no further order.
    Closed,
    /// Took an event.
    Delivered,
    /// Takes no more events.
    Left,
}

impl UserChannels {
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
    pub(super) async fn activity(&mut self) -> Activity {
        tokio::select! {
            order = self.orders.recv(), if self.open => match order {
                Some(order) => Activity::Order(order.into()),
                None => {
                    self.open = false;
                    Activity::Closed
                }
            },
            permit = self.events.reserve(), if !self.ready.is_empty() => {
                if let (Ok(permit), Some(event)) = (permit, self.ready.pop_front()) {
                    permit.send(Ok(event));
                }
                Activity::Delivered
            }
            () = self.events.closed() => Activity::Left,
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
