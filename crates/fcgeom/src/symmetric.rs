//! Symmetric 3x3 matrices and their eigenvalue problem.

use glam::{DMat3, DVec3};
use std::ops::{Add, AddAssign, Mul, Sub};

/// A symmetric 3x3 matrix, stored once: `xx xy xz yy yz zz`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct SymMat3 {
    /// Row x, column x.
    pub xx: f64,
    /// Row x, column y, and the other way round.
    pub xy: f64,
    /// Row x, column z, and the other way round.
    pub xz: f64,
    /// Row y, column y.
    pub yy: f64,
    /// Row y, column z, and the other way round.
    pub yz: f64,
    /// Row z, column z.
    pub zz: f64,
}

impl SymMat3 {
    /// The matrix of zeros: where sums start.
    pub const ZERO: Self = Self { xx: 0.0, xy: 0.0, xz: 0.0, yy: 0.0, yz: 0.0, zz: 0.0 };
    /// The identity.
    pub const IDENTITY: Self = Self { xx: 1.0, xy: 0.0, xz: 0.0, yy: 1.0, yz: 0.0, zz: 1.0 };

    /// `v v^T`.
    #[inline]
    #[must_use]
    pub fn outer(v: DVec3) -> Self {
        Self { xx: v.x * v.x, xy: v.x * v.y, xz: v.x * v.z, yy: v.y * v.y, yz: v.y * v.z, zz: v.z * v.z }
    }

    /// `a b^T + b a^T`.
    #[inline]
    #[must_use]
    pub fn outer_pair(a: DVec3, b: DVec3) -> Self {
        Self {
            xx: 2.0 * a.x * b.x,
            xy: a.x * b.y + a.y * b.x,
            xz: a.x * b.z + a.z * b.x,
            yy: 2.0 * a.y * b.y,
            yz: a.y * b.z + a.z * b.y,
            zz: 2.0 * a.z * b.z,
        }
    }

    /// The symmetric part `(m + m^T) / 2` of any matrix.
    #[must_use]
    pub fn symmetric_part(m: &DMat3) -> Self {
        let (c0, c1, c2) = (m.x_axis, m.y_axis, m.z_axis);
        Self {
            xx: c0.x,
            xy: 0.5 * (c0.y + c1.x),
            xz: 0.5 * (c0.z + c2.x),
            yy: c1.y,
            yz: 0.5 * (c1.z + c2.y),
            zz: c2.z,
        }
    }

    /// All entries times `factor`.
    #[inline]
    #[must_use]
    pub fn scale(self, factor: f64) -> Self {
        self * factor
    }

    /// The matrix times a vector.
    #[inline]
    #[must_use]
    pub fn mul_vec(&self, v: DVec3) -> DVec3 {
        DVec3::new(
            self.xx * v.x + self.xy * v.y + self.xz * v.z,
            self.xy * v.x + self.yy * v.y + self.yz * v.z,
            self.xz * v.x + self.yz * v.y + self.zz * v.z,
        )
    }

    /// `v^T M v`.
    #[inline]
    #[must_use]
    pub fn quadratic(&self, v: DVec3) -> f64 {
        v.dot(self.mul_vec(v))
    }

    /// The sum of the diagonal, which is the sum of the eigenvalues.
    #[inline]
    #[must_use]
    pub fn trace(&self) -> f64 {
        self.xx + self.yy + self.zz
    }

    /// The same matrix with all nine entries.
    #[must_use]
    pub fn to_dmat3(&self) -> DMat3 {
        DMat3::from_cols(
            DVec3::new(self.xx, self.xy, self.xz),
            DVec3::new(self.xy, self.yy, self.yz),
            DVec3::new(self.xz, self.yz, self.zz),
        )
    }

    /// The largest magnitude of an entry; NaN if any entry is NaN.
    #[must_use]
    pub fn max_abs(&self) -> f64 {
        let mut max = 0.0f64;
        for entry in [self.xx, self.xy, self.xz, self.yy, self.yz, self.zz] {
            if entry.is_nan() {
                return entry;
            }
            max = entry.abs().max(max);
        }
        max
    }
}

impl From<SymMat3> for DMat3 {
    fn from(m: SymMat3) -> Self {
        m.to_dmat3()
    }
}

impl Add for SymMat3 {
    type Output = Self;
    #[inline]
    fn add(self, o: Self) -> Self {
        Self {
            xx: self.xx + o.xx,
            xy: self.xy + o.xy,
            xz: self.xz + o.xz,
            yy: self.yy + o.yy,
            yz: self.yz + o.yz,
            zz: self.zz + o.zz,
        }
    }
}

impl AddAssign for SymMat3 {
    #[inline]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl Sub for SymMat3 {
    type Output = Self;
    #[inline]
    fn sub(self, o: Self) -> Self {
        self + o * -1.0
    }
}

impl Mul<f64> for SymMat3 {
    type Output = Self;
    #[inline]
    fn mul(self, k: f64) -> Self {
        Self {
            xx: self.xx * k,
            xy: self.xy * k,
            xz: self.xz * k,
            yy: self.yy * k,
            yz: self.yz * k,
            zz: self.zz * k,
        }
    }
}

/// Eigenvalues in descending order and an orthonormal, right-handed frame of eigenvectors.
///
/// The first two vectors have the sign of [`with_fixed_sign`]; the third is signed so that the frame is right-handed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eigen {
    /// Descending; equal ones in the order in which their axes came.
    pub values: [f64; 3],
    /// Unit vectors, `vectors[i]` belonging to `values[i]`.
    pub vectors: [DVec3; 3],
}

impl Eigen {
    /// The largest eigenvalue and its vector.
    #[must_use]
    pub fn largest(&self) -> (f64, DVec3) {
        (self.values[0], self.vectors[0])
    }

    /// The smallest eigenvalue and its vector.
    #[must_use]
    pub fn smallest(&self) -> (f64, DVec3) {
        (self.values[2], self.vectors[2])
    }
}

/// `v` or `-v`: the one whose component of largest magnitude is positive; of equal magnitudes the first counts.
///
/// An eigenvector is only known up to its sign; without this rule the two children of a split could trade places.
#[must_use]
pub fn with_fixed_sign(v: DVec3) -> DVec3 {
    let a = v.abs();
    let leading = if a.x >= a.y && a.x >= a.z {
        v.x
    } else if a.y >= a.z {
        v.y
    } else {
        v.z
    };
    if leading < 0.0 { -v } else { v }
}

/// Sweeps before the iteration gives up. Convergence is quadratic and takes five to seven; the bound only makes the
/// end certain, and with fewer the vectors of the hardest matrices would lose digits.
const MAX_SWEEPS: usize = 32;

/// An off-diagonal entry is dropped when its square is at most this times the product of its two diagonal entries:
/// relative to the diagonal, so that small eigenvalues of a graded matrix keep their digits.
const NEGLIGIBLE_SQUARED: f64 = 1.0e-33;

/// Off-diagonal entries below this are dropped in any case; the matrix is scaled to entries of about 1 before.
const NEGLIGIBLE: f64 = 1.0e-150;

/// Eigenvalues and eigenvectors of a symmetric matrix, by cyclic Jacobi rotations.
///
/// It always ends, and for finite input everything is finite. The zero matrix gives the axes x, y, z. A matrix that
/// is scaled by a power of two has the same vectors, bit for bit, and its values scaled by it (barring underflow). If
/// an entry is infinite or NaN, the values are NaN and the vectors x, y, z.
#[must_use]
pub fn eigen(m: &SymMat3) -> Eigen {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let largest = m.max_abs();
    if !largest.is_finite() {
        return Eigen { values: [f64::NAN; 3], vectors: axes };
    }
    if largest == 0.0 {
        return Eigen { values: [0.0; 3], vectors: axes };
    }
    let exponent = exponent_of(largest);
    let mut a = [[0.0; 3]; 3];
    for (row, column, entry) in
        [(0, 0, m.xx), (0, 1, m.xy), (0, 2, m.xz), (1, 1, m.yy), (1, 2, m.yz), (2, 2, m.zz)]
    {
        let scaled = times_power_of_two(entry, -exponent);
        a[row][column] = scaled;
        a[column][row] = scaled;
    }
    let mut vectors = axes;
    for _ in 0..MAX_SWEEPS {
        // The three calls may not be short-circuited: a sweep visits every pair.
        let turned = [(0, 1, 2), (0, 2, 1), (1, 2, 0)].map(|(p, q, k)| rotate(&mut a, &mut vectors, p, q, k));
        if !turned.contains(&true) {
            break;
        }
    }
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| a[j][j].total_cmp(&a[i][i]));
    let first = with_fixed_sign(vectors[order[0]]);
    let second = with_fixed_sign(vectors[order[1]]);
    let third = vectors[order[2]];
    let third = if first.cross(second).dot(third) < 0.0 { -third } else { third };
    Eigen {
        // An eigenvalue can be three times the largest entry: hence the clamp. Adding zero turns minus zero into zero,
        // between which `f64::max` of a caller could choose freely.
        values: order.map(|i| times_power_of_two(a[i][i], exponent).clamp(f64::MIN, f64::MAX) + 0.0),
        vectors: [first, second, third],
    }
}

/// Turns the plane of `p` and `q` so that `a[p][q]` vanishes; false if it already did. `k` is the third index.
fn rotate(a: &mut [[f64; 3]; 3], vectors: &mut [DVec3; 3], p: usize, q: usize, k: usize) -> bool {
    let apq = a[p][q];
    if apq.abs() <= NEGLIGIBLE || apq * apq <= NEGLIGIBLE_SQUARED * (a[p][p] * a[q][q]).abs() {
        a[p][q] = 0.0;
        a[q][p] = 0.0;
        return false;
    }
    // The smaller root of t^2 + 2 theta t - 1 = 0, which turns by at most 45 degrees. Entries are at most about 1 and
    // apq is above 1e-150, so that theta squared cannot overflow.
    let theta = (a[q][q] - a[p][p]) / (2.0 * apq);
    let t = 1.0f64.copysign(theta) / (theta.abs() + (theta * theta + 1.0).sqrt());
    let c = 1.0 / (t * t + 1.0).sqrt();
    let s = t * c;
    a[p][p] -= t * apq;
    a[q][q] += t * apq;
    a[p][q] = 0.0;
    a[q][p] = 0.0;
    let (akp, akq) = (a[k][p], a[k][q]);
    a[k][p] = c * akp - s * akq;
    a[p][k] = a[k][p];
    a[k][q] = s * akp + c * akq;
    a[q][k] = a[k][q];
    let (vp, vq) = (vectors[p], vectors[q]);
    vectors[p] = vp * c - vq * s;
    vectors[q] = vp * s + vq * c;
    true
}

/// The exponent of the power of two at or below a positive finite number; for subnormals that of the smallest normal.
fn exponent_of(x: f64) -> i32 {
    let biased = (x.to_bits() >> 52) & 0x7ff;
    (biased as i32).max(1) - 1023
}

/// `x 2^exponent`, exact unless it leaves the range of `f64`.
fn times_power_of_two(x: f64, exponent: i32) -> f64 {
    // Two factors, because 2^exponent itself may lie outside the range although the product does not.
    let half = exponent / 2;
    x * power_of_two(half) * power_of_two(exponent - half)
}

/// `2^exponent` for exponents of normal numbers.
fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(((exponent.clamp(-1022, 1023) + 1023) as u64) << 52)
}
