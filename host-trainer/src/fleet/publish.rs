//! Events of a device, published until the broker has acknowledged each.

use std::collections::VecDeque;
use std::sync::mpsc::{self, Receiver, SyncSender, TryRecvError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use ballrace_core::monitor::Status;
use ballrace_core::telemetry::{Kind, MESSAGE_LEN, Message, TelemetryError};
use ballrace_firmware_sim::event::{Event, Statistics};
use rumqttc::{Outgoing, Packet, QoS};

use super::link::{Link, LinkError};
use super::settings::FleetSettings;

const SETTINGS: FleetSettings = FleetSettings::DEFAULT;
/// Longest wait for the connection while nothing is under way.
const POLL: Duration = Duration::from_millis(10);

/// Bytes of a message.
pub type Bytes = [u8; MESSAGE_LEN];

/// Events of one session of a device as messages.
#[derive(Clone, Debug)]
pub struct Encoder {
    machine: String,
    session: u64,
    sequence: u32,
    model_crc: u32,
    limit: f32,
    recording: u32,
    time_s: f64,
    status: Status,
    statistics: Statistics,
}

impl Encoder {
    /// Encoder of a new session, whose number is the clock in µs.
    pub fn new(machine: &str, model_crc: u32, limit: f32) -> Self {
        let statistics = Statistics { block: 0, level: f32::NAN, deviation: f32::NAN, ewma: 0.0 };
        let session = clock().as_micros() as u64;
        let status = Status::Starting;
        Self {
            machine: machine.to_owned(),
            session,
            sequence: 0,
            model_crc,
            limit,
            recording: 0,
            time_s: 0.0,
            status,
            statistics,
        }
    }

    /// Message of an event.
    ///
    /// # Errors
    /// A name that is none, a limit that is not positive.
    pub fn encode(&mut self, event: &Event<'_>) -> Result<Bytes, TelemetryError> {
        let (kind, at) = match event {
            Event::Status(change) => {
                self.status = change.status;
                self.statistics = change.statistics.unwrap_or(self.statistics);
                (Kind::Status { was: change.was }, Some(change.at))
            }
            Event::Block(end) => {
                (self.status, self.statistics) = (end.status, end.statistics);
                (Kind::Block, Some(end.at))
            }
            Event::Fault(fault) => {
                (Kind::Fault { quality: fault.kind, value: fault.value.unwrap_or(f32::NAN) }, Some(fault.at))
            }
            Event::Summary(summary) => {
                self.status = summary.status;
                (Kind::Summary { faults: summary.faults, alarms: summary.alarms }, None)
            }
        };
        if let Some(at) = at {
            (self.recording, self.time_s) = (at.recording_index, at.time_s);
        }
        let Statistics { block, level, deviation, ewma } = self.statistics;
        let message = Message {
            machine: &self.machine,
            session: self.session,
            sequence: self.sequence,
            model_crc: self.model_crc,
            unix_ms: clock().as_millis() as u64,
            recording: self.recording,
            time_s: self.time_s,
            status: self.status,
            kind,
            block,
            level,
            deviation,
            ewma,
            limit: self.limit,
        };
        let mut bytes = [0; MESSAGE_LEN];
        message.encode(&mut bytes)?;
        self.sequence += 1;
        Ok(bytes)
    }
}

fn clock() -> Duration {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default()
}

/// Publisher on a thread of its own.
#[derive(Debug)]
pub struct Publisher {
    messages: SyncSender<Bytes>,
    thread: JoinHandle<Result<usize, LinkError>>,
}

impl Publisher {
    /// Connects; messages go to the topic `PREFIX/machine` at QoS 1.
    ///
    /// # Errors
    /// A broker that cannot be reached or refuses.
    pub fn connect(link: &Link, machine: &str) -> Result<Self, LinkError> {
        let (messages, waiting) = mpsc::sync_channel(SETTINGS.batch);
        let (ready, first) = mpsc::channel();
        let mut sender = Sender {
            link: link.clone(),
            topic: format!("{}/{machine}", link.prefix),
            // A new name for each publisher: two of one machine must not throw each other out.
            client_id: format!("ballrace-{machine}-{:x}", clock().as_nanos()),
            waiting,
            finished: false,
            unsent: VecDeque::new(),
            sent: VecDeque::new(),
            acknowledged: 0,
            ready: Some(ready),
        };
        let thread = std::thread::spawn(move || sender.run());
        match first.recv() {
            Ok(()) => Ok(Self { messages, thread }),
            // The thread has ended, with its error.
            Err(_) => Err(ended(thread).err().unwrap_or_else(|| link.refused("nothing was sent".into()))),
        }
    }

    /// Takes a message; waits while the broker is slow. One that comes after the thread gave up is dropped: `finish` says so.
    pub fn send(&self, message: Bytes) {
        let _ = self.messages.send(message);
    }

    /// Waits for the acknowledgements of all messages; their number.
    ///
    /// # Errors
    /// A broker that stayed away too long or refuses.
    pub fn finish(self) -> Result<usize, LinkError> {
        drop(self.messages);
        ended(self.thread)
    }
}

fn ended(thread: JoinHandle<Result<usize, LinkError>>) -> Result<usize, LinkError> {
    thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}

struct Sender {
    link: Link,
    topic: String,
    client_id: String,
    waiting: Receiver<Bytes>,
    /// Whether no more messages will come.
    finished: bool,
    /// Messages to send again after a lost connection, in order.
    unsent: VecDeque<Bytes>,
    /// Messages without acknowledgement, in order of their sending, and their packet number once they have one.
    sent: VecDeque<(Option<u16>, Bytes)>,
    acknowledged: usize,
    /// Notice of the first connection.
    ready: Option<mpsc::Sender<()>>,
}

impl Sender {
    fn run(&mut self) -> Result<usize, LinkError> {
        let (mut failed, mut lost) = (0, Instant::now());
        loop {
            let (start, before) = (Instant::now(), self.acknowledged);
            let error = match self.connection() {
                Ok(()) => return Ok(self.acknowledged),
                Err(error) => error,
            };
            // A connection that served, or that stayed while there was nothing to send.
            if self.acknowledged > before || start.elapsed() > SETTINGS.longest_wait {
                (failed, lost) = (0, Instant::now());
            }
            if self.ready.is_some() || error.is_input() {
                return Err(error);
            }
            if lost.elapsed() > SETTINGS.patience {
                let count = self.unsent.len() + self.waiting.try_iter().count();
                return Err(LinkError::Unacknowledged { broker: self.link.broker(), count, reason: error.to_string() });
            }
            std::thread::sleep(SETTINGS.wait(failed));
            failed += 1;
        }
    }

    /// One connection: until all is acknowledged, or until it is lost.
    fn connection(&mut self) -> Result<(), LinkError> {
        let (client, mut connection) = self.link.client(&self.client_id, false);
        let mut connected = false;
        let result = 'connection: loop {
            while self.sent.len() < SETTINGS.window
                && connected
                && let Some(message) = self.next()
            {
                self.sent.push_back((None, message));
                if let Err(error) = client.try_publish(&self.topic, QoS::AtLeastOnce, false, message) {
                    // There is room for more than a window of requests.
                    let (broker, reason) = (self.link.broker(), error.to_string());
                    break 'connection Err(LinkError::Unreachable { broker, reason });
                }
            }
            if self.finished && self.sent.is_empty() {
                break Ok(());
            }
            // A timeout would give up an attempt to connect, which has one of its own.
            match connection.recv_timeout(if connected { POLL } else { SETTINGS.longest_wait }) {
                Err(_) => {}
                Ok(Err(error)) => break Err(self.link.error(&error)),
                Ok(Ok(rumqttc::Event::Incoming(Packet::ConnAck(_)))) => {
                    connected = true;
                    if let Some(ready) = self.ready.take() {
                        let _ = ready.send(());
                    }
                }
                Ok(Ok(rumqttc::Event::Outgoing(Outgoing::Publish(id)))) => {
                    if let Some((number, _)) = self.sent.iter_mut().find(|(number, _)| number.is_none()) {
                        *number = Some(id);
                    }
                }
                Ok(Ok(rumqttc::Event::Incoming(Packet::PubAck(ack)))) => {
                    if let Some(at) = self.sent.iter().position(|(number, _)| *number == Some(ack.pkid)) {
                        self.sent.remove(at);
                        self.acknowledged += 1;
                    }
                }
                Ok(Ok(_)) => {}
            }
        };
        if result.is_ok() {
            let _ = client.try_disconnect();
            while let Ok(Ok(event)) = connection.recv_timeout(Duration::from_secs(1)) {
                if matches!(event, rumqttc::Event::Outgoing(Outgoing::Disconnect)) {
                    break;
                }
            }
        }
        // What has no acknowledgement comes first on the next connection.
        self.sent.drain(..).rev().for_each(|(_, message)| self.unsent.push_front(message));
        result
    }

    fn next(&mut self) -> Option<Bytes> {
        if let Some(message) = self.unsent.pop_front() {
            return Some(message);
        }
        match self.waiting.try_recv() {
            Ok(message) => Some(message),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => {
                self.finished = true;
                None
            }
        }
    }
}
