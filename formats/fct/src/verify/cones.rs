//! That normal cones hold the normals of their faces.

use crate::error::Violation;
use crate::records::{FaceRecord, NodeRecord, VertexRecord};
use crate::rule::Rule;
use crate::walk::{Subtree, node_place, to_index};

use super::vector::{Vector, cross, dot, length, sub, widen};

/// Larger clusters are not looked at: their cones follow from the same code, and seldom cull anything.
const MAX_CLUSTER: u32 = 64;

/// Slack of a cosine.
const SLACK: f64 = 1e-4;

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
        index: u32,
        node: &NodeRecord,
        subtree: &Subtree,
        faces: &[FaceRecord],
        vertices: &[VertexRecord],
    ) -> Result<(), Box<Violation>> {
        if subtree.face_count() > MAX_CLUSTER || node.cos.get() <= -1.0 {
            return Ok(());
        }
        let axis = widen(node.axis);
        let cos = f64::from(node.cos.get()) - SLACK;
        for (face, normal) in (subtree.first_face..).zip(self.normals(subtree, faces, vertices)) {
            let Some(normal) = normal else { continue };
            let found = dot(*normal, axis);
            if found < cos {
                return Err(Violation::new(
                    Rule::ConeHolds,
                    node_place(index),
                    format!(
                        "the normal of face {face} has the cosine {found} with its axis, and its cone {}",
                        node.cos.get()
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
        faces: &[FaceRecord],
        vertices: &[VertexRecord],
    ) -> &[Option<Vector>] {
        let place = |first: u32| {
            let start = to_index(subtree.first_face.checked_sub(first)?)?;
            Some(start..start.checked_add(to_index(subtree.face_count())?)?)
        };
        if place(self.first).is_none_or(|range| range.end > self.normals.len()) {
            self.first = subtree.first_face;
            self.normals.clear();
            let cluster = subtree.of(faces);
            self.normals.extend(cluster.iter().map(|f| normal_of(f.indices(), vertices)));
        }
        place(self.first).and_then(|range| self.normals.get(range)).unwrap_or_default()
    }
}

/// The unit normal of a face, or none if it has no area.
fn normal_of(corners: [u32; 3], vertices: &[VertexRecord]) -> Option<Vector> {
    let [a, b, c] = corners.map(|v| {
        let vertex = to_index(v).and_then(|i| vertices.get(i))?;
        Some(widen(vertex.position))
    });
    let a = a?;
    let (ab, ac) = (sub(b?, a), sub(c?, a));
    let [x, y, z] = cross(ab, ac);
    let area = length([x, y, z]);
    (area > SLIVER * length(ab) * length(ac)).then(|| [x / area, y / area, z / area])
}
