//! An extraction on all threads of the pool that it is called from.

use crate::extraction::Stats;
use crate::part::{Part, Sight};
use crate::{Error, Extraction, Selection};
use fct::{Child, Subtree, Tree};
use rayon::prelude::*;

/// Extracts on many threads; keeps its memory from one time to the next.
#[derive(Debug, Default)]
pub struct ParallelExtractor {
    /// The upper part of the walk, in the order in which one thread would take it.
    walk: Vec<Step>,
    parts: Vec<Part>,
    /// What each part comes to.
    meshes: Vec<Extraction>,
}

/// A step of the walk through the upper part of the tree.
#[derive(Clone, Copy, Debug)]
enum Step {
    /// Looks at a subtree.
    Visit(Part),
    /// The mesh of the next part stands here.
    Take,
    /// The mesh of a subtree begins here.
    Open,
    /// It ends here.
    Close(Subtree),
}

/// Parts have this share of the faces at most, so that a thread that is done early finds another one, and what a view
/// shows in one place is still divided.
const SHARE: usize = 256;

/// A part of fewer faces is not worth a turn.
const FEWEST_FACES: u32 = 512;

impl ParallelExtractor {
    /// Extracts the mesh of `selection` from `tree` into `out`: what [`crate::extract`] extracts, in the same order.
    ///
    /// # Errors
    /// As [`crate::extract`].
    pub fn extract(&mut self, tree: &Tree, selection: &Selection, out: &mut Extraction) -> Result<(), Error> {
        selection.check()?;
        out.clear();
        self.divide(tree, selection, &mut out.stats)?;
        if self.meshes.len() < self.parts.len() {
            self.meshes.resize_with(self.parts.len(), Extraction::default);
        }
        self.meshes.par_iter_mut().zip(&self.parts).try_for_each(|(mesh, part)| {
            mesh.clear();
            mesh.append(tree, selection, part)
        })?;
        self.join(out)
    }

    /// Walks down to the parts; what is left out on the way is counted.
    fn divide(&mut self, tree: &Tree, selection: &Selection, stats: &mut Stats) -> Result<(), Error> {
        let reader = tree.reader();
        let most = u32::try_from(tree.face_count() / SHARE).unwrap_or(u32::MAX).max(FEWEST_FACES);
        self.walk.clear();
        self.parts.clear();
        let mut stack = vec![Step::Visit(Part::whole(tree, selection))];
        while let Some(step) = stack.pop() {
            let Step::Visit(part) = step else {
                self.walk.push(step);
                continue;
            };
            let Part { subtree, inside } = part;
            if subtree.face_count() > most
                && let Child::Node(_) = subtree.child.kind()
            {
                match selection.sight(&subtree, &reader.node(&subtree)?, inside, stats) {
                    Sight::Culled => continue,
                    Sight::Refined { inside } => {
                        self.walk.push(Step::Open);
                        let [left, right] = reader.children(&subtree)?;
                        let visit = |subtree| Step::Visit(Part { subtree, inside });
                        stack.extend([Step::Close(subtree), visit(right), visit(left)]);
                        continue;
                    }
                    // The part counts its own node.
                    Sight::Drawn => stats.nodes_visited -= 1,
                }
            }
            self.parts.push(part);
            self.walk.push(Step::Take);
        }
        Ok(())
    }

    /// Puts the meshes of the parts one after the other.
    fn join(&mut self, out: &mut Extraction) -> Result<(), Error> {
        let meshes = self.meshes.get(..self.parts.len()).unwrap_or_default();
        let indices: usize = meshes.iter().map(|mesh| mesh.indices.len()).sum();
        u32::try_from(indices).map_err(|_overflow| Error::TooManyTriangles)?;
        let mut open = Vec::new();
        let mut first_index = 0;
        let mut next = meshes.iter();
        for step in &self.walk {
            match *step {
                Step::Visit(_) => {}
                Step::Open => open.push((first_index, out.batches.len())),
                Step::Take => {
                    let Some(mesh) = next.next() else { continue };
                    out.clusters.extend(mesh.clusters.iter().map(|triangle| triangle + first_index / 3));
                    out.batches.extend(mesh.batches.iter().map(|batch| batch.moved(first_index)));
                    out.stats.add(&mesh.stats);
                    first_index += mesh.indices.len() as u32;
                }
                Step::Close(subtree) => {
                    let Some((first, batch)) = open.pop() else { continue };
                    out.close(subtree, first, first_index, batch);
                }
            }
        }
        // Most of the joining is copying these, and memory is faster by two.
        out.indices.resize(indices, 0);
        let mut places = Vec::with_capacity(meshes.len());
        let mut left = out.indices.as_mut_slice();
        for mesh in meshes {
            let (place, after) = left.split_at_mut(mesh.indices.len());
            places.push((place, mesh));
            left = after;
        }
        places.into_par_iter().for_each(|(place, mesh)| place.copy_from_slice(&mesh.indices));
        Ok(())
    }
}
