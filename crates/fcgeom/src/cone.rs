//! Cones of normals: all of a cluster's faces turn away at once, or it is not known.

use crate::ball::{Ball, Pair};
use crate::{Quads, Sphere, round_down};
use glam::{DVec3, Vec3};
use std::borrow::Borrow;

/// An axis and the cosine of a half angle: all directions within that angle of the axis.
///
/// # Paper
/// The normal cone of `[Tsuji07]`, section 5.2 and figure 6.
///
/// # Deviations
/// The paper's axis is the mean normal; ours is that or the centre of a small ball of the normals, whichever gives
/// the narrower cone (8 to 17 % for small clusters).
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Cone {
    /// The axis, a unit vector up to rounding.
    pub axis: Vec3,
    /// The cosine of the half angle, rounded down: the stored cone is never too narrow.
    pub cos: f32,
}

/// A side of a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// That from which its corners run counter-clockwise.
    Front,
    /// The other.
    Back,
}

/// What is seen in single precision.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Glance {
    /// The answer.
    Clear(Option<Side>),
    /// It takes a closer look.
    Unclear,
}

/// What a test for back faces must exceed, as a sine. Normals and axes in `f32` are off by up to 1e-7; a face that is
/// seen at a flatter angle than this has no width on the screen.
const MARGIN: f64 = 1.0e-6;

/// What rounding to single precision may do to the lengths that [`Cone::side`] compares, over the distance, and
/// [`MARGIN`]: a vector of length D comes out within 1e-7 D, its product with an axis within 6e-7 D, and with
/// [`NEARBY`] the tangent's length within 1.5e-6 D.
const DOUBT: f32 = 8.0e-6;

/// The square of the sine of an angle, see [`DOUBT`]: the eye is farther away than 1.02 radii.
const NEARBY: f32 = 0.04;

/// Squares of lengths are no smaller than this.
const SMALLEST: f32 = 1.0e-24;

/// How far from 1 the square of a unit vector's length may be.
const UNIT: f32 = 1.0e-6;

/// Two normals farther apart than twice this need a cone with a half angle of over 87 degrees. That never culls
/// anything in practice; the closed surfaces near a tree's root are spared the rest of the work.
const HOPELESS: f64 = 0.999;

/// What the cosine of a half angle may be off because normals, axis and distances are rounded to `f32`, relative to the
/// sine: a rounding turns a vector by about 1e-7, and lengths that are not quite 1 cancel where vectors are near.
const ROUNDING: f64 = 5.0e-7;

impl Cone {
    /// All directions: never back-facing.
    pub const FULL: Self = Self { axis: Vec3::Z, cos: -1.0 };

    /// A narrow cone around normals of any length; zero ones count for nothing, as faces without area have no side.
    ///
    /// [`Cone::FULL`] if there is no normal, if no cone narrower than a half space was found (which can miss one that
    /// nearly fills it), or if a normal is not finite.
    #[must_use]
    pub fn of_normals<N: Borrow<Vec3>>(normals: impl IntoIterator<Item = N>) -> Self {
        let mut units = Vec::new();
        for n in normals {
            let n = n.borrow().as_dvec3();
            if !n.is_finite() {
                return Self::FULL;
            }
            units.extend(n.try_normalize());
        }
        let mut quads = Quads::default();
        quads.extend(&units, |n| n.as_vec3());
        Self::of_quads(&quads)
    }

    /// The same around normals by fours, all of which must be unit vectors up to rounding.
    #[must_use]
    pub fn of_quads(normals: &Quads) -> Self {
        match normals.sum().try_normalize() {
            Some(mean) => Self::of_quads_near(normals, mean.as_vec3()).0,
            None => Self::FULL,
        }
    }

    /// The same by a search that starts from a unit vector among the normals, and the least cosine of an angle between
    /// that vector and a normal, within 1e-6; infinite if there is no normal.
    #[must_use]
    pub fn of_quads_near(normals: &Quads, start: Vec3) -> (Self, f32) {
        if let Some([p, q]) = normals.pair() {
            let ball = Ball::across(p.as_dvec3(), q.as_dvec3());
            let cone = Self::about(ball.center, ball.radius * ball.radius);
            let least = start.dot(p).min(start.dot(q));
            return (if cone.cos > 0.0 { cone } else { Self::FULL }, least);
        }
        let start = start.as_dvec3();
        let Some(pair) = Pair::of(normals, start) else {
            return (Self::FULL, f32::INFINITY);
        };
        // Both are unit vectors, so that their square distance tells the angle.
        let least = (1.0 - 0.5 * pair.square_reach()) as f32;
        if pair.ball().radius > HOPELESS {
            return (Self::FULL, least);
        }
        let about_start = Self::about(start, pair.square_reach());
        let ball = pair.grown_around(normals);
        let about_ball = Self::about(ball.center, ball.radius * ball.radius);
        let best = if about_ball.cos > about_start.cos { about_ball } else { about_start };
        (if best.cos > 0.0 { best } else { Self::FULL }, least)
    }

    /// The narrowest cone about a given axis around unit vectors, by the largest square distance from its tip.
    ///
    /// With a unit vector n and the tip c, (n - c)^2 = 1 + c^2 - 2 n c; the difference keeps all the digits that a
    /// product near 1 would lose.
    fn about(tip: DVec3, square_distance: f64) -> Self {
        // What the distances were measured from.
        let tip = tip.as_vec3().as_dvec3();
        let length = tip.length();
        let Some(axis) = tip.try_normalize() else {
            return Self::FULL;
        };
        let cos =
            ((1.0 - square_distance) / length + length) * 0.5 - ROUNDING * square_distance.sqrt() / length;
        Self { axis: axis.as_vec3(), cos: round_down(cos.min(1.0)) }
    }

    /// Whether every point of the sphere, with every normal of the cone, faces away from the eye.
    ///
    /// That is so if angle(axis, direction to the centre) + half angle + angle of the sphere's radius is at most 90
    /// degrees. False when in doubt: with NaN, or with the eye inside the sphere.
    ///
    /// # Paper
    /// `[Tsuji07]`, section 5.2, made safe for all points of the cluster by its sphere.
    #[must_use]
    pub fn is_backfacing(&self, sphere: &Sphere, eye: DVec3) -> bool {
        self.side(sphere, eye) == Some(Side::Back)
    }

    /// The side that every point of the sphere, with every normal of the cone, turns to the eye, if all turn the same.
    ///
    /// None when in doubt: with NaN, or with the eye inside the sphere. See [`Cone::is_backfacing`].
    #[must_use]
    #[inline]
    pub fn side(&self, sphere: &Sphere, eye: DVec3) -> Option<Side> {
        let cos = self.cos;
        let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
        // NaN, and a cosine of more than 1, are not clear either.
        let is_unit = (self.axis.length_squared() - 1.0).abs() < UNIT;
        match Self::side_at_a_glance(self.axis, [sin, cos], sphere, eye) {
            Glance::Clear(side) if is_unit => side,
            _ => self.side_exactly(sphere, eye),
        }
    }

    /// What [`Cone::side`] says, in single precision, where that leaves no doubt; for a unit axis, and the sine and the
    /// cosine of the half angle, all within 4e-7.
    #[must_use]
    #[inline]
    pub fn side_at_a_glance(axis: Vec3, [sin, cos]: [f32; 2], sphere: &Sphere, eye: DVec3) -> Glance {
        let to_center = (sphere.center.as_dvec3() - eye).as_vec3();
        let squared = to_center.length_squared();
        let radius = sphere.radius;
        let tangent_squared = squared - radius * radius;
        // Nearer to the sphere too many digits are lost, with smaller numbers all of them.
        let is_apart = tangent_squared > NEARBY * squared && radius >= 0.0 && squared > SMALLEST;
        let tangent = tangent_squared.sqrt();
        let along = to_center.dot(axis);
        let least = sin * tangent + cos * radius;
        let cos_sum = cos * tangent - sin * radius;
        // No less than the distance times that.
        let doubt = DOUBT * (tangent + radius);
        if !is_apart || cos.is_nan() {
            Glance::Unclear
        } else if along.abs() < least - doubt || cos_sum < -doubt {
            Glance::Clear(None)
        } else if along.abs() > least + doubt && cos_sum > doubt && cos > 0.0 {
            Glance::Clear(Some(if along > 0.0 { Side::Back } else { Side::Front }))
        } else {
            Glance::Unclear
        }
    }

    pub(crate) fn side_exactly(&self, sphere: &Sphere, eye: DVec3) -> Option<Side> {
        let to_center = sphere.center.as_dvec3() - eye;
        let squared = to_center.length_squared();
        let radius = f64::from(sphere.radius);
        let tangent_squared = squared - radius * radius;
        let (sin, cos) = self.half_angle()?;
        let eye_outside = tangent_squared > 0.0 && radius >= 0.0;
        if !eye_outside {
            return None;
        }
        let (distance, tangent) = (squared.sqrt(), tangent_squared.sqrt());
        // With b = asin(r / D): D sin(half angle + b) and D cos(half angle + b).
        let sin_sum = sin * tangent + cos * radius;
        let cos_sum = cos * tangent - sin * radius;
        let least = sin_sum + MARGIN * distance;
        let along = self.along(to_center);
        match cos_sum >= 0.0 {
            true if along >= least => Some(Side::Back),
            true if -along >= least => Some(Side::Front),
            _ => None,
        }
    }

    /// Whether every normal of the cone faces away from a viewer who looks along `direction` (of any length) without
    /// perspective. False when in doubt.
    #[must_use]
    pub fn is_backfacing_along(&self, direction: DVec3) -> bool {
        let Some((sin, _)) = self.half_angle() else {
            return false;
        };
        let length = direction.length();
        length > 0.0 && self.along(direction) >= (sin + MARGIN) * length
    }

    /// Sine and cosine of the half angle if it is less than 90 degrees.
    fn half_angle(&self) -> Option<(f64, f64)> {
        let cos = f64::from(self.cos).min(1.0);
        // As a product, this loses no digits near cos = 1. NaN fails the comparison.
        (f64::from(self.cos) > 0.0).then(|| (((1.0 - cos) * (1.0 + cos)).sqrt(), cos))
    }

    /// The length of `v` along the axis.
    fn along(&self, v: DVec3) -> f64 {
        let axis = self.axis.as_dvec3();
        v.dot(axis) / axis.length()
    }
}
