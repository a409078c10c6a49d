//! Welding of vertices at equal positions, and the faces that survive it.

use super::shares::shares;
use crate::import::{DropReason, Tally};
use glam::Vec3;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// Which vertices become one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Weld {
    /// Those whose coordinates are the same bits, with -0 = +0. Scans need it: as shipped, many repeat vertices.
    Exact,
    /// Each vertex joins the first earlier one within this distance, in the input's unit.
    Within(f64),
    /// None.
    Off,
}

/// For every vertex the lowest-numbered vertex it is welded to (itself, if none).
pub(super) fn weld(positions: &[Vec3], weld: Weld) -> Vec<u32> {
    match weld {
        Weld::Off => (0..positions.len() as u32).collect(),
        Weld::Exact => weld_exact(positions),
        Weld::Within(distance) => weld_within(positions, distance),
    }
}

fn weld_exact(positions: &[Vec3]) -> Vec<u32> {
    let key = |i: usize| positions[i].to_array().map(|x| (x + 0.0).to_bits());
    let representative: Vec<AtomicU32> =
        (0..positions.len() as u32).into_par_iter().map(AtomicU32::new).collect();
    // Equal positions have one hash, and so one thread.
    let parts = rayon::current_num_threads();
    (0..parts).into_par_iter().for_each(|part| {
        let hash = |i: usize| Some(CellTable::hash(key(i))).filter(|h| (h >> 32) as usize % parts == part);
        let own = (0..positions.len()).filter(|i| hash(*i).is_some()).count();
        let mut table = CellTable::for_items(own);
        for (i, representative) in representative.iter().enumerate() {
            if let Some(hash) = hash(i) {
                let slot = table.slot(hash, |other| key(other as usize) == key(i));
                representative.store(*table.entry(slot, i as u32), Relaxed);
            }
        }
    });
    representative.into_iter().map(AtomicU32::into_inner).collect()
}

/// A grid of cells as wide as the distance: partners lie in the 27 cells around a point.
fn weld_within(positions: &[Vec3], distance: f64) -> Vec<u32> {
    if distance.is_nan() || distance <= 0.0 {
        return weld_exact(positions);
    }
    // Cells are counted in doubles: so far out that a neighbour's number is the same, single-precision positions are
    // farther apart than the distance, unless they are equal and so in the same cell.
    let cell = |p: Vec3| (p.as_dvec3() / distance).floor().to_array().map(|x| x.clamp(-f64::MAX, f64::MAX));
    let hashed = |c: [f64; 3]| c.map(|x| ((x + 0.0).to_bits() ^ ((x + 0.0).to_bits() >> 32)) as u32);
    let mut table = CellTable::for_items(positions.len());
    let mut next_in_cell: Vec<u32> = vec![u32::MAX; positions.len()];
    let mut representative: Vec<u32> = Vec::with_capacity(positions.len());
    for (i, &p) in positions.iter().enumerate() {
        let home = cell(p);
        let mut best = i as u32;
        for n in 0..27 {
            let near = [0, 1, 2].map(|axis| home[axis] + f64::from(n / [1, 3, 9][axis] % 3 - 1));
            let slot =
                table.slot(CellTable::hash(hashed(near)), |other| cell(positions[other as usize]) == near);
            let mut candidate = table.get(slot);
            while candidate != u32::MAX {
                if positions[candidate as usize].as_dvec3().distance(p.as_dvec3()) <= distance {
                    best = best.min(candidate);
                }
                candidate = next_in_cell[candidate as usize];
            }
        }
        representative.push(best);
        if best == i as u32 {
            // Only representatives are entered, so a chain of near points cannot creep.
            let slot =
                table.slot(CellTable::hash(hashed(home)), |other| cell(positions[other as usize]) == home);
            let head = *table.entry(slot, i as u32);
            if head != i as u32 {
                next_in_cell[i] = next_in_cell[head as usize];
                next_in_cell[head as usize] = i as u32;
            }
        }
    }
    representative
}

/// An open-addressing table from cells to vertex indices; it is only ever looked into, never iterated.
struct CellTable {
    slots: Vec<u32>,
}

impl CellTable {
    fn for_items(n: usize) -> Self {
        CellTable { slots: vec![u32::MAX; (2 * n + 2).next_power_of_two()] }
    }

    fn hash(key: [u32; 3]) -> u64 {
        let mut hash = 0x9e37_79b9_7f4a_7c15_u64;
        for k in key {
            hash = (hash ^ u64::from(k)).wrapping_mul(0xff51_afd7_ed55_8ccd);
            hash ^= hash >> 32;
        }
        hash
    }

    /// The slot of the entry that `same` accepts, or the free slot where it belongs.
    fn slot(&self, hash: u64, same: impl Fn(u32) -> bool) -> usize {
        let mask = self.slots.len() - 1;
        let mut slot = hash as usize & mask;
        while self.slots[slot] != u32::MAX && !same(self.slots[slot]) {
            slot = (slot + 1) & mask;
        }
        slot
    }

    fn get(&self, slot: usize) -> u32 {
        self.slots[slot]
    }

    /// The entry at `slot`, filled with `index` if it was free.
    fn entry(&mut self, slot: usize, index: u32) -> &u32 {
        if self.slots[slot] == u32::MAX {
            self.slots[slot] = index;
        }
        &self.slots[slot]
    }
}

/// The faces that keep three different vertices and repeat no earlier face; the others are counted.
pub(super) fn keep_faces(triangles: &[[u32; 3]], representative: &[u32], tally: &mut Tally) -> Vec<u32> {
    let mut rotated: Vec<[u32; 3]> = triangles
        .par_iter()
        .map(|t| {
            let t = rotate_lowest_first(t.map(|v| representative[v as usize]));
            if t[0] == t[1] || t[1] == t[2] || t[2] == t[0] { [u32::MAX; 3] } else { t }
        })
        .collect();
    let repeated: Vec<Vec<u32>> =
        shares(representative.len()).map(|own| repeated_faces(&rotated, own)).collect();
    for face in repeated.into_iter().flatten() {
        rotated[face as usize][2] |= MARK;
    }
    let mut kept = Vec::with_capacity(triangles.len());
    for (i, t) in rotated.iter().enumerate() {
        if t[0] == u32::MAX {
            tally.dropped.add(DropReason::RepeatedIndex, i as u64, 1);
        } else if t[2] & MARK == 0 {
            kept.push(i as u32);
        } else {
            tally.dropped.add(DropReason::Duplicate, i as u64, 1);
        }
    }
    kept
}

/// The faces that repeat an earlier one, of those whose lowest vertex is one of `own`.
fn repeated_faces(rotated: &[[u32; 3]], own: Range<usize>) -> Vec<u32> {
    // Faces in buckets of their lowest vertex; within a bucket equal faces are neighbours once it is sorted.
    let mut start = vec![0_u32; own.len() + 1];
    let bucket = |t: &[u32; 3]| Some(t[0] as usize).filter(|v| own.contains(v)).map(|v| v - own.start);
    for v in rotated.iter().filter_map(bucket) {
        start[v] += 1;
    }
    let mut sum = 0;
    for s in &mut start {
        sum += std::mem::replace(s, sum);
    }
    let mut bucketed = vec![0_u32; sum as usize];
    for (i, t) in rotated.iter().enumerate() {
        if let Some(v) = bucket(t) {
            let slot = &mut start[v];
            bucketed[*slot as usize] = i as u32;
            *slot += 1;
        }
    }
    let mut repeated = Vec::new();
    let mut low = 0;
    // `start[v]` has moved to the end of bucket v.
    for &high in &start[..own.len()] {
        let bucket = &mut bucketed[low as usize..high as usize];
        bucket.sort_unstable_by_key(|&i| (rotated[i as usize], i));
        let pairs = bucket.windows(2).filter(|pair| rotated[pair[0] as usize] == rotated[pair[1] as usize]);
        repeated.extend(pairs.map(|pair| pair[1]));
        low = high;
    }
    repeated
}

/// Vertex indices stay below 2^31 (three half-edges a face do), so the top bit can mark a repeated face.
const MARK: u32 = 1 << 31;

fn rotate_lowest_first(t: [u32; 3]) -> [u32; 3] {
    let [a, b, c] = t;
    if a <= b && a <= c {
        t
    } else if b <= c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(n: u32) -> Vec<Vec3> {
        (0..n).map(|i| Vec3::new((i * 7 % 13) as f32, (i % 5) as f32 * -0.0, (i / 6) as f32 * 0.01)).collect()
    }

    #[test]
    fn exact_welding_equals_the_quadratic_search() {
        let points = points(300);
        let naive: Vec<u32> =
            points.iter().map(|p| points.iter().position(|q| p == q).unwrap_or(0) as u32).collect();
        assert_eq!(weld_exact(&points), naive);
    }

    #[test]
    fn welding_within_a_distance_equals_the_quadratic_search() {
        let points = points(300);
        for distance in [0.005, 0.011, 0.5, 1.2] {
            let mut naive: Vec<u32> = Vec::new();
            for (i, p) in points.iter().enumerate() {
                let first = (0..i).find(|&j| {
                    naive[j] == j as u32 && points[j].as_dvec3().distance(p.as_dvec3()) <= distance
                });
                naive.push(first.unwrap_or(i) as u32);
            }
            assert_eq!(weld_within(&points, distance), naive, "{distance}");
        }
    }

    #[test]
    fn a_distance_far_below_the_coordinates_welds_what_is_equal() {
        let points = [Vec3::splat(1e20), Vec3::splat(-3e37), Vec3::splat(1e20), Vec3::new(1e20, 1e20, 2e20)];
        for distance in [1e-300, 1e-20, 0.3] {
            assert_eq!(weld_within(&points, distance), [0, 1, 0, 3]);
        }
    }

    #[test]
    fn repeated_and_degenerate_faces_are_counted() {
        let mut tally = Tally::default();
        let faces = [[0, 1, 2], [1, 2, 0], [2, 1, 0], [0, 0, 1], [3, 1, 2], [2, 0, 1], [0, 1, 2]];
        assert_eq!(keep_faces(&faces, &[0, 1, 2, 3], &mut tally), [0, 2, 4]);
        assert_eq!(tally.dropped.count(DropReason::Duplicate), 3);
        assert_eq!(tally.dropped.count(DropReason::RepeatedIndex), 1);
    }
}
