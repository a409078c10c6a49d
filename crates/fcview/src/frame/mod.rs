//! One frame, stage by stage: say what each instance in sight shows, then round by round ask which whole instances the
//! nearer ones hide, divide the others into pieces, ask about those, and cut and draw what is left.

pub(crate) mod corners;
pub(crate) mod depths;
pub(crate) mod meshes;
pub(crate) mod outline;
pub(crate) mod pieces;
pub(crate) mod plan;
pub(crate) mod questions;
