//! A priority queue over the edges of a cluster graph whose costs change while they wait.

/// Not in the queue.
const OUT: u32 = u32::MAX;

/// A binary heap that knows where each edge stands, least cost first, ties by edge number.
#[derive(Debug, Default)]
pub(super) struct Queue {
    heap: Vec<(u64, u32)>,
    place: Vec<u32>,
}

impl Queue {
    /// Takes edges 0, 1, ... with these costs, which are not negative.
    pub(super) fn fill(&mut self, costs: impl Iterator<Item = f64>) {
        self.heap.clear();
        self.heap.extend(costs.enumerate().map(|(i, c)| (c.to_bits(), i as u32)));
        self.place.clear();
        self.place.extend(0..self.heap.len() as u32);
        for at in (0..self.heap.len() / 2).rev() {
            self.sink(at, self.heap[at]);
        }
    }

    /// The edge of least cost.
    pub(super) fn first(&self) -> Option<(f64, u32)> {
        self.heap.first().map(|&(cost, edge)| (f64::from_bits(cost), edge))
    }

    pub(super) fn set(&mut self, edge: u32, cost: f64) {
        let at = self.place[edge as usize];
        if at != OUT {
            self.settle(at as usize, (cost.to_bits(), edge));
        }
    }

    pub(super) fn remove(&mut self, edge: u32) {
        let at = std::mem::replace(&mut self.place[edge as usize], OUT) as usize;
        if at == OUT as usize {
            return;
        }
        if let Some(last) = self.heap.pop()
            && at < self.heap.len()
        {
            self.settle(at, last);
        }
    }

    /// Puts an entry at a free place and moves it to where it belongs.
    fn settle(&mut self, at: usize, entry: (u64, u32)) {
        if at > 0 && entry < self.heap[(at - 1) / 2] {
            self.rise(at, entry);
        } else {
            self.sink(at, entry);
        }
    }

    fn rise(&mut self, mut at: usize, entry: (u64, u32)) {
        while at > 0 {
            let above = (at - 1) / 2;
            if entry >= self.heap[above] {
                break;
            }
            self.put(at, self.heap[above]);
            at = above;
        }
        self.put(at, entry);
    }

    fn sink(&mut self, mut at: usize, entry: (u64, u32)) {
        let n = self.heap.len();
        loop {
            let mut below = 2 * at + 1;
            if below >= n {
                break;
            }
            if below + 1 < n && self.heap[below + 1] < self.heap[below] {
                below += 1;
            }
            if entry <= self.heap[below] {
                break;
            }
            self.put(at, self.heap[below]);
            at = below;
        }
        self.put(at, entry);
    }

    fn put(&mut self, at: usize, entry: (u64, u32)) {
        self.heap[at] = entry;
        self.place[entry.1 as usize] = at as u32;
    }
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
        let mut costs: Vec<Option<f64>> = (0..200).map(|_| Some(random(50) as f64)).collect();
        let mut queue = Queue::default();
        queue.fill(costs.iter().flatten().copied());
        for _ in 0..2000 {
            let edge = random(costs.len());
            if costs[edge].is_some() {
                if random(8) == 0 {
                    queue.remove(edge as u32);
                    costs[edge] = None;
                } else {
                    let cost = random(50) as f64;
                    queue.set(edge as u32, cost);
                    costs[edge] = Some(cost);
                }
            }
            let naive = costs.iter().enumerate().filter_map(|(i, c)| Some((c.as_ref()?.to_bits(), i as u32)));
            assert_eq!(queue.first(), naive.min().map(|(c, i)| (f64::from_bits(c), i)));
        }
    }
}
