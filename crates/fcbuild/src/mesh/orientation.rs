//! Whether a surface looks outwards.

use super::DualGraph;
use glam::{DVec3, Vec3};

/// True if the faces enclose a volume and look into it, as in a scan stored with the wrong winding.
///
/// Only surfaces that are closed but for small holes are judged: at most one edge in a hundred may lack a neighbour,
/// and the volume must be a hundredth of that of the bounding box, or chance decides the sign.
pub(super) fn looks_inwards(positions: &[Vec3], faces: &[[u32; 3]], graph: &DualGraph) -> bool {
    if graph.boundary_edges + graph.seam_edges > faces.len() as u64 * 3 / 200 {
        return false;
    }
    let corners = |f: &[u32; 3]| f.map(|v| positions[v as usize].as_dvec3());
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for p in faces.iter().flat_map(corners) {
        low = low.min(p);
        high = high.max(p);
    }
    let center = (low + high) * 0.5;
    let six_volumes: f64 = faces
        .iter()
        .map(|f| {
            let [a, b, c] = corners(f).map(|p| p - center);
            a.dot(b.cross(c))
        })
        .sum();
    six_volumes / 6.0 < -0.01 * (high - low).element_product()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tetrahedron_is_told_from_its_inside() {
        let p = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        let out = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let inside = out.map(|[a, b, c]| [a, c, b]);
        assert!(!looks_inwards(&p, &out, &DualGraph::of(&out, 4, &[])));
        assert!(looks_inwards(&p, &inside, &DualGraph::of(&inside, 4, &[])));
        // Without one face it is open, and nothing is said.
        assert!(!looks_inwards(&p, &inside[..3], &DualGraph::of(&inside[..3], 4, &[])));
    }
}
