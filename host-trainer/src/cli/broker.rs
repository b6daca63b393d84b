//! Options of a link to a broker.

use std::path::PathBuf;

use super::Failure;
use crate::fleet::link::{Link, LinkError};

/// User and authority at a broker.
#[derive(clap::Args, Debug)]
pub struct Broker {
    /// Certificates in PEM of the authority that signed the broker's, for mqtts:// [default: the system's]
    #[arg(long, value_name = "FILE")]
    ca: Option<PathBuf>,
    /// User at the broker; the password comes from --password-file or the variable BALLRACE_MQTT_PASSWORD
    #[arg(long, value_name = "NAME")]
    user: Option<String>,
    /// File whose text is the password
    #[arg(long, value_name = "FILE")]
    password_file: Option<PathBuf>,
}

impl Broker {
    /// Link to the broker of an address.
    pub fn link(&self, address: &str) -> Result<Link, Failure> {
        Link::new(address, self.ca.as_ref(), self.user.as_deref(), self.password_file.as_ref()).map_err(failure)
    }

    /// Whether no option is given.
    pub fn is_empty(&self) -> bool {
        self.ca.is_none() && self.user.is_none() && self.password_file.is_none()
    }
}

/// Failure of a link, with its exit status.
pub fn failure(error: LinkError) -> Failure {
    if error.is_input() { Failure::input(error) } else { Failure::other(error) }
}
