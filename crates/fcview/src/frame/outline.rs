//! An octagon on screen around the triangles of a small piece, and before them.
//!
//! A piece that is no subtree of its own has no stored bounding polygon, and a stored one, made for the surface at
//! full resolution and for any view, is larger than a few triangles need. Few corners are soon looked at one by one.
//!
//! # Paper
//! [Tsuji07, 5.3 and fig. 8]: a polygon "enclosing the cluster in the image".
//!
//! # Deviations
//! The polygon follows the slope of the triangles in depth instead of lying across the view at their nearest corner,
//! so that it does not rise above what is before a slanting piece.

use crate::bounding_polygon::{DIRECTIONS, MARGIN_PIXELS, corners};
use crate::camera::View;
use glam::{DMat4, DVec3, DVec4};

/// Takes a model's corners to the screen.
pub(crate) struct Screen {
    clip_from_model: DMat4,
    near: f64,
    /// A pixel's width and height where the picture is 2 wide and 2 high.
    pixel: [f64; 2],
    /// How far 32-bit positions may be off, in the scene's unit.
    slack: f64,
    /// Relative lift of depths toward the eye.
    lift: f64,
}

/// Corners of a convex polygon in clip space.
pub(crate) type Octagon = [[f32; 4]; 8];

/// Beyond this many half pictures from the middle a polygon may be rasterised inexactly; it is not asked about.
const FAR_OUT: f64 = 16.0;

impl Screen {
    /// For a model placed by `world_from_model`, all of it within `reach` of the eye.
    pub(crate) fn new(view: &View, world_from_model: DMat4, reach: f64) -> Screen {
        let m = &view.clip_from_eye;
        let pixel = [0, 1].map(|k| view.pixel * m.row(k).truncate().length());
        Screen {
            clip_from_model: view.clip_from_world() * world_from_model,
            near: view.near,
            pixel,
            // A position goes through about ten roundings of one part in 2^24.
            slack: 1e-6 * reach,
            // A corner that the rasteriser snaps to its grid takes its depth along; rounding adds far less.
            lift: MARGIN_PIXELS * view.pixel + 4e-6,
        }
    }

    /// Where a point of the model is seen, in clip space; none unless it is before the eye.
    pub(crate) fn clip(&self, point: DVec3) -> Option<DVec4> {
        let clip = self.clip_from_model * point.extend(1.0);
        (clip.w > self.near).then_some(clip)
    }

    /// The octagon around some points of the model, or `None` if there is none that is safe; the piece then counts as
    /// visible. `scratch` is overwritten.
    pub(crate) fn octagon(
        &self,
        points: impl Iterator<Item = DVec3>,
        scratch: &mut Vec<DVec3>,
    ) -> Option<Octagon> {
        scratch.clear();
        let [px, py] = self.pixel;
        let mut nearest = f64::INFINITY;
        for p in points {
            let clip: DVec4 = self.clip_from_model * p.extend(1.0);
            let ahead = clip.w > self.near * (1.0 + 1e-4);
            if !ahead {
                return None;
            }
            nearest = nearest.min(clip.w);
            scratch.push(DVec3::new(clip.x / (px * clip.w), clip.y / (py * clip.w), clip.z / clip.w));
        }
        let off = self.slack / nearest;
        let exact = off < 1e-2;
        let first = scratch.first()?;
        if !exact {
            return None;
        }

        let margin = 2.0 * MARGIN_PIXELS + off / px.min(py);
        let mut support = [f64::NEG_INFINITY; 8];
        for p in scratch.iter() {
            for (support, [c, s]) in support.iter_mut().zip(DIRECTIONS) {
                *support = support.max(p.x * c + p.y * s);
            }
        }
        let outline = corners(&support.map(|s| s + margin));
        let inside = |[x, y]: [f64; 2]| (x * px).abs() < FAR_OUT && (y * py).abs() < FAR_OUT;
        if !outline.iter().all(|corner| inside(*corner)) {
            return None;
        }

        let lift = 1.0 + self.lift + 2.0 * off;
        let plane = |[a, b]: [f64; 2]| {
            let above = |p: &DVec3| p.z - a * (p.x - first.x) - b * (p.y - first.y);
            let height = scratch.iter().fold(f64::NEG_INFINITY, |height, p| height.max(above(p)));
            let height = height + (a.abs() + b.abs()) * margin;
            outline.map(|[x, y]| (height + a * (x - first.x) + b * (y - first.y)) * lift)
        };
        let mut depths = plane(slope(scratch));
        let [low, high] = range(&depths);
        // Interpolation rounds relative to the largest depth, and clipping would cut the polygon.
        let gentle = low > 0.5 * high && high < 1.0;
        if !gentle {
            depths = plane([0.0; 2]);
        }
        let [low, high] = range(&depths);
        let drawable = low > 0.0 && high < 1.0;
        let mut octagon = [[0.0; 4]; 8];
        for ((out, [x, y]), depth) in octagon.iter_mut().zip(outline).zip(depths) {
            *out = [(x * px) as f32, (y * py) as f32, depth as f32, 1.0];
        }
        drawable.then_some(octagon)
    }
}

/// The gradient of the plane that fits points (x, y, depth) best, or none where they lie about on a line.
fn slope(points: &[DVec3]) -> [f64; 2] {
    let middle = points.iter().sum::<DVec3>() / points.len() as f64;
    let [mut xx, mut xy, mut yy, mut xz, mut yz] = [0.0; 5];
    for p in points {
        let d = *p - middle;
        xx += d.x * d.x;
        xy += d.x * d.y;
        yy += d.y * d.y;
        xz += d.x * d.z;
        yz += d.y * d.z;
    }
    let determinant = xx * yy - xy * xy;
    let wide = determinant > 1e-3 * (xx + yy) * (xx + yy);
    if wide { [(xz * yy - yz * xy) / determinant, (yz * xx - xz * xy) / determinant] } else { [0.0; 2] }
}

fn range(values: &[f64; 8]) -> [f64; 2] {
    values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(*v), high.max(*v)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::random::Random;

    const SIZE: [u32; 2] = [640, 360];

    fn view() -> View {
        let camera = Camera::look_at(DVec3::new(1.0, 2.0, 5.0), DVec3::new(0.2, 0.1, -0.3), 0.8).unwrap();
        camera.view(SIZE, 0.01).unwrap()
    }

    /// Points about a slanting plane somewhere in the view.
    fn points(random: &mut Random, size: f64) -> Vec<DVec3> {
        let normal = random.direction();
        let (t, b) = fcgeom::tangent_frame(normal);
        let middle = random.direction() * random.unit();
        let mut offset = || 2.0 * random.unit() - 1.0;
        (0..12).map(|_| middle + size * (offset() * t + offset() * b + 0.1 * offset() * normal)).collect()
    }

    /// How far a pixel lies within the octagon, in pixels, and the octagon's depth there.
    fn at(octagon: &Octagon, [x, y]: [f64; 2]) -> (f64, f64) {
        let corners = octagon.map(|c| {
            let [x, y, z, _] = c.map(f64::from);
            DVec3::new(0.5 * x * f64::from(SIZE[0]), 0.5 * y * f64::from(SIZE[1]), z)
        });
        let mut within = f64::INFINITY;
        for (p, q) in corners.iter().zip(corners.iter().cycle().skip(1)) {
            let edge = (q - p).truncate();
            within = within.min(edge.perp_dot(glam::DVec2::new(x, y) - p.truncate()) / edge.length());
        }
        let [p, q, r] = [corners[0], corners[2], corners[5]];
        let normal = (q - p).cross(r - p);
        let depth = p.z - (normal.x * (x - p.x) + normal.y * (y - p.y)) / normal.z;
        (within, depth)
    }

    fn project(view: &View, p: DVec3) -> ([f64; 2], f64) {
        let clip = view.clip_from_world() * p.extend(1.0);
        let pixel = |v: f64, size: u32| 0.5 * v / clip.w * f64::from(size);
        ([pixel(clip.x, SIZE[0]), pixel(clip.y, SIZE[1])], clip.z / clip.w)
    }

    #[test]
    fn the_octagon_lies_around_and_before_every_point_and_close_to_them() {
        let view = view();
        let mut random = Random::new(12);
        let screen = Screen::new(&view, DMat4::IDENTITY, 10.0);
        let mut scratch = Vec::new();
        for _ in 0..3000 {
            let size = 0.3 * random.unit() + 1e-3;
            let points = points(&mut random, size);
            let octagon = screen.octagon(points.iter().copied(), &mut scratch).unwrap();
            let [mut widest, mut highest] = [f64::INFINITY; 2];
            for p in &points {
                let (pixel, depth) = project(&view, *p);
                let (within, before) = at(&octagon, pixel);
                assert!(within > MARGIN_PIXELS, "a point {within} pixels within");
                assert!(before > depth, "a point at {depth}, the octagon at {before}");
                widest = widest.min(within);
                highest = highest.min(before / depth - 1.0);
            }
            assert!(widest < 0.2, "{widest} pixels around the points");
            assert!(highest < 0.01, "{highest} before the points");
        }
    }

    #[test]
    fn a_slanting_piece_has_a_slanting_octagon() {
        let view = view();
        let screen = Screen::new(&view, DMat4::IDENTITY, 10.0);
        let slant = (view.right + view.forward) * 0.2;
        let points = [DVec3::ZERO, slant, view.up * 0.2, slant + view.up * 0.2];
        let octagon = screen.octagon(points.into_iter(), &mut Vec::new()).unwrap();
        for p in points {
            let (pixel, depth) = project(&view, p);
            let (_, before) = at(&octagon, pixel);
            assert!(before / depth - 1.0 < 1e-2, "{before} and {depth}");
        }
    }

    #[test]
    fn points_behind_the_eye_far_beside_the_picture_or_without_a_place_have_none() {
        let view = view();
        let screen = Screen::new(&view, DMat4::IDENTITY, 10.0);
        let octagon = |points: &[DVec3]| screen.octagon(points.iter().copied(), &mut Vec::new());
        let seen = view.eye + view.forward;
        assert!(octagon(&[seen]).is_some());
        assert_eq!(octagon(&[]), None);
        assert_eq!(octagon(&[seen, view.eye - view.forward]), None);
        assert_eq!(octagon(&[seen, seen + 20.0 * view.right]), None);
        assert_eq!(octagon(&[seen, DVec3::NAN]), None);
        // A hair before the eye, 32-bit positions say too little.
        assert!(octagon(&[view.eye + 0.02 * view.forward]).is_some());
        let vast = Screen::new(&view, DMat4::IDENTITY, 1e6);
        assert_eq!(vast.octagon([view.eye + 0.02 * view.forward].into_iter(), &mut Vec::new()), None);
    }
}
