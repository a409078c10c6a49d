//! The smallest eigenvalue of a covariance and its vector, several times faster than the whole system.

use crate::symmetric::{SymMat3, eigen};
use glam::DVec3;

/// The smallest eigenvalue of a positive semidefinite matrix, many times faster than [`eigen`] and less exact.
///
/// Good to about six digits where it is well below the other two, which is what it is for; never above the true
/// value by more than rounding, and never negative.
#[must_use]
#[inline]
pub fn smallest_eigenvalue(m: &SymMat3) -> f64 {
    let (trace, minors, determinant) = invariants(m);
    // Halley's method on the characteristic polynomial, all of whose roots are real: from 0 it rises to the smallest.
    let mut root = 0.0_f64;
    for _ in 0..HALLEY_STEPS {
        let value = ((trace - root) * root - minors) * root + determinant;
        let slope = (2.0 * trace - 3.0 * root) * root - minors;
        let bend = 2.0 * trace - 6.0 * root;
        let step = 2.0 * value * slope / (2.0 * slope * slope - value * bend);
        // Not a number, or backwards: what is left is rounding.
        root -= if step < 0.0 { step } else { 0.0 };
    }
    root
}

/// Each trebles the digits; for a matrix near the identity, where all roots are close, an eighth of the way is left.
const HALLEY_STEPS: usize = 3;

/// The smallest eigenvalue of a positive semidefinite matrix and a unit vector that belongs to it, of either sign.
///
/// As exact as the matrix, about: the vector is off by at most 3e-8, unless the next eigenvalue is so near
/// that directions between the two are as good.
#[must_use]
pub fn smallest_eigenpair(m: &SymMat3) -> (f64, DVec3) {
    smallest_eigenpair_near(m, smallest_eigenvalue(m))
}

/// The same for whoever has the [`smallest_eigenvalue`] already.
#[must_use]
pub fn smallest_eigenpair_near(m: &SymMat3, low: f64) -> (f64, DVec3) {
    let (trace, minors, _) = invariants(m);
    let mut value = low;
    for _ in 0..INVERSE_STEPS {
        let Some(vector) = null_vector(m, value) else { break };
        let image = m.mul_vec(vector);
        value = vector.dot(image);
        // The vector is off by the residual over the distance to the next eigenvalue, which is minors / trace where
        // the smallest is small. Near the wrong eigenvalue the first look would have been too low.
        let residual = (image - vector * value).length();
        if residual * trace <= TOLERANCE * minors && value <= low * 1.01 + ROUNDING * trace {
            return (value.max(0.0), vector);
        }
    }
    let (value, vector) = eigen(m).smallest();
    (value.max(0.0), vector)
}

/// An angle, below what single precision tells of a direction.
const TOLERANCE: f64 = 3e-8;

/// What the smallest eigenvalue may lose in relation to the largest.
const ROUNDING: f64 = 1e-13;

/// One is enough for a flat cluster, and each squares the error, or better; what takes longer is done by rotations.
const INVERSE_STEPS: usize = 3;

/// The direction that `m - value I` maps to nothing, if `value` is an eigenvalue and a single one: the longest column
/// of the adjugate.
fn null_vector(m: &SymMat3, value: f64) -> Option<DVec3> {
    let x = DVec3::new(m.xx - value, m.xy, m.xz);
    let y = DVec3::new(m.xy, m.yy - value, m.yz);
    let z = DVec3::new(m.xz, m.yz, m.zz - value);
    let columns = [y.cross(z), z.cross(x), x.cross(y)];
    let [a, b, c] = columns.map(DVec3::length_squared);
    let (longest, squared) = if a >= b && a >= c {
        (columns[0], a)
    } else if b >= c {
        (columns[1], b)
    } else {
        (columns[2], c)
    };
    let vector = longest * (1.0 / squared.sqrt());
    vector.is_finite().then_some(vector)
}

/// Trace, sum of the principal minors, and determinant.
#[inline]
fn invariants(m: &SymMat3) -> (f64, f64, f64) {
    let minor_x = m.yy * m.zz - m.yz * m.yz;
    let minor_y = m.xx * m.zz - m.xz * m.xz;
    let minor_z = m.xx * m.yy - m.xy * m.xy;
    let determinant =
        m.xx * minor_x - m.xy * (m.xy * m.zz - m.yz * m.xz) + m.xz * (m.xy * m.yz - m.yy * m.xz);
    (m.trace(), minor_x + minor_y + minor_z, determinant)
}
