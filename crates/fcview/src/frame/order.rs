//! The order in which pieces are drawn.

use super::pieces::Piece;

/// Sorts pieces nearest first. The order depends on the scene, the view and the division alone, never on threads.
pub(crate) fn front_to_back(pieces: &mut [Piece]) {
    pieces.sort_by(|a, b| {
        a.near.total_cmp(&b.near).then((a.placed, a.first_index).cmp(&(b.placed, b.first_index)))
    });
}

/// The number of indices of some pieces.
pub(crate) fn indices(pieces: &[Piece]) -> u64 {
    pieces.iter().map(|piece| u64::from(piece.index_count)).sum()
}

/// The number of pieces, from the first, that hold at least `indices` indices.
pub(crate) fn leading(pieces: &[Piece], indices: u64) -> usize {
    let mut sum = 0;
    for (piece, number) in pieces.iter().zip(1_usize..) {
        sum += u64::from(piece.index_count);
        if sum >= indices {
            return number;
        }
    }
    pieces.len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::cut::CutId;

    fn pieces(counts: &[u32]) -> Vec<Piece> {
        let piece = |(number, count): (usize, &u32)| Piece {
            placed: 0,
            cut: CutId::Own(0),
            subtree: fct::Subtree::default(),
            first_index: number as u32,
            index_count: *count,
            near: 0.0,
        };
        counts.iter().enumerate().map(piece).collect()
    }

    #[test]
    fn the_nearest_come_first_and_ties_are_settled() {
        let mut pieces = pieces(&[1, 1, 1, 1]);
        for (piece, near) in pieces.iter_mut().zip([2.0, 1.0, 2.0, -1.0]) {
            piece.near = near;
        }
        front_to_back(&mut pieces);
        assert_eq!(pieces.iter().map(|piece| piece.first_index).collect::<Vec<_>>(), [3, 1, 0, 2]);
    }

    #[test]
    fn leading_pieces_reach_the_number_of_indices_or_are_all() {
        let pieces = pieces(&[30, 60, 9]);
        for (wanted, expected) in [(0, 1), (30, 1), (31, 2), (90, 2), (99, 3), (1000, 3)] {
            assert_eq!(leading(&pieces, wanted), expected, "{wanted}");
        }
        assert_eq!(leading(&[], 5), 0);
        assert_eq!(indices(&pieces), 99);
    }
}
