//! A proxy of HTTP/2 that gives pages in place of answers and cuts streams off, as those do whose
//! server is gone, and that notes to which session each call says it belongs.

use std::collections::VecDeque;
use std::convert::Infallible;
use std::pin::{Pin, pin};
use std::sync::{Arc, Mutex};
use std::task::{Context, Poll};

use bytes::Bytes;
use hyper::body::{Frame, Incoming};
use hyper::{Request, Response};
use hyper_util::rt::{TokioExecutor, TokioIo};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::watch;
use tokio::task::JoinHandle;
use tonic::body::Body;
use tonic::transport::{Channel, Endpoint};
use tower::ServiceExt as _;

/// What the next call gets in place of an answer.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Mishap {
    /// A page of HTML with that status.
    Page(u16),
    /// The end of the stream, without a word.
    Cancel,
}

/// A call: its method, and the session that it names.
pub(crate) type Call = (String, Option<String>);

/// Between clients and a server.
pub(crate) struct Gateway {
    /// Where clients go.
    pub(crate) url: String,
    state: Arc<State>,
    task: JoinHandle<()>,
}

struct State {
    server: Channel,
    mishaps: Mutex<VecDeque<Mishap>>,
    calls: Mutex<Vec<Call>>,
    /// A change cuts every open call off.
    cuts: watch::Sender<u64>,
}

impl Gateway {
    /// Starts in front of a server.
    pub(crate) async fn start(server: &str) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let url = format!("http://{}", listener.local_addr().unwrap());
        let server = Endpoint::from_shared(server.to_owned()).unwrap();
        let state = Arc::new(State {
            server: server.connect().await.unwrap(),
            mishaps: Mutex::default(),
            calls: Mutex::default(),
            cuts: watch::Sender::new(0),
        });
        let task = tokio::spawn(accept(listener, Arc::clone(&state)));
        Self { url, state, task }
    }

    /// What happens to the next calls, one each.
    pub(crate) fn expect(&self, mishaps: &[Mishap]) {
        self.state.mishaps.lock().unwrap().extend(mishaps);
    }

    /// Cuts every open call off.
    pub(crate) fn cut(&self) {
        self.state.cuts.send_modify(|cuts| *cuts += 1);
    }

    /// The calls so far.
    pub(crate) fn calls(&self) -> Vec<Call> {
        self.state.calls.lock().unwrap().clone()
    }
}

impl Drop for Gateway {
    fn drop(&mut self) {
        self.task.abort();
    }
}

async fn accept(listener: TcpListener, state: Arc<State>) {
    loop {
        let (client, _) = listener.accept().await.unwrap();
        tokio::spawn(carry(client, Arc::clone(&state)));
    }
}

async fn carry(client: TcpStream, state: Arc<State>) {
    let answer = hyper::service::service_fn(|request| {
        let state = Arc::clone(&state);
        async move { Ok::<_, Infallible>(answer(&state, request).await) }
    });
    let builder = hyper::server::conn::http2::Builder::new(TokioExecutor::new());
    // Whoever leaves ends it.
    let _left = builder.serve_connection(TokioIo::new(client), answer).await;
}

async fn answer(state: &State, request: Request<Incoming>) -> Response<Cuttable> {
    let cut = state.cuts.subscribe();
    let session = request.headers().get("x-signorini-session");
    let session = session.map(|id| id.to_str().unwrap().to_owned());
    let method = request.uri().path().rsplit('/').next().unwrap().to_owned();
    state.calls.lock().unwrap().push((method, session));
    let mishap = state.mishaps.lock().unwrap().pop_front();
    let answer = match mishap {
        Some(Mishap::Page(status)) => page(status),
        Some(Mishap::Cancel) => {
            let (_, cut) = watch::channel(0);
            return Response::new(Cuttable {
                body: Body::empty(),
                cut: Box::pin(cut_off(cut)),
            });
        }
        None => {
            let forwarded = request.map(Body::new);
            let sent = state.server.clone().oneshot(forwarded).await;
            sent.unwrap_or_else(|_| page(502))
        }
    };
    let cut = Box::pin(cut_off(cut));
    answer.map(|body| Cuttable { body, cut })
}

fn page(status: u16) -> Response<Body> {
    let text = "<html><body><h1>No server is available</h1></body></html>";
    let response = Response::builder().status(status);
    let response = response.header("content-type", "text/html");
    response.body(Body::new(text.to_owned())).unwrap()
}

/// Completes at the next cut, or when there is nobody to make one.
async fn cut_off(mut cut: watch::Receiver<u64>) {
    let _cut = cut.changed().await;
}

/// A body that ends by a reset.
struct Cuttable {
    body: Body,
    cut: Pin<Box<dyn Future<Output = ()> + Send>>,
}

impl hyper::body::Body for Cuttable {
    type Data = Bytes;
    type Error = Box<dyn std::error::Error + Send + Sync>;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, Self::Error>>> {
        if self.cut.as_mut().poll(context).is_ready() {
            let reset = h2::Error::from(h2::Reason::CANCEL);
            return Poll::Ready(Some(Err(reset.into())));
        }
        let frame = pin!(&mut self.body).poll_frame(context);
        frame.map(|frame| frame.map(|frame| frame.map_err(Into::into)))
    }
}
