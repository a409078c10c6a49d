//! Where a vertex is drawn in coarse meshes.
//!
//! All vertices of a mesh lie on its surface, so that every chord cuts below a bump and above a hollow. In the budget
//! order a vertex may be drawn beside its place instead, as far as its own record and the tolerance say: all clusters
//! that share it agree, and at full resolution it is where it was.

use crate::records::VertexRecord;

/// Tolerances, as shares of the budget key, that displacements are stored for.
pub(crate) const SHARES: [f64; 2] = [0.7, 0.35];

/// Steps of a displacement in a budget key: the most is half the key.
const STEPS: f64 = 256.0;

impl VertexRecord {
    /// The shares of the budget key at which the two displacements of a vertex are its own: between them they are
    /// interpolated, above the first they stay, below the second they shrink with the square of the tolerance.
    pub const DISPLACED_AT: [f64; 2] = SHARES;

    /// Stores displacements (length) for the two shares of the key. An infinite key, or one of 0, has none.
    #[must_use]
    pub fn with_displacement(mut self, displacement: [[f64; 3]; 2]) -> Self {
        let unit = f64::from(self.budget.get()) / STEPS;
        self.displacement = displacement.map(|d| {
            if unit > 0.0 && unit.is_finite() && d.iter().all(|x| x.is_finite()) {
                let longest = d.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
                // A longer one keeps its direction.
                let fit = if longest > 127.0 * unit { 127.0 * unit / longest } else { 1.0 };
                #[allow(clippy::cast_possible_truncation, reason = "at most 127")]
                d.map(|x| (x * fit / unit).round() as i8)
            } else {
                [0; 3]
            }
        });
        self
    }

    /// How far beside its place the vertex is drawn (length) when its tolerance in the budget order is `allowed`.
    ///
    /// Zero where nothing is allowed, and for a vertex that is in every mesh; never longer than the key.
    pub fn displaced(&self, allowed: f64) -> [f64; 3] {
        let key = f64::from(self.budget.get());
        let share = allowed / key;
        if self.displacement == [[0; 3]; 2] || !(share > 0.0 && key.is_finite()) {
            return [0.0; 3];
        }
        let [high, low] = SHARES;
        let (of_high, of_low) = if share >= low {
            let along = ((share - low) / (high - low)).min(1.0);
            (along, 1.0 - along)
        } else {
            (0.0, share * share / (low * low))
        };
        let [[a, b, c], [d, e, f]] = self.displacement;
        let unit = key / STEPS;
        [(a, d), (b, e), (c, f)].map(|(d, e)| unit * (of_high * f64::from(d) + of_low * f64::from(e)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::short_float::ShortFloat;

    #[test]
    fn a_displacement_comes_back_at_its_tolerances_and_vanishes_with_them() {
        let record = VertexRecord { budget: ShortFloat::up(2.0), ..VertexRecord::default() };
        let given = [[0.5, -0.25, 0.125], [0.25, 0.0, -0.5]];
        let record = record.with_displacement(given);
        let key = f64::from(record.budget.get());
        for (share, d) in SHARES.into_iter().zip(given) {
            let back = record.displaced(share * key);
            assert!((0..3).all(|k| (back[k] - d[k]).abs() < key / 256.0), "{back:?}");
        }
        assert_eq!(record.displaced(key), record.displaced(0.7 * key));
        assert_eq!(record.displaced(0.0), [0.0; 3]);
        assert_eq!(record.displaced(f64::NAN), [0.0; 3]);
        let length = |d: [f64; 3]| d.iter().map(|x| x * x).sum::<f64>().sqrt();
        assert!(length(record.displaced(0.01)) < 1e-3);
        // Continuous, and never beyond the key.
        let wild = record.with_displacement([[9.0; 3], [-9.0; 3]]);
        let mut last = wild.displaced(0.0);
        for i in 1..=1000 {
            let next = wild.displaced(f64::from(i) / 1000.0 * key);
            assert!(length([0, 1, 2].map(|k| next[k] - last[k])) < 0.02 * key && length(next) <= key);
            last = next;
        }
    }

    #[test]
    fn vertices_of_every_mesh_stay() {
        let record = VertexRecord { budget: ShortFloat::up(f64::INFINITY), ..VertexRecord::default() };
        assert_eq!(record.with_displacement([[1.0; 3]; 2]).displaced(1.0), [0.0; 3]);
    }
}
