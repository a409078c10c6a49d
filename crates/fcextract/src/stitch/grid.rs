//! Places in a plane on a grid so fine that nothing is lost, and so coarse that it is exact on which side of a line one
//! lies.

use glam::DVec2;

/// The logarithm of how far from the origin places on the grid may be: differences of their coordinates are exact then.
const BITS: i32 = 50;

/// Moves places to the grid, scaled by a power of two, which is returned. What is no number comes to the origin.
pub(super) fn snap(points: &mut [DVec2]) -> f64 {
    let size = points.iter().fold(0.0_f64, |size, p| size.max(p.x.abs()).max(p.y.abs()));
    // The exponent of a number as it is stored; places made of single precision have one far from both ends.
    let exponent = (size.to_bits() >> 52) as i32 - 1023;
    let scale = if exponent.abs() < 900 { power_of_two(BITS - 1 - exponent) } else { 0.0 };
    // A sum with so large a number has no digits behind the point.
    let rounded = |c: f64| (c * scale + ROUNDING) - ROUNDING;
    for p in points {
        *p = DVec2::new(rounded(p.x), rounded(p.y));
        if !p.is_finite() {
            *p = DVec2::ZERO;
        }
    }
    scale
}

const ROUNDING: f64 = 1.5 * (1_u64 << 52) as f64;

fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(((exponent + 1023) as u64) << 52)
}

/// Twice the area of a triangle between places on the grid, negative if it is turned over; its sign is exact.
#[inline]
pub(super) fn area(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let (u, v) = (b - a, c - a);
    let (left, right) = (u.x * v.y, u.y * v.x);
    let area = left - right;
    // Each product and the difference are rounded by at most 2^-53 of themselves.
    if area.abs() > 4e-16 * (left.abs() + right.abs()) { area } else { exact(u, v) }
}

#[cold]
fn exact(u: DVec2, v: DVec2) -> f64 {
    let [ux, uy, vx, vy] = [u.x, u.y, v.x, v.y].map(|c| i128::from(c as i64));
    (ux * vy - uy * vx) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn places_keep_their_shape(points in prop::collection::vec([-1e3_f32..1e3, -1e3_f32..1e3], 1..20)) {
            let before: Vec<DVec2> = points.iter().map(|p| DVec2::from_array(p.map(f64::from))).collect();
            let mut after = before.clone();
            let scale = snap(&mut after);
            for (p, q) in before.iter().zip(&after) {
                prop_assert!((*p * scale - *q).abs().max_element() <= 0.5);
                prop_assert!(q.abs().max_element() <= (1_u64 << BITS) as f64);
                prop_assert!(q.x.fract() == 0.0 && q.y.fract() == 0.0);
            }
            prop_assert!(after.iter().any(|q| q.abs().max_element() >= (1_u64 << (BITS - 1)) as f64)
                || before.iter().all(|p| *p == DVec2::ZERO));
        }

        /// A point on a line, and one step of the grid beside it.
        #[test]
        fn sides_are_exact(x in -1_i64 << 40..1 << 40, y in -1_i64 << 40..1 << 40, along in 1_i64..500) {
            let place = |x: i64, y: i64| DVec2::new(x as f64, y as f64);
            let (a, b, c) = (place(-7, 11), place(x - 7, y + 11), place(along * x - 7, along * y + 11));
            prop_assert_eq!(area(a, b, c), 0.0);
            let beside = |step: i64| area(a, b, place(along * x - 7, along * y + 11 + step));
            prop_assert_eq!(beside(1).partial_cmp(&0.0), x.partial_cmp(&0));
            prop_assert_eq!(beside(-1).partial_cmp(&0.0), (-x).partial_cmp(&0));
        }
    }

    #[test]
    fn what_is_no_number_is_at_the_origin() {
        let mut points = [DVec2::NAN, DVec2::ONE, DVec2::new(f64::NAN, 3.0)];
        snap(&mut points);
        assert!(points[0] == DVec2::ZERO && points[1] != DVec2::ZERO && points[2] == DVec2::ZERO);
        let mut points = [DVec2::INFINITY, DVec2::ONE];
        snap(&mut points);
        assert_eq!(points, [DVec2::ZERO; 2]);
    }
}
