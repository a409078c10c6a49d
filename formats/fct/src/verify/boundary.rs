//! That loops are what they say: the boundary of their cluster.
//!
//! Each directed edge gets a number that changes sign with the direction. Summed over the three edges of every face of a
//! cluster, edges inside cancel and the boundary remains; the edges of the loops must give the same sum.
//! A sum that agrees by chance has odds of one in 2^64, and costs no memory and no look at neighbours.

use zerocopy::little_endian::U32;

use crate::error::Violation;
use crate::records::NodeRecord;
use crate::rule::Rule;
use crate::walk::{Loops, node_place, to_index};

/// The number of the directed edge from `a` to `b`, minus that from `b` to `a`.
fn edge_number(a: u32, b: u32) -> u64 {
    mix(a, b).wrapping_sub(mix(b, a))
}

/// A bijection of 64 bits that spreads neighbouring inputs (the finaliser of SplitMix64).
fn mix(a: u32, b: u32) -> u64 {
    let x = (u64::from(a) << 32) | u64::from(b);
    let x = x.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^ (x >> 31)
}

/// The boundary of a face.
pub(crate) fn face_number([a, b, c]: [u32; 3]) -> u64 {
    edge_number(a, b).wrapping_add(edge_number(b, c)).wrapping_add(edge_number(c, a))
}

/// Compares the loops of a node with the boundary of its faces, which the caller has summed.
pub(crate) fn check(
    index: u32,
    node: &NodeRecord,
    loops: Loops<'_>,
    of_faces: u64,
) -> Result<(), Box<Violation>> {
    // A node that must always be refined is never drawn and may do without.
    if node.loop_len.get() == 0 && node.bound.get() == f32::INFINITY {
        return Ok(());
    }
    let mut of_loops = 0_u64;
    for boundary in loops {
        let next = boundary.vertices().skip(1).chain(boundary.vertices().take(1));
        for (a, b) in boundary.vertices().zip(next) {
            of_loops = of_loops.wrapping_add(edge_number(a, b));
        }
    }
    if of_loops == of_faces {
        return Ok(());
    }
    Err(Violation::new(
        Rule::LoopBoundary,
        node_place(index),
        format!("its {} loop entries are not the boundary of its faces", node.loop_len.get()),
    ))
}

/// Which entries of section `LOOP` some node has claimed.
pub(crate) struct Covered {
    words: Vec<u64>,
    claimed: usize,
    entries: usize,
}

impl Covered {
    /// None when the memory is not there.
    pub(crate) fn for_entries(entries: usize) -> Option<Self> {
        let mut words = Vec::new();
        let len = entries.div_ceil(64);
        words.try_reserve_exact(len).ok()?;
        words.resize(len, 0);
        Some(Self { words, claimed: 0, entries })
    }

    /// Claims the entries of a node, whose range was checked.
    pub(crate) fn claim(&mut self, index: u32, node: &NodeRecord) -> Result<(), Box<Violation>> {
        let start = to_index(node.loop_start.get()).unwrap_or(usize::MAX);
        let len = to_index(node.loop_len.get()).unwrap_or(usize::MAX);
        for entry in start..start.saturating_add(len) {
            let bit = 1_u64 << (entry & 63);
            if let Some(word) = self.words.get_mut(entry >> 6) {
                if *word & bit != 0 {
                    return Err(Violation::new(
                        Rule::LoopCover,
                        node_place(index),
                        format!("entry {entry} of section LOOP belongs to an earlier node, too"),
                    ));
                }
                *word |= bit;
            }
        }
        self.claimed = self.claimed.saturating_add(len);
        Ok(())
    }

    /// After the last node: nothing may be left.
    pub(crate) fn check_all(&self, loops: &[U32]) -> Result<(), Box<Violation>> {
        if self.claimed == self.entries && loops.len() == self.entries {
            return Ok(());
        }
        Err(Violation::new(
            Rule::LoopCover,
            "section LOOP".to_owned(),
            format!("nodes own {} of its {} entries", self.claimed, loops.len()),
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::{edge_number, face_number};

    #[test]
    fn inner_edges_cancel_and_the_boundary_remains() {
        // Two triangles over the diagonal 0-2 of a square.
        let square = face_number([0, 1, 2]).wrapping_add(face_number([0, 2, 3]));
        let rim = [(0, 1), (1, 2), (2, 3), (3, 0)];
        let sum =
            |edges: &[(u32, u32)]| edges.iter().fold(0_u64, |s, &(a, b)| s.wrapping_add(edge_number(a, b)));
        assert_eq!(square, sum(&rim));
        assert_ne!(square, sum(&rim.map(|(a, b)| (b, a))), "wound the other way");
        assert_ne!(square, sum(&rim[..3]), "not closed");
    }
}
