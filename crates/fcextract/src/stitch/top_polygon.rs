//! Polygons of few corners above the pages: the general way's own numbers, worked out side by side.

use super::best::{BEST_UP_TO, Best};
use super::{grid, position};
use fct::{Node, VertexRecord};
use glam::{DVec2, DVec3};

/// One number a corner, and as many as fill the machine's vectors.
type Lanes = [f64; BEST_UP_TO];

/// Lays the corners of a node that does not fold over into the plane of its cone's axis, as seen from the first one, and
/// in a unit of their own. `first_corner` is that of the node's first face.
pub(super) fn lay(
    records: &[VertexRecord],
    vertices: &[u32],
    (node, first_corner): (&Node, u32),
    best: &mut Best,
) {
    let axis = DVec3::from_array(node.axis().map(f64::from));
    let (normal, height) = node.plane();
    let normal = DVec3::from_array(normal);
    let level = normal.dot(position(records, first_corner)) + height;
    let first = vertices.first().map_or(DVec3::ZERO, |first| position(records, *first));
    // Lanes beyond the last corner have the first one.
    let mut at = [[first.x; BEST_UP_TO], [first.y; BEST_UP_TO], [first.z; BEST_UP_TO]];
    let [x, y, z] = &mut at;
    for (((x, y), z), vertex) in x.iter_mut().zip(y).zip(z).zip(vertices) {
        [*x, *y, *z] = position(records, *vertex).to_array();
    }
    let frame = fcgeom::tangent_frame(axis);
    match vertices.len() {
        ..=4 => project::<4>(&at, first, frame, (normal, level), best),
        5..=8 => project::<8>(&at, first, frame, (normal, level), best),
        _ => project::<BEST_UP_TO>(&at, first, frame, (normal, level), best),
    }
}

#[inline(always)]
fn project<const LANES: usize>(
    [x, y, z]: &[Lanes; 3],
    first: DVec3,
    (tangent, other): (DVec3, DVec3),
    (normal, level): (DVec3, f64),
    best: &mut Best,
) {
    let mut points = [DVec2::ZERO; LANES];
    for (i, point) in points.iter_mut().enumerate() {
        let p = DVec3::new(x[i], y[i], z[i]) - first;
        *point = DVec2::new(p.dot(tangent), p.dot(other));
    }
    let scale = grid::snap(&mut points);
    let size = points.iter().fold(0.0_f64, |size, p| size.max(p.x.abs()).max(p.y.abs()));
    for (i, point) in points.iter().enumerate() {
        let height = scale * (normal.dot(DVec3::new(x[i], y[i], z[i])) - level);
        best.x[i] = (point.x / size) as f32;
        best.y[i] = (point.y / size) as f32;
        best.height[i] = (height / size) as f32;
    }
}
