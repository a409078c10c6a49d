//! That vertices are drawn where their faces are.

use crate::error::Violation;
use crate::records::{NodeRecord, VertexRecord};
use crate::rule::Rule;
use crate::walk::to_index;

use super::vector::{length, sub, widen};

/// Slack relative to the radius; builders pad a vertex's sphere by more than its rounding.
const SLACK: f64 = 1e-6;

/// Checks that whenever the node above a face is refined, so that the face is drawn, its corners are active: their keys
/// are not below the node's, and their spheres hold the node's.
pub(crate) fn check_face(
    parent: &NodeRecord,
    face_index: u32,
    corners: [u32; 3],
    vertices: &[VertexRecord],
) -> Result<(), Box<Violation>> {
    for corner in corners {
        let Some(vertex) = to_index(corner).and_then(|i| vertices.get(i)) else {
            continue;
        };
        let is_eager = vertex.bound.get() >= parent.bound.get() && vertex.budget.get() >= parent.budget.get();
        // Where the key is infinite the sphere does not matter.
        let always = vertex.bound.get() == f32::INFINITY && vertex.budget.get() == f32::INFINITY;
        let radius = f64::from(vertex.radius.get());
        let reach = length(sub(widen(vertex.center), widen(parent.center))) + f64::from(parent.radius.get());
        if !is_eager || !(always || reach <= radius + radius * SLACK) {
            return Err(Violation::new(
                Rule::VertexActive,
                format!("section FACE, face {face_index}"),
                format!("its vertex {corner} may be left out where the node above it is refined"),
            ));
        }
    }
    Ok(())
}
