//! (being written)

use super::curves::CurveRecord;
use super::loops::Loops;
use crate::bounds::NodeBounds;
use crate::partition::Split;
use crate::tree_order::TreeMesh;

/// (being written)
pub fn records(_mesh: &TreeMesh, _splits: &[Split], _loops: &Loops, _nodes: &[NodeBounds]) -> Vec<CurveRecord> {
    Vec::new()
}
