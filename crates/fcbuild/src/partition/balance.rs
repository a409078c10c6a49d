//! Keeping the tree shallow: the most even connected cut there is.

use super::DEPTH_LIMIT;
use super::side::Side;
use crate::mesh::NONE;

/// True if a child of `faces` faces at `depth` can still be split down to single faces within [`DEPTH_LIMIT`].
pub(super) fn fits(faces: usize, depth: u32) -> bool {
    depth + even_depth(faces) <= DEPTH_LIMIT
}

/// Depth that even cuts need: a connected graph of degree 3 has a spanning tree, and that an edge with at least
/// (n - 1) / 3 vertices to either side.
fn even_depth(mut faces: usize) -> u32 {
    let mut depth = 0;
    while faces > 1 {
        faces -= (faces - 1).div_ceil(3);
        depth += 1;
    }
    depth
}

/// Cuts the spanning tree found breadth first from face 0 at its most even edge; both sides are connected.
pub(super) fn cut_spanning_tree(adjacent: &[[u32; 3]], side: &mut [Side]) {
    let n = adjacent.len();
    let mut parent = vec![NONE; n];
    let mut order = Vec::with_capacity(n);
    parent[0] = 0;
    order.push(0_u32);
    let mut head = 0;
    while head < order.len() {
        let face = order[head];
        head += 1;
        for &near in &adjacent[face as usize] {
            if near != NONE && parent[near as usize] == NONE {
                parent[near as usize] = face;
                order.push(near);
            }
        }
    }
    let mut size = vec![1_u32; n];
    let mut best = (u32::MAX, 0);
    for &face in order[1..].iter().rev() {
        let s = size[face as usize];
        size[parent[face as usize] as usize] += s;
        best = best.min(((n as u32).abs_diff(2 * s), face));
    }
    side.fill(Side::Left);
    side[best.1 as usize] = Side::Right;
    // Parents come before children in `order`, so one pass hands the label down.
    for &face in &order[1..] {
        if side[parent[face as usize] as usize] == Side::Right {
            side[face as usize] = Side::Right;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_cuts_fit_the_largest_mesh() {
        assert!(fits(crate::mesh::MAX_FACES as usize, DEPTH_LIMIT - 54));
        assert_eq!([1, 2, 3, 4, 7].map(even_depth), [0, 1, 2, 3, 4]);
    }

    #[test]
    fn a_strip_is_cut_in_its_middle() {
        let n = 101_u32;
        let strip: Vec<[u32; 3]> = (0..n)
            .map(|i| [i.checked_sub(1).unwrap_or(NONE), if i + 1 < n { i + 1 } else { NONE }, NONE])
            .collect();
        let mut side = vec![Side::Left; n as usize];
        cut_spanning_tree(&strip, &mut side);
        let right = side.iter().filter(|s| **s == Side::Right).count();
        assert!((50..=51).contains(&right), "{right}");
        assert_eq!(side.windows(2).filter(|w| w[0] != w[1]).count(), 1);
    }
}
