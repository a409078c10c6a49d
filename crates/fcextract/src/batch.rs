//! Runs of triangles worth a question to the depth buffer.

use fcgeom::Sphere;
use fct::{Child, Reader, Subtree, Tree};

use crate::extraction::sphere_of;

/// A run of an extraction's triangles that comes from one subtree.
///
/// The batches of an extraction are disjoint, in order, and cover all its indices.
#[derive(Clone, Copy, Debug)]
pub struct Batch {
    /// The subtree.
    pub subtree: Subtree,
    /// Where the run starts in [`Extraction::indices`](crate::Extraction::indices).
    pub first_index: u32,
    /// Its length, three a triangle.
    pub index_count: u32,
    /// Index of its bounding polygon in the tree, if the node has one.
    pub bounding_polygon: Option<u32>,
    /// Encloses the triangles.
    pub sphere: Sphere,
}

impl Batch {
    /// A run whose bounds are not looked up yet: most runs are joined into larger ones first.
    pub(crate) fn new(subtree: Subtree, first_index: u32, index_count: u32) -> Batch {
        Batch { subtree, first_index, index_count, bounding_polygon: None, sphere: Sphere::EMPTY }
    }

    /// The same run, so many indices further on.
    pub(crate) fn moved(&self, by: u32) -> Batch {
        Batch { first_index: self.first_index + by, ..*self }
    }

    /// Looks the sphere and the bounding polygon up; the polygons' records are sorted by node.
    pub(crate) fn find_bounds(&mut self, tree: &Tree, reader: &Reader<'_>) {
        match self.subtree.child.kind() {
            Child::Node(node) => {
                self.sphere = reader.node(&self.subtree).map_or(Sphere::EMPTY, |n| sphere_of(&n));
                self.bounding_polygon = tree.bounding_polygon_of(node).and_then(|i| u32::try_from(i).ok());
            }
            Child::Face(_) => {
                let corner = |v: u32| tree.vertices().get(v as usize).map(|r| r.position().into());
                self.sphere = reader.face(&self.subtree).map_or(Sphere::EMPTY, |corners| {
                    Sphere::of_points(corners.map(|v| corner(v).unwrap_or(glam::Vec3::NAN)))
                });
            }
        }
    }
}
