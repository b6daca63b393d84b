//! Telemetry of machines by MQTT: published by devices, collected into SQLite and Parquet, summed up machine by machine.
//!
//! | module | holds |
//! |---|---|
//! | [`link`] | address of a broker, TLS, password, errors of a connection |
//! | [`publish`] | events of a device as messages, sent until each is acknowledged |
//! | [`collect`] | messages of a broker, stored before they are acknowledged |
//! | [`store`] | the SQLite file |
//! | [`partitions`] | its messages as Parquet, by machine and day |
//! | [`machines`] | state of each machine, worst first |
//!
//! [`ballrace_core::telemetry`] has the message.

pub mod collect;
pub mod link;
pub mod machines;
pub mod partitions;
pub mod publish;
pub mod settings;
pub mod store;
