//! Value noise from an integer hash: the same bits on every machine, because it uses no table and no libm.

use glam::DVec3;

/// A well mixed 64-bit hash of a lattice point and a seed.
pub(crate) fn hash(x: i64, y: i64, z: i64, seed: u64) -> u64 {
    // The bits of the signed numbers are what is hashed; the signs have no meaning here.
    let [x, y, z] = [x, y, z].map(|v| u64::from_ne_bytes(v.to_ne_bytes()));
    let mut h = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15)
        ^ x.wrapping_mul(0xd1b5_4a32_d192_ed03)
        ^ y.wrapping_mul(0xaef1_7502_108e_f2d9).rotate_left(21)
        ^ z.wrapping_mul(0x8ebc_6af0_9c88_c6e3).rotate_left(42);
    h ^= h >> 32;
    h = h.wrapping_mul(0xc4ce_b9fe_1a85_ec53);
    h ^= h >> 29;
    h = h.wrapping_mul(0xff51_afd7_ed55_8ccd);
    h ^ h >> 32
}

/// The hash as a number in [0, 1), with 53 random bits.
pub(crate) fn unit(x: i64, y: i64, z: i64, seed: u64) -> f64 {
    (hash(x, y, z, seed) >> 11) as f64 / (1_u64 << 53) as f64
}

/// Fade with zero first and second derivatives at both ends, so that the lattice leaves no creases.
fn fade(t: f64) -> f64 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

fn mix(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

/// Value noise in [-1, 1] with one lattice point per unit of length.
pub(crate) fn value(p: DVec3, seed: u64) -> f64 {
    let cell = p.floor();
    let (x, y, z) = (cell.x as i64, cell.y as i64, cell.z as i64);
    let f = p - cell;
    let (u, v, w) = (fade(f.x), fade(f.y), fade(f.z));
    let at = |dx: i64, dy: i64, dz: i64| unit(x + dx, y + dy, z + dz, seed);
    let row = |dy: i64, dz: i64| mix(at(0, dy, dz), at(1, dy, dz), u);
    let sheet = |dz: i64| mix(row(0, dz), row(1, dz), v);
    2.0 * mix(sheet(0), sheet(1), w) - 1.0
}

/// Sum of octaves, each half as long and half as high as the one before; the first has wavelength 1.
pub(crate) fn octaves(p: DVec3, count: u32, seed: u64) -> f64 {
    let mut sum = 0.0;
    let mut frequency = 1.0;
    let mut height = 1.0;
    for octave in 0..count {
        sum += height * value(p * frequency, seed.wrapping_add(u64::from(octave)));
        // Not exactly 2, so that the lattices of the octaves do not line up.
        frequency *= 2.03;
        height *= 0.5;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_bounded_continuous_and_not_constant() {
        let mut low = f64::INFINITY;
        let mut high = f64::NEG_INFINITY;
        for i in 0..4000 {
            let p = DVec3::new(f64::from(i) * 0.037 - 60.0, f64::from(i) * 0.011, 0.3);
            let v = value(p, 7);
            low = low.min(v);
            high = high.max(v);
            assert!((-1.0..=1.0).contains(&v));
            assert!((value(p + DVec3::X * 1e-6, 7) - v).abs() < 1e-5);
        }
        assert!(high - low > 1.2);
        assert_ne!(value(DVec3::ONE * 0.5, 7).to_bits(), value(DVec3::ONE * 0.5, 8).to_bits());
    }
}
