//! What a node outside the entered pages is drawn by, whether it is of the crown or of a chunk's top.

use fct::{Chunk, Crown, Loops, Node, Subtree, TopRecord, VertexRecord};

/// What a node is drawn by, but for its loops.
pub(super) struct Ready {
    pub(super) top: TopRecord,
    /// The first corner of its first face, by name, and its record.
    pub(super) corner: (u32, VertexRecord),
    /// None for a single face, which has no plane and no bound of its own.
    pub(super) node: Option<Node>,
}

impl Ready {
    /// Reads a node of the crown and its loops.
    pub(super) fn of_crown(crown: &Crown, node: u32, loops: &mut Loops) -> Option<Ready> {
        crown.read_loops(node, loops)?;
        let (corner, place) = crown.corner(node)?;
        let stored = *crown.vertices().get(place)?;
        let decoded = crown.node(node)?;
        let is_node = decoded.bound != 0.0 || decoded.radius != 0.0;
        Some(Ready { top: crown.top(node)?, corner: (corner, stored), node: is_node.then_some(decoded) })
    }

    /// Reads a top node or the root of a page of a chunk, and its loops.
    pub(super) fn of_chunk(chunk: &Chunk, subtree: &Subtree, loops: &mut Loops) -> Option<Ready> {
        chunk.read_loops(subtree, loops)?;
        let corner = chunk.corner(subtree)?;
        let stored = *chunk.vertices().get(chunk.find(corner)?)?;
        // Errors are texts, which take memory: a face is not asked about.
        let node = if subtree.face_count() > 1 { chunk.node(subtree).ok() } else { None };
        Some(Ready { top: chunk.record(subtree)?, corner: (corner, stored), node })
    }
}
