//! Cones whose axis moved when it was rounded.

use crate::node::cosine_of;
use crate::octahedral::NormalRecord;

/// What the stored axis and cosines may lose when they are rounded to single precision.
const ROUNDING: f64 = 4e-7;

/// The width of a cone about the decoded `axis` that holds the cone of `exact` and `cos`.
pub(super) fn width(exact: [f32; 3], cos: f32, axis: NormalRecord) -> u8 {
    let (a, b) = (exact.map(f64::from), axis.decode().map(f64::from));
    let along = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let across = (cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2]).sqrt();
    let length = (along * along + across * across).sqrt();
    // Written so that NaN is a cone that culls nothing.
    if !(cos > 0.0 && length > 0.0) {
        return u8::MAX;
    }
    let cos = f64::from(cos).min(1.0);
    // The cosine of the sum of the half angle and the angle between the axes.
    let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
    let sum = (cos * along - sin * across) / length - ROUNDING;
    // The width of which `sum` is the cosine, and the first from there that is low enough.
    let about = ((1.0 - sum).max(0.0).sqrt() * WIDTHS).min(254.0) as u8;
    (about..u8::MAX).find(|width| f64::from(cosine_of(*width)) <= sum).unwrap_or(u8::MAX)
}

/// A width of so many steps would be a right angle, if it could be stored.
const WIDTHS: f64 = 256.0;

#[cfg(test)]
mod tests {
    use super::width;
    use crate::node::cosine_of;
    use crate::octahedral::NormalRecord;
    use proptest::prelude::*;

    #[test]
    fn what_is_no_cone_culls_nothing() {
        let axis = NormalRecord::default();
        for cos in [-1.0, 0.0, f32::NAN] {
            assert_eq!(width([0.0, 0.0, 1.0], cos, axis), u8::MAX);
        }
        assert_eq!(width([0.0; 3], 0.5, axis), u8::MAX);
        assert_eq!(width([0.0, 0.0, -1.0], 0.9, axis), u8::MAX);
    }

    proptest! {
        /// Never too narrow, and no wider than the steps of axis and angle ask for.
        #[test]
        fn normals_of_the_cone_stay_inside(
            x in -1.0_f32..1.0, y in -1.0_f32..1.0, z in -1.0_f32..1.0, half in 0.0_f64..1.2, turn in 0.0_f64..6.3,
        ) {
            prop_assume!(x * x + y * y + z * z > 1e-2);
            let length = (x * x + y * y + z * z).sqrt();
            let exact = [x / length, y / length, z / length];
            let axis = NormalRecord::encode(exact);
            let stored = f64::from(cosine_of(width(exact, half.cos() as f32 - 1e-7, axis)));
            let a = exact.map(f64::from);
            let side = crate::octahedral::tangent_of(a);
            let other = [a[1] * side[2] - a[2] * side[1], a[2] * side[0] - a[0] * side[2], a[0] * side[1] - a[1] * side[0]];
            let normal = [0, 1, 2].map(|k| {
                a[k] * half.cos() + (side[k] * turn.cos() + other[k] * turn.sin()) * half.sin()
            });
            let along: f64 = normal.iter().zip(axis.direction()).map(|(n, a)| n * a).sum();
            prop_assert!(along >= stored - 1e-6);
            prop_assert!(stored.acos() <= half + 0.013 + 0.02, "{} for {half}", stored.acos());
        }
    }
}
