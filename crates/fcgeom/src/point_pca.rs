//! The covariance of discrete points, which depends on how densely the surface is sampled; kept for comparison.

use crate::SymMat3;
use glam::DVec3;

/// The sample covariance of points; zero for fewer than two of them. Unit: length squared.
///
/// The builder uses [`Moments::position_covariance`](crate::Moments::position_covariance) instead: subdividing a
/// triangle changes this covariance, though the surface stays the same.
///
/// # Paper
/// `[Tsuji07, eq. 1]`, which equals `[Tsuji07, eq. 2]` and loses fewer digits.
#[must_use]
pub fn point_covariance(points: &[DVec3]) -> SymMat3 {
    if points.len() < 2 {
        return SymMat3::ZERO;
    }
    let mean = points.iter().fold(DVec3::ZERO, |sum, &p| sum + p) / points.len() as f64;
    let sum = points.iter().fold(SymMat3::ZERO, |sum, &p| sum + SymMat3::outer(p - mean));
    sum * (1.0 / (points.len() - 1) as f64)
}
