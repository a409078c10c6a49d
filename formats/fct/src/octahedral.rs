//! Unit vectors in two or four bytes: the octahedron unfolded onto a square.

use zerocopy::little_endian::I16;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// A unit vector as two 8-bit coordinates on the unfolded octahedron. 2 bytes.
///
/// The decoded direction is within 0.7 degrees of the encoded one.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(transparent)]
pub struct NormalRecord {
    /// The coordinates, in 1/127; -128 reads as -127.
    pub uv: [i8; 2],
}

/// A unit vector as two 16-bit coordinates on the unfolded octahedron. 4 bytes.
///
/// The decoded direction is within 0.005 degrees of the encoded one.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(transparent)]
pub struct FineNormalRecord {
    /// The coordinates, in 1/32767; -32768 reads as -32767.
    pub uv: [I16; 2],
}

const _: () = assert!(size_of::<NormalRecord>() == 2);
const _: () = assert!(size_of::<FineNormalRecord>() == 4);

const STEPS: f64 = 127.0;
const FINE_STEPS: f64 = 32767.0;

impl NormalRecord {
    /// Encodes a direction of any length; zero and non-finite vectors become +z.
    ///
    /// Of the four values around the exact one it takes the nearest direction, which plain rounding may miss.
    pub fn encode(normal: [f32; 3]) -> Self {
        let normal = normal.map(f64::from);
        let Some([u, v]) = unfold(normal) else {
            return Self::default();
        };
        let (u, v) = (u * STEPS, v * STEPS);
        let mut best = (f64::NEG_INFINITY, Self::default());
        for [u, v] in [[low(u), low(v)], [high(u), low(v)], [low(u), high(v)], [high(u), high(v)]] {
            let candidate = Self { uv: [narrow(u), narrow(v)] };
            let direction = unfolded(candidate.uv.map(|c| f64::from(c) / STEPS));
            let along = dot(direction, normal);
            // The cosine of the angle, squared, times the square of the normal's length.
            let nearness = along * along.abs() / dot(direction, direction);
            if nearness > best.0 {
                best = (nearness, candidate);
            }
        }
        best.1
    }

    /// The unit vector that is stored. Every value of the two bytes has one.
    #[inline]
    pub fn decode(self) -> [f32; 3] {
        self.direction().map(single)
    }

    /// The same but for rounding, and sooner.
    #[inline]
    pub(crate) fn near(self) -> [f32; 3] {
        let [u, v] = self.uv.map(|c| f32::from(c).max(-127.0));
        let z = 127.0 - u.abs() - v.abs();
        // Below the equator the coordinates are folded over.
        let over = (-z).max(0.0);
        let [x, y] = [u, v].map(|c| c - over.copysign(c));
        let per_length = 1.0 / (x * x + y * y + z * z).sqrt();
        [x * per_length, y * per_length, z * per_length]
    }

    /// The same in double precision.
    #[inline]
    pub fn direction(self) -> [f64; 3] {
        fold(self.uv.map(|c| (f64::from(c) / STEPS).max(-1.0)))
    }
}

impl FineNormalRecord {
    /// Encodes a direction of any length; zero and non-finite vectors become +z.
    pub fn encode(normal: [f32; 3]) -> Self {
        let uv = unfold(normal.map(f64::from)).unwrap_or_default();
        Self { uv: uv.map(|c| I16::new(narrow_fine((c * FINE_STEPS).round()))) }
    }

    /// The unit vector that is stored. Every value of the four bytes has one.
    pub fn direction(self) -> [f64; 3] {
        fold(self.uv.map(|c| (f64::from(c.get()) / FINE_STEPS).max(-1.0)))
    }
}

/// Coordinates on the square, or none for a vector without a direction.
fn unfold([x, y, z]: [f64; 3]) -> Option<[f64; 2]> {
    let sum = x.abs() + y.abs() + z.abs();
    if !(sum > 0.0 && sum.is_finite()) {
        return None;
    }
    let (u, v) = (x / sum, y / sum);
    // The lower half is folded outwards over the four edges of the upper one.
    Some(if z >= 0.0 { [u, v] } else { [(1.0 - v.abs()) * sign_or_one(u), (1.0 - u.abs()) * sign_or_one(v)] })
}

#[inline]
fn fold(uv: [f64; 2]) -> [f64; 3] {
    let [x, y, z] = unfolded(uv);
    // |x| + |y| + |z| = 1, so the length is at least 1 / sqrt 3.
    let per_length = 1.0 / (x * x + y * y + z * z).sqrt();
    [x * per_length, y * per_length, z * per_length]
}

/// The point of the octahedron.
#[inline]
fn unfolded([u, v]: [f64; 2]) -> [f64; 3] {
    let z = 1.0 - u.abs() - v.abs();
    let (x, y) =
        if z >= 0.0 { (u, v) } else { ((1.0 - v.abs()) * sign_or_one(u), (1.0 - u.abs()) * sign_or_one(v)) };
    [x, y, z]
}

/// The whole number below or at one of a few hundred.
#[allow(clippy::cast_possible_truncation, reason = "it is a few hundred")]
fn low(x: f64) -> f64 {
    let near = f64::from(x as i32);
    if near > x { near - 1.0 } else { near }
}

/// The whole number above or at one of a few hundred.
fn high(x: f64) -> f64 {
    -low(-x)
}

/// A unit vector at right angles to a unit vector, by + - * / alone; continuous but where z changes its sign.
pub(crate) fn tangent_of([x, y, z]: [f64; 3]) -> [f64; 3] {
    let side = if z < 0.0 { -1.0 } else { 1.0 };
    // The reflection that takes the pole on the vector's side to the vector, applied to the x axis.
    let k = x / (side + z);
    [1.0 - side * x * k, -side * y * k, -side * x]
}

fn dot([ax, ay, az]: [f64; 3], [bx, by, bz]: [f64; 3]) -> f64 {
    ax * bx + ay * by + az * bz
}

fn sign_or_one(x: f64) -> f64 {
    if x < 0.0 { -1.0 } else { 1.0 }
}

#[allow(clippy::cast_possible_truncation, reason = "the value is clamped to the range of i8 first")]
fn narrow(u: f64) -> i8 {
    u.clamp(-STEPS, STEPS) as i8
}

#[allow(clippy::cast_possible_truncation, reason = "the value is clamped to the range of i16 first")]
fn narrow_fine(u: f64) -> i16 {
    u.clamp(-FINE_STEPS, FINE_STEPS) as i16
}

#[allow(clippy::cast_possible_truncation, reason = "rounding a component of a unit vector to f32 is meant")]
fn single(x: f64) -> f32 {
    x as f32
}

#[cfg(test)]
mod tests {
    use super::{FineNormalRecord, NormalRecord, dot, tangent_of};
    use proptest::prelude::*;
    use zerocopy::little_endian::I16;

    fn angle_degrees(a: [f64; 3], b: [f64; 3]) -> f64 {
        let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
        let sine = cross.iter().map(|c| c * c).sum::<f64>().sqrt();
        let cosine: f64 = a.iter().zip(b).map(|(x, y)| x * y).sum();
        sine.atan2(cosine).to_degrees()
    }

    #[test]
    fn axes_are_exact() {
        for axis in 0..3 {
            for sign in [-1.0_f32, 1.0] {
                let mut n = [0.0_f32; 3];
                n[axis] = sign;
                assert_eq!(NormalRecord::encode(n).decode().map(|c| c + 0.0), n);
                assert_eq!(FineNormalRecord::encode(n).direction().map(|c| c + 0.0), n.map(f64::from));
            }
        }
    }

    #[test]
    fn directions_without_a_length_become_z() {
        for n in [[0.0; 3], [f32::NAN, 0.0, 1.0], [f32::INFINITY, 0.0, 0.0]] {
            assert_eq!(NormalRecord::encode(n).decode(), [0.0, 0.0, 1.0]);
            assert_eq!(FineNormalRecord::encode(n).direction(), [0.0, 0.0, 1.0]);
        }
    }

    proptest! {
        #[test]
        fn directions_survive(x in -1.0_f32..1.0, y in -1.0_f32..1.0, z in -1.0_f32..1.0) {
            prop_assume!(x * x + y * y + z * z > 1e-6);
            let exact = [x, y, z].map(f64::from);
            prop_assert!(angle_degrees(exact, NormalRecord::encode([x, y, z]).direction()) < 0.7);
            prop_assert!(angle_degrees(exact, FineNormalRecord::encode([x, y, z]).direction()) < 0.005);
        }

        #[test]
        fn every_value_decodes_to_a_unit_vector_with_a_tangent(u: i16, v: i16) {
            let fine = FineNormalRecord { uv: [I16::new(u), I16::new(v)] }.direction();
            let [u, v] = [u, v].map(|c| c.to_le_bytes()[0].cast_signed());
            for n in [fine, NormalRecord { uv: [u, v] }.direction()] {
                let t = tangent_of(n);
                prop_assert!((dot(n, n) - 1.0).abs() < 1e-12);
                prop_assert!((dot(t, t) - 1.0).abs() < 1e-12 && dot(t, n).abs() < 1e-12);
            }
        }
    }
}
