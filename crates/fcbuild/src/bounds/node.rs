//! The bounds of a node, in two steps: what its faces alone tell, then what must be nested over the tree.

use super::distance;
use super::overhang::Overhang;
use super::slab::{self, EASE, MIN_FACING, Points};
use super::slack::Slack;
use super::support::Support;
use super::supports::Supports;
use crate::arcs::loops::{LAST, split_loops};
use crate::partition::Split;
use crate::tree_order::TreeMesh;
use fcgeom::{Cone, Quads, Sphere, round_up};
use glam::{DVec3, Vec3};
use std::ops::Range;

/// The bounds of a node. Its sphere is found by the file's packer, its cone stands beside it.
#[derive(Clone, Copy, Debug)]
pub struct NodeBounds {
    /// No point of the cluster is farther from the drawn mesh, and no point of the cluster's polygon from the surface, in
    /// normal units; not below a child's once nested.
    pub bound: f32,
    /// The bound, or how far a cluster with holes and without a slab reaches over its plane if all faces show the same side
    /// of that and it is less; a length in normal units, not below a child's once nested. It promises nothing.
    pub reach: f32,
    /// Budget key, a length in normal units; not below a child's once nested.
    pub budget: f32,
    /// What the cluster is measured by.
    pub fit: Fit,
    /// What the bound leaves to displaced vertices.
    pub slack: Slack,
}

/// What a cluster is measured by, and how near its plane is to its normals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fit {
    /// Its own bound is a distance from corners that are always drawn, so that no polygon must lie under it.
    Corners,
    /// Its own bound is a slab.
    Slab,
    /// The same, and its plane is nearly perpendicular to the axis of its normal cone; so it is with all clusters below
    /// once nested.
    AlongCone,
    /// The same, and its own cone is narrow.
    Flat,
}

impl Fit {
    fn is_along_cone(self) -> bool {
        matches!(self, Fit::AlongCone | Fit::Flat)
    }
}

impl NodeBounds {
    /// A place for bounds that are still to be measured.
    pub const UNKNOWN: NodeBounds = NodeBounds {
        bound: f32::INFINITY,
        reach: f32::INFINITY,
        budget: f32::INFINITY,
        fit: Fit::Corners,
        slack: Slack::NONE,
    };

    /// Whether no two clusters or faces in the node's subtree meet at more than 20 degrees.
    ///
    /// The cones below have their axes in this one's: their planes and normals lie within 10 degrees of its axis.
    pub fn is_flat(&self) -> bool {
        self.fit == Fit::Flat
    }

    /// Whether the cluster's own bound is a distance from its corners.
    pub fn is_from_corners(&self) -> bool {
        self.fit == Fit::Corners
    }

    /// Raises the bound to at least this.
    pub fn raise_bound(&mut self, bound: f32) {
        let raised = self.bound.max(bound);
        self.slack = self.slack.raised(self.bound, raised);
        self.bound = raised;
    }

    /// Nests the bounds of a node over those of its children: keys not below theirs.
    pub fn nest(&mut self, children: [Option<&NodeBounds>; 2]) {
        for child in children.into_iter().flatten() {
            self.raise_bound(child.bound);
            self.budget = self.budget.max(child.budget);
            self.reach = self.reach.max(child.reach);
            if self.fit.is_along_cone() && !child.fit.is_along_cone() {
                self.fit = Fit::Slab;
            }
        }
    }
}

// There are as many as faces.
const _: () = assert!(size_of::<NodeBounds>() == 20);

/// Cosine of 2.9 degrees: how far a plane's normal may be from the axis of its cone to follow it.
const FOLLOWS: f32 = 0.99872;

/// Cosine of 7 degrees, the half angle of a cone that is called flat.
const FLAT_CONE: f32 = 0.99255;

/// Cosine of the angle (30 degrees) up to which a slab is turned away from the axis along which readers triangulate the
/// polygon: far from there triangles that are the right way round for them may be turned over along the slab.
const TURNED_TO: f64 = 0.87;

/// Slabs of clusters with at least so many faces are turned to be lower.
const TURNED_FROM: usize = 32;

/// Clusters of at least so many faces are measured between planes that lean. From four on fine meshes have 0.4 % fewer
/// triangles, and a build takes 3 % more processor time and 4 bytes of memory a face more.
const SUPPORTED_FROM: usize = 6;

/// Planes that lean count if they make a cluster lower than this share of its slab.
const WORTH: f64 = 0.97;

/// A node as it is shown to be measured.
pub struct Cluster<'a> {
    /// Its number, counted from the first node of a piece of [`super::AllSupports`].
    pub place: u16,
    /// Its faces.
    pub faces: Range<usize>,
    /// Its loops, as in [`crate::arcs::loops::Loops::read`].
    pub loops: &'a [u32],
    /// Of half-edges `3 * faces.start` on: whether one on the loops starts at a corner that an ancestor registers,
    /// present whenever the node is drawn.
    pub registered: &'a [bool],
}

/// The node that is split into a cluster and another.
#[derive(Clone, Copy, Debug)]
pub enum Above {
    /// None that can register more corners: the cluster is the root, or a component whose corners a join would register
    /// for every mesh.
    Nothing,
    /// One that is refined in every mesh.
    NeverDrawn,
    /// One that is drawn in place of the cluster from this bound on.
    Drawn(f64),
}

/// Measures nodes, one after the other in the same memory.
pub struct Measurer<'a> {
    mesh: &'a TreeMesh,
    /// The vertices of the cluster, those of its border first.
    points: Quads,
    /// The normals of its faces but for those without area.
    normals: Quads,
    corners: Vec<Vec3>,
    overhang: Overhang,
    supports: Supports,
}

impl<'a> Measurer<'a> {
    /// A measurer of clusters of `mesh`.
    pub fn new(mesh: &'a TreeMesh) -> Measurer<'a> {
        Measurer {
            mesh,
            points: Quads::default(),
            normals: Quads::default(),
            corners: Vec::new(),
            overhang: Overhang::default(),
            supports: Supports::default(),
        }
    }

    /// Measures one node by itself: its bounds, a cone that holds the normals of its faces, and half-edges on its loops
    /// that start at vertices which the node `above` must register too.
    ///
    /// `inherited` is the direction of the slab of the node above, if it has one. The planes that the node is measured
    /// between, if they lean, are added to `supports`.
    pub fn measure(
        &mut self,
        split: &Split,
        at: &Cluster<'_>,
        above: Above,
        inherited: Option<Vec3>,
        supports: &mut Vec<Support>,
    ) -> (NodeBounds, Cone, &[u32]) {
        let mesh = self.mesh;
        let corner_vertices = mesh.faces.as_flattened();
        let vertex = |h: &u32| mesh.positions[corner_vertices[(h & !LAST) as usize] as usize];
        let (cone, along_plane) = self.cone(split, &at.faces);
        let mut bound = None;
        let mut slack = Slack::NONE;
        let mut reach = f32::INFINITY;
        let mut added: &[u32] = &[];
        self.corners.clear();
        let is_corner = |h: &&u32| at.registered[(**h & !LAST) as usize - 3 * at.faces.start];
        if !split.joins_components && at.loops.iter().any(|h| is_corner(&h)) {
            self.points.clear();
            let inside = self.points.extend(at.loops, vertex);
            // A disc of faces without a vertex inside has two vertices more than faces, all on its one loop.
            let own = mesh.own_vertices(&at.faces);
            let end = if at.loops.len() == at.faces.len() + 2 {
                inside
            } else {
                self.points.extend(&mesh.positions[own], |p| *p)
            };
            let along_axis = cone.cos > MIN_FACING;
            let middle = if along_axis { cone.axis } else { split.normal };
            // Where chords cross a hole the polygon lies over it. A slab of a cluster with holes holds only if corners keep
            // them apart, and if the polygon is cut into triangles along a direction that is near the slab's.
            let has_holes = at.loops.iter().rev().skip(1).any(|h| h & LAST != 0);
            let may_have_slab = !has_holes
                || along_axis
                    && !matches!(above, Above::Nothing)
                    && split_loops(at.loops).all(|ring| ring.iter().any(|h| is_corner(&h)));
            if may_have_slab {
                let is_near = |normal: &Vec3| !has_holes || f64::from(normal.dot(middle)) > TURNED_TO;
                let directions = [
                    along_plane.then_some(split.normal).filter(is_near),
                    along_axis.then_some(cone.axis),
                    inherited.filter(|direction| self.may_turn_to(direction.as_dvec3(), middle)),
                ];
                let points = Points { all: &self.points, border: 0..inside, inside: inside..end };
                if let Some(mut slab) = slab::slab(directions.into_iter().flatten(), &points) {
                    if at.faces.len() >= TURNED_FROM {
                        slab = slab::turned(slab, &points, |direction| self.may_turn_to(direction, middle));
                    }
                    let is_large = at.faces.len() >= SUPPORTED_FROM;
                    let found = self.overhang.widen(mesh, at, &mut slab, above, is_large);
                    added = found.added;
                    if is_large && slab.least_height() < WORTH * slab.height() {
                        let apart = self.supports.measure(mesh, at, &slab, &points, found.beyond);
                        if apart[0].max(apart[1]) < WORTH * slab.height() {
                            slab.support(apart);
                            supports.extend(self.supports.found(at.place, apart));
                        }
                    }
                    bound = Some(slab.bound());
                    slack = slab.slack();
                }
            }
            if bound.is_none() {
                self.corners.extend(at.loops.iter().filter(is_corner).map(vertex));
                // A cluster with holes and no slab. Of one that folds over, a spike may lie in its own plane: that says
                // nothing.
                if along_plane {
                    let points = Points { all: &self.points, border: 0..inside, inside: inside..end };
                    let over_plane = slab::slab(std::iter::once(split.normal), &points);
                    reach = over_plane.map_or(reach, |slab| round_up(slab.bound()));
                }
            }
        }
        let from_corners = bound.is_none();
        let bound = match bound {
            Some(bound) => bound,
            // A node that must be refined in every order: the root of a closed surface, a join of components.
            None if self.corners.is_empty() => f64::INFINITY,
            None => {
                let there =
                    distance::from_corners(&self.points, longest_edge(mesh, &at.faces), &mut self.corners);
                let border = Sphere::of_points(at.loops.iter().map(vertex));
                let own = there.max(f64::from(border.radius));
                slack = Slack::of_folded(own);
                EASE * own
            }
        };
        let budget = if bound == f64::INFINITY { f32::INFINITY } else { split.key };
        // Rounding leaves more of it, not less.
        let bound = round_up(bound);
        let is_along_cone = split.normal.dot(cone.axis) > FOLLOWS;
        let fit = match (from_corners, is_along_cone) {
            (true, _) => Fit::Corners,
            (false, false) => Fit::Slab,
            (false, true) if cone.cos > FLAT_CONE => Fit::Flat,
            (false, true) => Fit::AlongCone,
        };
        let reach = reach.min(bound);
        (NodeBounds { bound, reach, budget, fit, slack }, cone, added)
    }

    /// Whether all faces face a direction that is near the one along which the polygon is triangulated.
    fn may_turn_to(&self, direction: DVec3, middle: Vec3) -> bool {
        if direction.dot(middle.as_dvec3()) < TURNED_TO {
            return false;
        }
        let (least, _) = self.normals.extent(self.normals.groups(), direction);
        least > f64::from(MIN_FACING)
    }

    /// The cone of some faces' normals, and whether the plane of their cluster has a side that all of them show.
    fn cone(&mut self, split: &Split, faces: &Range<usize>) -> (Cone, bool) {
        if split.joins_components {
            return (Cone::FULL, false);
        }
        let mesh = self.mesh;
        self.normals.clear();
        let normals = &mesh.face_normals[faces.clone()];
        if mesh.has_flat_face(faces) {
            let with_side: Vec<Vec3> = normals.iter().copied().filter(|n| *n != Vec3::ZERO).collect();
            self.normals.extend(&with_side, |n| *n);
        } else {
            self.normals.extend(normals, |n| *n);
        }
        if split.normal == Vec3::ZERO {
            return (Cone::of_quads(&self.normals), false);
        }
        let (cone, least) = Cone::of_quads_near(&self.normals, split.normal);
        (cone, least > MIN_FACING)
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
