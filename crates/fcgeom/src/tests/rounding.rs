use crate::{round_down, round_up};
use proptest::prelude::*;

proptest! {
    /// Each is on its side, and the nearest there: the next number the other way is beyond.
    #[test]
    fn is_directed_and_tight(x in prop_oneof![-1.0e39f64..1.0e39, -1.0f64..1.0, -1.0e-44f64..1.0e-44]) {
        let (up, down) = (round_up(x), round_down(x));
        prop_assert!(f64::from(up) >= x && f64::from(down) <= x);
        prop_assert!(f64::from(up.next_down()) < x || up == f32::MIN);
        prop_assert!(f64::from(down.next_up()) > x || down == f32::MAX);
    }

    #[test]
    fn keeps_what_is_exact(x in proptest::num::f32::NORMAL | proptest::num::f32::SUBNORMAL | proptest::num::f32::ZERO) {
        prop_assert_eq!(round_up(f64::from(x)), x);
        prop_assert_eq!(round_down(f64::from(x)), x);
    }
}

#[test]
fn saturates_on_the_safe_side() {
    assert_eq!(round_up(1.0e300), f32::INFINITY);
    assert_eq!(round_down(1.0e300), f32::MAX);
    assert_eq!(round_up(-1.0e300), f32::MIN);
    assert_eq!(round_down(-1.0e300), f32::NEG_INFINITY);
    assert_eq!(round_up(1.0e-300), f32::from_bits(1));
    assert_eq!(round_down(1.0e-300), 0.0);
    assert!(round_up(f64::NAN).is_nan() && round_down(f64::NAN).is_nan());
    assert_eq!(round_up(f64::INFINITY), f32::INFINITY);
}
