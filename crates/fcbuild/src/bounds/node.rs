//! The bounds of a node, in two steps: what its faces alone tell, then what must be nested over the tree.

use super::{BoundingPolygon, distance};
use crate::arcs::loops::LAST;
use crate::partition::Split;
use crate::tree_order::TreeMesh;
use fcgeom::{Cone, Quads, Sphere, round_up};
use glam::Vec3;
use std::ops::Range;

/// The bounds of a node.
#[derive(Clone, Copy, Debug)]
pub struct NodeBounds {
    /// No point of the cluster is farther from the drawn mesh, in normal units; not below a child's once nested.
    pub bound: f32,
    /// Budget key, a length in normal units; not below a child's once nested.
    pub budget: f32,
    /// Encloses the cluster, and the spheres of the children once nested.
    pub sphere: Sphere,
    /// Holds the normals of the cluster's faces.
    pub cone: Cone,
    /// True if the cluster's own bound is a distance from corners that are always drawn, so that no polygon must lie
    /// under it.
    pub from_corners: bool,
    /// True if the cluster's plane is nearly perpendicular to the cone's axis, and a slab its bound; the same of all
    /// clusters below once nested.
    pub follows_cone: bool,
}

impl NodeBounds {
    /// A place for bounds that are still to be measured.
    pub const UNKNOWN: NodeBounds = NodeBounds {
        bound: f32::INFINITY,
        budget: f32::INFINITY,
        sphere: Sphere::EMPTY,
        cone: Cone::FULL,
        from_corners: true,
        follows_cone: false,
    };

    /// Whether no two clusters or faces in the node's subtree meet at more than 20 degrees.
    ///
    /// The cones below have their axes in this one's: their planes and normals lie within 10 degrees of its axis.
    pub fn is_flat(&self) -> bool {
        self.follows_cone && self.cone.cos > FLAT_CONE
    }

    /// Nests the bounds of a node over those of its children: a sphere around theirs, keys not below theirs.
    pub fn nest(&mut self, children: [Option<&NodeBounds>; 2]) {
        for child in children.into_iter().flatten() {
            self.bound = self.bound.max(child.bound);
            self.budget = self.budget.max(child.budget);
            self.follows_cone &= child.follows_cone;
        }
        self.sphere = around_children(&self.sphere, children);
    }
}

/// Cosine of 2.9 degrees: how far a plane's normal may be from the axis of its cone to follow it.
const FOLLOWS: f32 = 0.99872;

/// Cosine of 7 degrees, the half angle of a cone that is called flat.
const FLAT_CONE: f32 = 0.99255;

/// Clusters of fewer faces get no bounding polygon: a query costs as much as drawing them.
const POLYGON_FROM: usize = 64;

/// A node as it is shown to be measured.
pub struct Cluster<'a> {
    /// Its faces.
    pub faces: Range<usize>,
    /// Its loops, as in [`crate::arcs::loops::Loops::of_node`].
    pub loops: &'a [u32],
    /// Of half-edges `3 * faces.start` on: whether one on the loops starts at a corner that an ancestor registers,
    /// present whenever the node is drawn.
    pub registered: &'a [bool],
}

/// Measures nodes, one after the other in the same memory.
pub struct Measurer<'a> {
    mesh: &'a TreeMesh,
    /// The vertices of the cluster, those of its border first.
    points: Quads,
    /// The normals of its faces but for those without area.
    normals: Quads,
    corners: Vec<Vec3>,
}

impl<'a> Measurer<'a> {
    /// A measurer of clusters of `mesh`.
    pub fn new(mesh: &'a TreeMesh) -> Measurer<'a> {
        Measurer { mesh, points: Quads::default(), normals: Quads::default(), corners: Vec::new() }
    }

    /// Measures one node by itself, with a bounding polygon if it is worth an occlusion query.
    pub fn measure(&mut self, split: &Split, at: &Cluster<'_>) -> (NodeBounds, Option<BoundingPolygon>) {
        let mesh = self.mesh;
        let corner_vertices = mesh.faces.as_flattened();
        let vertex = |h: &u32| mesh.positions[corner_vertices[(h & !LAST) as usize] as usize];
        self.points.clear();
        let inside = self.points.extend(at.loops, vertex);
        let end = self.points.extend(&mesh.positions[mesh.own_vertices(&at.faces)], |p| *p);
        self.normals.clear();
        let normals = &mesh.face_normals[at.faces.clone()];
        if mesh.has_flat_face(&at.faces) {
            let with_side: Vec<Vec3> = normals.iter().copied().filter(|n| *n != Vec3::ZERO).collect();
            self.normals.extend(&with_side, |n| *n);
        } else {
            self.normals.extend(normals, |n| *n);
        }

        let cone = if split.joins_components { Cone::FULL } else { Cone::of_quads(&self.normals) };
        let mut bound = None;
        let is_corner = |h: &&u32| at.registered[(**h & !LAST) as usize - 3 * at.faces.start];
        if !split.joins_components && at.loops.iter().any(|h| is_corner(&h)) {
            // Around a hole the outline may be cut by so few chords that they cross the hole: no slab holds then.
            let has_holes = at.loops.iter().rev().skip(1).any(|h| h & LAST != 0);
            if !has_holes {
                let along_plane =
                    split.normal != Vec3::ZERO && self.normals.all_above(split.normal, distance::MIN_FACING);
                let along_axis = cone.cos > distance::MIN_FACING;
                let directions = [along_plane.then_some(split.normal), along_axis.then_some(cone.axis)];
                bound = distance::from_slab(directions, &self.points, 0..inside, inside..end);
            }
            if bound.is_none() {
                self.corners.clear();
                self.corners.extend(at.loops.iter().filter(is_corner).map(vertex));
            }
        }
        let from_corners = bound.is_none();
        let bound = bound.unwrap_or_else(|| {
            distance::from_corners(&self.points, longest_edge(mesh, &at.faces), &mut self.corners)
        });
        // A node that must be refined in every order: the root of a closed surface, a join of components.
        let never_drawn = bound == f64::INFINITY;
        let budget = if never_drawn { f64::INFINITY } else { split.key };
        let sphere = Sphere::of_quads(&self.points);
        let polygon = (at.faces.len() >= POLYGON_FROM).then(|| {
            let normal = if split.normal == Vec3::ZERO { cone.axis } else { split.normal };
            BoundingPolygon::around(&self.points, sphere.center, normal)
        });
        let (bound, budget) = (round_up(bound), round_up(budget));
        let follows_cone = !from_corners && split.normal.dot(cone.axis) > FOLLOWS;
        (NodeBounds { bound, budget, sphere, cone, from_corners, follows_cone }, polygon)
    }
}

/// Of some faces, in normal units.
fn longest_edge(mesh: &TreeMesh, faces: &Range<usize>) -> f32 {
    let squared = |f: &[u32; 3]| {
        let [a, b, c] = f.map(|v| mesh.positions[v as usize]);
        a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a))
    };
    mesh.faces[faces.clone()].iter().map(squared).fold(0.0, f32::max).sqrt()
}

/// The smaller of two spheres: the cluster's own, grown over the children's, or the one around the children's.
fn around_children(own: &Sphere, children: [Option<&NodeBounds>; 2]) -> Sphere {
    let center = own.center.as_dvec3();
    let reach = children
        .iter()
        .flatten()
        .map(|c| center.distance(c.sphere.center.as_dvec3()) + f64::from(c.sphere.radius));
    let radius = reach.fold(f64::from(own.radius), f64::max);
    let grown = Sphere { center: own.center, radius: round_up(radius * (1.0 + 1e-12)) };
    match children {
        [Some(a), Some(b)] => {
            let merged = Sphere::enclosing(&a.sphere, &b.sphere);
            if merged.radius < grown.radius { merged } else { grown }
        }
        _ => grown,
    }
}
