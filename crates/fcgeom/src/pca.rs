//! Principal component analysis of a surface: the axis of a split, the fitted plane and its error.

use crate::symmetric::with_fixed_sign;
use crate::{Moments, Plane, eigen};
use glam::DVec3;

/// The direction in which the surface extends most: a unit vector with fixed sign, x if there is no area.
///
/// # Paper
/// `p_max` of `[Tsuji07, eq. 16]`: the eigenvector of the largest eigenvalue of `Z_rr` (`[Tsuji07, eq. 8]`).
#[must_use]
pub fn pca_axis(m: &Moments) -> DVec3 {
    eigen(&m.position_covariance()).vectors[0]
}

/// The plane that fits a surface best.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneFit {
    /// The mean position: a point of the plane.
    pub centroid: DVec3,
    /// The unit normal: the direction in which the surface extends least, on the side of its mean normal.
    pub normal: DVec3,
    /// The mean square distance of the surface from the plane, at least zero. Unit: length squared.
    pub epsilon: f64,
}

impl PlaneFit {
    /// The plane alone.
    #[must_use]
    pub fn plane(&self) -> Plane {
        Plane::through(self.centroid, self.normal)
    }
}

impl Moments {
    /// The plane through the centroid with the smallest mean square distance, turned to the side of the mean normal.
    ///
    /// Where the mean normal is zero or lies in the plane, the sign is that of
    /// [`with_fixed_sign`]. Without area the plane is z = 0.
    ///
    /// # Paper
    /// `p_min` and epsilon of `[Tsuji07]`, section 4.1.
    #[must_use]
    pub fn plane(&self) -> PlaneFit {
        let (value, vector) = eigen(&self.position_covariance()).smallest();
        let side = vector.dot(self.normal);
        let normal = if side > 0.0 {
            vector
        } else if side < 0.0 {
            -vector
        } else {
            with_fixed_sign(vector)
        };
        PlaneFit { centroid: self.centroid(), normal, epsilon: value.max(0.0) }
    }

    /// The paper's modelling error: the mean square distance from the best plane, which is the smallest eigenvalue of
    /// `Z_rr`. Never negative; zero without area. Unit: length squared.
    ///
    /// # Paper
    /// Epsilon of `[Tsuji07]`, section 4.1, as compared in `[Tsuji07, eq. 17]`.
    #[must_use]
    pub fn epsilon(&self) -> f64 {
        eigen(&self.position_covariance()).values[2].max(0.0)
    }
}
