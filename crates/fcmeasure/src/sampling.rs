//! Points spread evenly over the area of a mesh, the same on every run.

use crate::Surface;
use crate::color::Color;
use glam::DVec3;

/// The one seed: figures of one day can be compared with those of another.
const SEED: u64 = 2007;

/// A point of a mesh, and its colour if the mesh has colours.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    pub(crate) point: DVec3,
    pub(crate) color: Option<Color>,
}

/// `count` points on the mesh, each standing for the same area; none when the mesh has no area.
///
/// The area is cut into `count` equal parts along the order of the faces and each part gets one point, so that a sum
/// over the points varies far less than over points that are drawn freely.
pub fn sample(mesh: Surface<'_>, count: usize) -> Vec<DVec3> {
    samples(mesh, count).iter().map(|sample| sample.point).collect()
}

/// The same with colours.
pub(crate) fn samples(mesh: Surface<'_>, count: usize) -> Vec<Sample> {
    let corners = |f: &[u32; 3]| mesh.corners(f).map(|p| p.as_dvec3());
    let area = |f: &[u32; 3]| {
        let [a, b, c] = corners(f);
        0.5 * (b - a).cross(c - a).length()
    };
    let total: f64 = mesh.faces.iter().map(area).sum();
    if total <= 0.0 || !total.is_finite() {
        return Vec::new();
    }
    let mut points = Vec::with_capacity(count);
    // The area before the next face; rounding leaves the last samples to the last face that has an area.
    let mut done = 0.0;
    let random = |i: usize, k: u64| unit(i as u64, k, SEED);
    let place = |i: usize| (i as f64 + random(i, 0)) / count as f64 * total;
    let point = |i: usize, f: &[u32; 3]| {
        let [a, b, c] = corners(f);
        let (root, along) = (random(i, 1).sqrt(), random(i, 2));
        let weights = DVec3::new(1.0 - root, root * (1.0 - along), root * along);
        Sample {
            point: a * weights.x + b * weights.y + c * weights.z,
            color: mesh.colors(f).map(|colors| Color::between(colors, weights)),
        }
    };
    let mut last = None;
    for f in mesh.faces {
        let own = area(f);
        if own > 0.0 {
            last = Some(f);
        }
        done += own;
        while points.len() < count && place(points.len()) < done {
            points.push(point(points.len(), f));
        }
    }
    if let Some(f) = last {
        while points.len() < count {
            points.push(point(points.len(), f));
        }
    }
    points
}

/// A well mixed hash of two numbers and a seed, as a number in [0, 1) with 53 random bits.
pub(crate) fn unit(x: u64, y: u64, seed: u64) -> f64 {
    let mut h = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15)
        ^ x.wrapping_mul(0xd1b5_4a32_d192_ed03)
        ^ y.wrapping_mul(0xaef1_7502_108e_f2d9).rotate_left(21);
    h ^= h >> 32;
    h = h.wrapping_mul(0xc4ce_b9fe_1a85_ec53);
    h ^= h >> 29;
    h = h.wrapping_mul(0xff51_afd7_ed55_8ccd);
    ((h ^ h >> 32) >> 11) as f64 / (1_u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::Mesh;

    /// Two squares of areas 1 and 3 share 4,000 points as 1 to 3, and either's mean is its centre.
    #[test]
    fn samples_follow_area_and_fill_the_faces() {
        let mut mesh = Mesh::default();
        for (x, side) in [(0.0, 1.0), (10.0, 3.0_f64.sqrt())] {
            let corner = [(0.0, 0.0), (side, 0.0), (side, side), (0.0, side)]
                .map(|(u, v)| mesh.vertex(DVec3::new(x + u, v, 0.0)));
            mesh.quad(corner);
        }
        let points = sample(mesh.surface(), 4_000);
        let (small, large): (Vec<DVec3>, Vec<DVec3>) = points.iter().partition(|p| p.x < 5.0);
        assert_eq!((small.len(), large.len()), (1_000, 3_000));
        for (side, x, points) in [(1.0, 0.0, small), (3.0_f64.sqrt(), 10.0, large)] {
            let mean = points.iter().sum::<DVec3>() / points.len() as f64;
            assert!((mean - DVec3::new(x + side / 2.0, side / 2.0, 0.0)).length() < 0.02 * side, "{mean}");
            assert!(points.iter().all(|p| p.x >= x && p.x <= x + side && p.y >= 0.0 && p.y <= side));
        }
    }

    #[test]
    fn a_mesh_without_area_has_no_samples() {
        assert!(sample(Mesh::default().surface(), 10).is_empty());
        let flat = Mesh { positions: vec![[1.0; 3]; 3], faces: vec![[0, 1, 2]], colors: Vec::new() };
        assert!(sample(flat.surface(), 10).is_empty());
    }
}
