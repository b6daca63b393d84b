//! Collector: messages of a broker into a [`Store`], each stored before it is acknowledged, and from there into Parquet.

use std::collections::{HashSet, VecDeque};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use ballrace_core::telemetry::{MESSAGE_LEN, Message};
use rumqttc::{Client, Connection, Event, Packet, Publish, QoS, SubscribeReasonCode};

use super::link::{Link, LinkError};
use super::partitions::{PartitionError, Partitions};
use super::settings::FleetSettings;
use super::store::{Counts, Received, Store, StoreError};

const SETTINGS: FleetSettings = FleetSettings::DEFAULT;
/// Longest wait for a message before the ends are checked.
const POLL: Duration = Duration::from_millis(100);

/// When to end, and which machines to take.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Names of the machines to take; `None`: all.
    pub known: Option<HashSet<String>>,
    /// Time after which the collector ends; `None`: never.
    pub end_after: Option<Duration>,
    /// Time without a message, while connected, after which it ends; `None`: never.
    pub until_idle: Option<Duration>,
    /// Folder of Parquet partitions; `None`: SQLite alone.
    pub parquet: Option<PathBuf>,
}

/// What happens to a collector.
#[derive(Debug)]
pub enum Notice<'a> {
    /// Connected; whether the broker kept the session.
    Connected {
        /// Whether the broker kept the session, and with it the messages since.
        kept: bool,
    },
    /// Connection lost; tried again after a wait.
    Lost {
        /// Error of the connection.
        error: &'a LinkError,
        /// Wait before the next attempt.
        wait: Duration,
    },
    /// Batch stored; the counts since the start.
    Stored(&'a Counts),
}

/// Failure of a collector.
#[derive(Debug, thiserror::Error)]
pub enum CollectError {
    /// Failure of the link.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// Failure of the file.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// Failure of the Parquet partitions.
    #[error(transparent)]
    Partitions(#[from] PartitionError),
}

/// Takes messages until an end of the options; returns what was counted since the call.
///
/// # Errors
/// A broker that cannot be reached at first or refuses, errors of the files. A connection lost later is made again.
pub fn collect(
    link: &Link,
    store: &mut Store,
    options: &Options,
    on_notice: &mut dyn FnMut(&Notice<'_>),
) -> Result<Counts, CollectError> {
    let parts = options.parquet.as_deref().map(|folder| Parts::open(folder, store)).transpose()?;
    let start = Instant::now();
    let mut collector = Collector {
        client_id: store.client_id()?,
        link,
        store,
        options,
        on_notice,
        start,
        heard: start,
        ever_connected: false,
        counts: Counts::default(),
        parts,
    };
    let mut failed = 0;
    loop {
        let heard = collector.heard;
        let error = match collector.connection() {
            Ok(()) => break,
            Err(CollectError::Link(error)) if collector.ever_connected && !error.is_input() => error,
            Err(error) => return Err(error),
        };
        failed = if collector.heard > heard { 0 } else { failed + 1 };
        let wait = SETTINGS.wait(failed);
        (collector.on_notice)(&Notice::Lost { error: &error, wait });
        if collector.is_over() {
            break;
        }
        std::thread::sleep(wait);
    }
    if let Some(parts) = &mut collector.parts {
        parts.partitions.write(collector.store, usize::MAX)?;
    }
    Ok(collector.counts)
}

struct Collector<'a> {
    link: &'a Link,
    store: &'a mut Store,
    options: &'a Options,
    on_notice: &'a mut dyn FnMut(&Notice<'_>),
    client_id: String,
    start: Instant,
    /// Last message or connection.
    heard: Instant,
    ever_connected: bool,
    counts: Counts,
    parts: Option<Parts>,
}

/// Parquet partitions, and when they are written next.
struct Parts {
    partitions: Partitions,
    due: Instant,
}

impl Parts {
    /// Partitions that have all of the store.
    fn open(folder: &Path, store: &Store) -> Result<Self, PartitionError> {
        let mut partitions = Partitions::open(folder, store)?;
        partitions.write(store, usize::MAX)?;
        Ok(Self { partitions, due: Instant::now() + SETTINGS.parquet_every })
    }

    /// Writes some if it is time.
    fn write_if_due(&mut self, store: &Store) -> Result<(), PartitionError> {
        if Instant::now() < self.due {
            return Ok(());
        }
        self.partitions.write(store, SETTINGS.partitions_at_once)?;
        if self.partitions.is_current() {
            self.due = Instant::now() + SETTINGS.parquet_every;
        }
        Ok(())
    }
}

impl Collector<'_> {
    fn is_over(&self) -> bool {
        self.options.end_after.is_some_and(|end| self.start.elapsed() >= end)
    }

    fn is_idle(&self) -> bool {
        self.options.until_idle.is_some_and(|idle| self.heard.elapsed() >= idle)
    }

    /// One connection: until an end, or until it is lost. A new one begins with nothing of the one before, so that no
    /// acknowledgement reaches the broker under a packet number that meanwhile means another message.
    fn connection(&mut self) -> Result<(), CollectError> {
        let (client, mut connection) = self.link.client(&self.client_id, true);
        let mut batch: Vec<Publish> = Vec::new();
        // Stored, and not yet acknowledged: the client's queue of requests has its end.
        let mut stored: VecDeque<Publish> = VecDeque::new();
        let mut connected = false;
        loop {
            while let Some(publish) = stored.front()
                && client.try_ack(publish).is_ok()
            {
                stored.pop_front();
            }
            if let Some(parts) = &mut self.parts {
                parts.write_if_due(self.store)?;
            }
            // While messages are at hand, take what has already arrived and do not wait for more.
            let wait = match (connected, batch.is_empty()) {
                (false, _) => SETTINGS.longest_wait,
                (true, true) => POLL,
                (true, false) => Duration::ZERO,
            };
            match connection.recv_timeout(wait) {
                Ok(Ok(Event::Incoming(Packet::ConnAck(ack)))) => {
                    (connected, self.ever_connected, self.heard) = (true, true, Instant::now());
                    (self.on_notice)(&Notice::Connected { kept: ack.session_present });
                    let filter = format!("{}/#", self.link.prefix);
                    client.try_subscribe(filter, QoS::AtLeastOnce).map_err(|e| self.link.refused(e.to_string()))?;
                }
                Ok(Ok(Event::Incoming(Packet::SubAck(ack)))) => {
                    if ack.return_codes.contains(&SubscribeReasonCode::Failure) {
                        let topic = format!("the topic {}/#; expected one that the user may read", self.link.prefix);
                        return Err(self.link.refused(topic).into());
                    }
                }
                Ok(Ok(Event::Incoming(Packet::Publish(mut publish)))) => {
                    self.heard = Instant::now();
                    if publish.payload.len() > MESSAGE_LEN {
                        // Enough to know that it is too long: a batch of the longest would fill the memory.
                        publish.payload = publish.payload[..=MESSAGE_LEN].to_vec().into();
                    }
                    batch.push(publish);
                    if batch.len() >= SETTINGS.batch {
                        self.store(&mut batch, &mut stored)?;
                    }
                }
                Ok(Ok(_)) => {}
                Ok(Err(error)) => {
                    // The broker sends these again; then they are duplicates.
                    self.keep(&batch)?;
                    return Err(self.link.error(&error).into());
                }
                Err(_) if !batch.is_empty() => self.store(&mut batch, &mut stored)?,
                Err(_) => {
                    if self.is_over() || connected && stored.is_empty() && self.is_idle() {
                        leave(&client, &mut connection);
                        return Ok(());
                    }
                }
            }
            if self.is_over() {
                self.store(&mut batch, &mut stored)?;
                leave(&client, &mut connection);
                return Ok(());
            }
        }
    }

    /// Stores a batch, whose acknowledgements may follow.
    fn store(&mut self, batch: &mut Vec<Publish>, stored: &mut VecDeque<Publish>) -> Result<(), CollectError> {
        self.keep(batch)?;
        stored.extend(batch.drain(..).filter(|publish| publish.qos != QoS::AtMostOnce));
        Ok(())
    }

    /// Stores a batch without acknowledgement.
    fn keep(&mut self, batch: &[Publish]) -> Result<(), CollectError> {
        if batch.is_empty() {
            return Ok(());
        }
        let received: Vec<Received<'_>> = batch.iter().map(|publish| self.received(publish)).collect();
        let received_ms = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_millis() as i64;
        let added = self.store.take(&received, received_ms)?;
        if let Some(parts) = &mut self.parts {
            let machines = received.iter().filter_map(|received| match received {
                Received::Message(message) => Some(message.machine),
                _ => None,
            });
            machines.for_each(|machine| parts.partitions.note(machine, received_ms));
        }
        self.counts = self.counts.with(&added);
        (self.on_notice)(&Notice::Stored(&self.counts));
        Ok(())
    }

    fn received<'p>(&self, publish: &'p Publish) -> Received<'p> {
        if publish.payload.len() > MESSAGE_LEN {
            return Received::TooLong;
        }
        let Ok(message) = Message::decode(&publish.payload) else { return Received::Malformed };
        let of_topic = publish.topic.strip_prefix(&self.link.prefix).and_then(|rest| rest.strip_prefix('/'));
        if of_topic != Some(message.machine) {
            return Received::Malformed;
        }
        match &self.options.known {
            Some(known) if !known.contains(message.machine) => Received::UnknownMachine,
            _ => Received::Message(message),
        }
    }
}

/// Sends what waits, acknowledgements included, and closes the connection.
fn leave(client: &Client, connection: &mut Connection) {
    if client.try_disconnect().is_err() {
        return;
    }
    while let Ok(Ok(event)) = connection.recv_timeout(Duration::from_secs(1)) {
        if matches!(event, Event::Outgoing(rumqttc::Outgoing::Disconnect)) {
            return;
        }
    }
}
