//! Shapes that enclose a cluster, from which the polygons for occlusion queries are made.
//!
//! # Paper
//! [Tsuji07, 5.3 and fig. 8]: "the polygons enclosing clusters in the image by establishing and expanding the
//! depth value in front of the cluster".
//!
//! # Deviations
//! What is stored with a cluster is the same for every view: a prism around it. For a view the prism's corners are
//! outlined on screen, see `frame/outline.rs`; no point of the cluster is nearer than that polygon or beside it, so a
//! hidden polygon proves a hidden cluster.

use glam::{DVec3, DVec4};

/// Cosine of 45 degrees.
const DIAGONAL: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// The cosines and sines of k times 45 degrees.
pub(crate) const DIRECTIONS: [[f64; 2]; 8] = [
    [1.0, 0.0],
    [DIAGONAL, DIAGONAL],
    [0.0, 1.0],
    [-DIAGONAL, DIAGONAL],
    [-1.0, 0.0],
    [-DIAGONAL, -DIAGONAL],
    [0.0, -1.0],
    [DIAGONAL, -DIAGONAL],
];

/// How far polygons are grown and lifted toward the eye, in pixels at their farthest corner.
///
/// Rasterisers snap corners to a grid of at worst 1/16 pixel (4 bits; most have 8), so the cluster's corners and the
/// polygon's are each off by at most half of that. More is safe too, but hides less.
pub(crate) const MARGIN_PIXELS: f64 = 1.0 / 16.0;

/// The same, relative to the cluster's size, for rounding in the stored records.
const MARGIN_SIZE: f64 = 1e-4;

/// The nearest that the square before a sphere may be to the eye, as a part of the way to the sphere's centre: nearer it
/// would be huge.
const FLATTEST: f64 = 0.01;

/// A prism around a cluster: the points `origin + x t + y b + z n` with `low <= z <= high` and
/// `x cos(k 45 deg) + y sin(k 45 deg) <= support[k]`, where t is the tangent, n the normal and b = n x t.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prism {
    /// Origin of the frame.
    pub origin: DVec3,
    /// Unit normal.
    pub normal: DVec3,
    /// Unit vector at right angles to the normal.
    pub tangent: DVec3,
    /// Least height.
    pub low: f64,
    /// Greatest height.
    pub high: f64,
    /// Support in eight directions.
    pub support: [f64; 8],
}

impl From<&fct::BoundingPolygon> for Prism {
    fn from(polygon: &fct::BoundingPolygon) -> Prism {
        Prism {
            origin: polygon.origin.into(),
            normal: polygon.normal.into(),
            tangent: polygon.tangent.into(),
            low: polygon.low,
            high: polygon.high,
            support: polygon.support,
        }
    }
}

impl Prism {
    /// The corners of both faces, a hair outside: the cluster lies in their hull, whatever the stored records round.
    pub fn corners(&self) -> [DVec3; 16] {
        let bitangent = self.normal.cross(self.tangent);
        let breadth = self.support.iter().fold(0.0, |sum: f64, s| sum + s.abs());
        let margin = MARGIN_SIZE * (breadth + (self.high - self.low));
        let outline = corners(&self.support.map(|s| s + margin));
        let mut all = [DVec3::ZERO; 16];
        for (out, (height, [x, y])) in all.iter_mut().zip(
            [self.low - margin, self.high + margin]
                .into_iter()
                .flat_map(|h| outline.map(|corner| (h, corner))),
        ) {
            *out = self.origin + x * self.tangent + y * bitangent + height * self.normal;
        }
        all
    }
}

/// The corners of the octagon with the given supports: where neighbouring edges meet.
pub(crate) fn corners(support: &[f64; 8]) -> [[f64; 2]; 8] {
    let mut corners = [[0.0; 2]; 8];
    let next = support.iter().zip(DIRECTIONS).cycle().skip(1);
    for (((corner, a), [ca, sa]), (b, [cb, sb])) in corners.iter_mut().zip(support).zip(DIRECTIONS).zip(next)
    {
        // The edges' directions differ by 45 degrees, so the determinant is the sine of that.
        *corner = [(a * sb - b * sa) / DIAGONAL, (b * ca - a * cb) / DIAGONAL];
    }
    corners
}

/// A square that covers a sphere as seen from the eye and lies in front of it, or `None` if the eye is inside or
/// so near that the square would be seen flat.
pub fn sphere_polygon(center: DVec3, radius: f64, eye: DVec3, pixel: f64) -> Option<[DVec3; 4]> {
    let offset = center - eye;
    let distance = offset.length();
    let margin = MARGIN_SIZE * radius + MARGIN_PIXELS * pixel * (distance + radius);
    let radius = radius + margin;
    let toward = offset.try_normalize()?;
    // The tangent plane at the nearest point, which separates the sphere from the eye.
    let plane = distance - radius;
    let before_the_plane = plane > FLATTEST * distance;
    if !before_the_plane {
        return None;
    }
    let half = plane * radius / (distance * distance - radius * radius).sqrt() + margin;
    let (across, along) = fcgeom::tangent_frame(toward);
    let middle = eye + plane * toward;
    let square = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
        .map(|[x, y]| middle + half * (x * across + y * along));
    square.iter().all(|p| p.is_finite()).then_some(square)
}

/// Corners relative to the eye taken to clip space, a hair nearer than they are, or `None` if one is at or behind
/// the near plane or so far beside the picture that rasterising it would be inexact.
pub fn to_clip<const N: usize>(corners: &[DVec3; N], view: &crate::camera::View) -> Option<[[f32; 4]; N]> {
    /// Beyond this many half pictures from the middle; larger only means more queries.
    const FAR_OUT: f64 = 16.0;
    /// Relative shift of depths toward the eye: many times the rounding of 32-bit depths, and far below what a
    /// pixel's step means on any surface.
    const NEARER: f64 = 1.0 + 4e-6;

    let mut clip = [[0.0; 4]; N];
    for (out, corner) in clip.iter_mut().zip(corners) {
        let p: DVec4 = view.clip_from_eye * corner.extend(1.0);
        let ahead = p.w > view.near * (1.0 + 1e-4);
        if !(ahead && p.x.abs() < FAR_OUT * p.w && p.y.abs() < FAR_OUT * p.w) {
            return None;
        }
        *out = [p.x as f32, p.y as f32, (p.z * NEARER) as f32, p.w as f32];
    }
    Some(clip)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// Whether the ray from the eye through `point` meets the convex polygon before or at the point.
    fn covers(polygon: &[DVec3], eye: DVec3, point: DVec3) -> bool {
        let ray = point - eye;
        let mut sign = 0.0_f64;
        for (a, b) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
            let side = (a - eye).cross(b - eye).dot(ray);
            if side * sign < 0.0 {
                return false;
            }
            if side != 0.0 {
                sign = side;
            }
        }
        let normal = (polygon[1] - polygon[0]).cross(polygon[2] - polygon[0]);
        let along = normal.dot(polygon[0] - eye) / normal.dot(ray);
        along > 0.0 && along <= 1.0
    }

    fn random_prism(random: &mut Random) -> (Prism, Vec<DVec3>) {
        let normal = random.direction();
        let tangent = fcgeom::tangent_frame(normal).0;
        let bitangent = normal.cross(tangent);
        let origin = 10.0 * random.direction();
        let flat = random.unit() * random.unit();
        let points: Vec<DVec3> = (0..12)
            .map(|_| {
                let [x, y, z] = [(); 3].map(|()| 2.0 * random.unit() - 1.0);
                origin + x * tangent + 0.6 * y * bitangent + flat * z * normal
            })
            .collect();
        let mut prism = Prism {
            origin,
            normal,
            tangent,
            low: f64::INFINITY,
            high: f64::NEG_INFINITY,
            support: [f64::NEG_INFINITY; 8],
        };
        for p in &points {
            let (x, y) = ((p - origin).dot(tangent), (p - origin).dot(bitangent));
            prism.low = prism.low.min((p - origin).dot(normal));
            prism.high = prism.high.max((p - origin).dot(normal));
            for (support, [c, s]) in prism.support.iter_mut().zip(DIRECTIONS) {
                *support = support.max(x * c + y * s);
            }
        }
        (prism, points)
    }

    #[test]
    fn the_corners_enclose_the_cluster_and_little_more() {
        let mut random = Random::new(7);
        for _ in 0..2000 {
            let (prism, points) = random_prism(&mut random);
            let corners = prism.corners();
            let along = random.direction();
            let reach =
                |points: &[DVec3]| points.iter().fold(f64::NEG_INFINITY, |far, p| far.max(along.dot(*p)));
            assert!(reach(&corners) > reach(&points), "{prism:?} along {along}");
            for (axis, far) in [(prism.normal, prism.high), (-prism.normal, -prism.low)] {
                let height =
                    corners.iter().fold(f64::NEG_INFINITY, |far, p| far.max(axis.dot(p - prism.origin)));
                assert!((far..far + 1e-2).contains(&height), "{height} for {far}");
            }
        }
    }

    #[test]
    fn the_square_covers_and_precedes_the_sphere() {
        let mut random = Random::new(10);
        let mut squares = 0;
        for _ in 0..2000 {
            let center = 3.0 * random.direction();
            let radius = 0.01 + random.unit();
            let eye = center + (radius * (1.0 + 8.0 * random.unit())) * random.direction();
            let Some(square) = sphere_polygon(center, radius, eye, 1e-3) else { continue };
            squares += 1;
            for _ in 0..20 {
                let p = center + radius * random.direction();
                assert!(covers(&square, eye, p), "center {center} radius {radius} eye {eye} point {p}");
            }
        }
        assert!(squares > 1500, "{squares} squares");
        assert_eq!(sphere_polygon(DVec3::ZERO, 1.0, DVec3::X * 0.5, 1e-3), None);
        assert_eq!(sphere_polygon(DVec3::ZERO, f64::NAN, DVec3::X * 5.0, 1e-3), None);
    }

    #[test]
    fn corners_behind_the_near_plane_or_far_beside_the_picture_are_refused() {
        let camera = crate::camera::Camera { eye: DVec3::ZERO, forward: -DVec3::Z, up: DVec3::Y, fov: 1.0 };
        let view = camera.view([100, 100], 0.5).unwrap();
        let ahead = DVec3::new(0.0, 0.0, -2.0);
        let clip = to_clip(&[ahead], &view).unwrap();
        assert!(f64::from(clip[0][2] / clip[0][3]) > 0.25 && f64::from(clip[0][2] / clip[0][3]) < 0.2501);
        assert_eq!(to_clip(&[ahead, DVec3::new(0.0, 0.0, -0.5)], &view), None);
        assert_eq!(to_clip(&[ahead, DVec3::new(0.0, 0.0, 3.0)], &view), None);
        assert_eq!(to_clip(&[ahead, DVec3::new(900.0, 0.0, -2.0)], &view), None);
        assert_eq!(to_clip(&[DVec3::NAN], &view), None);
    }
}
