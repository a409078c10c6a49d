//! Tests by promise. The slow, obvious definitions that the crate is compared with are in [`reference`].

mod cca;
mod cone;
mod frustum;
mod moments;
mod plane;
mod quads;
mod reference;
mod rounding;
mod segment;
mod smallest;
mod sphere;
mod symmetric;

use glam::{DMat3, DVec3, Vec3};

/// A small generator with a seed (splitmix64), so that a failure can be repeated.
struct Rng(u64);

impl Rng {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in 0..1.
    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    fn index(&mut self, len: usize) -> usize {
        (self.next() % len as u64) as usize
    }

    /// Uniform in the cube from -1 to 1.
    fn in_cube(&mut self) -> DVec3 {
        DVec3::new(self.range(-1.0, 1.0), self.range(-1.0, 1.0), self.range(-1.0, 1.0))
    }

    /// Uniform on the unit sphere.
    fn direction(&mut self) -> DVec3 {
        loop {
            let v = self.in_cube();
            let squared = v.length_squared();
            if squared > 1.0e-4 && squared <= 1.0 {
                return v / squared.sqrt();
            }
        }
    }

    /// Within an angle (below 90 degrees) of an axis, often exactly at it.
    fn direction_near(&mut self, axis: DVec3, angle: f64) -> DVec3 {
        let side = axis.any_orthonormal_vector();
        let turn = self.range(0.0, std::f64::consts::TAU);
        let around = side * turn.cos() + axis.cross(side) * turn.sin();
        let tilt = if self.unit() < 0.5 { angle } else { angle * self.unit() };
        axis * tilt.cos() + around * tilt.sin()
    }

    fn rotation(&mut self) -> DMat3 {
        DMat3::from_axis_angle(self.direction(), self.range(-3.0, 3.0))
    }

    fn triangle(&mut self) -> [DVec3; 3] {
        [self.in_cube(), self.in_cube(), self.in_cube()]
    }

    fn triangles(&mut self, count: usize) -> Vec<[DVec3; 3]> {
        (0..count).map(|_| self.triangle()).collect()
    }
}

fn to_f32(points: &[DVec3]) -> Vec<Vec3> {
    points.iter().map(|p| p.as_vec3()).collect()
}

#[track_caller]
fn assert_close(actual: f64, expected: f64, tolerance: f64) {
    let difference = (actual - expected).abs();
    assert!(difference <= tolerance, "{actual} is not {expected} within {tolerance}");
}

#[track_caller]
fn assert_close_mat(actual: DMat3, expected: DMat3, tolerance: f64) {
    assert!(actual.abs_diff_eq(expected, tolerance), "{actual} is not {expected} within {tolerance}");
}
