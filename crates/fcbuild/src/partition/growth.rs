//! Growing two connected clusters from the seeds on either side of a plane.
//!
//! # Paper
//! `[Tsuji07]` 4.2: seeds by eq. 16, growth in steps 1 to 3.

use super::side::Side;
use crate::mesh::NONE;

/// Cuts a connected cluster by the plane where `height` (the R of eq. 16) is zero.
///
/// `side` and `queue` are scratch as long as the cluster; `side` holds the answer. Both sides are connected and not
/// empty. Returns false, with `side` unfinished, when all faces lie at the same height.
pub(super) fn grow(adjacent: &[[u32; 3]], height: &[f32], side: &mut [Side], queue: &mut [u32]) -> bool {
    // Seeds: the faces of largest and smallest R (eq. 16); the first of equals.
    let (mut top, mut bottom) = (0, 0);
    for (i, h) in height.iter().enumerate() {
        if *h > height[top] {
            top = i;
        }
        if *h < height[bottom] {
            bottom = i;
        }
    }
    if top == bottom {
        return false;
    }
    side.fill(Side::Neither);
    // Taken before the first growth, so that a centroid shifted by rounding cannot leave the right side empty.
    side[bottom] = Side::Right;
    let mut growth = Growth { adjacent, side, queue, filled: 0 };
    growth.run(top, Side::Left, |near| height[near] > 0.0); // step 1
    growth.run(bottom, Side::Right, |near| height[near] < 0.0); // step 2
    growth.flood(); // step 3
    true
}

struct Growth<'a> {
    adjacent: &'a [[u32; 3]],
    side: &'a mut [Side],
    queue: &'a mut [u32],
    filled: usize,
}

impl Growth<'_> {
    fn run(&mut self, seed: usize, mine: Side, belongs: impl Fn(usize) -> bool) {
        let mut head = self.filled;
        self.add(seed, mine);
        while head < self.filled {
            let face = self.queue[head] as usize;
            head += 1;
            for &near in &self.adjacent[face] {
                if near != NONE && self.side[near as usize] == Side::Neither && belongs(near as usize) {
                    self.add(near as usize, mine);
                }
            }
        }
    }

    /// What neither side reached joins the side that touches it, layer by layer.
    fn flood(&mut self) {
        let mut head = 0;
        while self.filled < self.adjacent.len() && head < self.filled {
            let face = self.queue[head] as usize;
            head += 1;
            for &near in &self.adjacent[face] {
                if near != NONE && self.side[near as usize] == Side::Neither {
                    self.add(near as usize, self.side[face]);
                }
            }
        }
    }

    fn add(&mut self, face: usize, mine: Side) {
        self.side[face] = mine;
        self.queue[self.filled] = face as u32;
        self.filled += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn strip(n: u32) -> Vec<[u32; 3]> {
        (0..n).map(|i| [i.wrapping_sub(1), if i + 1 < n { i + 1 } else { NONE }, NONE]).collect()
    }

    fn cut(height: &[f32]) -> Option<Vec<Side>> {
        let n = height.len();
        let (mut side, mut queue) = (vec![Side::Neither; n], vec![0; n]);
        grow(&strip(n as u32), height, &mut side, &mut queue).then_some(side)
    }

    #[test]
    fn a_pocket_out_of_reach_joins_the_side_it_touches() {
        // The third face is above the plane and the fourth below, each cut off from its seed by the other.
        let side = cut(&[-3.0, -0.5, 0.5, -1.0, 2.0, 4.0]);
        use Side::{Left, Right};
        assert_eq!(side, Some(vec![Right, Right, Right, Left, Left, Left]));
    }

    #[test]
    fn equal_heights_are_refused_and_positive_ones_still_cut() {
        assert_eq!(cut(&[1.0; 4]), None);
        assert_eq!(cut(&[2.0, 1.0]), Some(vec![Side::Left, Side::Right]));
    }
}
