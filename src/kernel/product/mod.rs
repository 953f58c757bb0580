//! Matrix products: of activations with constant weights, in attention, and as convolutions that are no 3×3.

pub(in crate::kernel) mod attention;
mod dense;
pub(in crate::kernel) mod depthwise;
mod inverted;
mod panels;
mod patches;
mod project;
pub(in crate::kernel) mod soft;
pub(in crate::kernel) mod tile;

pub use attention::{Attention, Head, MOST_BIASES, Sides};
pub use dense::Dense;
pub use depthwise::DepthWise;
pub use inverted::Inverted;
pub use panels::Panels;
pub use patches::Patches;
pub use project::{Columns, Project};

#[cfg(test)]
mod tests;
