//! That spheres hold what they should.

use crate::error::Violation;
use crate::records::{NodeRecord, VertexRecord};
use crate::rule::Rule;
use crate::walk::{node_place, to_index};

use super::vector::{length, sub, widen};

/// Slack relative to the radius: builders round radii up, this covers a square root that rounds the other way.
const SLACK: f64 = 1e-6;

/// Checks that a child's sphere lies inside its parent's.
pub(crate) fn check_nested(
    parent: &NodeRecord,
    child: &NodeRecord,
    child_index: u32,
) -> Result<(), Box<Violation>> {
    let radius = f64::from(parent.radius.get());
    let reach = length(sub(widen(child.center), widen(parent.center))) + f64::from(child.radius.get());
    if reach <= radius + radius * SLACK {
        return Ok(());
    }
    Err(Violation::new(
        Rule::SphereNested,
        node_place(child_index),
        format!("it reaches {reach:e} from the centre of its parent, whose radius is {radius:e}"),
    ))
}

/// Checks that the corners of a face lie inside the sphere of the node above it.
pub(crate) fn check_face(
    parent: &NodeRecord,
    face_index: u32,
    corners: [u32; 3],
    vertices: &[VertexRecord],
) -> Result<(), Box<Violation>> {
    let radius = f64::from(parent.radius.get());
    for corner in corners {
        let Some(vertex) = to_index(corner).and_then(|i| vertices.get(i)) else {
            continue;
        };
        let distance = length(sub(widen(vertex.position), widen(parent.center)));
        if distance > radius + radius * SLACK {
            return Err(Violation::new(
                Rule::SphereHolds,
                format!("section FACE, face {face_index}"),
                format!(
                    "its vertex {corner} is {distance:e} from the centre of the node above it, whose radius is {radius:e}"
                ),
            ));
        }
    }
    Ok(())
}
