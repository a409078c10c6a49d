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
    runs: Vec<Run>,
}

/// Parts that stand one after the other, extracted by one thread into one place: what it works with stays near.
#[derive(Debug, Default)]
struct Run {
    mesh: Extraction,
    /// Where each part ends among the mesh's indices and batches.
    ends: Vec<(usize, usize)>,
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

/// Runs for each thread: more of them share the work more evenly and use more memory at once.
const RUNS: usize = 16;

impl ParallelExtractor {
    /// Extracts the mesh of `selection` from `tree` into `out`: what [`crate::extract`] extracts, in the same order.
    ///
    /// # Errors
    /// As [`crate::extract`].
    pub fn extract(&mut self, tree: &Tree, selection: &Selection, out: &mut Extraction) -> Result<(), Error> {
        selection.check()?;
        out.clear();
        self.divide(tree, selection, &mut out.stats)?;
        let run_length = self.parts.len().div_ceil(RUNS * rayon::current_num_threads()).max(1);
        let runs = self.parts.len().div_ceil(run_length);
        if self.runs.len() < runs {
            self.runs.resize_with(runs, Run::default);
        }
        self.runs.par_iter_mut().zip(self.parts.par_chunks(run_length)).try_for_each(|(run, parts)| {
            run.mesh.clear();
            run.ends.clear();
            for part in parts {
                run.mesh.append(tree, selection, part)?;
                run.ends.push((run.mesh.indices.len(), run.mesh.batches.len()));
            }
            Ok::<_, Error>(())
        })?;
        self.runs.iter_mut().skip(runs).for_each(|run| run.ends.clear());
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
            let Part { subtree, settled } = part;
            if subtree.face_count() > most
                && let Child::Node(_) = subtree.child.kind()
            {
                match selection.sight(&subtree, &reader.node(&subtree)?, settled, stats) {
                    Sight::Culled => continue,
                    Sight::Refined { settled } => {
                        self.walk.push(Step::Open);
                        let [left, right] = reader.children(&subtree)?;
                        let visit = |subtree| Step::Visit(Part { subtree, settled });
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

    /// Puts the meshes of the runs one after the other, and joins the batches of parts that are small together.
    fn join(&self, out: &mut Extraction) -> Result<(), Error> {
        let mut parts =
            self.runs.iter().flat_map(|run| run.ends.iter().enumerate().map(move |part| (run, part)));
        let mut open = Vec::new();
        // Where the mesh of the run begins, and where that of the next part does.
        let (mut base, mut next) = (0, 0);
        for step in &self.walk {
            match *step {
                Step::Visit(_) => {}
                Step::Open => open.push((next, out.batches.len())),
                Step::Take => {
                    let Some((Run { mesh, ends }, (place, &(end, batch_end)))) = parts.next() else {
                        continue;
                    };
                    if place == 0 {
                        base = next;
                        out.clusters.extend(mesh.clusters.iter().map(|triangle| triangle + base / 3));
                        out.indices.extend_from_slice(&mesh.indices);
                        out.stats.add(&mesh.stats);
                    }
                    let first =
                        place.checked_sub(1).and_then(|before| ends.get(before)).map_or(0, |end| end.1);
                    let batches = mesh.batches.get(first..batch_end).unwrap_or_default();
                    out.batches.extend(batches.iter().map(|batch| batch.moved(base)));
                    next = u32::try_from(base as usize + end).map_err(|_overflow| Error::TooManyTriangles)?;
                }
                Step::Close(subtree) => {
                    let Some((first, batch)) = open.pop() else { continue };
                    out.close(subtree, first, next, batch);
                }
            }
        }
        Ok(())
    }
}
