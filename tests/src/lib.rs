//! What the promise tests share: meshes, trees built in memory, and the definitions that promises are held against.

pub mod commands;
pub mod cracks;
pub mod deviation;
pub mod distance;
pub mod meshes;
pub mod parts;
pub mod random;
pub mod trees;
