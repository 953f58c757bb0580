//! (to come)
pub mod tract;
