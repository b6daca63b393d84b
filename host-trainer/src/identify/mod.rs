//! Parameters of a rig from recordings.

pub mod calibrate;
pub mod force_balance;
pub mod likelihood;
