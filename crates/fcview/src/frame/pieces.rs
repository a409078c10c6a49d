//! The triangles of a frame in pieces: subtrees that are drawn, asked about and left out together.

use super::cut::{CutId, Cuts};
use crate::camera::View;
use crate::scene::Scene;
use fcextract::Batch;
use fct::{Child, Subtree};
use glam::DVec3;
use std::ops::Range;

/// A subtree's triangles in one instance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece {
    /// Number of the placed instance, which is also its row on the GPU.
    pub(crate) placed: u32,
    /// Its cut.
    pub(crate) cut: CutId,
    /// The subtree that it is, or is a part of.
    pub(crate) subtree: Subtree,
    /// Its first index within the cut.
    pub(crate) first_index: u32,
    /// Its number of indices.
    pub(crate) index_count: u32,
    /// Distance of the eye from the subtree's sphere, in the scene's unit; negative inside.
    pub(crate) near: f64,
}

/// Pieces are never made smaller than this many triangles on purpose: one triangle is drawn sooner than asked about.
const FEWEST_TRIANGLES: u64 = 2;

/// Divides a frame's triangles into about `wanted` pieces, in the order of instances and trees. Returns the most
/// triangles of a piece.
///
/// What is divided depends on the cuts alone, so every way to draw a selection has the same pieces.
pub(crate) fn divide(scene: &Scene, view: &View, cuts: &Cuts, wanted: usize, out: &mut Vec<Piece>) -> u32 {
    out.clear();
    let slots = || cuts.placed.iter().filter_map(|placed| cuts.slot(placed.cut));
    let indices: u64 = slots().map(|slot| slot.extraction.indices.len() as u64).sum();
    let most = 3 * (indices / 3 / wanted.max(1) as u64).max(FEWEST_TRIANGLES);
    for (placed, number) in cuts.placed.iter().zip(0_u32..) {
        let (Some(instance), Some(slot)) = (scene.instances.get(placed.instance), cuts.slot(placed.cut))
        else {
            continue;
        };
        let Some(model) = scene.models.get(slot.model) else { continue };
        let eye = instance.to_model(view.eye);
        let tree = &model.tree;
        group(tree, &slot.extraction.batches, most, |subtree, first_index, index_count| {
            let (center, radius) = sphere(tree, &subtree);
            let near = instance.scale * (center.distance(eye) - radius);
            out.push(Piece { placed: number, cut: placed.cut, subtree, first_index, index_count, near });
        });
    }
    u32::try_from(most / 3).unwrap_or(u32::MAX)
}

/// Joins the batches of a cut, which stand in the order of the tree, into subtrees of at most `most` indices, and
/// divides batches that are larger into runs, which lie together as the tree's leaves do.
fn group(tree: &fct::Tree, batches: &[Batch], most: u64, mut piece: impl FnMut(Subtree, u32, u32)) {
    // Where each batch ends in indices, so that any run's size is one subtraction.
    let start = batches.first().map_or(0, |batch| batch.first_index);
    let ends: Vec<u32> = batches.iter().map(|batch| batch.first_index + batch.index_count).collect();
    let begin = |i: usize| if i == 0 { start } else { ends.get(i - 1).copied().unwrap_or(start) };
    let mut stack: Vec<(Subtree, Range<usize>)> = vec![(tree.whole(), 0..batches.len())];
    while let Some((subtree, range)) = stack.pop() {
        let count = begin(range.end) - begin(range.start);
        if count == 0 {
            continue;
        }
        let run = batches.get(range.clone()).unwrap_or(&[]);
        if u64::from(count) <= most {
            piece(subtree, begin(range.start), count);
            continue;
        }
        let children = match (run, subtree.child.kind()) {
            ([_, _, ..], Child::Node(_)) => tree.children(&subtree).ok(),
            _ => None,
        };
        match children {
            Some([left, right]) => {
                let split = run.partition_point(|batch| batch.subtree.first_face < right.first_face);
                let middle = range.start + split;
                stack.push((right, middle..range.end));
                stack.push((left, range.start..middle));
            }
            // A single batch, or a tree that is damaged here: batch by batch.
            None => {
                for batch in run {
                    let triangles = batch.index_count / 3;
                    let runs = triangles.div_ceil((most / 3).max(1) as u32);
                    let bound = |i: u32| 3 * (u64::from(triangles) * u64::from(i) / u64::from(runs)) as u32;
                    for i in 0..runs {
                        piece(batch.subtree, batch.first_index + bound(i), bound(i + 1) - bound(i));
                    }
                }
            }
        }
    }
}

/// A sphere around a subtree, in the model's coordinates: centre and radius.
pub(crate) fn sphere(tree: &fct::Tree, subtree: &Subtree) -> (DVec3, f64) {
    let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    match subtree.child.kind() {
        Child::Node(_) => tree
            .node(subtree)
            .map_or((DVec3::ZERO, 0.0), |node| (vector(node.center), f64::from(node.radius))),
        Child::Face(_) => {
            let corner =
                |v: u32| tree.vertices().get(v as usize).map_or(DVec3::ZERO, |v| vector(v.position()));
            let [a, b, c] = tree.reader().face(subtree).unwrap_or_default().map(corner);
            let center = (a + b + c) / 3.0;
            (center, a.distance(center).max(b.distance(center)).max(c.distance(center)))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tree of `faces` faces, balanced; only its structure is right.
    fn tree(faces: u32) -> fct::Tree {
        fn split(first: u32, end: u32, left_faces: &mut Vec<u32>) {
            if end - first > 1 {
                let middle = first.midpoint(end);
                left_faces.push(middle - first);
                split(first, middle, left_faces);
                split(middle, end, left_faces);
            }
        }
        let mut clusters = fct::PlainClusters {
            faces: vec![[0, 1, 2]; faces as usize],
            positions: vec![[0.0; 3]; 3],
            ..Default::default()
        };
        split(0, faces, &mut clusters.left_faces);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.fct");
        let data = fct::TreeData {
            meta: &fct::Meta::default(),
            clusters: &fct::Packed::new(&clusters).unwrap(),
            vertices: &[fct::VertexRecord::default(); 3],
            weld: &[],
            bounding_polygons: &[],
            normals: None,
            colors: None,
            groups: &[],
        };
        fct::write(&path, &data, &fct::WriteOptions::default()).unwrap();
        fct::Tree::open(&path).unwrap()
    }

    /// A cut of every face as a batch of its own, some left out.
    fn batches(tree: &fct::Tree, faces: u32, kept: impl Fn(u32) -> bool) -> Vec<Batch> {
        let batch = |(face, number): (u32, u32)| Batch {
            subtree: tree.find(fct::ChildRef::face(face)).unwrap(),
            first_index: 3 * number,
            index_count: 3,
            bounding_polygon: None,
            sphere: fcgeom::Sphere::EMPTY,
        };
        (0..faces).filter(|face| kept(*face)).zip(0..).map(batch).collect()
    }

    #[test]
    fn pieces_are_disjoint_cover_everything_and_keep_to_their_size() {
        let tree = tree(1000);
        for most in [3, 30, 299, 5000] {
            for every in [1, 3] {
                let batches = batches(&tree, 1000, |face| face % every == 0);
                let mut end = 0;
                let mut pieces = 0;
                group(&tree, &batches, most, |_, first, count| {
                    assert_eq!(first, end, "a gap or an overlap");
                    assert!(count > 0 && u64::from(count) <= most);
                    end = first + count;
                    pieces += 1;
                });
                assert_eq!(end as usize, 3 * batches.len());
                let fewest = u64::from(end).div_ceil(most);
                assert!(pieces <= 4 * fewest, "{pieces} pieces, {fewest} would do");
            }
        }
    }

    #[test]
    fn no_batches_are_no_pieces() {
        group(&tree(4), &[], 30, |_, _, _| panic!("a piece of nothing"));
    }
}
