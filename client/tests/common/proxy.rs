//! A TCP proxy that breaks connections when it is told to.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::tcp::{OwnedReadHalf, OwnedWriteHalf};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::watch;
use tokio::task::JoinHandle;

/// Forwards bytes between a client and a server.
pub(crate) struct Proxy {
    /// Where clients go.
    pub(crate) url: String,
    faults: Arc<Faults>,
    task: JoinHandle<()>,
}

struct Faults {
    /// A change breaks every connection.
    cuts: watch::Sender<u64>,
    /// Nobody is let in.
    closed: AtomicBool,
    /// Bytes to the client until the next break, and from that one to the one after.
    allowances: Mutex<VecDeque<usize>>,
}

impl Proxy {
    /// Starts in front of a server.
    pub(crate) async fn start(server: &str) -> Self {
        let server = server.strip_prefix("http://").unwrap().to_owned();
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let url = format!("http://{}", listener.local_addr().unwrap());
        let faults = Arc::new(Faults {
            cuts: watch::Sender::new(0),
            closed: AtomicBool::new(false),
            allowances: Mutex::default(),
        });
        let task = tokio::spawn(accept(listener, server, Arc::clone(&faults)));
        Self { url, faults, task }
    }

    /// Breaks every connection now.
    pub(crate) fn cut(&self) {
        self.faults.cuts.send_modify(|cuts| *cuts += 1);
    }

    /// Breaks every connection each time that so many bytes more have gone to the
    /// client, wherever in a message that is.
    pub(crate) fn cut_after(&self, bytes: &[usize]) {
        self.faults.allowances.lock().unwrap().extend(bytes);
    }

    /// Breaks every connection and lets nobody in.
    pub(crate) fn close(&self) {
        self.faults.closed.store(true, Ordering::SeqCst);
        self.cut();
    }

    /// Lets clients in again.
    pub(crate) fn open(&self) {
        self.faults.closed.store(false, Ordering::SeqCst);
    }
}

impl Drop for Proxy {
    fn drop(&mut self) {
        self.task.abort();
    }
}

async fn accept(listener: TcpListener, server: String, faults: Arc<Faults>) {
    loop {
        let (client, _) = listener.accept().await.unwrap();
        if faults.closed.load(Ordering::SeqCst) {
            continue;
        }
        let mut cuts = faults.cuts.subscribe();
        let server = TcpStream::connect(&server).await.unwrap();
        let faults = Arc::clone(&faults);
        tokio::spawn(async move {
            let (from_client, to_client) = client.into_split();
            let (from_server, to_server) = server.into_split();
            tokio::select! {
                () = up(from_client, to_server) => {}
                () = down(from_server, to_client, &faults) => {}
                _ = cuts.changed() => {}
            }
        });
    }
}

async fn up(mut client: OwnedReadHalf, mut server: OwnedWriteHalf) {
    // Either side may leave at any time.
    let _left = tokio::io::copy(&mut client, &mut server).await;
}

async fn down(mut server: OwnedReadHalf, mut client: OwnedWriteHalf, faults: &Faults) {
    let mut buffer = vec![0; 4096];
    loop {
        let Ok(count @ 1..) = server.read(&mut buffer).await else {
            return;
        };
        let (allowed, cut) = faults.pass(count);
        if client.write_all(&buffer[..allowed]).await.is_err() {
            return;
        }
        if cut {
            faults.cuts.send_modify(|cuts| *cuts += 1);
            return;
        }
    }
}

impl Faults {
    /// How many of these bytes may pass, and whether the break follows.
    fn pass(&self, count: usize) -> (usize, bool) {
        let mut allowances = self.allowances.lock().unwrap();
        let Some(allowance) = allowances.front_mut() else {
            return (count, false);
        };
        let allowed = count.min(*allowance);
        *allowance -= allowed;
        let cut = *allowance == 0;
        if cut {
            allowances.pop_front();
        }
        (allowed, cut)
    }
}
