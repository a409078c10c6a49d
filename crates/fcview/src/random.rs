//! Seeded random numbers, the same on every platform for ever: what a seed places must not depend on a library.

use glam::{DQuat, DVec3};

/// A generator of 64-bit numbers (the splitmix64 sequence).
#[derive(Clone, Debug)]
pub struct Random {
    state: u64,
}

impl Random {
    /// The sequence of a seed.
    pub fn new(seed: u64) -> Random {
        Random { state: seed }
    }

    /// The next 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A number in 0..1, uniform.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A number in 0..n, uniform up to a part in 2^64; 0 for n = 0.
    pub fn below(&mut self, n: u64) -> u64 {
        ((u128::from(self.bits()) * u128::from(n)) >> 64) as u64
    }

    /// A unit vector, uniform on the sphere.
    pub fn direction(&mut self) -> DVec3 {
        loop {
            let p = DVec3::from_array([(); 3].map(|()| 2.0 * self.unit() - 1.0));
            let squared = p.length_squared();
            if squared <= 1.0 && squared > 1e-6 {
                return p / squared.sqrt();
            }
        }
    }

    /// A rotation, uniform.
    pub fn rotation(&mut self) -> DQuat {
        loop {
            let q = DQuat::from_array([(); 4].map(|()| 2.0 * self.unit() - 1.0));
            let squared = q.length_squared();
            if squared <= 1.0 && squared > 1e-6 {
                return q * (1.0 / squared.sqrt());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sequence_is_fixed_for_ever() {
        let mut random = Random::new(0);
        assert_eq!(random.bits(), 0xE220_A839_7B1D_CDAF);
        assert_eq!(random.bits(), 0x6E78_9E6A_A1B9_65F4);
    }

    #[test]
    fn directions_and_rotations_are_unit_and_spread_out() {
        let mut random = Random::new(3);
        let mut sum = DVec3::ZERO;
        for _ in 0..4000 {
            let d = random.direction();
            assert!((d.length() - 1.0).abs() < 1e-12);
            sum += d + random.rotation() * DVec3::X;
        }
        assert!(sum.length() < 400.0);
        assert!((0..100).all(|_| random.below(7) < 7));
    }
}
