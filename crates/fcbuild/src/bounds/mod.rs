//! What is measured on every node: error bounds and normal cone.

mod distance;
mod flood;
mod hull;
mod node;
mod outliers;
mod overhang;
mod slab;
mod slack;

pub use node::{Above, Cluster, Measurer, NodeBounds};
pub use outliers::raise_keys;
pub(crate) use slab::RIDGE;
