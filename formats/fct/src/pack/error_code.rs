//! Modelling errors in a byte.

use crate::node::root_of;

/// The code whose root is nearest to that of a mean square distance, in quanta.
pub(super) fn encode(epsilon: f64, quantum: f64) -> u8 {
    let root = epsilon.max(0.0).sqrt() / quantum;
    // The codes are in order, so the first that is not below is found by halving.
    let (mut low, mut high) = (0_u8, u8::MAX);
    while low < high {
        let middle = low + (high - low) / 2;
        if root_of(middle) >= root {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    if low > 0 && root - root_of(low - 1) < root_of(low) - root { low - 1 } else { low }
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
        assert_eq!(encode(-1.0, 1.0), 0);
        assert_eq!(encode(1e30, 1.0), u8::MAX);
    }
}
