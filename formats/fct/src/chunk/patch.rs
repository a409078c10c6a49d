//! Nodes of the crown and of chunks' tops, made ready to be drawn with the vertices that are at hand.

use std::collections::HashMap;
use std::path::Path;

use zerocopy::little_endian::U32;

use crate::child::ChildRef;
use crate::loops::Loops;
use crate::pack::encode_top;
use crate::records::{LOOP_END, TopRecord, VertexRecord};
use crate::subtree::{Place, Subtree};
use crate::walk::Reader;

/// Some nodes with vertices of their own; reuse it to keep its memory.
///
/// Which vertices stand on the loops is for the caller to say: all nodes must see the same.
#[derive(Debug, Default)]
pub struct Patch {
    tops: Vec<TopRecord>,
    loops: Vec<u8>,
    corners: Vec<U32>,
    vertices: Vec<VertexRecord>,
    ids: Vec<u32>,
    numbers: HashMap<u32, u32>,
    entries: Vec<u32>,
}

impl Patch {
    /// Forgets all nodes.
    pub fn clear(&mut self) {
        self.tops.clear();
        self.loops.clear();
        self.corners.clear();
        self.vertices.clear();
        self.ids.clear();
        self.numbers.clear();
    }

    /// Adds a node with those vertices of its loops for which there is a record, and says how to draw it.
    ///
    /// `top` is its record, of which loops and children mean nothing, and `corner` the first corner of its first face.
    /// None if there is no record of that.
    pub fn push(
        &mut self,
        mut top: TopRecord,
        loops: &Loops,
        (corner, stored): (u32, VertexRecord),
        mut record: impl FnMut(u32) -> Option<VertexRecord>,
    ) -> Option<Subtree> {
        top.loop_start = u32::try_from(self.loops.len()).ok()?.into();
        self.entries.clear();
        for ring in loops.iter() {
            let start = self.entries.len();
            for id in ring {
                if let Some(number) = self.number(*id, &mut record) {
                    self.entries.push(number);
                }
            }
            // One of fewer than two vertices is no loop.
            if self.entries.len() < start.saturating_add(2) {
                self.entries.truncate(start);
            } else if let Some(last) = self.entries.last_mut() {
                *last |= LOOP_END;
            }
        }
        encode_top(&self.entries, &mut self.loops);
        top.loop_end = u32::try_from(self.loops.len()).ok()?.into();
        let corner = self.number(corner, |_| Some(stored))?;
        let index = u32::try_from(self.tops.len()).ok()?;
        self.corners.push(corner.into());
        self.tops.push(top);
        Some(Subtree {
            child: ChildRef::node(index),
            first_face: 0,
            face_end: 2,
            place: Place::Top { record: index },
        })
    }

    /// The nodes as a stitcher reads them; vertices are those of the patch.
    pub fn reader(&self) -> Reader<'_> {
        Reader {
            tops: &self.tops,
            top_loops: &self.loops,
            top_corners: &self.corners,
            pages: &[],
            nodes: &[],
            faces: &[],
            links: &[],
            loops: &[],
            vertices: &self.vertices,
            path: Path::new("<crown>"),
        }
    }

    /// The names of its vertices in the whole tree.
    pub fn ids(&self) -> &[u32] {
        &self.ids
    }

    /// The number here of a vertex; it gets one if there is a record of it.
    fn number(&mut self, id: u32, record: impl FnOnce(u32) -> Option<VertexRecord>) -> Option<u32> {
        if let Some(number) = self.numbers.get(&id) {
            return Some(*number);
        }
        let record = record(id)?;
        let number = u32::try_from(self.vertices.len()).ok()?;
        self.vertices.push(record);
        self.ids.push(id);
        self.numbers.insert(id, number);
        Some(number)
    }
}
