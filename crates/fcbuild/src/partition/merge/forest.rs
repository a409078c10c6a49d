//! From a list of merges to a tree in preorder.

use super::graph::Merge;
use crate::partition::hierarchy::Split;

/// Below this many faces a subtree is laid out on one thread.
const SERIAL_BELOW: usize = 4096;

/// Lays out the tree under `root`. References below `faces` are faces, others merges counted from `faces`.
pub(super) fn lay_out(merges: &[Merge], root: u32, faces: usize) -> (Vec<Split>, Vec<u32>) {
    let mut splits = vec![Split::EMPTY; faces - 1];
    let mut order = vec![0_u32; faces];
    Layout { merges, first_merge: faces as u32 }.place(root, &mut splits, &mut order);
    (splits, order)
}

#[derive(Clone, Copy)]
struct Layout<'a> {
    merges: &'a [Merge],
    first_merge: u32,
}

impl Layout<'_> {
    fn faces(&self, reference: u32) -> usize {
        if reference < self.first_merge {
            1
        } else {
            self.merges[(reference - self.first_merge) as usize].faces as usize
        }
    }

    /// The depth of the recursion is that of the tree, which the caller has checked.
    fn place(&self, reference: u32, splits: &mut [Split], order: &mut [u32]) {
        let Some((own, below)) = splits.split_first_mut() else {
            order[0] = reference;
            return;
        };
        let merge = &self.merges[(reference - self.first_merge) as usize];
        let [left, right] = merge.children;
        let left_faces = self.faces(left);
        *own = Split {
            left_faces: left_faces as u32,
            joins_components: merge.key == f32::INFINITY,
            epsilon: merge.epsilon,
            key: merge.key,
            offset: merge.offset,
            normal: merge.normal,
        };
        let (splits_l, splits_r) = below.split_at_mut(left_faces - 1);
        let (order_l, order_r) = order.split_at_mut(left_faces);
        if order_l.len() + order_r.len() < SERIAL_BELOW {
            self.place(left, splits_l, order_l);
            self.place(right, splits_r, order_r);
        } else {
            rayon::join(|| self.place(left, splits_l, order_l), || self.place(right, splits_r, order_r));
        }
    }
}
