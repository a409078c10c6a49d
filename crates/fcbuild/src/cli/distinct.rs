//! How many different positions there are, about, in little memory.

use fcbuild::import::Positions;
use xxhash_rust::xxh3::xxh3_64;

/// Bits of the table for each position; with four the estimate is within 1 % for any mesh that is worth estimating.
const BITS_EACH: usize = 4;

/// Estimates the number of different positions by linear counting: each sets the bit that its hash names, and the
/// share of bits that stay clear tells how many there were.
pub(crate) fn positions(positions: &Positions) -> u64 {
    let mut table = Table::new(positions.len());
    match positions {
        // Adding zero makes -0 and 0 one, as welding does.
        Positions::F32(v) => v.iter().for_each(|p| table.set(p.map(|x| f64::from(x) + 0.0))),
        Positions::F64(v) => v.iter().for_each(|p| table.set(p.map(|x| x + 0.0))),
    }
    table.estimate().min(positions.len() as u64)
}

struct Table {
    words: Vec<u64>,
    mask: u64,
}

impl Table {
    fn new(items: usize) -> Table {
        let bits = items.saturating_mul(BITS_EACH).max(1024).next_power_of_two();
        Table { words: vec![0; bits / 64], mask: bits as u64 - 1 }
    }

    fn set(&mut self, position: [f64; 3]) {
        let mut bytes = [0_u8; 24];
        for (eight, x) in bytes.chunks_exact_mut(8).zip(position) {
            eight.copy_from_slice(&x.to_le_bytes());
        }
        let bit = xxh3_64(&bytes) & self.mask;
        if let Some(word) = self.words.get_mut((bit / 64) as usize) {
            *word |= 1 << (bit % 64);
        }
    }

    fn estimate(&self) -> u64 {
        let bits = self.words.len() as f64 * 64.0;
        let clear: u64 = self.words.iter().map(|w| u64::from(w.count_zeros())).sum();
        (-bits * (clear.max(1) as f64 / bits).ln()).round() as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_estimate_is_within_a_percent() {
        for (n, copies) in [(1, 5), (1000, 1), (20_000, 1), (20_000, 6)] {
            let list: Vec<[f32; 3]> = (0..n * copies).map(|i| [(i % n) as f32, 0.5, -0.0]).collect();
            let found = positions(&Positions::F32(list)) as f64;
            assert!((found - n as f64).abs() <= (0.02 * n as f64).max(1.0), "{found} of {n}");
        }
        assert_eq!(positions(&Positions::F32(Vec::new())), 0);
    }

    #[test]
    fn both_zeros_are_one() {
        assert_eq!(positions(&Positions::F64(vec![[0.0, -0.0, 0.0], [-0.0, 0.0, 0.0]])), 1);
    }
}
