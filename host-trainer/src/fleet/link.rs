//! Link to an MQTT broker.

use std::path::PathBuf;
use std::{env, fs, io};

use rumqttc::{Client, ConnectReturnCode, Connection, ConnectionError, MqttOptions, Transport};

use super::settings::FleetSettings;

const SETTINGS: FleetSettings = FleetSettings::DEFAULT;
/// Environment variable of the password, where no file is given.
pub const PASSWORD_VARIABLE: &str = "BALLRACE_MQTT_PASSWORD";
const EXPECTED: &str = "mqtt://HOST[:PORT][/PREFIX] or mqtts://HOST[:PORT][/PREFIX]";
/// Requests that wait for the connection, at most; more than the window of a publisher.
const REQUESTS: usize = 2 * SETTINGS.batch;

/// Broker, way to it, and credentials.
#[derive(Clone, Debug)]
pub struct Link {
    host: String,
    port: u16,
    /// First levels of the topics, without a `/` at either end.
    pub prefix: String,
    tls: bool,
    ca: Option<Vec<u8>>,
    credentials: Option<Credentials>,
}

#[derive(Clone)]
struct Credentials {
    user: String,
    password: String,
}

// A password is never printed.
impl std::fmt::Debug for Credentials {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Credentials").field("user", &self.user).finish_non_exhaustive()
    }
}

/// Failure of a link.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LinkError {
    /// Address, certificate file or password file that cannot be used.
    #[error("{place}: found {found}, expected {expected}")]
    Input {
        /// Option or file.
        place: String,
        /// What was found.
        found: String,
        /// What was expected.
        expected: String,
    },
    /// Broker that refuses the user, the password or the topic.
    #[error("{broker}: the broker refuses: {reason}")]
    Refused {
        /// Host and port.
        broker: String,
        /// Its reason.
        reason: String,
    },
    /// TLS that fails: another authority, another name, no TLS on that port.
    #[error("{broker}: TLS: {reason}; expected a certificate for this host from an authority of --ca or the system")]
    Tls {
        /// Host and port.
        broker: String,
        /// Reason.
        reason: String,
    },
    /// Broker that cannot be reached.
    #[error("{broker}: no connection: {reason}")]
    Unreachable {
        /// Host and port.
        broker: String,
        /// Reason.
        reason: String,
    },
    /// Messages that the broker did not acknowledge in time.
    #[error("{broker}: {count} messages are not acknowledged: {reason}")]
    Unacknowledged {
        /// Host and port.
        broker: String,
        /// Number of messages.
        count: usize,
        /// Last error of the connection.
        reason: String,
    },
}

impl LinkError {
    /// Whether the user's input is the cause.
    pub fn is_input(&self) -> bool {
        matches!(self, Self::Input { .. } | Self::Refused { .. } | Self::Tls { .. })
    }

    fn input(place: impl ToString, found: impl ToString, expected: impl ToString) -> Self {
        Self::Input { place: place.to_string(), found: found.to_string(), expected: expected.to_string() }
    }
}

impl Link {
    /// Link to the broker of an address; `ca` is a file of certificates in PEM. The password comes from `password_file`
    /// or the environment ([`PASSWORD_VARIABLE`]).
    ///
    /// # Errors
    /// An address of another form, files that cannot be read, TLS options without TLS, a user without a password.
    pub fn new(
        address: &str,
        ca: Option<&PathBuf>,
        user: Option<&str>,
        password_file: Option<&PathBuf>,
    ) -> Result<Self, LinkError> {
        let wrong = || LinkError::input("broker", without_password(address), EXPECTED);
        let (scheme, rest) = address.split_once("://").ok_or_else(wrong)?;
        let tls = match scheme {
            "mqtt" => false,
            "mqtts" => true,
            _ => return Err(wrong()),
        };
        let (authority, prefix) = rest.split_once('/').unwrap_or((rest, ""));
        if authority.contains('@') {
            let found = without_password(address);
            return Err(LinkError::input("broker", found, format!("{EXPECTED}, with --user and --password-file")));
        }
        let (host, port) = match authority.rsplit_once(':') {
            Some((host, port)) if !port.contains(']') => (host, port.parse().map_err(|_| wrong())?),
            _ => (authority, if tls { 8883 } else { 1883 }),
        };
        let host = host.trim_start_matches('[').trim_end_matches(']').to_owned();
        let prefix = prefix.trim_end_matches('/');
        let prefix = if prefix.is_empty() { "ballrace" } else { prefix };
        if host.is_empty() || prefix.contains(['+', '#']) || prefix.starts_with(['$', '/']) {
            return Err(wrong());
        }
        if ca.is_some() && !tls {
            return Err(LinkError::input("--ca", without_password(address), "an address mqtts://…"));
        }
        let ca = ca.map(read).transpose()?.map(String::into_bytes);
        if let Some(pem) = &ca
            && !String::from_utf8_lossy(pem).contains("-----BEGIN CERTIFICATE-----")
        {
            return Err(LinkError::input("--ca", "no certificate", "a certificate in PEM"));
        }
        let credentials = user.map(|user| credentials(user, password_file)).transpose()?;
        if credentials.is_none() && password_file.is_some() {
            return Err(LinkError::input("--password-file", "no user", "--user as well"));
        }
        Ok(Self { host, port, prefix: prefix.to_owned(), tls, ca, credentials })
    }

    /// Host and port.
    pub fn broker(&self) -> String {
        format!("{}:{}", self.host, self.port)
    }

    /// New client and its connection, which is made when it is polled. `persistent` keeps the session at the broker.
    pub(super) fn client(&self, id: &str, persistent: bool) -> (Client, Connection) {
        let mut options = MqttOptions::new(id, self.host.clone(), self.port);
        options
            .set_keep_alive(SETTINGS.keep_alive)
            .set_clean_session(!persistent)
            .set_manual_acks(persistent)
            .set_inflight(SETTINGS.window as u16)
            .set_max_packet_size(SETTINGS.greatest_packet, SETTINGS.greatest_packet);
        if let Some(Credentials { user, password }) = &self.credentials {
            options.set_credentials(user, password);
        }
        if self.tls {
            // Fails only where a provider is installed already.
            let _ = rustls::crypto::ring::default_provider().install_default();
            options.set_transport(match &self.ca {
                Some(ca) => Transport::tls(ca.clone(), None, None),
                None => Transport::tls_with_default_config(),
            });
        }
        let (client, mut connection) = Client::new(options, REQUESTS);
        let mut network = connection.eventloop.network_options();
        network.set_tcp_nodelay(true);
        connection.eventloop.set_network_options(network);
        (client, connection)
    }

    /// Error of a connection in words.
    pub(super) fn error(&self, error: &ConnectionError) -> LinkError {
        let (broker, reason) = (self.broker(), error.to_string());
        match error {
            ConnectionError::ConnectionRefused(code) => self.refused(match code {
                ConnectReturnCode::BadUserNamePassword | ConnectReturnCode::NotAuthorized => {
                    "user or password; expected those of --user and --password-file".into()
                }
                other => format!("{other:?}"),
            }),
            // A certificate that fails its check is an I/O error with a rustls error inside.
            ConnectionError::Tls(rumqttc::TlsError::Io(error)) if !is_rustls(error) => {
                LinkError::Unreachable { broker, reason }
            }
            ConnectionError::Tls(error) => LinkError::Tls { broker, reason: error.to_string() },
            _ => LinkError::Unreachable { broker, reason },
        }
    }

    /// Refusal by the broker.
    pub(super) fn refused(&self, reason: String) -> LinkError {
        LinkError::Refused { broker: self.broker(), reason }
    }
}

fn is_rustls(error: &io::Error) -> bool {
    error.get_ref().is_some_and(|inner| inner.is::<rustls::Error>())
}

fn without_password(address: &str) -> String {
    match (address.split_once("://"), address.rsplit_once('@')) {
        (Some((scheme, _)), Some((_, rest))) => format!("{scheme}://…@{rest}"),
        _ => address.to_owned(),
    }
}

fn read(path: &PathBuf) -> Result<String, LinkError> {
    fs::read_to_string(path).map_err(|error| LinkError::input(path.display(), error, "a text file"))
}

fn credentials(user: &str, password_file: Option<&PathBuf>) -> Result<Credentials, LinkError> {
    let password = match password_file {
        Some(path) => read(path)?.trim_end_matches(['\r', '\n']).to_owned(),
        None => env::var(PASSWORD_VARIABLE).map_err(|_| {
            LinkError::input("--user", "no password", format!("--password-file or the variable {PASSWORD_VARIABLE}"))
        })?,
    };
    Ok(Credentials { user: user.to_owned(), password })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn golden_addresses() {
        let parts = |address| Link::new(address, None, None, None).map(|l| (l.broker(), l.prefix, l.tls)).ok();
        let part = |broker: &str, prefix: &str, tls| Some((broker.to_owned(), prefix.to_owned(), tls));
        assert_eq!(parts("mqtt://broker"), part("broker:1883", "ballrace", false));
        assert_eq!(parts("mqtts://broker/a/b/"), part("broker:8883", "a/b", true));
        assert_eq!(parts("mqtt://127.0.0.1:99/x"), part("127.0.0.1:99", "x", false));
        assert_eq!(parts("mqtt://[::1]"), part("::1:1883", "ballrace", false));
        for wrong in
            ["broker", "http://broker", "mqtt://", "mqtt://b:port", "mqtt://b/a+", "mqtt://b/#", "mqtt://b/$SYS"]
        {
            assert_eq!(parts(wrong), None, "{wrong}");
        }
        let error = Link::new("mqtt://me:secret@broker", None, None, None).unwrap_err().to_string();
        assert!(!error.contains("secret") && error.contains("--password-file"), "{error}");
    }
}
