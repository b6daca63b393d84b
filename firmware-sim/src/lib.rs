//! ballrace.
