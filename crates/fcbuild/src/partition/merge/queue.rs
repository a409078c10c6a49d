//! A priority queue over the edges of a cluster graph.

use std::collections::BinaryHeap;

/// A heap of edges, least cost first, ties by edge number.
///
/// An entry is one number, so that it moves fast: above the edge stand the leading bits of its cost, six digits and the
/// whole exponent.
#[derive(Debug, Default)]
pub(super) struct Queue {
    /// The complements of the entries, since the library's heap gives the largest first.
    heap: BinaryHeap<u64>,
}

impl Queue {
    /// Takes edges 0, 1, ... with these costs, which are not negative.
    pub(super) fn new(costs: impl Iterator<Item = f64>) -> Queue {
        let entries: Vec<u64> = costs.enumerate().map(|(i, cost)| !entry(cost, i as u32)).collect();
        Queue { heap: BinaryHeap::from(entries) }
    }

    /// The edge of least cost, and this cost to six digits.
    pub(super) fn first(&self) -> Option<(u32, f64)> {
        self.heap.peek().map(|top| (!top as u32, f64::from_bits((!top >> 32) << 31)))
    }

    /// Takes the first edge out.
    pub(super) fn take(&mut self) {
        self.heap.pop();
    }

    /// Lets the first edge wait at another cost.
    pub(super) fn put_back(&mut self, cost: f64) {
        if let Some(mut top) = self.heap.peek_mut() {
            let edge = !*top as u32;
            *top = !entry(cost, edge);
        }
    }
}

/// The sign of a cost is no news: one more of the other bits has room.
fn entry(cost: f64, edge: u32) -> u64 {
    (cost.to_bits() >> 31) << 32 | u64::from(edge)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gives_edges_by_cost_whatever_changes_meanwhile() {
        let mut state = 7_u64;
        let mut random = |n: usize| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as usize % n
        };
        let mut costs: Vec<Option<f64>> = (0..200).map(|_| Some(random(50) as f64 * 0.5)).collect();
        let mut queue = Queue::new(costs.iter().flatten().copied());
        loop {
            let naive = costs.iter().enumerate().filter_map(|(i, c)| Some((i as u32, (*c)?)));
            let least = naive.min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
            assert_eq!(queue.first(), least);
            let Some((edge, cost)) = least else { break };
            if random(8) == 0 {
                queue.take();
                costs[edge as usize] = None;
            } else {
                let more = cost + random(50) as f64 * 0.5;
                queue.put_back(more);
                costs[edge as usize] = Some(more);
            }
        }
    }

    #[test]
    fn costs_keep_six_digits_and_their_order_at_any_size() {
        for cost in [0.0, 5e-324, 1e-60, 0.1, 1.0 / 3.0, 7e300, f64::MAX] {
            let kept = Queue::new([cost].into_iter()).first().unwrap().1;
            assert!(kept <= cost && (cost - kept <= 1e-6 * cost || cost < 1e-300), "{cost}: {kept}");
        }
    }
}
