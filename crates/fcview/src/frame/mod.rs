//! One frame, stage by stage: cut every instance, order the pieces front to back, draw the nearest, ask what they
//! hide, draw the rest.

pub(crate) mod cluster_colors;
pub(crate) mod cut;
pub(crate) mod order;
pub(crate) mod pieces;
pub(crate) mod questions;
