//! That vertices are drawn where their faces are.

use crate::error::Violation;
use crate::node::Node;
use crate::records::VertexRecord;
use crate::rule::Rule;
use crate::subtree::Subtree;
use crate::walk::to_index;

use super::vector::{length, sub, widen};

/// Checks that whenever the node above a face is refined, so that the face is drawn, its corners are active: their keys
/// are not below the node's, and their spheres hold the node's.
pub(crate) fn check_face(
    parent: &Node,
    face: &Subtree,
    corners: [u32; 3],
    vertices: &[VertexRecord],
) -> Result<(), Box<Violation>> {
    for corner in corners {
        let Some(vertex) = to_index(corner).and_then(|i| vertices.get(i)) else {
            continue;
        };
        let is_eager = vertex.bound() >= parent.bound && vertex.budget() >= parent.budget;
        // The sphere does not matter where the vertex is always active, or the node never refined by any tolerance.
        let always = vertex.bound() == f32::INFINITY && vertex.budget() == f32::INFINITY;
        let never = parent.bound <= 0.0 && parent.budget <= 0.0;
        let reach = length(sub(vertex.center(), widen(parent.center))) + f64::from(parent.radius);
        if !is_eager || !(always || never || reach <= vertex.radius()) {
            return Err(Violation::new(
                Rule::VertexActive,
                face.to_string(),
                format!("its vertex {corner} may be left out where the node above it is refined"),
            ));
        }
    }
    Ok(())
}
