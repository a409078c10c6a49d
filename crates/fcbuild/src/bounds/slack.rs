//! What bounds are raised by where their argument has a gap.

use super::NodeBounds;
use crate::partition::SplitMode;
use fcgeom::round_up;

/// A factor for distance bounds, of nodes and of vertices on curves alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slack(pub f64);

impl Slack {
    /// Clusters that grew by merging have bays and peninsulas: where their polygons overlap themselves, a point may be
    /// uncovered that is farther from the drawn mesh than any slab tells. Without slack the tolerance was passed by up
    /// to 1.16 on the bunny, and by 1.02 on a tree that was cut along planes. It is evidence, not proof: see
    /// `docs/decisions/0009-merged-trees.md` for a place on the dragon where even this is not enough.
    pub fn of(mode: SplitMode) -> Slack {
        match mode {
            SplitMode::Paper | SplitMode::Pca | SplitMode::Cca => Slack(1.05),
            SplitMode::Quality | SplitMode::Merge => Slack(1.25),
        }
    }

    /// A length raised, rounded up.
    pub fn raise(self, length: f64) -> f32 {
        round_up(length * self.0)
    }
}

/// Raises the bounds of all nodes. They stay nested.
pub fn loosen(nodes: &mut [NodeBounds], slack: Slack) {
    for node in nodes {
        node.bound = slack.raise(f64::from(node.bound));
    }
}
