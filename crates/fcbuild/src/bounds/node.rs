//! The bounds of a node, in two steps: what its faces alone tell, then what must be nested over the tree.

use super::{BoundingPolygon, distance};
use crate::arcs::corners::Cornered;
use crate::arcs::loops::LAST;
use crate::partition::Split;
use crate::tree_order::TreeMesh;
use fcgeom::{Cone, Sphere};
use glam::Vec3;

/// What a node's faces tell by themselves.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Distance bound of this node alone, in normal units.
    pub bound: f64,
    /// True if the bound is a distance from corners that are always drawn, so that no polygon must lie under it.
    pub from_corners: bool,
    /// Around the cluster's vertices.
    pub sphere: Sphere,
    /// Holds the normals of the cluster's faces.
    pub cone: Cone,
    /// Around the cluster, for nodes worth an occlusion query.
    pub polygon: Option<Box<BoundingPolygon>>,
}

impl Default for Measured {
    fn default() -> Self {
        Measured {
            bound: f64::INFINITY,
            from_corners: true,
            sphere: Sphere::EMPTY,
            cone: Cone::FULL,
            polygon: None,
        }
    }
}

/// The bounds of a node as they are stored.
#[derive(Clone, Copy, Debug)]
pub struct NodeBounds {
    /// No point of the cluster is farther from the drawn mesh, in normal units; never below a child's.
    pub bound: f64,
    /// Root of the largest epsilon in the subtree, in normal units.
    pub budget: f64,
    /// Encloses the cluster and the spheres of the children.
    pub sphere: Sphere,
    /// Holds the normals of the cluster's faces.
    pub cone: Cone,
}

/// Clusters of fewer faces get no bounding polygon: a query costs as much as drawing them.
const POLYGON_FROM: usize = 64;

/// Above this many faces a cone is found in one pass around the mean normal; such cones seldom cull.
const EXACT_CONE_UP_TO: usize = 2048;

/// Measures one node.
pub fn measure(mesh: &TreeMesh, split: &Split, at: &Cornered<'_>) -> Measured {
    let own = mesh.own_vertices(&at.faces);
    let border: Vec<Vec3> =
        at.loops.iter().map(|&h| mesh.positions[mesh.origin(h & !LAST) as usize]).collect();
    let points = || mesh.positions[own.clone()].iter().chain(&border);
    let normals = &mesh.face_normals[at.faces.clone()];
    let cone = if split.joins_components { Cone::FULL } else { cone_of(normals) };
    let (bound, from_corners) = if split.joins_components || at.corners.is_empty() {
        (f64::INFINITY, true)
    } else {
        let corners: Vec<Vec3> = at.corners.iter().map(|&v| mesh.positions[v as usize]).collect();
        // Around a hole the outline may be cut by so few chords that they cross the hole: no slab holds then.
        let has_holes = at.loops.iter().filter(|&&h| h & LAST != 0).count() > 1;
        let directions = if has_holes { &[][..] } else { &[split.normal, cone.axis] };
        distance::bound(normals, directions, &mesh.positions[own.clone()], &border, &corners)
    };
    let sphere = Sphere::of_points(points());
    let polygon = (at.faces.len() >= POLYGON_FROM).then(|| {
        let normal = if split.normal == Vec3::ZERO { cone.axis } else { split.normal };
        Box::new(BoundingPolygon::around(points().copied(), sphere.center, normal))
    });
    Measured { bound, from_corners, sphere, cone, polygon }
}

fn cone_of(normals: &[Vec3]) -> Cone {
    if normals.len() <= EXACT_CONE_UP_TO {
        return Cone::of_normals(normals.iter());
    }
    let mean: glam::DVec3 = normals.iter().map(|n| n.as_dvec3()).sum();
    let Some(axis) = mean.as_vec3().try_normalize() else { return Cone::FULL };
    let lowest = normals.iter().filter(|n| **n != Vec3::ZERO).map(|n| axis.as_dvec3().dot(n.as_dvec3()));
    let lowest = lowest.fold(1.0, f64::min);
    if lowest <= 0.0 { Cone::FULL } else { Cone { axis, cos: fcgeom::round_down(lowest - 1e-7) } }
}

/// Nests the measurements over the tree: spheres in spheres, keys that never grow towards the leaves.
pub fn combine(mesh: &TreeMesh, splits: &[Split], measured: &[Measured]) -> Vec<NodeBounds> {
    let mut nodes: Vec<NodeBounds> = splits
        .iter()
        .zip(measured)
        .map(|(s, m)| {
            // A node that must be refined in every order: the root of a closed surface, a join of components.
            let never_drawn = m.bound == f64::INFINITY;
            let budget = if never_drawn { f64::INFINITY } else { s.key };
            NodeBounds { bound: m.bound, budget, sphere: m.sphere, cone: m.cone }
        })
        .collect();
    // Children follow their parents, so backwards is from the faces up.
    for (node, faces) in preorder(splits, mesh.faces.len()).into_iter().rev() {
        let left = splits[node].left_faces as usize;
        let children = [(node + 1, left), (node + left, faces - left)];
        let inner = children.map(|(child, faces)| (faces > 1).then(|| nodes[child]));
        let mut own = nodes[node];
        for child in inner.iter().flatten() {
            own.bound = own.bound.max(child.bound);
            own.budget = own.budget.max(child.budget);
        }
        own.sphere = around_children(&own.sphere, &inner);
        nodes[node] = own;
    }
    nodes
}

/// The smaller of two spheres: the cluster's own, grown over the children's, or the one around the children's.
fn around_children(own: &Sphere, children: &[Option<NodeBounds>; 2]) -> Sphere {
    let center = own.center.as_dvec3();
    let reach = children
        .iter()
        .flatten()
        .map(|c| center.distance(c.sphere.center.as_dvec3()) + f64::from(c.sphere.radius));
    let radius = reach.fold(f64::from(own.radius), f64::max);
    let grown = Sphere { center: own.center, radius: fcgeom::round_up(radius * (1.0 + 1e-12)) };
    match children {
        [Some(a), Some(b)] => {
            let merged = Sphere::enclosing(&a.sphere, &b.sphere);
            if merged.radius < grown.radius { merged } else { grown }
        }
        _ => grown,
    }
}

/// Every node with its number of faces.
fn preorder(splits: &[Split], faces: usize) -> Vec<(usize, usize)> {
    let mut out = Vec::with_capacity(splits.len());
    let mut stack = vec![(0, faces)];
    while let Some((node, faces)) = stack.pop() {
        if faces > 1 {
            out.push((node, faces));
            let left = splits[node].left_faces as usize;
            stack.push((node + left, faces - left));
            stack.push((node + 1, left));
        }
    }
    out
}
