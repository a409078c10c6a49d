//! The pieces of a frame, front to back, and which of them are worth an occlusion query.

use super::cut::{CutId, Cuts};
use crate::bounding_polygon::{Prism, sphere_polygon, to_clip};
use crate::camera::View;
use crate::gpu::occlusion::PolygonList;
use crate::scene::Scene;

/// A subtree's triangles in one instance: what is drawn or left out together.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece {
    /// Number of the placed instance, which is also its row on the GPU.
    pub(crate) placed: u32,
    /// Its cut.
    pub(crate) cut: CutId,
    /// Its batch within the cut.
    pub(crate) batch: u32,
    /// Its first index within the cut.
    pub(crate) first_index: u32,
    /// Its number of indices.
    pub(crate) index_count: u32,
    /// Distance of the eye from its sphere; negative inside.
    near: f64,
}

/// Queries a frame: more would cost more than most frames can win, and some drivers stall on thousands.
const MOST_QUERIES: usize = 2048;

/// Batches of fewer triangles are drawn unasked: a query costs about as much as drawing them.
const FEWEST_TRIANGLES: u32 = 48;

/// All pieces, nearest first. The order depends on the scene and the view alone, never on threads or times.
pub(crate) fn pieces(scene: &Scene, view: &View, cuts: &Cuts, out: &mut Vec<Piece>) {
    out.clear();
    for (placed, number) in cuts.placed.iter().zip(0_u32..) {
        let (Some(instance), Some(slot)) = (scene.instances.get(placed.instance), cuts.slot(placed.cut))
        else {
            continue;
        };
        let eye = instance.to_model(view.eye);
        for (batch, index) in slot.extraction.batches.iter().zip(0_u32..) {
            if batch.index_count == 0 {
                continue;
            }
            let distance = batch.sphere.center.as_dvec3().distance(eye) - f64::from(batch.sphere.radius);
            out.push(Piece {
                placed: number,
                cut: placed.cut,
                batch: index,
                first_index: batch.first_index,
                index_count: batch.index_count,
                near: distance * instance.scale,
            });
        }
    }
    out.sort_by(|a, b| a.near.total_cmp(&b.near).then((a.placed, a.batch).cmp(&(b.placed, b.batch))));
}

/// The number of pieces, from the first, that hold at least a fraction of all `triangles`.
pub(crate) fn leading(pieces: &[Piece], indices: u64) -> usize {
    let mut sum = 0;
    for (piece, number) in pieces.iter().zip(1_usize..) {
        sum += u64::from(piece.index_count);
        if sum >= indices {
            return number;
        }
    }
    pieces.len()
}

/// Fills `polygons` for those pieces that are worth a query, and `asked` with their numbers.
pub(crate) fn questions(
    scene: &Scene,
    view: &View,
    cuts: &Cuts,
    pieces: &[Piece],
    polygons: &mut PolygonList,
    asked: &mut Vec<usize>,
) {
    asked.clear();
    asked.extend((0..pieces.len()).filter(|i| size(pieces, *i) >= FEWEST_TRIANGLES));
    if asked.len() > MOST_QUERIES {
        asked.sort_by_key(|i| (std::cmp::Reverse(size(pieces, *i)), *i));
        asked.truncate(MOST_QUERIES);
        asked.sort_unstable();
    }
    polygons.clear();
    asked.retain(|i| {
        pieces.get(*i).and_then(|piece| ask(scene, view, cuts, piece, polygons)).is_some()
    });
}

fn size(pieces: &[Piece], i: usize) -> u32 {
    pieces.get(i).map_or(0, |piece| piece.index_count / 3)
}

/// Adds the polygon of a piece; `None` if it has none that is safe, so that it counts as visible.
fn ask(scene: &Scene, view: &View, cuts: &Cuts, piece: &Piece, polygons: &mut PolygonList) -> Option<()> {
    let placed = cuts.placed.get(piece.placed as usize)?;
    let instance = scene.instances.get(placed.instance)?;
    let slot = cuts.slot(piece.cut)?;
    let batch = slot.extraction.batches.get(piece.batch as usize)?;
    let model = scene.models.get(slot.model)?;
    let eye = instance.to_model(view.eye);
    let from_eye = |p: glam::DVec3| instance.rotation * ((p - eye) * instance.scale);
    let record = batch.bounding_polygon.and_then(|i| model.tree.bounding_polygons().get(i as usize));
    let octagon = record.and_then(|record| Prism::from(record).polygon(eye, view.pixel));
    if let Some(clip) = octagon.and_then(|corners| to_clip(&corners.map(from_eye), view)) {
        polygons.push(&clip);
        return Some(());
    }
    let center = batch.sphere.center.as_dvec3();
    let square = sphere_polygon(center, f64::from(batch.sphere.radius), eye, view.pixel)?;
    polygons.push(&to_clip(&square.map(from_eye), view)?);
    Some(())
}
