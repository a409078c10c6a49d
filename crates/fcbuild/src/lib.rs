//! Builds a face-cluster tree from a polygon mesh.
//!
//! The way of the data, one module a stage:
//! [`import`] reads a file into a [`import::Soup`]; [`mesh`] welds and repairs it into oriented manifold pieces;
//! [`partition`] splits their faces in two again and again; [`arcs`] finds the clusters' boundaries and the corners
//! that every split registers; [`bounds`] measures errors, spheres, cones and bounding polygons;
//! [`build()`] strings the stages together and hands the records to the `fct` writer.
//!
//! The result depends on the input and the options alone, byte for byte: never on the number of threads.

pub mod arcs;
pub mod bounds;
mod build;
mod clusters;
pub mod colors;
mod displacement;
pub mod error;
mod groups;
pub mod import;
pub mod mesh;
pub mod partition;
mod records;
pub mod tree_order;

pub use build::{BuildOptions, Built, Extent, Phase, Prepared, build};
pub use error::Error;
pub use partition::SplitMode;
