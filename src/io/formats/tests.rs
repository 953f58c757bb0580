//! Tests that walk the table of formats.
