//! How much error is allowed where.

use crate::Error;
use glam::DVec3;

/// The error that a selection allows, by place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tolerance {
    /// None at all: every node is refined and the input's faces come out.
    Full,
    /// The same distance everywhere, in the tree's unit.
    Uniform {
        /// Not negative; infinite asks for the coarsest mesh.
        distance: f64,
    },
    /// As seen from a point.
    Perspective(Perspective),
}

/// A tolerance that grows with the distance from an eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Perspective {
    /// The eye, in the tree's coordinates.
    pub eye: DVec3,
    /// Direction of the view, of length 1 but for rounding; zero for all directions alike, which takes a point to be in the
    /// image centre.
    pub axis: DVec3,
    /// Allowed error per unit of distance from the eye, 0 or more. For an error of `p` pixels in an image `h` pixels high
    /// with a vertical field of view `f`, that is `p * 2 tan(f / 2) / h`.
    pub slope: f64,
    /// Cosine of the angle between the axis and the corner of the image. Perspective magnifies what is off the axis,
    /// by 1 / cos^2 of the angle; beyond the corner nothing is seen and the factor stays. With a vertical field of view `f`
    /// and a width `a` times the height, that is `1 / sqrt(1 + tan^2(f / 2) (1 + a^2))`.
    pub corner_cos: f64,
}

/// How far the length of an axis may be off 1: what rotations in single precision leave of it. What is allowed is then up to
/// twice as far off, which is nothing beside a pixel.
const AXIS_ROUNDING: f64 = 1e-4;

/// What a view allows around a sphere, but for rounding.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Near {
    /// No less than in any sphere that has a point in common with this one.
    pub(crate) most: f64,
    /// No more than in the sphere, and in any that lies in it.
    pub(crate) least: f64,
    /// The same for a sphere that is larger.
    pub(crate) least_wider: f64,
}

impl Tolerance {
    /// Whether something with this key and bounding sphere (a centre and a radius, asked for where they matter) must be
    /// refined: the key may be over the tolerance somewhere in the sphere.
    ///
    /// Nodes and vertices pass the same test. It is monotone: what has a smaller key and a sphere inside is refined
    /// only if this is. In doubt (NaN) it refines.
    #[inline]
    pub fn refines(&self, key: f32, sphere: impl FnOnce() -> (DVec3, f64)) -> bool {
        if let Tolerance::Perspective(view) = self {
            let (center, radius) = sphere();
            return view.is_exceeded(f64::from(key), center, radius);
        }
        Tolerance::is_over(key, self.allowed(sphere))
    }

    /// The test itself, where so much is allowed.
    #[inline]
    pub(crate) fn is_over(key: f32, allowed: Option<f64>) -> bool {
        let key = f64::from(key);
        // Where nothing is allowed even a key of 0 is refined.
        let Some(allowed) = allowed else { return true };
        key > allowed || key.is_nan() || allowed.is_nan()
    }

    /// As seen without perspective, in a picture `height` pixels high that shows `size` units of length: an error of
    /// `pixels` is as long everywhere.
    pub fn orthographic(pixels: f64, size: f64, height: f64) -> Tolerance {
        Tolerance::Uniform { distance: pixels * size / height }
    }

    /// As seen by a camera, see [`Perspective::new`].
    pub fn perspective(eye: DVec3, axis: DVec3, fov: f64, size: [f64; 2], pixels: f64) -> Tolerance {
        Tolerance::Perspective(Perspective::new(eye, axis, fov, size, pixels))
    }

    /// Refuses numbers that no tolerance follows from.
    pub(crate) fn check(&self) -> Result<(), Error> {
        match self {
            Tolerance::Uniform { distance } if distance.is_nan() || *distance < 0.0 => Err(Error::Selection(
                format!("its tolerance is a distance of {distance}; it is a length of 0 or more"),
            )),
            Tolerance::Full | Tolerance::Uniform { .. } => Ok(()),
            Tolerance::Perspective(view) => view.check(),
        }
    }

    /// The tolerance that allows `factor` times as much everywhere: nothing for 0, anything for infinity.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Tolerance {
        match self {
            _ if factor == 0.0 => Tolerance::Full,
            _ if factor == f64::INFINITY => Tolerance::Uniform { distance: factor },
            Tolerance::Full => Tolerance::Full,
            Tolerance::Uniform { distance } => Tolerance::Uniform { distance: distance * factor },
            Tolerance::Perspective(p) => Tolerance::Perspective(Perspective { slope: p.slope * factor, ..p }),
        }
    }

    /// The least error allowed in a sphere; none for the input's faces.
    #[inline]
    pub(crate) fn allowed(&self, sphere: impl FnOnce() -> (DVec3, f64)) -> Option<f64> {
        match self {
            Tolerance::Full => None,
            // Nodes that must never be drawn have an infinite key: no tolerance reaches it.
            Tolerance::Uniform { distance } => Some(distance.min(f64::MAX)),
            Tolerance::Perspective(p) => {
                let (center, radius) = sphere();
                Some(p.at(center, radius).min(f64::MAX))
            }
        }
    }
}

impl Perspective {
    /// A camera's: in its picture no error is longer than `pixels`.
    ///
    /// `eye` is where it stands and `axis` where it looks, of any length but zero, both in the tree's coordinates; see
    /// [`Selection::in_local_space`](crate::Selection::in_local_space) for those of a world with many models. `fov` is the
    /// vertical field of view in radians, more than 0 and less than pi; `size` is the width and the height of the picture in
    /// pixels. What comes of other numbers is refused when it is used, as [`Error::Selection`].
    ///
    /// ```
    /// # use fcextract::{Order, Perspective, Selection};
    /// # use glam::DVec3;
    /// let (eye, target) = (DVec3::new(0.0, 1.0, 5.0), DVec3::ZERO);
    /// let view = Perspective::new(eye, target - eye, 60_f64.to_radians(), [1920.0, 1080.0], 1.0);
    /// let selection = Selection::perspective(view, Order::Bound);
    /// ```
    pub fn new(eye: DVec3, axis: DVec3, fov: f64, size: [f64; 2], pixels: f64) -> Perspective {
        let [width, height] = size;
        let (aspect, tangent) = (width / height, (0.5 * fov).tan());
        Perspective {
            eye,
            // What has no direction is not made up for.
            axis: axis.try_normalize().unwrap_or(axis),
            slope: pixels * (2.0 * tangent / height),
            corner_cos: 1.0 / (1.0 + tangent * tangent * (1.0 + aspect * aspect)).sqrt(),
        }
    }

    fn check(&self) -> Result<(), Error> {
        let Perspective { eye, axis, slope, corner_cos } = self;
        let wrong = |what: String| Err(Error::Selection(format!("its tolerance has {what}")));
        if !eye.is_finite() {
            return wrong(format!("an eye of {eye}, which is not finite"));
        }
        let length = axis.length();
        // Written so that NaN is refused.
        if !(*axis == DVec3::ZERO || (length - 1.0).abs() <= AXIS_ROUNDING) {
            return wrong(format!("an axis of {axis}, of length {length}; it is of length 1, or zero"));
        }
        if slope.is_nan() || *slope < 0.0 {
            return wrong(format!("a slope of {slope}; it is a number of 0 or more"));
        }
        if (-1.0..=1.0).contains(corner_cos) {
            return Ok(());
        }
        wrong(format!("a corner_cos of {corner_cos}; it is a number from -1 to 1"))
    }

    /// The least error allowed in a sphere, the growth of perspective off the axis counted; zero around the eye.
    pub fn at(&self, center: DVec3, radius: f64) -> f64 {
        let to_center = center - self.eye;
        let distance = to_center.length();
        let nearest = distance - radius;
        if nearest <= 0.0 {
            return 0.0;
        }
        if self.axis == DVec3::ZERO {
            return self.slope * nearest;
        }
        let cos_farthest = self.cos_farthest(to_center, distance, radius);
        self.slope * nearest * cos_farthest * cos_farthest
    }

    /// What is allowed in and around a sphere, without looking closely. The cosine of the corner must not be negative.
    ///
    /// The nearest point of a sphere that has a point in common with this one is no farther than the farthest of this one,
    /// and the angle of its farthest no smaller than the smallest here.
    pub(crate) fn near(&self, center: DVec3, radius: f64, wider: f64) -> Near {
        let to_center = center - self.eye;
        let distance = to_center.length();
        let per_distance = 1.0 / distance;
        let sin_sphere = radius * per_distance;
        // Of a sphere so many times as large.
        let nearest = |times: f64| self.slope * (distance - times * radius).max(0.0);
        let farthest = self.slope * (distance + radius);
        if self.axis == DVec3::ZERO {
            return Near { most: farthest, least: nearest(1.0), least_wider: nearest(wider) };
        }
        let cos = (to_center.dot(self.axis) * per_distance).clamp(-1.0, 1.0);
        let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
        // cos(angle to the centre +- b) = cos cos b -+ sin sin b, without the root that gives cos b by sin b: it is no less
        // than 1 - x / 2 - x x / 2 with x = sin b sin b, and no more than 1.
        let least = |times: f64| {
            let sin_sphere = times * sin_sphere;
            let x = sin_sphere * sin_sphere;
            let along = cos.max(0.0) * (1.0 - 0.5 * (x + x * x)) + cos.min(0.0);
            let cos_farthest = (along - sin * sin_sphere).max(self.corner_cos);
            let cos_farthest = if x < 1.0 { cos_farthest } else { self.corner_cos };
            nearest(times) * cos_farthest * cos_farthest
        };
        let cos_nearest = (cos.max(0.0) + sin * sin_sphere).max(self.corner_cos).min(1.0);
        let most = if sin_sphere < 1.0 { farthest * cos_nearest * cos_nearest } else { farthest };
        Near { most, least: least(1.0), least_wider: least(wider) }
    }

    /// Whether a length is more than what is allowed in a sphere: exactly what comparing it with [`Perspective::at`] says,
    /// mostly without finding out the angle, which takes longest.
    #[inline]
    pub(crate) fn is_exceeded(&self, length: f64, center: DVec3, radius: f64) -> bool {
        let to_center = center - self.eye;
        let distance = to_center.length();
        let nearest = distance - radius;
        if nearest <= 0.0 {
            return length > 0.0 || length.is_nan();
        }
        // No more is allowed than in the image centre, and no less than in its corner; products of rounded numbers keep
        // that order.
        let most = (self.slope * nearest).min(f64::MAX);
        if length > most || length.is_nan() || most.is_nan() {
            return true;
        }
        let corner = self.corner_cos.max(0.0);
        if self.axis == DVec3::ZERO || length <= most * corner * corner {
            return false;
        }
        let cos_farthest = self.cos_farthest(to_center, distance, radius);
        length > most * cos_farthest * cos_farthest
    }

    /// The cosine of the largest angle off the axis in a sphere, but no less than that of the corner.
    fn cos_farthest(&self, to_center: DVec3, distance: f64, radius: f64) -> f64 {
        // cos(angle to the centre + asin(r / d)).
        let cos = (to_center.dot(self.axis) / distance).clamp(-1.0, 1.0);
        let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
        let sin_sphere = radius / distance;
        let cos_sphere = ((1.0 - sin_sphere) * (1.0 + sin_sphere)).sqrt();
        (cos * cos_sphere - sin * sin_sphere).max(self.corner_cos).min(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn random(state: &mut u64) -> f64 {
        *state ^= *state << 13;
        *state ^= *state >> 7;
        *state ^= *state << 17;
        (*state >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// No displacement as long as the tolerance, anywhere in the sphere and in any direction, moves a point on
    /// screen by more than the pixels asked for.
    #[test]
    fn a_tolerated_displacement_stays_within_the_pixels() {
        let (mut state, half_fov_tan, height, pixels) = (9, 0.577_350_269, 720.0, 1.5);
        let corner = 16.0 / 9.0 * half_fov_tan;
        let size = [16.0 / 9.0 * height, height];
        let fov = 2.0 * f64::atan(half_fov_tan);
        let view = Perspective::new(DVec3::ZERO, 3.0 * DVec3::Z, fov, size, pixels);
        let project = |p: DVec3| p.truncate() / p.z * height / (2.0 * half_fov_tan);
        let mut signed = || random(&mut state) * 2.0 - 1.0;
        let mut tightest = 0.0_f64;
        for _ in 0..20_000 {
            let center = DVec3::new(signed() * corner, signed() * half_fov_tan, 1.0) * (3.0 + signed());
            let radius = 0.3 * signed().abs();
            let inside = |v: DVec3| v.x.abs() <= corner * v.z && v.y.abs() <= half_fov_tan * v.z;
            let p = center + DVec3::new(signed(), signed(), signed()).normalize_or_zero() * radius;
            let step = DVec3::new(signed(), signed(), signed()).normalize_or_zero() * view.at(center, radius);
            if inside(p) {
                let moved = (project(p + step) - project(p)).length();
                assert!(moved <= pixels * 1.01, "{moved} pixels at {p}");
                tightest = tightest.max(moved / pixels);
            }
        }
        assert!(tightest > 0.9, "the tolerance wastes {tightest}");
    }

    #[test]
    fn the_short_way_to_compare_agrees_with_the_long_one() {
        let mut state = 5;
        let mut signed = || random(&mut state) * 2.0 - 1.0;
        let mut refined = 0;
        for round in 0..50_000 {
            let axis = if round % 10 == 0 { DVec3::ZERO } else { DVec3::Y };
            let corner_cos = if round % 7 == 0 { signed() } else { 0.6 };
            let view = Perspective { eye: DVec3::new(0.1, -2.0, 0.4), axis, slope: 0.01, corner_cos };
            let (center, radius) = (DVec3::new(signed(), signed(), signed()) * 3.0, signed().abs());
            let allowed = view.at(center, radius);
            // Around what is allowed, and exactly that.
            let near = (allowed * (1.0 + 0.5 * signed() * signed().abs())) as f32;
            for key in [near, allowed as f32, 0.0, f32::INFINITY, f32::NAN] {
                let expected = f64::from(key) > allowed || key.is_nan();
                let found = Tolerance::Perspective(view).refines(key, || (center, radius));
                assert_eq!(found, expected, "{key} of {allowed} for {view:?}");
                refined += u32::from(found);
            }
        }
        assert!((100_000..200_000).contains(&refined), "{refined}");
    }

    /// No sphere that touches another one is allowed more than that says, and some nearly as much.
    #[test]
    fn the_most_that_is_allowed_nearby_is_known() {
        let mut state = 11;
        let mut signed = || random(&mut state) * 2.0 - 1.0;
        let mut closest = 0.0_f64;
        for round in 0..50_000 {
            let axis = if round % 10 == 0 { DVec3::ZERO } else { DVec3::Y };
            let view = Perspective { eye: DVec3::new(0.1, -2.0, 0.4), axis, slope: 0.01, corner_cos: 0.6 };
            let mut direction = || DVec3::new(signed(), signed(), signed()).normalize_or_zero();
            let (from, outwards, to) = (direction() * 3.0, direction(), direction());
            let radius = 0.3 * signed().abs();
            let shared = from + outwards * radius * signed().abs();
            let other_radius = signed().abs();
            let other = shared + to * other_radius * signed().abs();
            let near = view.near(from, radius, 3.0);
            let (most, allowed) = (near.most, view.at(other, other_radius));
            assert!(allowed <= most * (1.0 + 1e-9), "{allowed} of {most}");
            closest = closest.max(allowed / most);
            for (least, times) in [(near.least, 1.0), (near.least_wider, 3.0)] {
                let allowed = view.at(from, times * radius);
                assert!(least <= allowed * (1.0 + 1e-9), "{least} of {allowed}");
                assert!(least >= 0.94 * allowed, "{least} of {allowed}");
            }
        }
        assert!(closest > 0.99, "{closest}");
    }

    #[test]
    fn nested_spheres_are_refined_inside_out() {
        let mut state = 3;
        let mut signed = || random(&mut state) * 2.0 - 1.0;
        let view =
            Perspective { eye: DVec3::new(0.1, -2.0, 0.4), axis: DVec3::Y, slope: 0.01, corner_cos: 0.6 };
        for _ in 0..50_000 {
            let (outer, r) = (DVec3::new(signed(), signed(), signed()) * 3.0, signed().abs());
            let inner_r = r * signed().abs();
            let inner = outer
                + DVec3::new(signed(), signed(), signed()).normalize_or_zero() * (r - inner_r) * signed();
            assert!(view.at(inner, inner_r) * (1.0 + 1e-9) >= view.at(outer, r));
        }
    }
}
