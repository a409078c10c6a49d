//! Vertices that the builder copied where it cut a seam.

use fct::Tree;

/// The copies of each vertex; all of them are drawn where one is.
#[derive(Debug, Default)]
pub(crate) struct Copies {
    /// Original and copy, in order.
    pairs: Vec<(u32, u32)>,
}

impl Copies {
    /// Of another tree.
    pub(crate) fn read(&mut self, tree: &Tree) {
        self.pairs.clear();
        self.pairs.extend(tree.weld().iter().map(|w| (w.representative.get(), w.vertex.get())));
        self.pairs.sort_unstable();
    }

    /// Shows a vertex and all vertices at its place that are one with it.
    pub(crate) fn each(&self, tree: &Tree, vertex: u32, mut show: impl FnMut(u32)) {
        if self.pairs.is_empty() {
            return show(vertex);
        }
        let original = tree.original(vertex);
        show(original);
        let first = self.pairs.partition_point(|(of, _)| *of < original);
        for (_, copy) in self.pairs.iter().skip(first).take_while(|(of, _)| *of == original) {
            show(*copy);
        }
    }
}
