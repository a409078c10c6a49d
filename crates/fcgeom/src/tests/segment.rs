//! Promise: the distance from a segment is that from its nearest point, ends included.

use super::*;
use crate::{distance_to_segment, offset_from_segment};

#[test]
fn no_point_of_a_segment_is_nearer() {
    let mut rng = Rng(5);
    for _ in 0..200 {
        let [p, a, b] = [0; 3].map(|_| rng.in_cube());
        let distance = distance_to_segment(p, a, b);
        let steps = (0..=1000).map(|i| a.lerp(b, f64::from(i) / 1000.0).distance(p));
        let nearest = steps.fold(f64::INFINITY, f64::min);
        assert!(distance <= nearest + 1e-12 && nearest <= distance + (b - a).length() / 1000.0);
        let foot = p - offset_from_segment(p, a, b);
        assert!(foot.distance(a) + foot.distance(b) <= a.distance(b) + 1e-12, "the nearest point lies on it");
    }
}

#[test]
fn a_segment_without_length_is_a_point() {
    assert_eq!(distance_to_segment(DVec3::new(3.0, 4.0, 0.0), DVec3::ZERO, DVec3::ZERO), 5.0);
}
