//! Parameters of a rig from recordings, theory (54) to (69).

pub mod calibrate;
pub mod force_balance;
pub(crate) mod input_check;
pub(crate) mod likelihood;
pub(crate) mod settings;
