//! Nodes that could be refined, and in which order.

use std::cmp::Ordering;

/// A node of a cut that could be refined.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    /// The factor below which the tolerance would refine it.
    pub(super) level: f64,
    pub(super) key: f32,
    /// Its tree's place in what is shown.
    pub(super) of: u32,
    pub(super) node: u32,
    pub(super) slot: u32,
}

impl Ord for Candidate {
    /// The one to be refined first is the greatest.
    fn cmp(&self, other: &Candidate) -> Ordering {
        let by_key = self.level.total_cmp(&other.level).then(self.key.total_cmp(&other.key));
        by_key.then((other.of, other.node).cmp(&(self.of, self.node)))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Candidate) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Candidate) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Candidate {}
