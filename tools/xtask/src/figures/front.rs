//! Fronts by the paper's error: the cluster of the largest epsilon is split, again and again.

use super::model::Model;
use fcbuild::partition::Hierarchy;
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::ops::Range;

/// A cluster on the front.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cluster {
    /// Mean square distance from the plane, in square normal units; infinite where components are only joined.
    epsilon: f64,
    node: usize,
    first: usize,
    faces: usize,
}

impl Eq for Cluster {}

impl PartialOrd for Cluster {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Cluster {
    /// What can be split, by epsilon; of equal ones the first in the tree is the larger. Single faces are smaller.
    fn cmp(&self, other: &Self) -> Ordering {
        (self.faces > 1)
            .cmp(&(other.faces > 1))
            .then(self.epsilon.total_cmp(&other.epsilon))
            .then(other.first.cmp(&self.first))
    }
}

/// A front that can be refined a cluster at a time.
#[derive(Debug)]
pub(crate) struct Front<'a> {
    hierarchy: &'a Hierarchy,
    clusters: BinaryHeap<Cluster>,
}

impl<'a> Front<'a> {
    /// The whole mesh as one cluster.
    pub(crate) fn new(hierarchy: &'a Hierarchy) -> Front<'a> {
        let mut front = Front { hierarchy, clusters: BinaryHeap::new() };
        front.push(0, 0, hierarchy.order.len());
        front
    }

    fn push(&mut self, node: usize, first: usize, faces: usize) {
        let epsilon = match self.hierarchy.splits.get(node) {
            Some(s) if faces > 1 && s.joins_components => f64::INFINITY,
            Some(s) if faces > 1 => f64::from(s.epsilon),
            _ => 0.0,
        };
        self.clusters.push(Cluster { epsilon, node, first, faces });
    }

    /// Splits until there are `clusters` clusters, or every one is a face.
    pub(crate) fn refine(&mut self, clusters: usize) {
        while self.clusters.len() < clusters {
            match self.clusters.peek() {
                Some(worst) if worst.faces > 1 => {}
                _ => return,
            }
            if let Some(worst) = self.clusters.pop() {
                let left = self.hierarchy.splits[worst.node].left_faces as usize;
                self.push(worst.node + 1, worst.first, left);
                self.push(worst.node + left, worst.first + left, worst.faces - left);
            }
        }
    }

    /// Places in the order of the tree that each cluster owns, in that order.
    pub(crate) fn ranges(&self) -> Vec<Range<usize>> {
        let mut ranges: Vec<Range<usize>> =
            self.clusters.iter().map(|c| c.first..c.first + c.faces).collect();
        ranges.sort_unstable_by_key(|r| r.start);
        ranges
    }
}

/// The mean modelling error per unit area for each of `counts` clusters, ascending, per squared diagonal: the sum of
/// area times epsilon over the sum of areas. Infinite while components are joined in one cluster.
///
/// # Paper
/// The ordinate of `[Tsuji07]` figure 9.
pub(crate) fn mean_errors(model: &Model, hierarchy: &Hierarchy, counts: &[usize]) -> Vec<f64> {
    let mut area_before = Vec::with_capacity(model.faces() + 1);
    let mut total = 0.0;
    area_before.push(0.0);
    for &f in &hierarchy.order {
        total += model.area(f as usize);
        area_before.push(total);
    }
    let mut front = Front::new(hierarchy);
    let mut means = Vec::with_capacity(counts.len());
    for &count in counts {
        front.refine(count);
        let mut sum = 0.0;
        let mut clusters: Vec<&Cluster> = front.clusters.iter().collect();
        // The order of a heap is none; that of the tree makes the sum the same on every run.
        clusters.sort_unstable_by_key(|c| c.first);
        for c in clusters {
            sum += c.epsilon * (area_before[c.first + c.faces] - area_before[c.first]);
        }
        means.push(model.per_square_diagonal(sum / total));
    }
    means
}

#[cfg(test)]
mod tests {
    use super::super::modes::PAPER;
    use super::super::sampling::ellipsoid;
    use super::*;
    use fcgeom::Moments;

    /// The front covers every face once, and its mean error is that of moments summed face by face.
    #[test]
    fn mean_error_is_what_it_is_by_definition() {
        let (positions, faces) = ellipsoid(24, 24, [1.0, 0.8, 0.5], 1.0);
        let model = Model::of_triangles("ellipsoid", positions, faces).unwrap();
        let hierarchy = model.hierarchy(PAPER);
        let counts = [1, 2, 7, 40];
        let means = mean_errors(&model, &hierarchy, &counts);
        for (count, mean) in counts.into_iter().zip(means) {
            let mut front = Front::new(&hierarchy);
            front.refine(count);
            let ranges = front.ranges();
            assert_eq!(ranges.len(), count);
            let (mut end, mut sum, mut area) = (0, 0.0, 0.0);
            for r in ranges {
                assert_eq!(r.start, end);
                end = r.end;
                let mut m = Moments::ZERO;
                for &f in &hierarchy.order[r] {
                    let [a, b, c] = model.corners(f as usize);
                    m += Moments::of_triangle(a, b, c);
                }
                sum += m.epsilon() * m.area;
                area += m.area;
            }
            assert_eq!(end, model.faces());
            let expected = model.per_square_diagonal(sum / area);
            assert!((mean - expected).abs() <= 1e-5 * expected, "{count}: {mean:e} {expected:e}");
        }
    }

    /// Refined to the end, every cluster is a face and nothing is left of the error.
    #[test]
    fn the_end_is_the_input() {
        let (positions, faces) = ellipsoid(6, 6, [1.0; 3], 1.0);
        let model = Model::of_triangles("sphere", positions, faces).unwrap();
        let hierarchy = model.hierarchy(PAPER);
        assert_eq!(mean_errors(&model, &hierarchy, &[model.faces(), usize::MAX]), [0.0, 0.0]);
    }
}
