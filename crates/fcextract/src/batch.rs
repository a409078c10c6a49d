//! Runs of triangles worth a question to the depth buffer.

use fcgeom::Sphere;
use fct::{Child, ChildRef, Tree};

/// A run of an extraction's triangles that comes from one subtree.
///
/// The batches of an extraction are disjoint, in order, and cover all its indices.
#[derive(Clone, Copy, Debug)]
pub struct Batch {
    /// The root of the subtree.
    pub node: ChildRef,
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
    pub(crate) fn new(node: ChildRef, first_index: u32, index_count: u32) -> Batch {
        Batch { node, first_index, index_count, bounding_polygon: None, sphere: Sphere::EMPTY }
    }

    /// Looks the sphere and the bounding polygon up; the polygons' records are sorted by node.
    pub(crate) fn find_bounds(&mut self, tree: &Tree) {
        self.sphere = sphere_of(tree, self.node);
        if let Child::Node(node) = self.node.kind() {
            let found = tree.bounding_polygons().binary_search_by_key(&node, |p| p.node.get());
            self.bounding_polygon = found.ok().and_then(|i| u32::try_from(i).ok());
        }
    }
}

fn sphere_of(tree: &Tree, node: ChildRef) -> Sphere {
    match node.kind() {
        Child::Node(i) => tree.node(i).map_or(Sphere::EMPTY, |n| Sphere {
            center: n.center.map(|x| x.get()).into(),
            radius: n.radius.get(),
        }),
        Child::Face(i) => tree.face(i).map_or(Sphere::EMPTY, |corners| {
            let corner = |v: u32| tree.vertices().get(v as usize).map(|r| r.position.map(|x| x.get()).into());
            Sphere::of_points(corners.map(|v| corner(v).unwrap_or(glam::Vec3::NAN)))
        }),
    }
}
