//! That normal cones hold the normals of their faces.

use crate::error::Violation;
use crate::node::Node;
use crate::records::VertexRecord;
use crate::rule::Rule;
use crate::subtree::Subtree;
use crate::walk::{Reader, to_index};

use super::vector::{Vector, cross, dot, length, sub, widen};

/// Larger clusters are not looked at: their cones follow from the same code, and seldom cull anything.
const MAX_CLUSTER: u32 = 64;

/// Slack of a cosine: the builder's normals come from the same positions in another order of sums.
const SLACK: f64 = 1e-6;

/// A face whose area is smaller than this part of the product of two edges has no normal that rounding leaves standing.
const SLIVER: f64 = 1e-10;

/// Checks cones on the way down, and remembers the normals of the small cluster it is in.
#[derive(Default)]
pub(crate) struct Cones {
    first: u32,
    normals: Vec<Option<Vector>>,
}

impl Cones {
    pub(crate) fn check(
        &mut self,
        node: &Node,
        subtree: &Subtree,
        reader: &Reader<'_>,
    ) -> Result<(), Box<Violation>> {
        let stored = node.cos();
        if subtree.face_count() > MAX_CLUSTER || stored <= -1.0 {
            return Ok(());
        }
        let axis = widen(node.axis());
        let cos = f64::from(stored) - SLACK;
        for (face, normal) in (subtree.first_face..).zip(self.normals(subtree, reader)?) {
            let Some(normal) = normal else { continue };
            let found = dot(*normal, axis);
            if found < cos {
                return Err(Violation::new(
                    Rule::ConeHolds,
                    subtree.to_string(),
                    format!(
                        "the normal of face {face} has the cosine {found} with its axis, and its cone {stored}"
                    ),
                ));
            }
        }
        Ok(())
    }

    /// The normals of a cluster; computed once for the largest small cluster, since its descendants come next.
    fn normals(
        &mut self,
        subtree: &Subtree,
        reader: &Reader<'_>,
    ) -> Result<&[Option<Vector>], Box<Violation>> {
        let place = |first: u32| {
            let start = to_index(subtree.first_face.checked_sub(first)?)?;
            Some(start..start.checked_add(to_index(subtree.face_count())?)?)
        };
        if place(self.first).is_none_or(|range| range.end > self.normals.len()) {
            self.first = subtree.first_face;
            self.normals.clear();
            for face in subtree.first_face..subtree.face_end {
                let corners = reader.corners(&reader.single(face))?;
                self.normals.push(normal_of(corners, reader.vertices));
            }
        }
        Ok(place(self.first).and_then(|range| self.normals.get(range)).unwrap_or_default())
    }
}

/// The unit normal of a face, or none if it has no area.
fn normal_of(corners: [u32; 3], vertices: &[VertexRecord]) -> Option<Vector> {
    let [a, b, c] = corners.map(|v| {
        let vertex = to_index(v).and_then(|i| vertices.get(i))?;
        Some(widen(vertex.position()))
    });
    let a = a?;
    let (ab, ac) = (sub(b?, a), sub(c?, a));
    let [x, y, z] = cross(ab, ac);
    let area = length([x, y, z]);
    (area > SLIVER * length(ab) * length(ac)).then(|| [x / area, y / area, z / area])
}
