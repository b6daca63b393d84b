//! Tests that cross crates: one module a kind (golden, literature), and the whole path on real recordings.

mod golden;
mod literature;
mod monitor;
