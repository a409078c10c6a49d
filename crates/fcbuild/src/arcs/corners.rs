//! Which vertices each split registers as corners of its children's polygons.

use super::anchors;
use super::curves::CurveRecord;
use super::loops::{LAST, Loops, split_loops};
use crate::bounds::{Above, AllSupports, Cluster, Measurer, NodeBounds, Piece};
use crate::partition::Split;
use crate::tree_order::TreeMesh;
use fcgeom::{Cone, Sphere};
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

    /// Registers the corners of one split.
    fn split(
        &self,
        at: &Child,
        bounds: &NodeBounds,
        registered: &mut [bool],
        memory: &mut Memory<'_>,
        out: &mut Found,
    ) -> [Child; 2] {
        let Child { node, ref faces, .. } = *at;
        let left_faces = self.splits[node].left_faces as usize;
        let middle = faces.start + left_faces;
        let parent = (!self.splits[node].joins_components).then_some(node as u32);
        let above = bounds.bound;
        let direction = (!bounds.is_from_corners()).then(|| bounds.slack.direction().as_vec3());
        let children = [
            Child { node: node + 1, parent, above, direction, faces: faces.start..middle },
            Child { node: node + left_faces, parent, above, direction, faces: middle..faces.end },
        ];
        let mut marks = Marks { mesh: self.mesh, registered, base: 3 * faces.start, node, later: None, out };
        // The ends of arcs around a single face are corners of it.
        let is_face = children.iter().any(|child| child.faces.len() == 1);
        let mut longest = [None; 2];
        for ((i, child), memory) in children.iter().enumerate().zip(&mut memory.loops) {
            let other = &children[1 - i].faces;
            // Both sides see the same ends of arcs; they are recorded once.
            let record = Record { closed_cuts: i == 0, ends: i == 0 && !is_face };
            longest[i] = self.inherit(child, other, record, &mut marks, memory);
        }
        for (i, child) in children.iter().enumerate() {
            // A polygon needs three corners on its longest loop, so that it does not collapse.
            if let Some(entries) = longest[i]
                && child.faces.len() > 1
            {
                self.anchor(entries, &children[1 - i].faces, &mut marks);
            }
        }
        children
    }

    /// Finds which corners of a child its ancestors register, this split included (steps 1 and 2 of `[Tsuji07]` 4.3).
    ///
    /// The child's longest loop comes back if it may have fewer than three corners; `memory` is for its loops.
    fn inherit<'m>(
        &self,
        child: &Child,
        sibling: &Range<usize>,
        record: Record,
        marks: &mut Marks<'_>,
        memory: &'m mut Vec<u32>,
    ) -> Option<&'m [u32]> {
        if child.faces.len() == 1 {
            if record.closed_cuts {
                self.inherit_loop(&face_loop(child.faces.start), sibling, record, marks);
            }
            return None;
        }
        // The first of the longest.
        let mut longest: (&[u32], usize) = (&[], 3);
        for entries in split_loops(self.loops.read(child.node, memory)) {
            let corners = self.inherit_loop(entries, sibling, record, marks);
            if entries.len() > longest.0.len() {
                longest = (entries, corners);
            }
        }
        (longest.1 < 3).then_some(longest.0)
    }

    /// The same for one loop; returns the number of its corners.
    fn inherit_loop(
        &self,
        entries: &[u32],
        sibling: &Range<usize>,
        record: Record,
        marks: &mut Marks<'_>,
    ) -> usize {
        {
            let cut = |h: u32| self.on_cut(h, sibling);
            let Some(&last) = entries.last() else { return 0 };
            let mut after_cut = cut(last & !LAST);
            let mut open = false;
            let mut corners = 0;
            for &h in entries {
                let h = h & !LAST;
                let now_cut = cut(h);
                let ends_here = if now_cut { self.loops.starts_at_end[h as usize] } else { after_cut };
                if now_cut {
                    marks.set(h, ends_here);
                } else if ends_here {
                    marks.set(h, true);
                }
                if ends_here && record.ends {
                    marks.record(self.mesh.origin(h));
                }
                corners += usize::from(if now_cut || ends_here { ends_here } else { marks.get(h) });
                open |= ends_here || !now_cut;
                after_cut = now_cut;
            }
            // A closed cut has no ends: three anchors stand in for them.
            if !open && record.closed_cuts {
                marks.later = self.later(entries, sibling, marks.node);
                self.anchor(entries, sibling, marks);
                marks.later = None;
            }
            corners
        }
    }

    /// When the budget order draws the anchors of a closed cut of a node, if that is later than the cut itself.
    ///
    /// Both clusters may leave the loop out as long as each has a wider one. So is a tunnel between two sheets closed: it
    /// would cost each of them a hole, five triangles and three corners.
    fn later(&self, entries: &[u32], sibling: &Range<usize>, node: usize) -> Option<Later> {
        let Split { left_faces, key, .. } = self.splits[node];
        let sphere = anchors::around(self.mesh, entries);
        let width = 2.0 * sphere.radius;
        let budget = TUNNEL * width;
        if left_faces == 1 || sibling.len() == 1 || budget >= key {
            return None;
        }
        let mut memory = Vec::new();
        let mut has_wider = |node: usize| {
            split_loops(self.loops.read(node, &mut memory))
                .any(|ring| 2.0 * anchors::around(self.mesh, ring).radius > width)
        };
        let is_small = has_wider(node + 1) && has_wider(node + left_faces as usize);
        is_small.then_some(Later { budget, sphere })
    }

    /// Completes a loop's corners to three.
    fn anchor(&self, entries: &[u32], sibling: &Range<usize>, marks: &mut Marks<'_>) {
        let mut chosen: Vec<usize> =
            (0..entries.len()).filter(|&i| marks.get(entries[i] & !LAST)).take(3).collect();
        let had = chosen.len();
        anchors::complete(self.mesh, self.splits, marks.node, entries, &mut chosen);
        for &i in &chosen[had..] {
            let h = entries[i] & !LAST;
            let before = entries[if i == 0 { entries.len() - 1 } else { i - 1 }] & !LAST;
            marks.set(h, true);
            marks.record(self.mesh.origin(h));
            // The sibling's half-edge that starts at the same vertex of the cut.
            if self.on_cut(before, sibling) {
                marks.set(self.mesh.opposite[before as usize], true);
            }
        }
    }

    fn on_cut(&self, half_edge: u32, sibling: &Range<usize>) -> bool {
        let across = self.mesh.opposite[half_edge as usize];
        (3 * sibling.start..3 * sibling.end).contains(&(across as usize))
    }
}

/// What the width of a closed cut is worth in the budget order: the surface that a lid over it leaves out, or adds, and
/// the triangles that are saved, make it a fifth or so. With 0.15 to 0.6 the mean errors are within 0.3 % of each other.
const TUNNEL: f32 = 0.2;

/// Anchors that the budget order draws later than their cut: the key, and what they are around.
#[derive(Clone, Copy)]
struct Later {
    budget: f32,
    sphere: Sphere,
}

/// What of a child's cut is registered: both children see the same cut.
#[derive(Clone, Copy)]
struct Record {
    ends: bool,
    closed_cuts: bool,
}

fn face_loop(face: usize) -> [u32; 3] {
    let h = 3 * face as u32;
    [h, h + 1, (h + 2) | LAST]
}

/// The corner marks of a split's faces, and the list that its registrations go to.
struct Marks<'a> {
    mesh: &'a TreeMesh,
    registered: &'a mut [bool],
    base: usize,
    node: usize,
    later: Option<Later>,
    out: &'a mut Found,
}

impl Marks<'_> {
    fn get(&self, half_edge: u32) -> bool {
        self.registered[half_edge as usize - self.base]
    }

    fn set(&mut self, half_edge: u32, is_corner: bool) {
        self.registered[half_edge as usize - self.base] = is_corner;
    }

    fn record(&mut self, vertex: u32) {
        let vertex = self.mesh.weld[vertex as usize];
        let node = self.node as u32;
        let Some(Later { budget, sphere }) = self.later else {
            self.out.registrations.push(Registration { vertex, node });
            return;
        };
        self.out.registrations.push(Registration { vertex, node: node | BOUND_ONLY });
        self.out.anchors.push(CurveRecord { vertex, bound: 0.0, budget: f64::from(budget), sphere });
    }
}
