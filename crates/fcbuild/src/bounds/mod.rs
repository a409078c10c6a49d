//! What is measured on every node: error bounds, sphere, normal cone and bounding polygon.

mod bounding_polygon;
mod distance;
mod node;
mod outliers;
mod slack;

pub use bounding_polygon::BoundingPolygon;
pub use node::{Cluster, Measurer, NodeBounds};
pub use outliers::raise_keys;
pub use slack::{Slack, loosen};
