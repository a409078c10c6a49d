//! That spheres hold what they should, to the last digit.

use crate::error::Violation;
use crate::node::Node;
use crate::records::VertexRecord;
use crate::rule::Rule;
use crate::subtree::Subtree;
use crate::walk::to_index;

use super::vector::{length, sub, widen};

/// Checks that a child's sphere lies inside its parent's.
pub(crate) fn check_nested(parent: &Node, child: &Node, place: &Subtree) -> Result<(), Box<Violation>> {
    let radius = f64::from(parent.radius);
    let reach = length(sub(widen(child.center), widen(parent.center))) + f64::from(child.radius);
    if reach <= radius {
        return Ok(());
    }
    Err(Violation::new(
        Rule::SphereNested,
        place.to_string(),
        format!("it reaches {reach:e} from the centre of its parent, whose radius is {radius:e}"),
    ))
}

/// Checks that the corners of a face lie inside the sphere of the node above it.
pub(crate) fn check_face(
    parent: &Node,
    face: &Subtree,
    corners: [u32; 3],
    vertices: &[VertexRecord],
) -> Result<(), Box<Violation>> {
    let radius = f64::from(parent.radius);
    for corner in corners {
        let Some(vertex) = to_index(corner).and_then(|i| vertices.get(i)) else {
            continue;
        };
        let distance = length(sub(widen(vertex.position()), widen(parent.center)));
        if distance > radius {
            return Err(Violation::new(
                Rule::SphereHolds,
                face.to_string(),
                format!(
                    "its vertex {corner} is {distance:e} from the centre of the node above it, whose radius is {radius:e}"
                ),
            ));
        }
    }
    Ok(())
}
