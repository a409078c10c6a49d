//! A camera that flies: it looks where the hand points it and goes where it is told.

use crate::camera::Camera;
use crate::orbit::{STEEPEST, angles, direction};
use crate::scene::Scene;
use glam::DVec3;
use std::f64::consts::TAU;

/// The slowest pace near and inside a model, in its radii a second.
const LEAST: f64 = 0.2;

/// A flying camera: +y is up, the horizon stays level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flight {
    /// Where it is.
    pub eye: DVec3,
    /// Angle around the vertical axis, radians; 0 looks along -z, and it falls when turning right.
    pub yaw: f64,
    /// Angle below the horizon, radians.
    pub pitch: f64,
    /// Vertical field of view, radians.
    pub fov: f64,
}

impl Flight {
    /// A flight that begins with what a camera sees; its horizon becomes level.
    pub fn from_camera(camera: &Camera) -> Flight {
        let (yaw, pitch) = angles(-camera.forward);
        Flight { eye: camera.eye, yaw, pitch, fov: camera.fov }
    }

    /// The camera.
    pub fn camera(&self) -> Camera {
        Camera { eye: self.eye, forward: -direction(self.yaw, self.pitch), up: DVec3::Y, fov: self.fov }
    }

    /// Looks elsewhere, by angles in radians.
    pub fn look(&mut self, right: f64, down: f64) {
        let (yaw, pitch) = (self.yaw - right, self.pitch + down);
        if yaw.is_finite() && pitch.is_finite() {
            self.yaw = yaw.rem_euclid(TAU);
            self.pitch = pitch.clamp(-STEEPEST, STEEPEST);
        }
    }

    /// Goes a way: to the right, up along the vertical, and ahead.
    pub fn go(&mut self, right: f64, up: f64, ahead: f64) {
        let back = direction(self.yaw, self.pitch);
        let across = DVec3::Y.cross(back).normalize_or(DVec3::X);
        let eye = self.eye + right * across + up * DVec3::Y - ahead * back;
        // Beyond, differences between neighbouring numbers would show.
        if eye.is_finite() && eye.abs().max_element() < 1e15 {
            self.eye = eye;
        }
    }
}

/// A pace for a flight, length a second: the distance to the nearest model, so that whatever the scale of a scene the
/// next model is about a second away, but never so slow that a flight near or inside one stands.
pub fn pace(scene: &Scene, eye: DVec3) -> f64 {
    let mut nearest: Option<(f64, f64)> = None;
    for (center, radius) in scene.instances.iter().filter_map(|instance| scene.sphere(instance)) {
        let clear = center.distance(eye) - radius;
        if nearest.is_none_or(|(least, _)| clear < least) {
            nearest = Some((clear, radius));
        }
    }
    match nearest {
        Some((clear, radius)) if clear.max(radius) > 0.0 => clear.max(LEAST * radius),
        _ => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    fn level() -> Flight {
        let camera = Camera { eye: DVec3::ONE, forward: DVec3::NEG_Z, up: DVec3::Y, fov: 0.7 };
        Flight::from_camera(&camera)
    }

    #[test]
    fn a_flight_begins_where_the_camera_was() {
        let mut random = Random::new(8);
        for _ in 0..100 {
            let forward = (random.direction() * DVec3::new(1.0, 0.5, 1.0)).normalize_or(DVec3::X);
            let camera = Camera { eye: random.direction(), forward, up: DVec3::Y, fov: 0.5 };
            let taken = Flight::from_camera(&camera).camera();
            assert!(taken.eye == camera.eye && taken.forward.distance(forward) < 1e-9, "{camera:?}");
        }
    }

    #[test]
    fn right_is_right_and_down_is_down() {
        let mut flight = level();
        flight.go(1.0, 2.0, 3.0);
        assert!(flight.eye.distance(DVec3::new(2.0, 3.0, -2.0)) < 1e-12);
        flight.look(0.1, 0.2);
        let forward = flight.camera().forward;
        assert!(forward.x > 0.0 && forward.y < 0.0 && forward.z < 0.0, "{forward}");
    }

    #[test]
    fn nothing_makes_a_camera_without_a_view() {
        let mut flight = level();
        let mut random = Random::new(9);
        for _ in 0..2000 {
            let wild = [1e-9, 1.0, 1e9, 1e300, f64::NAN, f64::INFINITY][random.below(6) as usize];
            let mut any = || wild * (random.unit() - 0.5);
            flight.look(any(), any());
            flight.go(any(), any(), any());
            assert!(flight.camera().view([64, 64], 0.01).is_ok(), "{flight:?}");
        }
    }

    #[test]
    fn an_empty_scene_has_a_pace() {
        assert_eq!(pace(&Scene::default(), DVec3::ZERO), 1.0);
    }
}
