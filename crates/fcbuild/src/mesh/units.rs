//! The unit of length that the builder works in.

use super::Weld;
use super::rounding::Rounding;
use crate::error::Error;
use crate::import::Positions;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// An exact change of units: the box of the used vertices gets a longest side in [1, 2).
///
/// The factor is a power of two, so a single-precision coordinate changes its exponent and nothing else.
/// It makes the tree independent of the unit of the mesh: a mesh scaled by a power of two gives the same tree.
/// Without it, squared lengths of very large or very small models would leave the range of single precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units {
    /// Length of one normal unit in the input's unit, a power of two, and its inverse.
    length: f64,
    inverse: f64,
    /// Added to the stored positions gives the input's coordinates; zero for single-precision input.
    pub origin: DVec3,
}

impl Units {
    /// The positions as a file stores them (moved to an origin if they were in double precision), and in normal units;
    /// how far that rounds them, which single precision never is.
    ///
    /// What no triangle uses and is not finite becomes zero. A coordinate 2^126 times smaller than the box loses digits
    /// in normal units; that is why the stored ones are kept beside them.
    ///
    /// # Errors
    /// Bad input when single precision cannot hold the model: it is too large, or so small that digits are lost.
    pub(crate) fn normalise(
        positions: Positions,
        triangles: &[[u32; 3]],
        weld: Weld,
    ) -> Result<(Units, Vec<Vec3>, Vec<Vec3>, Rounding), Error> {
        let empty = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let around = |(low, high): (DVec3, DVec3), v: &u32| match positions.get(*v as usize) {
            // Adding zero turns minus zero into zero, so that the order of equals does not matter.
            Some(p) => (low.min(DVec3::from(p) + 0.0), high.max(DVec3::from(p) + 0.0)),
            None => (low, high),
        };
        let (mut low, mut high) = triangles
            .as_flattened()
            .par_iter()
            .fold(|| empty, around)
            .reduce(|| empty, |a, b| (a.0.min(b.0), a.1.max(b.1)));
        if triangles.is_empty() {
            (low, high) = (DVec3::ZERO, DVec3::ZERO);
        }
        let size = (high - low).max_element();
        let origin = match positions {
            Positions::F32(_) => DVec3::ZERO,
            Positions::F64(_) => short_origin((low + high) * 0.5, size),
        };
        let reach = (low - origin).abs().max((high - origin).abs()).max_element();
        if reach > f64::from(f32::MAX) {
            return Err(too_large());
        }
        if size > 0.0 && size < SMALLEST {
            return Err(Error::bad_input(
                "FC292",
                format!("the model is {size:e} wide, too small for single precision"),
            )
            .remedy("scale it up before building"));
        }
        let exponent = binary_exponent(size);
        let units = Units { length: power_of_two(exponent), inverse: power_of_two(-exponent), origin };
        let finite = |p: Vec3| if p.is_finite() { p } else { Vec3::ZERO };
        let mut rounding = Rounding::default();
        let stored: Vec<Vec3> = match positions {
            Positions::F32(v) => v.into_iter().map(|p| finite(p.into())).collect(),
            Positions::F64(v) => {
                let stored: Vec<Vec3> =
                    v.iter().map(|p| finite((DVec3::from(*p) - origin).as_vec3())).collect();
                let exact = |i: u32| DVec3::from(v[i as usize]);
                rounding = Rounding::of(triangles, weld, exact, |i| origin + stored[i as usize].as_dvec3());
                stored
            }
        };
        let normal = stored.par_iter().map(|p| units.normal(*p)).collect();
        Ok((units, stored, normal, rounding))
    }

    /// A stored position in normal units.
    pub fn normal(&self, stored: Vec3) -> Vec3 {
        (stored.as_dvec3() * self.inverse).as_vec3()
    }

    /// A position in normal units as it is stored: the same again, unless [`Units::normal`] lost digits of it.
    pub fn stored(&self, normal: Vec3) -> Vec3 {
        (normal.as_dvec3() * self.length).as_vec3()
    }

    /// Length of one normal unit in the input's unit: a power of two.
    pub fn length(&self) -> f64 {
        self.length
    }
}

/// A place near the middle of a box, rounded to single precision, so that the sum of origin and position is short in
/// decimal; where that is farther off than the model is wide, to a multiple of about that width.
fn short_origin(middle: DVec3, size: f64) -> DVec3 {
    let unit = power_of_two(binary_exponent(size));
    let short = |x: f64| {
        let rounded = f64::from(x as f32);
        let is_near = (x - rounded).abs() <= size || !rounded.is_finite();
        if is_near { rounded } else { (x / unit).round() * unit }
    };
    DVec3::from(middle.to_array().map(short))
}

/// A model this wide still has all 24 bits of a coordinate's digits above the subnormal numbers, in a box a few times
/// larger than itself.
const SMALLEST: f64 = 1e-30;

/// The error for lengths, or squares of lengths, beyond single precision.
pub(crate) fn too_large() -> Error {
    Error::bad_input("FC292", "the model is too large for single precision")
        .remedy("scale it down before building")
}

/// The exponent e with 2^e <= x < 2^(e+1); 0 for zero and for what is not finite.
fn binary_exponent(x: f64) -> i32 {
    if x.is_normal() { ((x.to_bits() >> 52) & 0x7ff) as i32 - 1023 } else { 0 }
}

/// 2^e, exact, for |e| up to 1022.
fn power_of_two(e: i32) -> f64 {
    f64::from_bits(((e.clamp(-1022, 1023) + 1023) as u64) << 52)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_double_precision_tells_apart_stays_apart_far_away() {
        for far in [1e9, 1e15, -3e12] {
            let places: Vec<[f64; 3]> = (0..4).map(|i| [far + 0.125 * f64::from(i), far, 0.0]).collect();
            let triangles = [[0, 1, 2], [1, 2, 3]];
            let (units, stored, ..) =
                Units::normalise(Positions::F64(places.clone()), &triangles, Weld::Exact).unwrap();
            for (place, position) in places.iter().zip(stored) {
                assert_eq!(units.origin + position.as_dvec3(), DVec3::from(*place));
            }
        }
        // Near enough, the origin is short.
        assert_eq!(short_origin(DVec3::splat(1e6 + 0.3), 1.0), DVec3::splat(f64::from(1_000_000.3_f32)));
    }

    #[test]
    fn exponent_brackets_the_length() {
        for x in [1e-30, 0.3, 0.5, 1.0, 1.999, 2.0, 7.5e20] {
            let e = binary_exponent(x);
            assert!(power_of_two(e) <= x && x < power_of_two(e + 1), "{x}: {e}");
        }
        assert_eq!(binary_exponent(0.0), 0);
    }

    #[test]
    fn single_precision_is_stored_as_it_is() {
        let points =
            vec![[1.0e-3_f32, -7.25, 3.0e5], [0.1, 0.2, 0.3], [f32::NAN, 0.0, 0.0], [5.0, 6.0, -2.0e5]];
        let (units, stored, normal, _) =
            Units::normalise(Positions::F32(points.clone()), &[[0, 1, 3]], Weld::Exact).unwrap();
        for ((p, s), n) in points.iter().zip(&stored).zip(&normal).filter(|((p, _), _)| p[0].is_finite()) {
            assert_eq!(*s, Vec3::from(*p));
            assert_eq!((n.as_dvec3() * units.length()).as_vec3(), *s);
        }
    }

    #[test]
    fn double_precision_keeps_millimetres_far_from_the_origin() {
        let points = vec![
            [500_000.001, 4_000_000.0, 0.0],
            [500_000.002, 4_000_000.0, 0.0],
            [500_010.0, 4_000_010.0, 1.0],
        ];
        let (units, stored, ..) =
            Units::normalise(Positions::F64(points.clone()), &[[0, 1, 2]], Weld::Exact).unwrap();
        for (p, s) in points.iter().zip(&stored) {
            let back = s.as_dvec3() + units.origin;
            assert!((back - DVec3::from(*p)).length() < 1e-5, "{back}");
        }
    }

    #[test]
    fn what_single_precision_cannot_hold_is_refused() {
        let wide = |x: f64| Positions::F64(vec![[0.0; 3], [x, 0.0, 0.0], [0.0, x, 0.0]]);
        for x in [1e308, 1e300, 7e38, 1e-31, 1e-40] {
            let error = Units::normalise(wide(x), &[[0, 1, 2]], Weld::Exact).unwrap_err();
            assert_eq!(error.code(), "FC292", "{x:e}");
        }
        for x in [6e38, 1.0, 1e-29] {
            assert!(Units::normalise(wide(x), &[[0, 1, 2]], Weld::Exact).is_ok(), "{x:e}");
        }
    }
}
