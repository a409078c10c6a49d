//! One frame, stage by stage: cut every instance, order the pieces front to back, draw the nearest, then round by
//! round ask which of the next ones they hide and draw the others.

pub(crate) mod cluster_colors;
pub(crate) mod cut;
pub(crate) mod order;
pub(crate) mod outline;
pub(crate) mod pieces;
pub(crate) mod questions;
