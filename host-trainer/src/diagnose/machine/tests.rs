//! Tests of the diagnosis of machines of unknown structure.
