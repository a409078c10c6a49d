//! Which pieces are worth an occlusion query, and by which polygon.

use super::cut::Cuts;
use super::pieces::{Piece, sphere};
use crate::bounding_polygon::{Prism, sphere_polygon, to_clip};
use crate::camera::View;
use crate::gpu::occlusion::PolygonList;
use crate::scene::Scene;
use fct::Child;

/// Pieces of fewer triangles are drawn unasked: a query costs about as much as drawing them.
const FEWEST_TRIANGLES: u32 = 32;

/// Fills `polygons` for those of the pieces, at most `most`, that are worth a query, and `asked` with their numbers,
/// rising.
pub(crate) fn questions(
    scene: &Scene,
    view: &View,
    cuts: &Cuts,
    pieces: &[Piece],
    most: usize,
    polygons: &mut PolygonList,
    asked: &mut Vec<usize>,
) {
    asked.clear();
    asked.extend((0..pieces.len()).filter(|i| size(pieces, *i) >= FEWEST_TRIANGLES));
    if asked.len() > most {
        asked.sort_by_key(|i| (std::cmp::Reverse(size(pieces, *i)), *i));
        asked.truncate(most);
        asked.sort_unstable();
    }
    polygons.clear();
    asked.retain(|i| pieces.get(*i).and_then(|piece| ask(scene, view, cuts, piece, polygons)).is_some());
}

fn size(pieces: &[Piece], i: usize) -> u32 {
    pieces.get(i).map_or(0, |piece| piece.index_count / 3)
}

/// Adds the polygon of a piece; `None` if it has none that is safe, so that it counts as visible.
fn ask(scene: &Scene, view: &View, cuts: &Cuts, piece: &Piece, polygons: &mut PolygonList) -> Option<()> {
    let instance = scene.instances.get(cuts.placed.get(piece.placed as usize)?.instance)?;
    let tree = &scene.models.get(instance.model)?.tree;
    let eye = instance.to_model(view.eye);
    let from_eye = |p: glam::DVec3| instance.rotation * ((p - eye) * instance.scale);
    let record = match piece.node.kind() {
        Child::Node(node) => {
            let records = tree.bounding_polygons();
            let found = records.binary_search_by_key(&node, |record| record.node.get()).ok();
            found.and_then(|i| records.get(i))
        }
        Child::Face(_) => None,
    };
    let octagon = record.and_then(|record| Prism::from(record).polygon(eye, view.pixel));
    if let Some(clip) = octagon.and_then(|corners| to_clip(&corners.map(from_eye), view)) {
        polygons.push(&clip);
        return Some(());
    }
    let (center, radius) = sphere(tree, piece.node);
    let square = sphere_polygon(center, radius, eye, view.pixel)?;
    polygons.push(&to_clip(&square.map(from_eye), view)?);
    Some(())
}
