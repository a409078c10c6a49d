//! Small numbers for the vertices of a cell.

use crate::mesh::NONE;

/// Numbers vertices 0, 1, ... in the order in which they are asked for.
///
/// A table of its own and not the library's, because it is asked for three times a face.
#[derive(Debug)]
pub(super) struct Numbering {
    /// Open addressing: a vertex and its number.
    table: Vec<(u32, u32)>,
    /// The vertex of each number.
    pub(super) vertices: Vec<u32>,
}

impl Numbering {
    /// For at most `capacity` different vertices.
    pub(super) fn with_capacity(capacity: usize) -> Numbering {
        let slots = (capacity * 4 / 3 + 1).next_power_of_two();
        Numbering { table: vec![(NONE, 0); slots], vertices: Vec::new() }
    }

    pub(super) fn number(&mut self, vertex: u32) -> u32 {
        let mask = self.table.len() - 1;
        // Fibonacci hashing: neighbours in the list of vertices fall far apart.
        let mut at = (u64::from(vertex).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32) as usize & mask;
        loop {
            let (found, number) = self.table[at];
            if found == vertex {
                return number;
            }
            if found == NONE {
                let number = self.vertices.len() as u32;
                self.table[at] = (vertex, number);
                self.vertices.push(vertex);
                return number;
            }
            at = (at + 1) & mask;
        }
    }
}
