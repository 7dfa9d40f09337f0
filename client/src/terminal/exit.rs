//! Exit codes, and the failures that lead to them.

use std::io::ErrorKind;
use std::path::Path;
use std::process::ExitCode;

use signorini_client::scene_file::SceneFileError;
use signorini_client::study::StudyError;
use signorini_client::{ClientError, Refusal, Violation};
use signorini_proto::v1::Termination;
use tonic::Code;

use crate::terminal::text::note;

/// How the process ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Exit {
    /// All well.
    Ok = 0,
    /// Wrong arguments, names that the server does not know, or files that cannot be written.
    Usage = 2,
    /// A step did not converge; results are kept.
    NotConverged = 3,
    /// A scene or mesh that is invalid or not supported.
    Invalid = 4,
    /// No server answers.
    NoServer = 5,
    /// Quota, queue, memory or size, a name that is in use, or a token that does not do.
    Refused = 6,
    /// Time is up.
    Deadline = 7,
    /// A fault of the server.
    Server = 8,
    /// No room for what is to be written.
    DiskFull = 9,
    /// The server was restarted and has lost the session; results so far are kept.
    Restarted = 10,
    /// A limit came before goals were known as well as the scene asks; results are kept.
    Inaccurate = 11,
    /// Ctrl-C.
    Interrupted = 130,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit as u8)
    }
}

impl From<Termination> for Exit {
    fn from(termination: Termination) -> Self {
        match termination {
            Termination::Converged => Self::Ok,
            Termination::NotConverged | Termination::Cancelled => Self::NotConverged,
            Termination::DeadlineExceeded => Self::Deadline,
            Termination::InternalError | Termination::Unspecified => Self::Server,
        }
    }
}

/// Why a command could not do its work.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Failure {
    exit: Exit,
    messages: Vec<String>,
}

impl Failure {
    pub(crate) fn new(exit: Exit, message: impl Into<String>) -> Self {
        let messages = vec![message.into()];
        Self { exit, messages }
    }

    /// A file that cannot be read; where it was looked for when it is not there.
    pub(crate) fn unreadable(path: &Path, error: &std::io::Error) -> Self {
        let mut message = format!("{}: {error}", path.display());
        if error.kind() == ErrorKind::NotFound
            && path.is_relative()
            && let Ok(whole) = std::path::absolute(path)
        {
            message.push_str(&format!("; looked for {}", whole.display()));
        }
        Self::new(Exit::Invalid, message)
    }

    /// The same failure with a hint after its last message.
    #[must_use]
    pub(crate) fn hint(mut self, hint: &str) -> Self {
        if let Some(last) = self.messages.last_mut() {
            last.push_str(hint);
        }
        self
    }

    /// The same failure, its messages saying which file they are about.
    #[must_use]
    pub(crate) fn about(mut self, path: &Path) -> Self {
        for message in &mut self.messages {
            message.insert_str(0, &format!("{}: ", path.display()));
        }
        self
    }

    /// A file that cannot be written.
    pub(crate) fn unwritable(path: &Path, error: &std::io::Error) -> Self {
        let is_full = matches!(
            error.kind(),
            ErrorKind::StorageFull | ErrorKind::QuotaExceeded | ErrorKind::FileTooLarge
        );
        if is_full {
            let text = format!("{}: {error}; files before it are whole", path.display());
            return Self::new(Exit::DiskFull, text);
        }
        Self::new(Exit::Usage, format!("{}: {error}", path.display()))
    }

    /// Its messages in one line.
    pub(crate) fn text(&self) -> String {
        self.messages.join("; ")
    }

    fn violations(violations: &[Violation]) -> Self {
        let messages = violations.iter().map(ToString::to_string).collect();
        Self {
            exit: Exit::Invalid,
            messages,
        }
    }

    /// Prints its messages, one a line.
    pub(crate) fn report(&self) -> Exit {
        for message in &self.messages {
            note(&format!("error: {message}\n"));
        }
        self.exit
    }
}

impl From<SceneFileError> for Failure {
    fn from(error: SceneFileError) -> Self {
        match &error {
            SceneFileError::Invalid(violations) => Self::violations(violations),
            SceneFileError::Syntax(_) => Self::new(Exit::Invalid, error.to_string()),
        }
    }
}

impl From<StudyError> for Failure {
    fn from(error: StudyError) -> Self {
        match error {
            StudyError::Invalid(violations) => Self::violations(&violations),
            StudyError::Scene { path, source } => Self::from(source).about(&path),
            StudyError::File { path, source } => Self::unreadable(&path, &source),
            StudyError::Syntax { .. } | StudyError::List { .. } => {
                Self::new(Exit::Invalid, error.to_string())
            }
        }
    }
}

impl From<&Refusal> for Failure {
    fn from(refusal: &Refusal) -> Self {
        let exit = exit_of(refusal);
        if refusal.violations.is_empty() {
            return Self::new(exit, refusal.to_string()).hint(way_on(refusal));
        }
        let mut violations = refusal.violations.clone();
        if refusal.code == Code::Unimplemented {
            for violation in &mut violations {
                violation.message = format!("not supported yet: {}", violation.message);
            }
        }
        Self {
            exit,
            ..Self::violations(&violations)
        }
    }
}

impl From<ClientError> for Failure {
    fn from(error: ClientError) -> Self {
        if let Some(refusal) = error.refusal() {
            return Self::from(refusal);
        }
        let exit = match error {
            ClientError::Address(_)
            | ClientError::Token
            | ClientError::NoAuthority(_)
            | ClientError::Readable(_) => Exit::Usage,
            ClientError::Unreachable { .. }
            | ClientError::Gateway { .. }
            | ClientError::Broken { .. }
            | ClientError::Silent(_) => Exit::NoServer,
            ClientError::MeshTooLarge(_) => Exit::Invalid,
            ClientError::SessionLost(_) => Exit::Restarted,
            ClientError::Refused(_)
            | ClientError::Protocol(_)
            | ClientError::Array(_)
            | ClientError::ResultsLost { .. }
            | ClientError::Closed => Exit::Server,
        };
        Self::new(exit, error.to_string())
    }
}

/// A task of this process that ended by a defect.
pub(crate) fn panicked(error: &tokio::task::JoinError) -> Failure {
    Failure::new(Exit::Server, format!("a defect of this program: {error}"))
}

/// What to do about a refusal, where that is a command.
fn way_on(refusal: &Refusal) -> &'static str {
    match refusal.reason.as_str() {
        "SESSION_NOT_FOUND" => "; `signorini session list` shows those there are",
        _ => "",
    }
}

/// Whether a session failed for want of memory, not by a defect.
fn is_memory(refusal: &Refusal) -> bool {
    let cause = refusal.metadata.get("cause");
    cause.is_some_and(|cause| cause == "memory")
}

fn exit_of(refusal: &Refusal) -> Exit {
    match refusal.reason.as_str() {
        "SESSION_NOT_FOUND" | "SESSION_EXPIRED" | "STEP_NOT_FOUND" | "REQUEST_INVALID" => {
            return Exit::Usage;
        }
        "SESSION_EXISTS" | "MESH_IN_USE" | "SURFACE_IN_USE" => return Exit::Refused,
        "MESH_NOT_FOUND" | "SURFACE_NOT_FOUND" => return Exit::Invalid,
        "SESSION_FAILED" if is_memory(refusal) => return Exit::Refused,
        "REFINEMENT_FAILED" => return Exit::NotConverged,
        _ => {}
    }
    match refusal.code {
        Code::InvalidArgument => Exit::Invalid,
        // A server that lacks the whole method has no reason to give.
        Code::Unimplemented if !refusal.reason.is_empty() => Exit::Invalid,
        Code::Unavailable => Exit::NoServer,
        Code::ResourceExhausted
        | Code::Aborted
        | Code::PermissionDenied
        | Code::Unauthenticated => Exit::Refused,
        Code::DeadlineExceeded => Exit::Deadline,
        Code::Ok
        | Code::Cancelled
        | Code::Unknown
        | Code::NotFound
        | Code::AlreadyExists
        | Code::FailedPrecondition
        | Code::OutOfRange
        | Code::Unimplemented
        | Code::Internal
        | Code::DataLoss => Exit::Server,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(code: Code, reason: &str) -> Refusal {
        Refusal {
            code,
            reason: reason.to_owned(),
            message: "no".to_owned(),
            metadata: Default::default(),
            violations: Vec::new(),
        }
    }

    #[test]
    fn refusals_have_the_exit_codes_of_the_contract() {
        for (code, reason, exit) in [
            (Code::InvalidArgument, "SCENE_INVALID", Exit::Invalid),
            (Code::InvalidArgument, "MESH_INVALID", Exit::Invalid),
            (
                Code::Unimplemented,
                "UNSUPPORTED_COMBINATION",
                Exit::Invalid,
            ),
            (Code::Unimplemented, "", Exit::Server),
            (Code::NotFound, "MESH_NOT_FOUND", Exit::Invalid),
            (Code::NotFound, "SURFACE_NOT_FOUND", Exit::Invalid),
            (Code::NotFound, "SESSION_NOT_FOUND", Exit::Usage),
            (Code::NotFound, "STEP_NOT_FOUND", Exit::Usage),
            (Code::AlreadyExists, "SESSION_EXISTS", Exit::Refused),
            (Code::FailedPrecondition, "MESH_IN_USE", Exit::Refused),
            (Code::FailedPrecondition, "SURFACE_IN_USE", Exit::Refused),
            (Code::InvalidArgument, "REQUEST_INVALID", Exit::Usage),
            (Code::Unavailable, "SHUTTING_DOWN", Exit::NoServer),
            (Code::ResourceExhausted, "MEMORY_BUDGET", Exit::Refused),
            (Code::Aborted, "SESSION_BUSY", Exit::Refused),
            (Code::Aborted, "REFINEMENT_FAILED", Exit::NotConverged),
            (Code::Unauthenticated, "UNAUTHENTICATED", Exit::Refused),
            (Code::PermissionDenied, "PERMISSION_DENIED", Exit::Refused),
            (Code::DeadlineExceeded, "", Exit::Deadline),
            (Code::Internal, "INTERNAL", Exit::Server),
        ] {
            assert_eq!(exit_of(&refusal(code, reason)), exit, "{reason}");
        }
    }

    #[test]
    fn a_session_that_is_not_there_is_told_with_the_way_to_those_that_are() {
        let message = |reason| {
            let failure = Failure::from(&refusal(Code::NotFound, reason));
            failure.messages.concat()
        };
        assert!(
            message("SESSION_NOT_FOUND")
                .ends_with("`signorini session list` shows those there are")
        );
        assert!(!message("MESH_NOT_FOUND").contains("session list"));
    }

    #[test]
    fn a_session_that_failed_for_want_of_memory_is_refused_and_no_defect() {
        let mut failed = refusal(Code::FailedPrecondition, "SESSION_FAILED");
        assert_eq!(exit_of(&failed), Exit::Server);
        failed
            .metadata
            .insert("cause".to_owned(), "memory".to_owned());
        assert_eq!(exit_of(&failed), Exit::Refused);
    }

    #[test]
    fn a_full_disk_and_a_lost_session_have_codes_of_their_own() {
        let path = Path::new("out/ring_0001.vtu");
        let full = Failure::unwritable(path, &ErrorKind::StorageFull.into());
        assert_eq!(full.exit, Exit::DiskFull);
        assert!(full.messages[0].starts_with("out/ring_0001.vtu: "));
        let denied = Failure::unwritable(path, &ErrorKind::PermissionDenied.into());
        assert_eq!(denied.exit, Exit::Usage);
        let lost = Failure::from(ClientError::SessionLost("sessions/ring-1".to_owned()));
        assert_eq!(lost.exit, Exit::Restarted);
    }

    #[test]
    fn each_violation_is_a_message_of_its_own() {
        let violation = |path: &str| Violation {
            path: path.to_owned(),
            message: "bad".to_owned(),
        };
        let mut refusal = refusal(Code::InvalidArgument, "SCENE_INVALID");
        refusal.violations = vec![violation("mesh"), violation("solver.tolerance")];
        let failure = Failure::from(&refusal);
        assert_eq!(failure.messages, ["mesh: bad", "solver.tolerance: bad"]);
    }

    #[test]
    fn terminations_have_the_exit_codes_of_the_contract() {
        assert_eq!(Exit::from(Termination::Converged), Exit::Ok);
        assert_eq!(Exit::from(Termination::NotConverged), Exit::NotConverged);
        assert_eq!(Exit::from(Termination::DeadlineExceeded), Exit::Deadline);
        assert_eq!(Exit::from(Termination::InternalError), Exit::Server);
    }
}
