//! Arguments about who may do what.

use std::path::{Path, PathBuf};

use clap::Args;
#[cfg(feature = "embedded")]
use clap::Subcommand;
use signorini_client::Credentials;

use crate::terminal::exit::{Exit, Failure};

/// What a server may ask for.
#[derive(Args, Clone, Debug)]
pub(crate) struct AccessArguments {
    /// File with the token to show the server; or the token itself in SIGNORINI_TOKEN
    #[arg(long, value_name = "FILE", env = "SIGNORINI_TOKEN_FILE")]
    token_file: Option<PathBuf>,
    /// Certificate of the authority that has signed that of the server (PEM), for https
    #[arg(long, value_name = "FILE", env = "SIGNORINI_CA")]
    ca: Option<PathBuf>,
    /// Certificate to show the server (PEM)
    #[arg(
        long = "cert",
        value_name = "FILE",
        env = "SIGNORINI_CERT",
        requires = "key"
    )]
    certificate: Option<PathBuf>,
    /// Key of that certificate (PEM)
    #[arg(
        long = "key",
        value_name = "FILE",
        env = "SIGNORINI_KEY",
        requires = "certificate"
    )]
    key: Option<PathBuf>,
}

impl AccessArguments {
    /// Reads the files. A token file goes before the variable.
    pub(crate) fn read(&self) -> Result<Credentials, Failure> {
        let mut credentials = Credentials::default();
        let token = match &self.token_file {
            Some(path) => Some(text(path)?),
            None => std::env::var("SIGNORINI_TOKEN").ok(),
        };
        if let Some(token) = token.filter(|token| !token.is_empty()) {
            credentials = credentials.with_token(&token)?;
        }
        if let Some(path) = &self.ca {
            credentials = credentials.with_authority(text(path)?);
        }
        if let (Some(certificate), Some(key)) = (&self.certificate, &self.key) {
            credentials = credentials.with_certificate(text(certificate)?, text(key)?);
        }
        Ok(credentials)
    }
}

fn text(path: &Path) -> Result<String, Failure> {
    std::fs::read_to_string(path)
        .map_err(|error| Failure::new(Exit::Usage, format!("{}: {error}", path.display())))
}

#[cfg(feature = "embedded")]
#[derive(Debug, Subcommand)]
pub(crate) enum TokenCommand {
    /// Add a token and print it, this once; or let in a certificate of that common name
    Add {
        /// Whom it lets in: 1 to 32 of letters, digits, `.`, `_` and `-`
        name: signorini_server::ClientName,
        /// What that one may do
        #[arg(long, value_name = "ROLE")]
        role: signorini_server::Role,
        /// No token: a client certificate with the name as its common name
        #[arg(long)]
        certificate: bool,
        #[command(flatten)]
        file: TokenFileArguments,
    },
    /// List names, roles and numbers of tokens
    List {
        /// One JSON object a line
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        file: TokenFileArguments,
    },
    /// Remove the tokens of a name; its open streams end within a second or two
    Revoke {
        /// Whom they let in
        name: signorini_server::ClientName,
        /// Only the one with that number
        #[arg(long, value_name = "ID")]
        id: Option<String>,
        #[command(flatten)]
        file: TokenFileArguments,
    },
}

#[cfg(feature = "embedded")]
#[derive(Args, Debug)]
pub(crate) struct TokenFileArguments {
    /// Token file, as `tokens` of the server's settings names it
    #[arg(long = "tokens", value_name = "FILE", env = "SIGNORINI_TOKENS")]
    pub(crate) path: PathBuf,
}

#[cfg(feature = "embedded")]
#[derive(Debug, Subcommand)]
pub(crate) enum CertsCommand {
    /// Make an authority, or use the one that is there, and certificates signed by it; a server
    /// that has one keeps its names and its key
    Init {
        /// Folder for them, made if it is missing
        #[arg(value_name = "DIR")]
        folder: PathBuf,
        /// Names and addresses of the server, beside localhost
        #[arg(long = "host", value_name = "HOST")]
        hosts: Vec<String>,
        /// Names of clients that get certificates; alone on a folder that has a server's, that
        /// one stays as it is
        #[arg(long = "client", value_name = "NAME")]
        clients: Vec<signorini_server::ClientName>,
        /// Days that they are good for; the authority is good for ten years
        #[arg(long, value_name = "N", default_value_t = 365,
            value_parser = clap::value_parser!(u32).range(1..=3650))]
        days: u32,
    },
    /// Make certificates of clients, signed by the authority that is there
    Client {
        /// Folder that init has made
        #[arg(value_name = "DIR")]
        folder: PathBuf,
        /// Their names
        #[arg(value_name = "NAME", required = true)]
        names: Vec<signorini_server::ClientName>,
        /// Days that they are good for
        #[arg(long, value_name = "N", default_value_t = 365,
            value_parser = clap::value_parser!(u32).range(1..=3650))]
        days: u32,
    },
}
