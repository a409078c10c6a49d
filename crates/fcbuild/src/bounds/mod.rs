//! What is measured on every node: error bounds and normal cone.

mod beyond;
mod distance;
mod flood;
mod gaze;
mod hull;
mod leaning;
mod node;
mod outliers;
mod overhang;
mod slab;
mod slack;
mod support;
mod supports;

pub(crate) use gaze::Gaze;
pub use node::{Above, Cluster, Fit, Measurer, NodeBounds};
pub use outliers::raise_keys;
pub(crate) use slab::RIDGE;
pub(crate) use support::farther;
pub use support::{AllSupports, Piece, Support};
