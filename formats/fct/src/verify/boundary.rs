//! That loops are what they say: the boundary of their cluster.
//!
//! Each directed edge gets a number that changes sign with the direction. Summed over the three edges of every face of a
//! cluster, edges inside cancel and the boundary remains; the edges of the loops must give the same sum.
//! A sum that agrees by chance has odds of one in 2^64, and costs no memory and no look at neighbours.

use crate::error::Violation;
use crate::loops::Loops;
use crate::node::Node;
use crate::rule::Rule;
use crate::subtree::Subtree;

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

/// Compares the loops of a node with the boundary of its faces, which the caller has summed. `follows` says that the
/// loops were not stored and follow from the faces, which must leave no choice.
pub(crate) fn check(
    subtree: &Subtree,
    node: &Node,
    loops: &Loops,
    follows: bool,
    of_faces: u64,
) -> Result<(), Box<Violation>> {
    // A node that must always be refined is never drawn and may do without.
    if node.bound == f32::INFINITY && (follows || loops.vertices.is_empty()) {
        return Ok(());
    }
    let mut of_loops = 0_u64;
    let met = &loops.vertices;
    let ambiguous = follows && met.iter().enumerate().any(|(i, v)| met.iter().take(i).any(|u| u == v));
    for ring in loops.iter() {
        let next = ring.iter().skip(1).chain(ring.first());
        for (a, b) in ring.iter().zip(next) {
            of_loops = of_loops.wrapping_add(edge_number(*a, *b));
        }
    }
    if of_loops == of_faces && !ambiguous {
        return Ok(());
    }
    Err(Violation::new(
        Rule::LoopBoundary,
        subtree.to_string(),
        if ambiguous {
            "its loops are not stored, and its faces leave a choice".to_owned()
        } else {
            format!("its {} loop entries are not the boundary of its faces", loops.vertices.len())
        },
    ))
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
