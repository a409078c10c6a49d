//! The measured tree as those see it who look for vertices, and the walk down it of those who find records.

use super::activity::Activity;
use super::curves::CurveRecord;
use super::loops::Loops;
use crate::bounds::NodeBounds;
use crate::partition::{Split, Subtree};
use crate::tree_order::TreeMesh;

/// A measured tree.
#[derive(Clone, Copy)]
pub struct ClusterTree<'a> {
    /// Its mesh, in the order of the tree.
    pub mesh: &'a TreeMesh,
    /// Its nodes in preorder.
    pub splits: &'a [Split],
    /// Their loops.
    pub loops: &'a Loops,
    /// Their bounds.
    pub nodes: &'a [NodeBounds],
    /// The welded vertices' records, as far as they are known.
    pub keys: &'a [Activity],
}

/// Below this many faces a subtree stays on one thread.
const SERIAL_BELOW: usize = 4096;

/// One who looks at nodes and finds records.
pub(super) trait Finder: Sync {
    /// Memory that is used again for each node.
    type Memory: Default;

    /// Looks at a node that is more than a face, whose parent has the budget key `above`, infinite for the root. Below
    /// nodes for which `false` comes back nothing is to be found.
    fn look(&self, at: &Subtree, above: f32, memory: &mut Self::Memory, found: &mut Vec<CurveRecord>)
    -> bool;
}

impl ClusterTree<'_> {
    /// The records that are found at all nodes, in the order of the nodes.
    pub(super) fn records<F: Finder>(&self, finder: &F) -> Vec<CurveRecord> {
        let whole = Subtree::whole(self.mesh.faces.len());
        self.records_below(&whole, f32::INFINITY, finder).concat()
    }

    /// The records of a node and of all below, in pieces. No tree is deep enough for the recursion to matter.
    fn records_below<F: Finder>(&self, at: &Subtree, above: f32, finder: &F) -> Vec<Vec<CurveRecord>> {
        let (mut found, mut memory) = (Vec::new(), F::Memory::default());
        if at.faces.len() < SERIAL_BELOW {
            self.records_below_serial(at, above, finder, &mut memory, &mut found);
            return vec![found];
        }
        if !finder.look(at, above, &mut memory, &mut found) {
            return vec![found];
        }
        let ([left, right], key) = (at.children(self.splits), self.nodes[at.node].budget);
        let (l, r) = rayon::join(
            || self.records_below(&left, key, finder),
            || self.records_below(&right, key, finder),
        );
        let mut pieces = vec![found];
        pieces.extend(l);
        pieces.extend(r);
        pieces
    }

    fn records_below_serial<F: Finder>(
        &self,
        at: &Subtree,
        above: f32,
        finder: &F,
        memory: &mut F::Memory,
        found: &mut Vec<CurveRecord>,
    ) {
        if at.is_face() || !finder.look(at, above, memory, found) {
            return;
        }
        let key = self.nodes[at.node].budget;
        for child in at.children(self.splits) {
            self.records_below_serial(&child, key, finder, memory, found);
        }
    }
}
