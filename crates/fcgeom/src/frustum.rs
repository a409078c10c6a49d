//! View frusta: six planes from a matrix, and where a sphere lies.

use crate::{Plane, Sphere};
use glam::{DMat4, DVec3, DVec4};

/// Where something lies with respect to a frustum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Containment {
    /// Certainly without a common point.
    Outside,
    /// Certainly all inside.
    Inside,
    /// Neither is certain.
    Crossing,
}

/// The part of space that a camera sees: the positive sides of six planes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frustum {
    /// Left, right, bottom, top, z = 0, z = 1, with normals inwards. A plane that the matrix does not have, such as
    /// the far plane of an infinite projection, has a zero normal and a huge `d`.
    pub planes: [Plane; 6],
}

/// Below this length, against that of the matrix's last row, a plane's normal is rounding: the plane lies at infinity.
const NO_NORMAL: f64 = 1.0e-14;

/// What rounding may do to a signed distance, relative to the numbers in it.
const ROUNDING: f64 = 1.0e-12;

impl Frustum {
    /// The frustum of a matrix that takes points to clip space with `-w <= x, y <= w` and `0 <= z <= w`, whichever
    /// way z runs. A matrix with a number that is not finite gives a frustum that every sphere crosses.
    #[must_use]
    pub fn from_view_projection(m: &DMat4) -> Self {
        let [x, y, z, w] = [m.row(0), m.row(1), m.row(2), m.row(3)];
        if !m.is_finite() {
            return Self { planes: [Plane { normal: DVec3::NAN, d: f64::NAN }; 6] };
        }
        let size = [x, y, z, w].iter().fold(0.0f64, |size, row| size.max(row.truncate().length()));
        Self { planes: [w + x, w - x, w + y, w - y, z, w - z].map(|row| normalized(row, size)) }
    }

    /// The same frustum in the coordinates of an instance, given the affine matrix from those to the frustum's own.
    ///
    /// Distances are then in the instance's unit, so its spheres can be classified as they are stored.
    #[must_use]
    pub fn in_local_space(&self, local_to_world: &DMat4) -> Self {
        if !local_to_world.is_finite() {
            return Self { planes: [Plane { normal: DVec3::NAN, d: f64::NAN }; 6] };
        }
        let back = local_to_world.transpose();
        let size = [local_to_world.x_axis, local_to_world.y_axis, local_to_world.z_axis]
            .iter()
            .fold(0.0f64, |size, column| size.max(column.truncate().length()));
        Self { planes: self.planes.map(|plane| normalized(back * plane.to_vec4(), size)) }
    }

    /// Where a sphere lies. With NaN it crosses; the empty sphere is outside.
    #[must_use]
    pub fn classify_sphere(&self, sphere: &Sphere) -> Containment {
        if sphere.is_empty() {
            return Containment::Outside;
        }
        let center = sphere.center.as_dvec3();
        let radius = f64::from(sphere.radius);
        let mut inside = true;
        for plane in &self.planes {
            let distance = plane.signed_distance(center);
            let doubt = ROUNDING * (plane.normal.abs().dot(center.abs()) + plane.d.abs());
            if distance < -radius - doubt {
                return Containment::Outside;
            }
            // Written so that NaN counts as not inside.
            inside &= distance >= radius + doubt;
        }
        if inside { Containment::Inside } else { Containment::Crossing }
    }
}

/// The plane of four coefficients, scaled to a unit normal; at infinity if the normal is nothing next to `size`.
fn normalized(row: DVec4, size: f64) -> Plane {
    let normal = row.truncate();
    let length = normal.length();
    if length > NO_NORMAL * size {
        return Plane { normal: normal / length, d: row.w / length };
    }
    // Every point lies on one side. f64::MAX instead of infinity, because infinity minus infinity is NaN.
    Plane { normal: DVec3::ZERO, d: if row.w >= 0.0 { f64::MAX } else { -f64::MAX } }
}
