//! Whether a model looks inwards, so that a viewer that draws fronts alone shows it hollow.

use crate::scene::Model;
use fcextract::{Extraction, Order, Selection, extract};
use glam::DVec3;

/// Error of the mesh that is judged, over the diagonal of the model's box: coarse is quick, and the sign of a volume
/// bears it.
const COARSE: f64 = 0.02;

/// True if the faces enclose a volume and look into it, judged as `fcbuild` does: at most one edge in a hundred may
/// lack a neighbour, and the volume must be a hundredth of that of the box. A tree that cannot be cut is not judged.
pub fn looks_inwards(model: &Model) -> bool {
    let meta = model.tree.meta();
    if meta.boundary_edges.saturating_add(meta.seam_edges)
        > (model.tree.face_count() as u64).saturating_mul(3) / 200
    {
        return false;
    }
    let mut cut = Extraction::default();
    let selection = Selection::uniform(2.0 * model.reach * COARSE, Order::Bound);
    if extract(&model.tree, &selection, &mut cut).is_err() {
        return false;
    }
    let vertices = model.tree.vertices();
    let corner = |v: &u32| {
        let position = vertices.get(*v as usize).map_or([0.0; 3], |vertex| vertex.position());
        DVec3::from(position.map(f64::from)) - model.center
    };
    let six_volumes: f64 = cut
        .indices
        .as_chunks()
        .0
        .iter()
        .map(|triangle: &[u32; 3]| {
            let [a, b, c] = triangle.each_ref().map(corner);
            a.dot(b.cross(c))
        })
        .sum();
    let size = DVec3::from(meta.bounds_max.map(f64::from)) - DVec3::from(meta.bounds_min.map(f64::from));
    six_volumes / 6.0 < -0.01 * size.element_product()
}
