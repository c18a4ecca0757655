//! A thread that keeps what may not change threads, such as simulated modules, and works on it by orders.

use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{JoinHandle, spawn};

/// A worker's thread has ended: it panicked, or broke off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Gone;

/// See the module's documentation. One order is under way at a time.
pub struct Worker<Order, Answer> {
    orders: Option<SyncSender<Order>>,
    answers: Receiver<Answer>,
    thread: Option<JoinHandle<()>>,
}

impl<Order: Send + 'static, Answer: Send + 'static> Worker<Order, Answer> {
    /// Lets `work` make on a thread of its own what it keeps, take orders until there are no more, and send an answer to each.
    #[must_use]
    pub fn new(work: impl FnOnce(Receiver<Order>, SyncSender<Answer>) + Send + 'static) -> Self {
        let (orders, ordered) = sync_channel(1);
        let (answered, answers) = sync_channel(1);
        Self { orders: Some(orders), answers, thread: Some(spawn(move || work(ordered, answered))) }
    }

    /// Hands over an order.
    ///
    /// # Errors
    /// [`Gone`].
    pub fn give(&self, order: Order) -> Result<(), Gone> {
        self.orders.as_ref().ok_or(Gone)?.send(order).map_err(|_| Gone)
    }

    /// Waits for the next answer.
    ///
    /// # Errors
    /// [`Gone`].
    pub fn answer(&self) -> Result<Answer, Gone> {
        self.answers.recv().map_err(|_| Gone)
    }
}

impl<Order, Answer> Drop for Worker<Order, Answer> {
    fn drop(&mut self) {
        self.orders = None;
        if let Some(thread) = self.thread.take() {
            // What it panicked with has been told.
            let _ = thread.join();
        }
    }
}
