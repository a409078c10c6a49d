//! The vertices of a tree in another order: those that coarse meshes draw come first.
//!
//! A tree has its vertices in the order of its faces, so those of a coarse mesh lie apart, a few in each page. Ordered by
//! how early they are drawn, and by the tree among equals, the vertices of a view lie together: those of coarse meshes at
//! the front, those of finer ones by where they are.

use fct::VertexRecord;

/// An order of a tree's vertices and its inverse; 8 bytes a vertex.
pub(crate) struct LevelOrder {
    /// The vertex at each place.
    vertices: Vec<u32>,
    /// The place of each vertex.
    places: Vec<u32>,
}

/// Levels: half an octave of the bound each.
const LEVELS: usize = 1 << 9;

impl LevelOrder {
    /// The order of some vertices, no more than 32 bits count.
    pub(crate) fn new(records: &[VertexRecord]) -> LevelOrder {
        let mut next = [0_u32; LEVELS];
        for record in records {
            if let Some(count) = next.get_mut(level(record)) {
                *count += 1;
            }
        }
        let mut start = 0;
        for next in &mut next {
            start += std::mem::replace(next, start);
        }
        let mut vertices = vec![0; records.len()];
        let mut places = Vec::with_capacity(records.len());
        for (record, vertex) in records.iter().zip(0_u32..) {
            let Some(next) = next.get_mut(level(record)) else { continue };
            if let Some(slot) = vertices.get_mut(*next as usize) {
                *slot = vertex;
            }
            places.push(*next);
            *next += 1;
        }
        LevelOrder { vertices, places }
    }

    /// The place of a vertex.
    #[inline]
    pub(crate) fn place(&self, vertex: u32) -> u32 {
        self.places.get(vertex as usize).copied().unwrap_or(0)
    }

    /// The vertices at some places, as far as there are.
    pub(crate) fn vertices(&self, places: std::ops::Range<usize>) -> &[u32] {
        let end = places.end.min(self.vertices.len());
        self.vertices.get(places.start.min(end)..end).unwrap_or(&[])
    }
}

/// Half octaves of the bound below the largest one; numbers that are none count as 0, the finest.
fn level(record: &VertexRecord) -> usize {
    // The sign is 0, so the bits ascend as the number does; 22 of 23 bits of the fraction are left out.
    LEVELS - 1 - (record.bound().max(0.0).to_bits() >> 22) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coarse_vertices_come_first_and_equal_ones_in_the_tree_s_order() {
        let bounds = [1.0, 100.0, 0.0, f64::INFINITY, 1.1, 100.0, 3.0, 0.0];
        let records: Vec<_> = bounds
            .iter()
            .map(|bound| VertexRecord::eager([0.0; 3], *bound, *bound, ([0.0; 3], 0.0)).unwrap())
            .collect();
        let order = LevelOrder::new(&records);
        assert_eq!(order.vertices(0..99), [3, 1, 5, 6, 0, 4, 2, 7]);
        assert_eq!(order.vertices(2..4), [5, 6]);
        assert_eq!(order.vertices(9..12), [0; 0]);
        for place in 0..8 {
            let vertex = order.vertices(place..place + 1)[0];
            assert_eq!(order.place(vertex) as usize, place);
        }
    }
}
