//! (to come)

pub use crate::field::DisparityMap;
