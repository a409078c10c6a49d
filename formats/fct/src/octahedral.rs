//! Unit normals in four bytes: the octahedron unfolded onto a square.

use zerocopy::little_endian::I16;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// A unit normal as two 16-bit coordinates on the unfolded octahedron. 4 bytes.
///
/// The decoded direction is within 0.005 degrees of the encoded one.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(C)]
pub struct NormalRecord {
    /// The coordinates, in 1/32767; -32768 reads as -32767.
    pub uv: [I16; 2],
}

const _: () = assert!(size_of::<NormalRecord>() == 4);

const STEPS: f64 = 32767.0;

impl NormalRecord {
    /// Encodes a direction of any length; zero and non-finite vectors become +z.
    pub fn encode(normal: [f32; 3]) -> Self {
        let [x, y, z] = normal.map(f64::from);
        let sum = x.abs() + y.abs() + z.abs();
        if !(sum > 0.0 && sum.is_finite()) {
            return Self::default();
        }
        let (u, v) = (x / sum, y / sum);
        // The lower half is folded outwards over the four edges of the upper one.
        let (u, v) = if z >= 0.0 {
            (u, v)
        } else {
            ((1.0 - v.abs()) * sign_or_one(u), (1.0 - u.abs()) * sign_or_one(v))
        };
        Self { uv: [quantise(u), quantise(v)] }
    }

    /// The unit vector that is stored. Every value of the four bytes has one.
    pub fn decode(self) -> [f32; 3] {
        let [u, v] = self.uv.map(|c| (f64::from(c.get()) / STEPS).max(-1.0));
        let z = 1.0 - u.abs() - v.abs();
        let (x, y) = if z >= 0.0 {
            (u, v)
        } else {
            ((1.0 - v.abs()) * sign_or_one(u), (1.0 - u.abs()) * sign_or_one(v))
        };
        // |x| + |y| + |z| = 1, so the length is at least 1 / sqrt 3.
        let length = (x * x + y * y + z * z).sqrt();
        [narrow(x / length), narrow(y / length), narrow(z / length)]
    }
}

fn sign_or_one(x: f64) -> f64 {
    if x < 0.0 { -1.0 } else { 1.0 }
}

#[allow(clippy::cast_possible_truncation, reason = "the value is clamped to the range of i16 first")]
fn quantise(u: f64) -> I16 {
    I16::new((u * STEPS).round().clamp(-STEPS, STEPS) as i16)
}

#[allow(clippy::cast_possible_truncation, reason = "rounding a component of a unit vector to f32 is meant")]
fn narrow(x: f64) -> f32 {
    x as f32
}

#[cfg(test)]
mod tests {
    use super::NormalRecord;
    use proptest::prelude::*;
    use zerocopy::little_endian::I16;

    fn angle_degrees(a: [f32; 3], b: [f32; 3]) -> f64 {
        let [a, b] = [a, b].map(|v| v.map(f64::from));
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
            }
        }
    }

    #[test]
    fn directions_without_a_length_become_z() {
        for n in [[0.0; 3], [f32::NAN, 0.0, 1.0], [f32::INFINITY, 0.0, 0.0]] {
            assert_eq!(NormalRecord::encode(n).decode(), [0.0, 0.0, 1.0]);
        }
    }

    proptest! {
        #[test]
        fn directions_survive(x in -1.0_f32..1.0, y in -1.0_f32..1.0, z in -1.0_f32..1.0) {
            prop_assume!(x * x + y * y + z * z > 1e-6);
            let decoded = NormalRecord::encode([x, y, z]).decode();
            prop_assert!(angle_degrees([x, y, z], decoded) < 0.005);
        }

        #[test]
        fn every_value_decodes_to_a_unit_vector(u: i16, v: i16) {
            let n = NormalRecord { uv: [I16::new(u), I16::new(v)] }.decode();
            let length: f32 = n.iter().map(|c| c * c).sum::<f32>().sqrt();
            prop_assert!((length - 1.0).abs() < 1e-6);
        }
    }
}
