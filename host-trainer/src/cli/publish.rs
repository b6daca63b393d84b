//! Option `--publish` of `ballrace monitor`.

use ballrace_core::telemetry::{NAME_RULE, is_name};
use ballrace_firmware_sim::event::Event;

use super::Failure;
use super::broker::{Broker, failure};
use crate::fleet::publish::{Encoder, Publisher};
use crate::model::OwnedModel;

/// Publication of a device's events.
#[derive(clap::Args, Debug)]
pub struct Publish {
    /// Publish events and blocks by MQTT at QoS 1, to PREFIX/MACHINE: mqtt://HOST[:PORT]/PREFIX or mqtts://…
    #[arg(long, value_name = "ADDRESS", requires = "machine")]
    publish: Option<String>,
    /// Name of the machine, 1 to 32 bytes
    #[arg(long, value_name = "NAME", requires = "publish")]
    machine: Option<String>,
    #[command(flatten)]
    broker: Broker,
}

/// Device that publishes.
#[derive(Debug)]
pub struct Publication {
    publisher: Publisher,
    encoder: Encoder,
    broker: String,
}

impl Publish {
    /// Connects where an address is given.
    pub fn connect(&self, model: &OwnedModel) -> Result<Option<Publication>, Failure> {
        let (Some(address), Some(machine)) = (&self.publish, &self.machine) else {
            return if self.broker.is_empty() {
                Ok(None)
            } else {
                Err(Failure::Input("--ca, --user, --password-file: found no --publish, expected one".into()))
            };
        };
        if !is_name(machine) {
            return Err(Failure::option("machine", format!("{machine:?}"), NAME_RULE));
        }
        let link = self.broker.link(address)?;
        let encoder = Encoder::new(machine, model.checksum(), model.view().monitor.limit);
        let publisher = Publisher::connect(&link, machine).map_err(failure)?;
        Ok(Some(Publication { publisher, encoder, broker: link.broker() }))
    }
}

impl Publication {
    /// Publishes an event.
    pub fn event(&mut self, event: &Event<'_>) -> Result<(), Failure> {
        let message = self.encoder.encode(event).map_err(|error| Failure::Input(format!("--publish: {error}")))?;
        self.publisher.send(message);
        Ok(())
    }

    /// Waits for all acknowledgements.
    pub fn finish(self) -> Result<(), Failure> {
        let count = self.publisher.finish().map_err(failure)?;
        eprintln!("{count} messages published to {}, all acknowledged", self.broker);
        Ok(())
    }
}
