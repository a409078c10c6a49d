//! Area-integrated moments of triangles: positions, normals, and how they go together.
//!
//! A cluster's statistics are integrals over its surface, not sums over its vertices, so they do not depend on how
//! finely the surface is cut into triangles. All of them follow from six sums, which add up over faces.

use crate::SymMat3;
use glam::{DMat3, DVec3, Vec3};
use std::ops::AddAssign;

/// Integrals over a surface: area, and first and second moments of positions and normals.
///
/// Sums of squares lose digits far from the origin: take positions relative to a point near the surface.
/// With no area, everything derived is zero and finite.
///
/// # Paper
/// `[Tsuji07, eq. 3 to 14]`: the sums from which `Z_rr`, `Z_nn` and `Z_rn` follow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments {
    /// The area. Unit: length squared.
    pub area: f64,
    /// The integral of `r`.
    pub first: DVec3,
    /// The integral of `r r^T`.
    pub second: SymMat3,
    /// The integral of the unit normal `n`: the vector area.
    pub normal: DVec3,
    /// The integral of `n n^T`.
    pub normal_second: SymMat3,
    /// The integral of `r n^T`: row of `r`, column of `n`.
    pub cross: DMat3,
}

impl Moments {
    /// The moments of nothing. (The default of glam's matrix is the identity, so sums must start here.)
    pub const ZERO: Self = Self {
        area: 0.0,
        first: DVec3::ZERO,
        second: SymMat3::ZERO,
        normal: DVec3::ZERO,
        normal_second: SymMat3::ZERO,
        cross: DMat3::ZERO,
    };

    /// The moments of one triangle. One without area, or with a coordinate that is not finite, contributes nothing.
    ///
    /// # Paper
    /// `[Tsuji07, eq. 6]` for the second moment, as `A/12 (sum v v^T + (sum v)(sum v)^T)` taken about the centroid of
    /// `[Tsuji07, eq. 7]`.
    #[must_use]
    pub fn of_triangle(a: DVec3, b: DVec3, c: DVec3) -> Self {
        let (area, normal) = area_and_normal(a, b, c);
        if area == 0.0 {
            return Self::ZERO;
        }
        let centroid = centroid(a, b, c);
        let mut moments = Self::ZERO;
        moments.add_face(area, centroid, normal, spread(a, b, c, centroid));
        moments
    }

    /// Adds the moments of another part of the surface.
    #[inline]
    pub fn add(&mut self, other: &Self) {
        self.area += other.area;
        self.first += other.first;
        self.second += other.second;
        self.normal += other.normal;
        self.normal_second += other.normal_second;
        self.cross += other.cross;
    }

    /// Adds one face, with positions taken relative to `origin`: the inner loop of the builder.
    #[inline]
    pub fn accumulate(&mut self, face: &FaceMoments, origin: DVec3) {
        let [xx, xy, xz, yy, yz, zz] = face.spread.map(f64::from);
        self.add_face(
            f64::from(face.area),
            face.centroid.as_dvec3() - origin,
            face.normal.as_dvec3(),
            SymMat3 { xx, xy, xz, yy, yz, zz },
        );
    }

    #[inline]
    fn add_face(&mut self, area: f64, r: DVec3, n: DVec3, spread: SymMat3) {
        let (ar, an) = (r * area, n * area);
        self.area += area;
        self.first += ar;
        self.second.xx += area * spread.xx + ar.x * r.x;
        self.second.xy += area * spread.xy + ar.x * r.y;
        self.second.xz += area * spread.xz + ar.x * r.z;
        self.second.yy += area * spread.yy + ar.y * r.y;
        self.second.yz += area * spread.yz + ar.y * r.z;
        self.second.zz += area * spread.zz + ar.z * r.z;
        self.normal += an;
        self.normal_second.xx += an.x * n.x;
        self.normal_second.xy += an.x * n.y;
        self.normal_second.xz += an.x * n.z;
        self.normal_second.yy += an.y * n.y;
        self.normal_second.yz += an.y * n.z;
        self.normal_second.zz += an.z * n.z;
        self.cross.x_axis += ar * n.x;
        self.cross.y_axis += ar * n.y;
        self.cross.z_axis += ar * n.z;
    }

    /// The moments of the same surface moved by a vector.
    #[must_use]
    pub fn translated(&self, by: DVec3) -> Self {
        Self {
            area: self.area,
            first: self.first + by * self.area,
            second: self.second + SymMat3::outer_pair(self.first, by) + SymMat3::outer(by) * self.area,
            normal: self.normal,
            normal_second: self.normal_second,
            cross: self.cross + outer(by, self.normal),
        }
    }

    /// The mean position.
    ///
    /// # Paper
    /// The mean of `[Tsuji07, eq. 4]`.
    #[must_use]
    pub fn centroid(&self) -> DVec3 {
        self.first * self.per_area()
    }

    /// The mean normal: at most of length 1, and zero for a closed surface.
    ///
    /// # Paper
    /// The mean of `[Tsuji07, eq. 11]`.
    #[must_use]
    pub fn mean_normal(&self) -> DVec3 {
        self.normal * self.per_area()
    }

    /// `Z_rr`, the covariance of positions. Unit: length squared.
    ///
    /// # Paper
    /// `[Tsuji07, eq. 8]`, for `[Tsuji07, eq. 3, 4]`.
    #[must_use]
    pub fn position_covariance(&self) -> SymMat3 {
        self.second * self.per_area() - SymMat3::outer(self.centroid())
    }

    /// `Z_nn`, the covariance of normals, without unit.
    ///
    /// # Paper
    /// `[Tsuji07, eq. 11]`, for `[Tsuji07, eq. 9, 10]`.
    #[must_use]
    pub fn normal_covariance(&self) -> SymMat3 {
        self.normal_second * self.per_area() - SymMat3::outer(self.mean_normal())
    }

    /// `Z_rn`, the covariance of positions (rows) with normals (columns). Unit: length.
    ///
    /// # Paper
    /// `[Tsuji07, eq. 14]`, for `[Tsuji07, eq. 12, 13]`.
    #[must_use]
    pub fn cross_covariance(&self) -> DMat3 {
        self.cross * self.per_area() - outer(self.centroid(), self.mean_normal())
    }

    /// One over the area, and zero for none, so that all means of nothing are zero.
    fn per_area(&self) -> f64 {
        let reciprocal = 1.0 / self.area;
        if reciprocal.is_finite() { reciprocal } else { 0.0 }
    }
}

impl Default for Moments {
    fn default() -> Self {
        Self::ZERO
    }
}

impl AddAssign for Moments {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        self.add(&other);
    }
}

impl AddAssign<&Self> for Moments {
    #[inline]
    fn add_assign(&mut self, other: &Self) {
        self.add(other);
    }
}

/// What a face contributes to [`Moments`], in 52 bytes: sums over a million faces are bound by memory.
///
/// Computed in `f64`, stored in `f32`. All numbers are finite; magnitudes beyond `f32` saturate, so scale a mesh to
/// coordinates of about 1 before the areas and spreads of its small faces underflow.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct FaceMoments {
    /// The centroid.
    pub centroid: Vec3,
    /// The unit normal by the right-hand rule; zero for a triangle without area.
    pub normal: Vec3,
    /// The area. Unit: length squared.
    pub area: f32,
    /// The covariance of positions about the centroid: xx xy xz yy yz zz. Unit: length squared.
    pub spread: [f32; 6],
}

impl FaceMoments {
    /// The moments of one triangle. One without area keeps its centroid and has neither normal nor spread; with a
    /// coordinate that is not finite all is zero.
    ///
    /// # Paper
    /// `[Tsuji07, eq. 6, 7]`.
    #[must_use]
    pub fn of_triangle(a: Vec3, b: Vec3, c: Vec3) -> Self {
        if !(a.is_finite() && b.is_finite() && c.is_finite()) {
            return Self::default();
        }
        let (a, b, c) = (a.as_dvec3(), b.as_dvec3(), c.as_dvec3());
        let (area, normal) = area_and_normal(a, b, c);
        let middle = centroid(a, b, c);
        let s = if area > 0.0 { spread(a, b, c, middle) } else { SymMat3::ZERO };
        Self {
            centroid: middle.as_vec3(),
            normal: normal.as_vec3(),
            area: saturate(area),
            spread: [s.xx, s.xy, s.xz, s.yy, s.yz, s.zz].map(saturate),
        }
    }
}

/// The nearest finite `f32`.
fn saturate(x: f64) -> f32 {
    (x as f32).clamp(f32::MIN, f32::MAX)
}

/// Two edges whose sine of the angle is below this are parallel: what their cross product has is rounding. The
/// thinnest triangle on a grid of 2^24 steps, where the product is exact, has a sine of 3.5e-15.
const PARALLEL_SINE: f64 = 1.0e-15;

/// Area and unit normal by the right-hand rule; both zero for a triangle without area or with numbers so large or
/// broken that its area is none.
fn area_and_normal(a: DVec3, b: DVec3, c: DVec3) -> (f64, DVec3) {
    let (u, v) = (b - a, c - a);
    let cross = u.cross(v);
    let length = cross.length();
    if length > PARALLEL_SINE * u.length() * v.length() && length.is_finite() {
        (0.5 * length, cross / length)
    } else {
        (0.0, DVec3::ZERO)
    }
}

/// # Paper
/// `[Tsuji07, eq. 7]`.
fn centroid(a: DVec3, b: DVec3, c: DVec3) -> DVec3 {
    (a + b + c) / 3.0
}

/// The covariance of a triangle's points about its centroid: `1/12 sum (v - m)(v - m)^T`.
fn spread(a: DVec3, b: DVec3, c: DVec3, m: DVec3) -> SymMat3 {
    (SymMat3::outer(a - m) + SymMat3::outer(b - m) + SymMat3::outer(c - m)) * (1.0 / 12.0)
}

/// `a b^T`.
fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}
