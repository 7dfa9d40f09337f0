//! What a client shows a server, and by what it knows the server.

use std::fmt;

use tonic::codegen::http::HeaderValue;
use tonic::transport::{Certificate, ClientTlsConfig, Identity};

use crate::library::error::ClientError;

/// Token and certificates of a client; by default none.
#[derive(Clone, Default)]
pub struct Credentials {
    token: Option<HeaderValue>,
    authority: Option<Certificate>,
    identity: Option<Identity>,
}

impl fmt::Debug for Credentials {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Never what they are: debug output ends in logs.
        out.debug_struct("Credentials")
            .field("token", &self.token.is_some())
            .field("authority", &self.authority.is_some())
            .field("identity", &self.identity.is_some())
            .finish()
    }
}

impl Credentials {
    /// Shows this token with each call.
    ///
    /// # Errors
    /// [`ClientError::Token`] for what cannot be a token.
    pub fn with_token(mut self, token: &str) -> Result<Self, ClientError> {
        let token = token.trim();
        let is_plain = !token.is_empty() && token.bytes().all(|byte| byte.is_ascii_graphic());
        let value = HeaderValue::from_str(&format!("Bearer {token}"));
        let mut value = value.map_err(|_| ClientError::Token)?;
        if !is_plain {
            return Err(ClientError::Token);
        }
        value.set_sensitive(true);
        self.token = Some(value);
        Ok(self)
    }

    /// Trusts servers whose certificate one of these has signed (PEM).
    #[must_use]
    pub fn with_authority(mut self, pem: impl AsRef<[u8]>) -> Self {
        self.authority = Some(Certificate::from_pem(pem));
        self
    }

    /// Shows a certificate of its own (PEM), whose key this is.
    #[must_use]
    pub fn with_certificate(mut self, pem: impl AsRef<[u8]>, key: impl AsRef<[u8]>) -> Self {
        self.identity = Some(Identity::from_pem(pem, key));
        self
    }

    pub(crate) fn header(&self) -> Option<HeaderValue> {
        self.token.clone()
    }

    /// Transport security for an address that asks for it.
    pub(crate) fn tls(&self, address: &str) -> Result<ClientTlsConfig, ClientError> {
        let authority = self.authority.clone();
        let authority = authority.ok_or_else(|| ClientError::NoAuthority(address.to_owned()))?;
        let config = ClientTlsConfig::new().ca_certificate(authority);
        Ok(match self.identity.clone() {
            Some(identity) => config.identity(identity),
            None => config,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_token_is_one_word_and_is_never_shown() {
        let shown = Credentials::default().with_token("signorini_12\n").unwrap();
        assert_eq!(shown.header().unwrap(), "Bearer signorini_12");
        assert!(!format!("{shown:?}").contains("signorini_12"));
        for bad in ["", " \n", "two words", "a\nb", "\u{e9}"] {
            let refused = Credentials::default().with_token(bad);
            assert!(matches!(refused, Err(ClientError::Token)), "{bad}");
        }
    }
}
