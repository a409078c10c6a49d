//! Cones of normals: all of a cluster's faces turn away at once, or it is not known.

use crate::ball::Ball;
use crate::{Sphere, round_down};
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

/// What a test for back faces must exceed, as a sine. Normals and axes in `f32` are off by up to 1e-7; a face that is
/// seen at a flatter angle than this has no width on the screen.
const MARGIN: f64 = 1.0e-6;

/// Two normals farther apart than twice this need a cone with a half angle of over 87 degrees. That never culls
/// anything in practice; the closed surfaces near a tree's root are spared the rest of the work.
const HOPELESS: f64 = 0.999;

impl Cone {
    /// All directions: never back-facing.
    pub const FULL: Self = Self { axis: Vec3::Z, cos: -1.0 };

    /// A narrow cone around unit normals; zero ones count for nothing, as faces without area have no side.
    ///
    /// Around vectors of other lengths it is still a cone, only wider than need be. [`Cone::FULL`] if there is no
    /// normal, if no cone narrower than a half space was found (which can miss one that nearly fills it), or if a
    /// normal is not finite.
    #[must_use]
    pub fn of_normals<N: Borrow<Vec3>>(normals: impl IntoIterator<Item = N, IntoIter: Clone>) -> Self {
        let normals = normals.into_iter().map(|n| n.borrow().as_dvec3()).filter(|n| *n != DVec3::ZERO);
        let Some(extremes) = Ball::across_extremes(normals.clone()) else {
            return Self::FULL;
        };
        if extremes.radius > HOPELESS {
            return Self::FULL;
        }
        let mean = normals.clone().fold(DVec3::ZERO, |sum, n| sum + n);
        let about_mean = Self::about(mean, normals.clone());
        let about_ball = Self::about(extremes.grown_around(normals.clone()).center, normals);
        let best = if about_ball.cos > about_mean.cos { about_ball } else { about_mean };
        if best.cos > 0.0 { best } else { Self::FULL }
    }

    /// The narrowest cone about a given axis.
    fn about(axis: DVec3, normals: impl Iterator<Item = DVec3>) -> Self {
        // The axis loses digits when it is rounded: measure from what is stored.
        let axis = axis.normalize_or_zero().as_vec3();
        let Some(stored) = axis.as_dvec3().try_normalize() else {
            return Self::FULL;
        };
        let mut cos = 1.0f64;
        for n in normals {
            let c = n.dot(stored) / n.length();
            if c.is_nan() {
                return Self::FULL;
            }
            cos = cos.min(c);
        }
        Self { axis, cos: round_down(cos) }
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
        let to_center = sphere.center.as_dvec3() - eye;
        let squared = to_center.length_squared();
        let radius = f64::from(sphere.radius);
        let tangent_squared = squared - radius * radius;
        let Some((sin, cos)) = self.half_angle() else {
            return false;
        };
        let eye_outside = tangent_squared > 0.0 && radius >= 0.0;
        if !eye_outside {
            return false;
        }
        let (distance, tangent) = (squared.sqrt(), tangent_squared.sqrt());
        // With b = asin(r / D): D sin(half angle + b) and D cos(half angle + b).
        let sin_sum = sin * tangent + cos * radius;
        let cos_sum = cos * tangent - sin * radius;
        cos_sum >= 0.0 && self.along(to_center) >= sin_sum + MARGIN * distance
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
