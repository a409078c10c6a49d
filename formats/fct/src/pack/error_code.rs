//! Modelling errors in a byte.

use crate::node::root_of;

/// The code whose root is nearest to that of a mean square distance, in quanta.
pub(super) fn encode(epsilon: f64, quantum: f64) -> u8 {
    let root = epsilon.max(0.0).sqrt() / quantum;
    let low = not_above(root);
    if low < u8::MAX && root_of(low + 1) - root <= root - root_of(low) { low + 1 } else { low }
}

/// The largest code whose root is not above this one: its exponent and the first three digits after the leading one.
fn not_above(root: f64) -> u8 {
    let digits = root.to_bits() >> 49;
    // (8 + m) 2^(e - 26) has the exponent e - 23.
    let zero = (1023 - 23) << 3;
    digits.saturating_sub(zero).min(u64::from(u8::MAX)) as u8
}

#[cfg(test)]
mod tests {
    use super::encode;
    use crate::node::root_of;

    #[test]
    fn roots_come_back_within_a_sixteenth() {
        for code in 0..=u8::MAX {
            let root = root_of(code);
            assert_eq!(encode(root * root * 16.0, 4.0), code);
            let between = root * 1.05;
            let found = root_of(encode(between * between, 1.0));
            assert!(code == u8::MAX || (found - between).abs() <= between / 16.0 + 1e-9);
        }
        // No other code is nearer.
        for step in 0..4000_u32 {
            let root = f64::from(step * step) * 2e-5;
            let away = |code: u8| (root_of(code) - root).abs();
            let nearest = (0..=u8::MAX).map(away).fold(f64::INFINITY, f64::min);
            assert_eq!(away(encode(root * root, 1.0)), nearest, "{root}");
        }
        assert_eq!(encode(-1.0, 1.0), 0);
        assert_eq!(encode(f64::NAN, 1.0), 0);
        assert_eq!(encode(1e30, 1.0), u8::MAX);
    }
}
