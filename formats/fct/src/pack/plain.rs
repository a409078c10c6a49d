//! Clusters in plain lists, for tools and tests that have no structures of their own.

use super::{ClusterData, Clusters};

/// A tree of clusters in lists.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlainClusters {
    /// Vertex indices of each face, in tree order.
    pub faces: Vec<[u32; 3]>,
    /// Positions, in order of first use by the faces.
    pub positions: Vec<[f32; 3]>,
    /// Faces of the left child of each node, nodes in preorder.
    pub left_faces: Vec<u32>,
    /// The cluster of each node.
    pub clusters: Vec<ClusterData>,
    /// The boundary loops of each node, with [`crate::LOOP_END`] set in the last vertex of each loop.
    pub boundaries: Vec<Vec<u32>>,
}

impl Clusters for PlainClusters {
    fn faces(&self) -> &[[u32; 3]] {
        &self.faces
    }

    fn vertex_count(&self) -> usize {
        self.positions.len()
    }

    fn position(&self, vertex: u32) -> [f32; 3] {
        self.positions.get(vertex as usize).copied().unwrap_or_default()
    }

    fn left_faces(&self, node: u32) -> u32 {
        self.left_faces.get(node as usize).copied().unwrap_or_default()
    }

    fn cluster(&self, node: u32) -> ClusterData {
        self.clusters.get(node as usize).copied().unwrap_or_default()
    }

    fn boundary(&self, node: u32, out: &mut Vec<u32>) {
        out.extend(self.boundaries.get(node as usize).into_iter().flatten());
    }
}
