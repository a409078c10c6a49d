//! What is measured on every node: error bounds and normal cone.

mod distance;
mod node;
mod outliers;
mod slack;

pub use node::{Cluster, Measurer, NodeBounds};
pub use outliers::raise_keys;
pub use slack::{Slack, loosen};
