//! What it means for an extracted mesh to have no crack.

use fct::Tree;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// The borders that a mesh may have, known from the tree's faces.
#[derive(Debug)]
pub struct Borders {
    weld: Vec<u32>,
    /// For each welded vertex, where the input's unmatched directed edges lead, and how many of each there are.
    onward: BTreeMap<u32, Vec<u32>>,
}

impl Borders {
    /// The input's edges that have no opposite, after counting opposite ones against each other.
    pub fn of(tree: &Tree) -> Borders {
        let mut weld: Vec<u32> = (0..tree.vertices().len() as u32).collect();
        for w in tree.weld() {
            weld[w.vertex.get() as usize] = w.representative.get();
        }
        Borders::by(tree, weld)
    }

    /// The same where seams count as borders: for meshes that may lack whole components.
    pub fn with_seams(tree: &Tree) -> Borders {
        Borders::by(tree, (0..tree.vertices().len() as u32).collect())
    }

    fn by(tree: &Tree, weld: Vec<u32>) -> Borders {
        let faces = tree.faces().unwrap_or_else(|e| panic!("{e}")).into_flattened();
        let mut borders = Borders { weld, onward: BTreeMap::new() };
        for (a, b) in borders.unmatched(&faces) {
            borders.onward.entry(a).or_default().push(b);
        }
        borders
    }

    /// Directed edges without an opposite, as often as they occur, in order.
    fn unmatched(&self, indices: &[u32]) -> Vec<(u32, u32)> {
        let mut net: HashMap<(u32, u32), i32> = HashMap::with_capacity(indices.len());
        for t in indices.chunks_exact(3) {
            for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                let (a, b) = (self.weld[a as usize], self.weld[b as usize]);
                let (key, step) = if a < b { ((a, b), 1) } else { ((b, a), -1) };
                *net.entry(key).or_insert(0) += step;
            }
        }
        let mut edges: Vec<(u32, u32)> = net
            .into_iter()
            .flat_map(|((a, b), n)| {
                let edge = if n > 0 { (a, b) } else { (b, a) };
                std::iter::repeat_n(edge, n.unsigned_abs() as usize)
            })
            .filter(|(a, b)| a != b)
            .collect();
        edges.sort_unstable();
        edges
    }

    /// The unmatched edges of a mesh that are no chords of the input's borders: its cracks.
    ///
    /// A chord leads from one vertex of a border to another, along the border, past vertices that the mesh's border
    /// does not use.
    pub fn cracks(&self, indices: &[u32]) -> Vec<(u32, u32)> {
        let unmatched = self.unmatched(indices);
        let used: BTreeSet<u32> = unmatched.iter().flat_map(|&(a, b)| [a, b]).collect();
        unmatched.iter().copied().filter(|&(a, b)| !self.is_chord(a, b, &used)).collect()
    }

    fn is_chord(&self, from: u32, to: u32, used: &BTreeSet<u32>) -> bool {
        let mut reached = BTreeSet::from([from]);
        let mut stack = vec![from];
        while let Some(at) = stack.pop() {
            for &next in self.onward.get(&at).into_iter().flatten() {
                if next == to {
                    return true;
                }
                if !used.contains(&next) && reached.insert(next) {
                    stack.push(next);
                }
            }
        }
        false
    }
}
