//! Which vertices each split registers as corners of its children's polygons.

mod cut;

use super::curves::CurveRecord;
use super::loops::{LAST, Loops};
use crate::bounds::{Above, AllSupports, Cluster, Measurer, NodeBounds, Piece};
use crate::partition::Split;
use crate::tree_order::TreeMesh;
use fcgeom::Cone;
use glam::Vec3;
use std::ops::Range;

/// A vertex that must be drawn whenever a node is refined.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Registration {
    /// The welded vertex (see [`TreeMesh::weld`]).
    pub vertex: u32,
    /// The node whose split needs it, with [`BOUND_ONLY`] or without.
    pub node: u32,
}

/// Set where only the distance bound needs a vertex. The budget order leaves it out, or draws it later: there it would
/// cost triangles that lower the mean error more elsewhere, and a bound that is printed counts it as left out.
pub const BOUND_ONLY: u32 = 1 << 31;

/// What the walk down the tree finds.
pub struct Registered {
    /// Registrations in pieces; in each piece, and from piece to piece, ancestors come before descendants.
    ///
    /// A split that leaves a single face needs all corners of it; they are not among these.
    pub registrations: Vec<Vec<Registration>>,
    /// When the budget order draws the anchors of small closed cuts.
    pub anchors: Vec<CurveRecord>,
    /// The nested bounds of each node.
    pub nodes: Vec<NodeBounds>,
    /// The normal cone of each node.
    pub cones: Vec<Cone>,
    /// Planes that clusters are measured between, in the order of the nodes.
    pub supports: AllSupports,
}

/// What a stretch of the walk finds, besides the measures of nodes.
struct Found {
    registrations: Vec<Registration>,
    anchors: Vec<CurveRecord>,
    supports: Piece,
}

/// Walks the tree from the root down, registers corners, and measures each interior node once it has got its corners.
///
/// `anchored` says of each vertex whether it is drawn in every mesh; `count` is told of faces that are done, from any thread.
pub fn register(
    mesh: &TreeMesh,
    splits: &[Split],
    loops: &Loops,
    anchored: &[bool],
    count: &(dyn Fn(u64) + Sync),
) -> Registered {
    let mut nodes = vec![NodeBounds::UNKNOWN; splits.len()];
    let mut cones = vec![Cone::FULL; splits.len()];
    if splits.is_empty() {
        // A single face: nothing is split, its corners are always drawn.
        let (registrations, anchors) = (Vec::new(), Vec::new());
        return Registered { registrations, anchors, nodes, cones, supports: AllSupports::default() };
    }
    let mut registered: Vec<bool> = vec![false; mesh.opposite.len()];
    for &h in loops.read(0, &mut Vec::new()) {
        registered[(h & !LAST) as usize] = anchored[mesh.origin(h & !LAST) as usize];
    }
    let walk = Walk { mesh, splits, loops, count };
    let root =
        Child { node: 0, parent: None, above: f32::INFINITY, direction: None, faces: 0..mesh.faces.len() };
    let measured = Measured { nodes: &mut nodes, cones: &mut cones };
    let mut found = walk.descend(root, &mut registered, measured);
    let anchors = found.iter_mut().flat_map(|found| std::mem::take(&mut found.anchors)).collect();
    let (registrations, supports): (_, Vec<Piece>) =
        found.into_iter().map(|found| (found.registrations, found.supports)).unzip();
    let supports = AllSupports::of_pieces(supports.into_iter());
    Registered { registrations, anchors, nodes, cones, supports }
}

struct Walk<'a> {
    mesh: &'a TreeMesh,
    splits: &'a [Split],
    loops: &'a Loops,
    count: &'a (dyn Fn(u64) + Sync),
}

/// Below this many faces a subtree stays on one thread.
const SERIAL_BELOW: usize = 4096;

/// One child of a split.
#[derive(Clone)]
struct Child {
    node: usize,
    /// The node that is split into this one, if that can register more corners: a join of components would register
    /// them for every mesh.
    parent: Option<u32>,
    /// The bound of that node, and the direction of its slab if it has one.
    above: f32,
    direction: Option<Vec3>,
    faces: Range<usize>,
}

impl Child {
    fn above(&self) -> Above {
        match self.parent {
            None => Above::Nothing,
            Some(_) if self.above.is_finite() => Above::Drawn(f64::from(self.above)),
            Some(_) => Above::NeverDrawn,
        }
    }
}

/// What one thread works with.
struct Memory<'a> {
    measurer: Measurer<'a>,
    /// Those of a node, or of its two children.
    loops: [Vec<u32>; 2],
}

impl<'a> Memory<'a> {
    fn new(mesh: &'a TreeMesh) -> Memory<'a> {
        Memory { measurer: Measurer::new(mesh), loops: [Vec::new(), Vec::new()] }
    }
}

/// Where the measures of a node and of all below it go.
struct Measured<'m> {
    nodes: &'m mut [NodeBounds],
    cones: &'m mut [Cone],
}

impl<'m> Measured<'m> {
    /// The places of the node itself, and those of the subtree of a left child of so many faces and of the right one.
    fn split(self, left_faces: usize) -> Option<(&'m mut NodeBounds, &'m mut Cone, [Measured<'m>; 2])> {
        let (bounds, nodes) = self.nodes.split_first_mut()?;
        let (cone, cones) = self.cones.split_first_mut()?;
        let (nodes_l, nodes_r) = nodes.split_at_mut(left_faces - 1);
        let (cones_l, cones_r) = cones.split_at_mut(left_faces - 1);
        let below = [(nodes_l, cones_l), (nodes_r, cones_r)].map(|(nodes, cones)| Measured { nodes, cones });
        Some((bounds, cone, below))
    }
}

impl Walk<'_> {
    /// Measures a node and registers what its split needs, and all below.
    ///
    /// `registered` holds, for each half-edge of the node's faces that lies on a boundary, whether its start is a
    /// corner registered by an ancestor.
    fn descend(&self, at: Child, registered: &mut [bool], places: Measured<'_>) -> Vec<Found> {
        let supports = Piece { first: at.node as u32, supports: Vec::new() };
        let mut own = Found { registrations: Vec::new(), anchors: Vec::new(), supports };
        if at.faces.len() < SERIAL_BELOW {
            let faces = at.faces.len() as u64;
            self.descend_serial(at, registered, places, &mut Memory::new(self.mesh), &mut own);
            (self.count)(faces);
            own.registrations.shrink_to_fit();
            own.supports.supports.shrink_to_fit();
            return vec![own];
        }
        let left_faces = self.splits[at.node].left_faces as usize;
        let Some((bounds, cone, [places_l, places_r])) = places.split(left_faces) else { return Vec::new() };
        // The memory of a large cluster goes before there is more of it.
        (*bounds, *cone) = self.measure(&at, registered, &mut Memory::new(self.mesh), &mut own);
        let memory = &mut Memory::new(self.mesh);
        let [left, right] = self.split(&at, bounds, registered, memory, &mut own);
        let (registered_l, registered_r) = registered.split_at_mut(3 * left_faces);
        let (nodes_l, nodes_r) = (&mut *places_l.nodes, &mut *places_r.nodes);
        let (l, r) = rayon::join(
            || self.descend(left, registered_l, Measured { nodes: &mut *nodes_l, cones: places_l.cones }),
            || self.descend(right, registered_r, Measured { nodes: &mut *nodes_r, cones: places_r.cones }),
        );
        bounds.nest([nodes_l.first(), nodes_r.first()]);
        let mut pieces = vec![own];
        pieces.extend(l);
        pieces.extend(r);
        pieces
    }

    fn descend_serial(
        &self,
        at: Child,
        registered: &mut [bool],
        places: Measured<'_>,
        memory: &mut Memory<'_>,
        out: &mut Found,
    ) {
        if places.nodes.is_empty() {
            return;
        }
        let left_faces = self.splits[at.node].left_faces as usize;
        let Some((bounds, cone, [places_l, places_r])) = places.split(left_faces) else { return };
        (*bounds, *cone) = self.measure(&at, registered, memory, out);
        let [left, right] = self.split(&at, bounds, registered, memory, out);
        let (registered_l, registered_r) = registered.split_at_mut(3 * left_faces);
        let (nodes_l, nodes_r) = (&mut *places_l.nodes, &mut *places_r.nodes);
        let places_l = Measured { nodes: &mut *nodes_l, cones: places_l.cones };
        let places_r = Measured { nodes: &mut *nodes_r, cones: places_r.cones };
        self.descend_serial(left, registered_l, places_l, memory, out);
        self.descend_serial(right, registered_r, places_r, memory, out);
        bounds.nest([nodes_l.first(), nodes_r.first()]);
    }

    /// Measures a node, and registers the corners that its bound counts on.
    fn measure(
        &self,
        at: &Child,
        registered: &mut [bool],
        memory: &mut Memory<'_>,
        out: &mut Found,
    ) -> (NodeBounds, Cone) {
        let Memory { measurer, loops: [loops, _] } = memory;
        let loops = self.loops.read(at.node, loops);
        // Pieces are subtrees of few faces, or single nodes.
        let place = (at.node as u32 - out.supports.first) as u16;
        let cluster = Cluster { place, faces: at.faces.clone(), loops, registered };
        let (bounds, cone, added) = measurer.measure(
            &self.splits[at.node],
            &cluster,
            at.above(),
            at.direction,
            &mut out.supports.supports,
        );
        for &h in added {
            registered[h as usize - 3 * at.faces.start] = true;
            let vertex = self.mesh.weld[self.mesh.origin(h) as usize];
            out.registrations.extend(at.parent.map(|node| Registration { vertex, node: node | BOUND_ONLY }));
        }
        (bounds, cone)
    }
}
