//! Settings of the link to a broker and of the collector.

use std::time::Duration;

/// Settings of publisher, collector and summary.
#[derive(Clone, Copy, Debug)]
pub struct FleetSettings {
    /// Interval of pings on an idle connection.
    pub keep_alive: Duration,
    /// Shortest wait before a new connection.
    pub shortest_wait: Duration,
    /// Longest wait before a new connection; the waits double from the shortest.
    pub longest_wait: Duration,
    /// Time without any acknowledgement after which a publisher gives up.
    pub patience: Duration,
    /// Messages sent and not yet acknowledged, at most.
    pub window: usize,
    /// Messages stored in one transaction, at most.
    pub batch: usize,
    /// Greatest packet taken, bytes: MQTT's own limit, since the broker sends a refused packet again and again.
    pub greatest_packet: usize,
    /// Interval at which Parquet partitions with new messages are written.
    pub parquet_every: Duration,
    /// Partitions written before the connection is served again, at most.
    pub partitions_at_once: usize,
    /// Blocks in the picture of a machine, at most; the newest.
    pub trend_blocks: usize,
    /// Silence of a machine while others are heard, after which it is to be looked at.
    pub silent_after: Duration,
    /// Share of the limit above which a healthy machine is to be watched.
    pub watch_share: f64,
}

impl FleetSettings {
    /// Settings in use.
    pub const DEFAULT: Self = Self {
        keep_alive: Duration::from_secs(15),
        shortest_wait: Duration::from_millis(100),
        longest_wait: Duration::from_secs(10),
        patience: Duration::from_secs(60),
        window: 64,
        batch: 1000,
        greatest_packet: 268_435_455,
        parquet_every: Duration::from_secs(300),
        partitions_at_once: 64,
        trend_blocks: 400,
        silent_after: Duration::from_secs(24 * 3600),
        watch_share: 0.7,
    };

    /// Wait before the attempt after `failed` ones.
    pub fn wait(&self, failed: u32) -> Duration {
        self.shortest_wait.saturating_mul(1 << failed.min(16)).min(self.longest_wait)
    }
}
