//! Which vertices a split needs, found from the boundaries of the two children.
//!
//! The file says of a vertex how eager it is to be drawn, and not which splits asked for it. Whoever refines a node
//! that no tolerance refines finds out here what has to be drawn for that.

use crate::{Error, Order};
use fct::{Child, Loops, Reader, Subtree};

/// Finds what splits need; keeps its memory from one to the next.
#[derive(Debug, Default)]
pub(crate) struct Corners {
    loops: [Loops; 2],
    /// Directed edges of the other child's loops, sorted.
    edges: Vec<(u32, u32)>,
    /// Vertices that one child's loops pass more than once, sorted.
    twice: Vec<u32>,
    needed: Vec<u32>,
}

impl Corners {
    /// The vertices that must be drawn when a node with this key is split into `children`, some of them more than once.
    ///
    /// They are the ends of the boundary between the children: where three clusters meet, or two and the mesh's
    /// border, polygons would leave a hole if that vertex were left out. A child of a single face needs all its
    /// corners. A loop of fewer than three would vanish; there the anchors that the builder chose are needed too,
    /// which are among the vertices with no smaller key than the node.
    ///
    /// # Paper
    /// `[Tsuji07]` 4.3, steps 1 and 2.
    pub(crate) fn of_split(
        &mut self,
        reader: &Reader<'_>,
        children: &[Subtree; 2],
        order: Order,
        key: f32,
        is_drawn: impl Fn(u32) -> bool,
    ) -> Result<&[u32], Error> {
        self.needed.clear();
        for (child, loops) in children.iter().zip(&mut self.loops) {
            reader.read_loops(child, loops)?;
            if let Child::Face(_) = child.child.kind() {
                self.needed.extend(&loops.vertices);
            }
        }
        for (own, other) in [(0, 1), (1, 0)] {
            self.add_ends(own, other);
        }
        let records = reader.vertices();
        let ends = self.needed.len();
        let [left, right] = &self.loops;
        for ring in left.iter().chain(right.iter()) {
            let (ends, _) = self.needed.split_at(ends);
            if ring.iter().filter(|v| is_drawn(**v) || ends.contains(v)).count() < 3 {
                let as_eager = |v: &u32| records.get(*v as usize).is_some_and(|r| order.of_vertex(r) >= key);
                self.needed.extend(ring.iter().copied().filter(as_eager));
            }
        }
        Ok(&self.needed)
    }

    /// Adds the vertices of one child's loops where its boundary with the other one begins, ends or crosses itself.
    fn add_ends(&mut self, own: usize, other: usize) {
        let Corners { loops, edges, twice, needed } = self;
        let (Some(own), Some(other)) = (loops.get(own), loops.get(other)) else { return };
        edges.clear();
        for ring in other.iter() {
            let after = ring.iter().skip(1).chain(ring.first());
            edges.extend(ring.iter().copied().zip(after.copied()));
        }
        edges.sort_unstable();
        twice.clear();
        twice.extend(&own.vertices);
        twice.sort_unstable();
        let mut before = None;
        twice.retain(|v| before.replace(*v) == Some(*v));
        for ring in own.iter() {
            let is_shared = |from: u32, to: u32| edges.binary_search(&(to, from)).is_ok();
            let (Some(&first), Some(&last)) = (ring.first(), ring.last()) else { continue };
            let mut behind = is_shared(last, first);
            for (i, &vertex) in ring.iter().enumerate() {
                let ahead = is_shared(vertex, ring.get(i + 1).copied().unwrap_or(first));
                let crosses = (ahead || behind) && twice.binary_search(&vertex).is_ok();
                if ahead != behind || crosses {
                    needed.push(vertex);
                }
                behind = ahead;
            }
        }
    }
}
