//! Vertex records that are never less eager than the nodes that need them.

use crate::records::{VertexRecord, pack};
use crate::short_float::ShortFloat;

/// How much more than a node's sphere a vertex's must hold: 2^-20 of the radius, so that the rounding of a test can
/// never refine the node and leave the vertex out.
const EAGER: f64 = 1.0 + 1.0 / (1 << 20) as f64;

/// What a length may lose when it is too small for all digits of single precision.
const UNDERFLOW: f64 = 4.0 * f32::from_bits(1) as f64;

impl VertexRecord {
    /// The record of a vertex with the largest keys, and a sphere around the spheres, of the nodes that need it, all as
    /// decoded, see [`crate::Packed::decoded`]. The sphere is a centre and a radius.
    ///
    /// None if the sphere leaves the range of single precision.
    pub fn eager(position: [f32; 3], bound: f64, budget: f64, sphere: ([f64; 3], f64)) -> Option<Self> {
        let record = Self {
            position: pack(position),
            bound: ShortFloat::up(bound),
            budget: ShortFloat::up(budget),
            ..Self::default()
        };
        // No sphere matters where the answer is always or never: then none is stored.
        let always = bound == f64::INFINITY && budget == f64::INFINITY;
        if always || bound.max(budget) <= 0.0 {
            return Some(record);
        }
        let (center, radius) = sphere;
        let needed = radius.max(0.0) * EAGER + UNDERFLOW;
        let at = position.map(f64::from);
        let away = [0, 1, 2].map(|k| center[k] - at[k]);
        let farthest = away.iter().fold(0.0_f64, |m, d| m.max(d.abs()));
        let mut stored = ShortFloat::up(needed.max(farthest * (128.0 / 127.0)));
        // Each round is one step of the radius; rounding the centre takes less than a hundredth of it.
        while stored.get().is_finite() {
            let step = f64::from(stored.get()) / 128.0;
            let offset = away.map(|d| (d / step).round().clamp(-127.0, 127.0) as i8);
            let record = Self { radius: stored, offset, ..record };
            let decoded = record.center();
            let d = [0, 1, 2].map(|k| decoded[k] - center[k]);
            let moved = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
            if moved + needed <= f64::from(stored.get()) {
                return Some(record);
            }
            stored = stored.next_up();
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use crate::records::VertexRecord;
    use proptest::prelude::*;

    #[test]
    fn keys_of_always_and_never_stay_so() {
        let always = VertexRecord::eager([1.0; 3], f64::INFINITY, f64::INFINITY, ([0.0; 3], 3.0)).unwrap();
        assert_eq!((always.bound(), always.budget(), always.radius()), (f32::INFINITY, f32::INFINITY, 0.0));
        let never = VertexRecord::eager([1.0; 3], 0.0, 0.0, ([0.0; 3], -1.0)).unwrap();
        assert_eq!((never.bound(), never.budget()), (0.0, 0.0));
        assert_eq!(never.center(), [1.0; 3]);
        assert_eq!(VertexRecord::eager([0.0; 3], 1.0, 1.0, ([0.0; 3], 1e39)), None);
    }

    proptest! {
        /// Never too small, and not much too large.
        #[test]
        fn the_sphere_is_held(
            p in prop::array::uniform3(-100.0_f32..100.0),
            away in prop::array::uniform3(-1.0_f64..1.0),
            radius in 0.0_f64..50.0,
            key in 1e-6_f64..10.0,
        ) {
            let center = [0, 1, 2].map(|k| f64::from(p[k]) + away[k] * radius);
            let record = VertexRecord::eager(p, key, key / 2.0, (center, radius)).unwrap();
            let d = [0, 1, 2].map(|k| record.center()[k] - center[k]);
            let moved = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
            prop_assert!(moved + radius <= record.radius());
            prop_assert!(record.radius() <= radius * 1.03 + 1e-40);
            for (stored, key) in [(record.bound(), key), (record.budget(), key / 2.0)] {
                prop_assert!(f64::from(stored) > key * (1.0 + 1e-6) && f64::from(stored) < key * 1.01);
            }
        }
    }
}
