//! Drives a session step by step and passes its events to where they go.

use std::time::Duration;

use signorini_client::Client;
use signorini_client::result_line::{self, Totals};
use signorini_client::solve::{Attach, Canceller, Event, Events, Increment, Solve};
use signorini_proto::v1;
use tokio::signal::unix::{Signal, SignalKind, signal};

use crate::exit::{Exit, Failure};
use crate::output::LineSink;
use crate::progress::{Progress, Visibility};
use crate::results::ResultFolder;

/// Between two updates of a progress bar.
const PROGRESS_INTERVAL: Duration = Duration::from_millis(50);

/// Everything that a run writes to and has gathered.
pub(super) struct Run {
    pub(super) lines: LineSink,
    pub(super) folder: Option<ResultFolder>,
    pub(super) progress: Progress,
    pub(super) plan: v1::Plan,
    pub(super) reports: Vec<v1::StepReport>,
    pub(super) totals: Totals,
    visibility: Visibility,
    interrupted: bool,
}

/// What a run waits for. The signals are listened to all the time, so that none
/// is lost while files are written.
struct Answers {
    events: Events,
    canceller: Canceller,
    interrupts: Signal,
}

impl Run {
    pub(super) fn new(lines: LineSink, increments: u64, visibility: Visibility) -> Self {
        Self {
            lines,
            folder: None,
            progress: Progress::new(increments, visibility),
            plan: v1::Plan::default(),
            reports: Vec::new(),
            totals: Totals::default(),
            visibility,
            interrupted: false,
        }
    }

    /// Makes the folder for the results and starts its result lines anew.
    pub(super) fn open(&mut self, folder: ResultFolder) -> Result<(), Failure> {
        self.lines.open_file(&folder.lines())?;
        self.folder = Some(folder);
        Ok(())
    }

    /// Tells people about warnings.
    pub(super) fn warn(&self, warnings: &[String]) {
        if self.visibility == Visibility::Shown {
            for warning in warnings {
                self.progress.note(&format!("warning: {warning}"));
            }
        }
    }

    /// Sends the steps one after another until one does not converge.
    pub(super) async fn drive(
        &mut self,
        client: &Client,
        session: &str,
        steps: Vec<v1::LoadStep>,
    ) -> Result<Exit, Failure> {
        let Solve {
            mut updates,
            events,
            ..
        } = client.solve(session, self.attach()).await?;
        let canceller = updates.canceller();
        let interrupts = signal(SignalKind::interrupt())
            .map_err(|error| Failure::new(Exit::Server, format!("no signals: {error}")))?;
        let mut answers = Answers {
            events,
            canceller,
            interrupts,
        };
        for step in steps {
            let sequence = updates.load_step(step).await?;
            let termination = self.wait(sequence, &mut answers).await?;
            if self.interrupted {
                return Ok(Exit::Interrupted);
            }
            if termination != v1::Termination::Converged {
                return Ok(Exit::from(termination));
            }
        }
        Ok(Exit::Ok)
    }

    /// Every iteration for result lines, some of them for people.
    fn attach(&self) -> Attach {
        let interval = (!self.lines.is_open()).then_some(PROGRESS_INTERVAL);
        Attach {
            iteration_interval: interval,
            ..Default::default()
        }
    }

    /// Takes events until the step that was sent is done.
    async fn wait(
        &mut self,
        sequence: i64,
        answers: &mut Answers,
    ) -> Result<v1::Termination, Failure> {
        loop {
            let event = tokio::select! {
                event = answers.events.next() => event?,
                Some(()) = answers.interrupts.recv() => {
                    self.interrupt(sequence, &answers.canceller).await?;
                    continue;
                }
            };
            let Some(event) = event else {
                let message = "the stream ended before the result of a step";
                return Err(Failure::new(Exit::Server, message));
            };
            if let Some(termination) = self.take(event)? {
                return Ok(termination);
            }
        }
    }

    /// The first time cancels and keeps the last state, the second time quits.
    async fn interrupt(&mut self, sequence: i64, canceller: &Canceller) -> Result<(), Failure> {
        if self.interrupted {
            self.progress.clear();
            std::process::exit(Exit::Interrupted as i32);
        }
        self.interrupted = true;
        self.progress
            .note("cancelling; press Ctrl-C again to quit at once");
        Ok(canceller.cancel(sequence).await?)
    }

    /// How the step ended, when the event ends it.
    fn take(&mut self, event: Event) -> Result<Option<v1::Termination>, Failure> {
        match event {
            Event::Iteration(statistics) => {
                self.lines.write(&result_line::iteration(&statistics))?;
                self.progress
                    .iteration(&statistics.report.unwrap_or_default());
                Ok(None)
            }
            Event::Increment(increment) => self.add(*increment),
            Event::Rejected { refusal, .. } => Err(Failure::from(&*refusal)),
            Event::Heartbeat(_) => Ok(None),
        }
    }

    fn add(&mut self, increment: Increment) -> Result<Option<v1::Termination>, Failure> {
        self.lines.write(&result_line::step(&increment.report))?;
        if let Some(folder) = &mut self.folder {
            folder.add(&increment)?;
        }
        if increment.fields_dropped {
            self.warn(&["the fields of a result are no longer kept by the server".to_owned()]);
        }
        let termination = increment.report.termination();
        self.totals.add(&increment.report);
        self.reports.push(increment.report);
        self.progress.finished();
        Ok(increment.last.then_some(termination))
    }
}
