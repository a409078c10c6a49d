//! Canonical correlation analysis of positions and normals: along which direction do the normals change most?

use crate::symmetric::with_fixed_sign;
use crate::{Moments, SymMat3, eigen};
use glam::{DMat3, DVec3};

/// Added to `Z_rr`, times its trace: a flat cluster has no extent along its normal and `Z_rr` no inverse. Larger pulls
/// the axis towards that of the largest cross covariance; much smaller lets rounding decide.
const POSITION_RIDGE: f64 = 1.0e-2;

/// Added to `Z_nn`, times its trace: the normals of a cylinder, for one, lie in a plane and `Z_nn` has no inverse.
const NORMAL_RIDGE: f64 = 1.0e-4;

/// Below this trace of `Z_nn` the surface counts as flat: normals stored in `f32` vary by 1e-14 from rounding alone,
/// and an axis found in that would be noise.
const FLAT: f64 = 1.0e-9;

/// Below this squared correlation, positions say nothing about normals and the axis would be noise.
const UNCORRELATED: f64 = 1.0e-12;

/// The direction along which the position tells most about the normal: a unit vector with fixed sign.
///
/// `None` if there is no such direction: no area, a flat surface (trace of `Z_nn` below 1e-9), or normals that do not
/// depend on the position at all. The caller then takes [`pca_axis`](crate::pca_axis).
///
/// # Paper
/// The principal component vector of `B_rn = Z_rr^-1 Z_rn Z_nn^-1 Z_rn^T` (`[Tsuji07, eq. 15]`).
///
/// # Deviations
/// The paper inverts `Z_rr` and `Z_nn`, which are singular on flat clusters, cylinders and single faces; both get a
/// multiple of the identity added first. `B_rn` is not symmetric; with `Z_rr = L L^T` it has the eigenvalues of the
/// symmetric `L^-1 Z_rn Z_nn^-1 Z_rn^T L^-T`, whose eigenvector `u` gives that of `B_rn` as `L^-T u`.
#[must_use]
pub fn cca_axis(m: &Moments) -> Option<DVec3> {
    let z_nn = m.normal_covariance();
    let z_rr = m.position_covariance();
    // Stated as what must hold, so that NaN takes the early way out as well.
    let curved = z_nn.trace() >= FLAT && z_rr.trace() > 0.0;
    if !curved {
        return None;
    }
    let positions = Cholesky::of(&with_ridge(&z_rr, POSITION_RIDGE))?;
    let normals = Cholesky::of(&with_ridge(&z_nn, NORMAL_RIDGE))?;
    // With Z_nn = K K^T the matrix is W W^T, W = L^-1 Z_rn K^-T: symmetric and positive by construction.
    let left = per_column(&m.cross_covariance(), |column| positions.solve_lower(column));
    let w = per_column(&left.transpose(), |row| normals.solve_lower(row)).transpose();
    let (correlation, u) = eigen(&SymMat3::symmetric_part(&(w * w.transpose()))).largest();
    let correlated = correlation >= UNCORRELATED;
    correlated.then(|| unit(positions.solve_upper(u))).flatten().map(with_fixed_sign)
}

/// `m` plus a multiple of the identity, so that it has an inverse.
fn with_ridge(m: &SymMat3, ridge: f64) -> SymMat3 {
    *m + SymMat3::IDENTITY * (ridge * m.trace())
}

fn per_column(m: &DMat3, f: impl Fn(DVec3) -> DVec3) -> DMat3 {
    DMat3::from_cols(f(m.x_axis), f(m.y_axis), f(m.z_axis))
}

/// `v` with length 1, also where its squared length would leave the range of `f64`.
fn unit(v: DVec3) -> Option<DVec3> {
    let largest = v.abs().max_element();
    let scalable = largest > 0.0 && largest.is_finite();
    scalable.then(|| v / largest).and_then(DVec3::try_normalize)
}

/// The lower triangular factor `L` of a positive definite matrix `L L^T`.
struct Cholesky {
    xx: f64,
    yx: f64,
    yy: f64,
    zx: f64,
    zy: f64,
    zz: f64,
}

impl Cholesky {
    /// `None` if the matrix is not positive definite in floating point.
    fn of(m: &SymMat3) -> Option<Self> {
        let xx = positive_root(m.xx)?;
        let yx = m.xy / xx;
        let zx = m.xz / xx;
        let yy = positive_root(m.yy - yx * yx)?;
        let zy = (m.yz - zx * yx) / yy;
        let zz = positive_root(m.zz - zx * zx - zy * zy)?;
        Some(Self { xx, yx, yy, zx, zy, zz })
    }

    /// Solves `L y = b`.
    fn solve_lower(&self, b: DVec3) -> DVec3 {
        let x = b.x / self.xx;
        let y = (b.y - self.yx * x) / self.yy;
        let z = (b.z - self.zx * x - self.zy * y) / self.zz;
        DVec3::new(x, y, z)
    }

    /// Solves `L^T y = b`.
    fn solve_upper(&self, b: DVec3) -> DVec3 {
        let z = b.z / self.zz;
        let y = (b.y - self.zy * z) / self.yy;
        let x = (b.x - self.yx * y - self.zx * z) / self.xx;
        DVec3::new(x, y, z)
    }
}

fn positive_root(x: f64) -> Option<f64> {
    let root = x.sqrt();
    (root > 0.0 && root.is_finite()).then_some(root)
}
