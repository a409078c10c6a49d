//! One walk from the root, which meets nodes, faces, loops, bounding polygons and groups in file order.
//!
//! The walk ends on any bytes: each step is checked to go where preorder says, so nothing is met twice.
//! Its stack holds one waiting sibling and one open node a level, and levels are limited.

use crate::child::Child;
use crate::error::Violation;
use crate::records::{FaceRecord, MAX_DEPTH, NodeRecord, VertexRecord};
use crate::rule::Rule;
use crate::tree::Tree;
use crate::walk::{Subtree, children_of, loops_of, node_place, to_index};

use super::attached::Groups;
use super::boundary::{self, Covered};
use super::cones::Cones;
use super::polygons::Polygons;
use super::{activity, spheres, values};

/// What the walk found out about the whole.
pub(crate) struct Found {
    /// Child references on the longest way from the root to a face.
    pub(crate) depth: u32,
    /// Whether some edge has a face on one side only.
    pub(crate) has_boundary: bool,
}

/// What is left to do, innermost last.
enum Step {
    /// Look at a subtree whose root lies `depth` references below the root, under the node `parent`.
    Enter { subtree: Subtree, parent: Option<u32>, depth: u32 },
    /// All faces of a node were met.
    Leave { index: u32, subtree: Subtree, before: Before, polygon: Option<usize> },
}

/// What the walk had met when it came to a node.
#[derive(Clone, Copy)]
struct Before {
    boundary_sum: u64,
    used_vertices: u32,
}

pub(crate) fn check(tree: &Tree, covered: &mut Covered) -> Result<Found, Box<Violation>> {
    let mut walk = Walk {
        nodes: tree.nodes(),
        faces: tree.faces(),
        vertices: tree.vertices(),
        polygons: Polygons::new(tree.bounding_polygons()),
        groups: Groups::new(tree.groups(), tree.meta().group_names.len()),
        cones: Cones::default(),
        used_vertices: 0,
        boundary_sum: 0,
        deepest: 0,
        stack: Vec::new(),
    };
    let loops = tree.loops();
    walk.stack.push(Step::Enter { subtree: tree.whole(), parent: None, depth: 0 });
    while let Some(step) = walk.stack.pop() {
        match step {
            Step::Enter { subtree, parent, depth } => {
                walk.groups.check(&subtree)?;
                match subtree.child.kind() {
                    Child::Node(index) => walk.enter_node(index, subtree, parent, depth)?,
                    Child::Face(index) => walk.enter_face(index, parent, depth)?,
                }
            }
            Step::Leave { index, subtree, before, polygon } => {
                let node = walk.node(index)?;
                let own = loops_of(node, loops, walk.vertices.len(), index)?;
                covered.claim(index, node)?;
                let of_faces = walk.boundary_sum.wrapping_sub(before.boundary_sum);
                boundary::check(index, node, own, of_faces)?;
                if let Some(place) = polygon {
                    let first_used = before.used_vertices..walk.used_vertices;
                    let cluster = subtree.of(walk.faces);
                    walk.polygons.check(place, cluster, first_used, walk.vertices)?;
                }
            }
        }
    }
    walk.polygons.check_all()?;
    walk.groups.check_all()?;
    covered.check_all(loops)?;
    if to_index(walk.used_vertices) != Some(walk.vertices.len()) {
        return Err(Violation::new(
            Rule::VertexOrder,
            "section VERT".to_owned(),
            format!("the faces use {} of {} vertices", walk.used_vertices, walk.vertices.len()),
        ));
    }
    Ok(Found { depth: walk.deepest, has_boundary: walk.boundary_sum != 0 })
}

struct Walk<'a> {
    nodes: &'a [NodeRecord],
    faces: &'a [FaceRecord],
    vertices: &'a [VertexRecord],
    polygons: Polygons<'a>,
    groups: Groups<'a>,
    cones: Cones,
    /// Vertices met so far: all below this, since they stand in order of first use.
    used_vertices: u32,
    boundary_sum: u64,
    deepest: u32,
    stack: Vec<Step>,
}

impl<'a> Walk<'a> {
    fn node(&self, index: u32) -> Result<&'a NodeRecord, Box<Violation>> {
        to_index(index).and_then(|i| self.nodes.get(i)).ok_or_else(|| {
            let found = format!("there are {} nodes", self.nodes.len());
            Violation::new(Rule::ChildPlace, node_place(index), found)
        })
    }

    fn enter_node(
        &mut self,
        index: u32,
        subtree: Subtree,
        parent: Option<u32>,
        depth: u32,
    ) -> Result<(), Box<Violation>> {
        let node = self.node(index)?;
        // Its faces lie one deeper at least.
        if depth >= MAX_DEPTH {
            return Err(Violation::new(
                Rule::Depth,
                node_place(index),
                format!("it lies {depth} below the root"),
            ));
        }
        if node.first_face.get() != subtree.first_face {
            return Err(Violation::new(
                Rule::FaceRange,
                node_place(index),
                format!("its faces begin at {}, expected {}", node.first_face.get(), subtree.first_face),
            ));
        }
        values::check_node(index, node)?;
        if let Some(parent) = parent {
            let parent = self.node(parent)?;
            check_keys(parent, node, index)?;
            spheres::check_nested(parent, node, index)?;
        }
        let [left, right] = children_of(node, self.nodes, index, subtree.face_end)?;
        self.cones.check(index, node, &subtree, self.faces, self.vertices)?;
        let before = Before { boundary_sum: self.boundary_sum, used_vertices: self.used_vertices };
        let polygon = self.polygons.meet(index)?;
        self.stack.push(Step::Leave { index, subtree, before, polygon });
        for subtree in [right, left] {
            self.stack.push(Step::Enter { subtree, parent: Some(index), depth: depth.saturating_add(1) });
        }
        Ok(())
    }

    fn enter_face(&mut self, index: u32, parent: Option<u32>, depth: u32) -> Result<(), Box<Violation>> {
        self.deepest = self.deepest.max(depth);
        let face = to_index(index).and_then(|i| self.faces.get(i));
        let Some(corners) = face.map(FaceRecord::indices) else {
            return Err(Violation::new(
                Rule::ChildPlace,
                format!("section FACE, face {index}"),
                format!("there are {} faces", self.faces.len()),
            ));
        };
        for corner in corners {
            self.meet_vertex(index, corner)?;
        }
        if let Some(parent) = parent {
            let parent = self.node(parent)?;
            spheres::check_face(parent, index, corners, self.vertices)?;
            activity::check_face(parent, index, corners, self.vertices)?;
        }
        self.boundary_sum = self.boundary_sum.wrapping_add(boundary::face_number(corners));
        Ok(())
    }

    fn meet_vertex(&mut self, face: u32, corner: u32) -> Result<(), Box<Violation>> {
        let broken = |rule, found| Err(Violation::new(rule, format!("section FACE, face {face}"), found));
        if to_index(corner).is_none_or(|v| v >= self.vertices.len()) {
            return broken(Rule::VertexIndex, format!("it uses vertex {corner} of {}", self.vertices.len()));
        }
        if corner > self.used_vertices {
            return broken(
                Rule::VertexOrder,
                format!("it uses vertex {corner} before vertex {}", self.used_vertices),
            );
        }
        if corner == self.used_vertices {
            self.used_vertices = self.used_vertices.saturating_add(1);
        }
        Ok(())
    }
}

fn check_keys(parent: &NodeRecord, child: &NodeRecord, index: u32) -> Result<(), Box<Violation>> {
    let keys = [("bound", parent.bound, child.bound), ("budget key", parent.budget, child.budget)];
    for (what, above, below) in keys {
        let (above, below) = (above.get(), below.get());
        if below > above {
            return Err(Violation::new(
                Rule::KeyOrder,
                node_place(index),
                format!("its {what} is {below:e}, its parent's {above:e}"),
            ));
        }
    }
    Ok(())
}
