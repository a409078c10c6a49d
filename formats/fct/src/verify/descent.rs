//! One walk from the root, which meets nodes, faces, loops, bounding polygons and groups in file order.
//!
//! The walk ends on any bytes: each step is checked to go where preorder says, so nothing is met twice.
//! Its stack holds one waiting sibling and one open node a level, and levels are limited.

use std::ops::Range;

use crate::child::Child;
use crate::error::Violation;
use crate::loops::{Loops, read_stored};
use crate::node::Node;
use crate::outline::stores_loops;
use crate::records::MAX_DEPTH;
use crate::rule::Rule;
use crate::subtree::{Place, Subtree};
use crate::tree::Tree;
use crate::walk::{Reader, to_index};

use super::attached::Groups;
use super::boundary;
use super::cones::Cones;
use super::polygons::Polygons;
use super::{activity, spheres, values};

/// What the walk found out about the whole.
pub(crate) struct Found {
    /// Child references on the longest way from the root to a face.
    pub(crate) depth: u32,
    /// Whether some edge has a face on one side only.
    pub(crate) has_boundary: bool,
    /// Entries in the loops of all nodes.
    pub(crate) loop_entries: u64,
}

/// What is left to do, innermost last.
enum Step {
    /// Look at a subtree whose root lies `depth` references below the root, under a node.
    Enter { subtree: Subtree, parent: Option<Above>, depth: u32 },
    /// All faces of a node were met.
    Leave { subtree: Subtree, node: Node, stores: bool, before: Before, polygon: Option<usize> },
}

/// The node above a subtree.
#[derive(Clone, Copy)]
struct Above {
    node: Node,
    stores: bool,
}

/// What the walk had met when it came to a node.
#[derive(Clone, Copy)]
struct Before {
    boundary_sum: u64,
    used_vertices: u32,
}

/// Faces between two words of how far the walk is.
const TOLD_EVERY: u32 = 1 << 12;

/// Walks; `done` is told how many faces were met, at the begin and again and again.
pub(crate) fn check(
    tree: &Tree,
    reader: &Reader<'_>,
    done: &mut dyn FnMut(u64),
) -> Result<Found, Box<Violation>> {
    let mut walk = Walk {
        reader,
        polygons: Polygons::new(tree.bounding_polygons()),
        groups: Groups::new(tree.groups(), tree.meta().group_names.len()),
        cones: Cones::default(),
        loops: Loops::default(),
        used_vertices: 0,
        used_tops: 0,
        top_loop_end: 0,
        loop_end: 0,
        boundary_sum: 0,
        found: Found { depth: 0, has_boundary: false, loop_entries: 0 },
        stack: Vec::new(),
    };
    walk.stack.push(Step::Enter { subtree: reader.whole(), parent: None, depth: 0 });
    let mut told = 0;
    done(0);
    while let Some(step) = walk.stack.pop() {
        match step {
            Step::Enter { subtree, parent, depth } => {
                if subtree.first_face.saturating_sub(told) >= TOLD_EVERY {
                    told = subtree.first_face;
                    done(u64::from(told));
                }
                walk.groups.check(&subtree)?;
                match subtree.child.kind() {
                    Child::Node(index) => walk.enter_node(index, subtree, parent, depth)?,
                    Child::Face(_) => walk.enter_face(&subtree, parent, depth)?,
                }
            }
            Step::Leave { subtree, node, stores, before, polygon } => {
                walk.leave_node(&subtree, &node, stores, before, polygon)?;
            }
        }
    }
    walk.polygons.check_all()?;
    walk.groups.check_all()?;
    walk.check_ends()?;
    walk.found.has_boundary = walk.boundary_sum != 0;
    Ok(walk.found)
}

struct Walk<'a> {
    reader: &'a Reader<'a>,
    polygons: Polygons<'a>,
    groups: Groups<'a>,
    cones: Cones,
    loops: Loops,
    /// Vertices met so far: all below this, since they stand in order of first use.
    used_vertices: u32,
    /// Nodes above the pages met so far: all below this, since they stand in preorder.
    used_tops: u32,
    /// Bytes of section `TOPL` and of section `LOOP` that nodes met so far own.
    top_loop_end: usize,
    loop_end: usize,
    boundary_sum: u64,
    found: Found,
    stack: Vec<Step>,
}

impl Walk<'_> {
    fn enter_node(
        &mut self,
        index: u32,
        subtree: Subtree,
        parent: Option<Above>,
        depth: u32,
    ) -> Result<(), Box<Violation>> {
        // Its faces lie one deeper at least.
        if depth >= MAX_DEPTH {
            return Err(Violation::new(
                Rule::Depth,
                subtree.to_string(),
                format!("it lies {depth} below the root"),
            ));
        }
        let node = self.reader.decode(&subtree)?;
        values::check_node(&subtree, &node)?;
        if let Some(parent) = parent {
            check_keys(&parent.node, &node, &subtree)?;
            spheres::check_nested(&parent.node, &node, &subtree)?;
        }
        let stores = self.claim_loops(&subtree, parent)?;
        let [left, right] = self.reader.split(&subtree)?;
        self.cones.check(&node, &subtree, self.reader)?;
        let before = Before { boundary_sum: self.boundary_sum, used_vertices: self.used_vertices };
        let polygon = self.polygons.meet(index)?;
        self.stack.push(Step::Leave { subtree, node, stores, before, polygon });
        for subtree in [right, left] {
            let parent = Some(Above { node, stores });
            self.stack.push(Step::Enter { subtree, parent, depth: depth.saturating_add(1) });
        }
        Ok(())
    }

    /// Checks that the bytes of a node's loops follow those of the node before it. Says whether it has any.
    fn claim_loops(&mut self, subtree: &Subtree, parent: Option<Above>) -> Result<bool, Box<Violation>> {
        let broken = |rule, found| Err(Violation::new(rule, subtree.to_string(), found));
        match subtree.place {
            Place::Top { record } => {
                if record != self.used_tops {
                    return broken(Rule::ChildPlace, format!("it is met as number {}", self.used_tops));
                }
                self.used_tops = self.used_tops.saturating_add(1);
                let top = to_index(record).and_then(|i| self.reader.tops.get(i));
                let range =
                    top.and_then(|t| Some(to_index(t.loop_start.get())?..to_index(t.loop_end.get())?));
                let Some(Range { start, end }) = range.filter(|r| r.start <= r.end) else {
                    return broken(Rule::LoopRange, "its loops end before they begin".to_owned());
                };
                if start != self.top_loop_end {
                    let found = format!("its loops begin at byte {start}, expected {}", self.top_loop_end);
                    return broken(Rule::LoopCover, found);
                }
                self.top_loop_end = end;
                Ok(true)
            }
            Place::Page { page, record, loops } => {
                let node = to_index(record).and_then(|i| self.reader.nodes.get(i));
                let page = to_index(page).and_then(|i| self.reader.pages.get(i));
                let (Some(node), Some(page)) = (node, page) else {
                    return broken(Rule::ChildPlace, "its record is not there".to_owned());
                };
                if !stores_loops(node, subtree.face_count()) {
                    return Ok(false);
                }
                if parent.is_some_and(|p| !p.stores) {
                    return broken(Rule::LoopCover, "it stores loops and its parent does not".to_owned());
                }
                let start = to_index(page.first_loop.get().saturating_add(loops)).unwrap_or(usize::MAX);
                if start != self.loop_end {
                    let found = format!("its loops begin at byte {start}, expected {}", self.loop_end);
                    return broken(Rule::LoopCover, found);
                }
                // The skip of two bytes comes first.
                let own = start.saturating_add(2);
                match self.reader.loops.get(own..).and_then(|bytes| read_stored(bytes, |_| {})) {
                    Some(length) => self.loop_end = own.saturating_add(length),
                    None => return broken(Rule::LoopRange, "its loops do not end".to_owned()),
                }
                Ok(true)
            }
        }
    }

    fn leave_node(
        &mut self,
        subtree: &Subtree,
        node: &Node,
        stores: bool,
        before: Before,
        polygon: Option<usize>,
    ) -> Result<(), Box<Violation>> {
        self.reader.load_loops(subtree, &mut self.loops)?;
        let entries = u64::try_from(self.loops.vertices.len()).unwrap_or(u64::MAX);
        self.found.loop_entries = self.found.loop_entries.saturating_add(entries);
        let of_faces = self.boundary_sum.wrapping_sub(before.boundary_sum);
        boundary::check(subtree, node, &self.loops, !stores, of_faces)?;
        if let Some(place) = polygon {
            let first_used = before.used_vertices..self.used_vertices;
            self.polygons.check(place, node, &self.loops.vertices, first_used, self.reader.vertices)?;
        }
        Ok(())
    }

    fn enter_face(
        &mut self,
        subtree: &Subtree,
        parent: Option<Above>,
        depth: u32,
    ) -> Result<(), Box<Violation>> {
        self.found.depth = self.found.depth.max(depth);
        let corners = self.reader.corners(subtree)?;
        for corner in corners {
            if corner > self.used_vertices {
                return Err(Violation::new(
                    Rule::VertexOrder,
                    subtree.to_string(),
                    format!("it uses vertex {corner} before vertex {}", self.used_vertices),
                ));
            }
            if corner == self.used_vertices {
                self.used_vertices = self.used_vertices.saturating_add(1);
            }
        }
        if let Some(Above { node: parent, .. }) = parent {
            spheres::check_face(&parent, subtree, corners, self.reader.vertices)?;
            activity::check_face(&parent, subtree, corners, self.reader.vertices)?;
        }
        self.boundary_sum = self.boundary_sum.wrapping_add(boundary::face_number(corners));
        Ok(())
    }

    /// After the last face nothing may be left over.
    fn check_ends(&self) -> Result<(), Box<Violation>> {
        let reader = self.reader;
        let broken =
            |rule, section: &str, found| Err(Violation::new(rule, format!("section {section}"), found));
        if to_index(self.used_vertices) != Some(reader.vertices.len()) {
            let found = format!("the faces use {} of {} vertices", self.used_vertices, reader.vertices.len());
            return broken(Rule::VertexOrder, "VERT", found);
        }
        let ends = [
            ("LOOP", self.loop_end, reader.loops.len()),
            ("TOPL", self.top_loop_end, reader.top_loops.len()),
        ];
        for (section, end, all) in ends {
            if end != all {
                return broken(Rule::LoopCover, section, format!("nodes own {end} of its {all} bytes"));
            }
        }
        Ok(())
    }
}

fn check_keys(parent: &Node, child: &Node, place: &Subtree) -> Result<(), Box<Violation>> {
    let keys = [("bound", parent.bound, child.bound), ("budget key", parent.budget, child.budget)];
    for (what, above, below) in keys {
        if below > above {
            return Err(Violation::new(
                Rule::KeyOrder,
                place.to_string(),
                format!("its {what} is {below:e}, its parent's {above:e}"),
            ));
        }
    }
    Ok(())
}
