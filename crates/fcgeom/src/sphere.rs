//! Enclosing spheres, stored in `f32` and never too small.

use crate::ball::{Ball, Each, Pair};
use crate::round_up;
use glam::{DVec3, Vec3};
use std::borrow::Borrow;

/// A sphere that encloses something; [`Sphere::EMPTY`] encloses nothing.
///
/// What it is said to contain, it contains in `f64` arithmetic with its stored `f32` numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Sphere {
    /// The centre.
    pub center: Vec3,
    /// The radius, rounded up; infinite if something not finite had to be enclosed.
    pub radius: f32,
}

impl Sphere {
    /// The sphere of nothing: a negative radius, so that no point lies within.
    pub const EMPTY: Self = Self { center: Vec3::ZERO, radius: -1.0 };

    /// A sphere around points, a few percent larger than the smallest one; [`Sphere::EMPTY`] for no points.
    ///
    /// Takes anything that yields points and can be gone through repeatedly: a slice, or a mapped iterator.
    #[must_use]
    pub fn of_points<P: Borrow<Vec3>>(points: impl IntoIterator<Item = P, IntoIter: Clone>) -> Self {
        let cloud = Each(points.into_iter().map(|p| p.borrow().as_dvec3()));
        let Some(first) = cloud.first() else { return Self::EMPTY };
        let ball = Pair::of(&cloud, first).map(|pair| pair.grown_around(&cloud));
        let center = ball.map_or(DVec3::NAN, |ball: Ball| ball.center).as_vec3();
        if !center.is_finite() {
            return Self { center: Vec3::ZERO, radius: f32::INFINITY };
        }
        Self { center, radius: 0.0 }.grown_over(&cloud)
    }

    /// The smallest sphere around two spheres, rounded up; one of them if it contains the other.
    #[must_use]
    pub fn enclosing(a: &Self, b: &Self) -> Self {
        if a.contains_sphere(b) {
            return *a;
        }
        if b.contains_sphere(a) {
            return *b;
        }
        let (ca, cb) = (a.center.as_dvec3(), b.center.as_dvec3());
        let (ra, rb) = (f64::from(a.radius), f64::from(b.radius));
        let distance = ca.distance(cb);
        let radius = 0.5 * (distance + ra + rb);
        let center = (ca + (cb - ca) * ((radius - ra) / distance)).as_vec3();
        if !center.is_finite() {
            return Self { center: Vec3::ZERO, radius: f32::INFINITY };
        }
        // The centre moved when it was rounded: measure again from where it is now.
        let c = center.as_dvec3();
        Self { center, radius: round_up((c.distance(ca) + ra).max(c.distance(cb) + rb)) }
    }

    /// The sphere with the same centre and the smallest radius, not less than its own, that contains the points.
    /// An empty sphere becomes that of the points.
    #[must_use]
    pub fn grown_to_contain<P: Borrow<Vec3>>(
        self,
        points: impl IntoIterator<Item = P, IntoIter: Clone>,
    ) -> Self {
        if self.is_empty() {
            return Self::of_points(points);
        }
        self.grown_over(&Each(points.into_iter().map(|p| p.borrow().as_dvec3())))
    }

    fn grown_over<I: Iterator<Item = DVec3> + Clone>(self, cloud: &Each<I>) -> Self {
        let squared = cloud.largest_square_distance(self.center.as_dvec3());
        if squared.is_nan() {
            return Self { center: self.center, radius: f32::INFINITY };
        }
        Self { center: self.center, radius: self.radius.max(round_up(squared.sqrt())) }
    }

    /// Whether there is nothing inside.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.radius < 0.0
    }

    /// Whether a point lies inside or on the sphere. NaN lies nowhere.
    #[must_use]
    pub fn contains_point(&self, p: DVec3) -> bool {
        p.distance(self.center.as_dvec3()) <= f64::from(self.radius)
    }

    /// Whether another sphere lies wholly inside. The empty sphere lies in every one.
    #[must_use]
    pub fn contains_sphere(&self, other: &Self) -> bool {
        if other.is_empty() {
            return true;
        }
        let distance = self.center.as_dvec3().distance(other.center.as_dvec3());
        distance + f64::from(other.radius) <= f64::from(self.radius)
    }
}
