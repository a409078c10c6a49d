//! Cluster boundaries and the corners that splits register.
//!
//! Every boundary curve between two adjacent clusters is one ordered list of vertices, an *arc*, that both sides
//! read, so their polygons agree by construction: [`loops`] finds the boundary of every cluster, [`corners`] the
//! vertices that each split registers, [`curves`] those that open boundaries and seams need, [`activity`] turns all
//! of it into one record per vertex that says when the vertex is drawn.
//!
//! # Paper
//! `[Tsuji07]` 4.3, steps 1 to 3.
//!
//! # Deviations
//! A closed cut gets three anchors, where clusters will meet soon if there are such places (`anchors`); in the budget
//! order a small one gets them later than it is cut. Every child keeps at least three corners and those that its bound
//! counts on, vertices on open boundaries, on seams, along folds and around thin rings are drawn by the error of leaving
//! them out, and the copies of a vertex along a seam are drawn together.

pub mod activity;
mod anchors;
mod cluster_tree;
pub mod corners;
pub mod curves;
pub mod flaps;
pub mod holes;
pub mod loops;
pub(crate) mod polyline;
mod uncovered;

pub use cluster_tree::ClusterTree;
