//! The plane of a cluster in three bytes, by what is known of the cluster already.

use crate::octahedral::tangent_of;
use crate::records::NodeRecord;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// The plane that fits a cluster best. 3 bytes.
///
/// It is there to choose between triangulations of the cluster's polygon and promises nothing.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(C)]
pub struct PlaneRecord {
    /// How the plane's normal leans from the axis of the cone: along the axis's tangent and along `axis x tangent`, in
    /// 1/96 of the sine of the cone's half angle.
    pub tilt: [i8; 2],
    /// Height of the plane, along its normal, above the first corner of the cluster's first face, in 1/64 of the
    /// distance bound.
    pub height: i8,
}

/// A normal cone: axis and cosine of the half angle.
pub(crate) type Axis = ([f64; 3], f64);

impl PlaneRecord {
    /// The nearest record to a plane through the points x with `normal . x = offset`; `first` is the first corner.
    pub(crate) fn encode(normal: [f32; 3], offset: f64, first: [f32; 3], cone: Axis, bound: f32) -> Self {
        let (axis, tangent, other, step) = frame(cone);
        let normal = normal.map(f64::from);
        let along = dot(normal, axis);
        let tilt = if along > 0.0 && step > 0.0 {
            [tangent, other].map(|t| byte(dot(normal, t) / along / step))
        } else {
            [0, 0]
        };
        let unit = f64::from(bound) / HEIGHTS;
        let height = (offset - dot(normal, first.map(f64::from))) / unit;
        let usable = unit > 0.0 && unit.is_finite() && height.is_finite() && normal != [0.0; 3];
        let height = if usable { byte(height) } else { 0 };
        Self { tilt, height }
    }

    /// Unit normal, and the height above the first corner.
    pub(crate) fn decode(self, cone: Axis, bound: f32) -> ([f64; 3], f64) {
        let (axis, tangent, other, step) = frame(cone);
        let [u, v] = self.tilt.map(|t| f64::from(t) * step);
        let [[ax, ay, az], [tx, ty, tz], [bx, by, bz]] = [axis, tangent, other];
        let leaning = [ax + u * tx + v * bx, ay + u * ty + v * by, az + u * tz + v * bz];
        // At least the axis, to which the others are at right angles.
        let length = dot(leaning, leaning).sqrt();
        let height = f64::from(self.height) * f64::from(bound) / HEIGHTS;
        (leaning.map(|x| x / length), if height.is_finite() { height } else { 0.0 })
    }
}

/// A frame that follows a cluster of a page, in single precision and in steps of the page's grid.
///
/// Like a plane it is for choosing between triangulations and promises nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneFrame {
    /// Two directions at right angles to the axis of the cone and to each other, and the axis. They turn to the right.
    pub axes: [[f32; 3]; 3],
    /// How a direction at right angles to the plane leans from the axis, along the first two.
    pub lean: [f32; 2],
    /// The length of that direction.
    pub length: f32,
    /// Height of the plane above the first corner of the cluster's first face, in steps.
    pub height: f32,
}

impl PlaneFrame {
    /// Of a node in a page, by what makes steps of lengths there.
    #[inline]
    pub(crate) fn of(node: &NodeRecord, per_quantum: f32) -> Self {
        let [x, y, z] = node.axis.near();
        let side = if z < 0.0 { -1.0 } else { 1.0 };
        // As `tangent_of`, and the axis times it, which comes out as simple.
        let per_sum = 1.0 / (side + z);
        let k = x * per_sum;
        let tangent = [1.0 - side * x * k, -side * y * k, -side * x];
        let other = [-y * k, side - y * y * per_sum, -y];
        let w = f32::from(node.width) / 256.0;
        // sin^2 of the half angle whose cosine is 1 - w^2.
        let step = w * (2.0 - w * w).sqrt() * (1.0 / 96.0);
        let [u, v] = node.plane.tilt;
        let (u, v) = (f32::from(u) * step, f32::from(v) * step);
        let axes = [tangent, other, [x, y, z]];
        // A node without a bound is never drawn.
        let height = f32::from(node.plane.height) * node.bound.get() * (per_quantum / 64.0);
        Self { axes, lean: [u, v], length: (1.0 + u * u + v * v).sqrt(), height }
    }
}

/// Steps of the height in a distance bound.
const HEIGHTS: f64 = 64.0;

/// Steps of a lean in the sine of the cone's half angle; a plane may lie a little outside the cone of its faces.
const TILTS: f64 = 96.0;

/// The axis, two vectors at right angles, and the step of a lean.
fn frame((axis, cos): Axis) -> ([f64; 3], [f64; 3], [f64; 3], f64) {
    let tangent = tangent_of(axis);
    let ([ax, ay, az], [tx, ty, tz]) = (axis, tangent);
    let other = [ay * tz - az * ty, az * tx - ax * tz, ax * ty - ay * tx];
    let cos = cos.clamp(0.0, 1.0);
    (axis, tangent, other, ((1.0 - cos) * (1.0 + cos)).sqrt() / TILTS)
}

#[allow(clippy::cast_possible_truncation, reason = "clamped to the range of a byte")]
fn byte(x: f64) -> i8 {
    let x = x.clamp(-127.0, 127.0);
    // A cast takes what is behind the point away: to the nearest, halves away from zero.
    (x + 0.5_f64.copysign(x)) as i8
}

fn dot([ax, ay, az]: [f64; 3], [bx, by, bz]: [f64; 3]) -> f64 {
    ax * bx + ay * by + az * bz
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// What lies in the cone comes back within a step or so, any byte decodes to a unit normal.
        #[test]
        fn planes_survive(x in -1.0_f64..1.0, y in -1.0_f64..1.0, cos in 0.1_f64..1.0, h in -1.9_f64..1.9, any: [i8; 3]) {
            let axis = [0.6, 0.0, 0.8];
            let sin = (1.0 - cos * cos).sqrt();
            let n = [axis[0] + sin * 0.6 * y, sin * 0.6 * x, axis[2] - sin * 0.6 * y * 0.75];
            let length = dot(n, n).sqrt();
            let normal = n.map(|c| (c / length) as f32);
            let record = PlaneRecord::encode(normal, h * 0.5, [0.0; 3], (axis, cos), 0.5);
            let (back, height) = record.decode((axis, cos), 0.5);
            prop_assert!(dot(back, normal.map(f64::from)) > 1.0 - sin * sin / 9000.0 - 1e-6);
            prop_assert!((height - h * 0.5).abs() < 0.5 / 64.0);
            let (garbage, _) = PlaneRecord { tilt: [any[0], any[1]], height: any[2] }.decode((axis, cos), f32::INFINITY);
            prop_assert!((dot(garbage, garbage) - 1.0).abs() < 1e-9);
        }
    }
}
