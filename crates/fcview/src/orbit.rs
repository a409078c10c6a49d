//! A camera on a sphere around a point: what the mouse turns and what `--camera orbit` follows.

use crate::camera::Camera;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, TAU};

/// How near to straight up or down the camera may climb, radians: beyond, up would flip.
pub(crate) const STEEPEST: f64 = FRAC_PI_2 - 0.02;

/// Where a fresh camera stands: a little to the right of the front.
const FIRST_YAW: f64 = 0.45;

/// An orbit camera: +y is up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orbit {
    /// The point looked at.
    pub target: DVec3,
    /// Angle around the vertical axis, radians; 0 looks along -z.
    pub yaw: f64,
    /// Angle above the horizon, radians.
    pub pitch: f64,
    /// Distance of the eye from the target.
    pub distance: f64,
    /// Vertical field of view, radians.
    pub fov: f64,
    /// The size of what is looked at, against which distances are limited.
    reach: f64,
}

impl Orbit {
    /// A camera that sees all of `points` in a picture of `aspect` (width over height) from every side.
    pub fn around(points: &[DVec3], fov: f64, aspect: f64) -> Orbit {
        let sides = (0..24).map(|step| TAU * f64::from(step) / 24.0);
        Orbit::fitted(points, fov, aspect, sides)
    }

    /// A camera that sees all of `points` from where it starts, as near as that allows.
    pub fn facing(points: &[DVec3], fov: f64, aspect: f64) -> Orbit {
        Orbit::fitted(points, fov, aspect, std::iter::once(FIRST_YAW))
    }

    /// A camera far enough for all of `points` from each of `sides`, with a little margin.
    fn fitted(points: &[DVec3], fov: f64, aspect: f64, sides: impl Iterator<Item = f64>) -> Orbit {
        let low = points.iter().fold(DVec3::INFINITY, |low, p| low.min(*p));
        let high = points.iter().fold(DVec3::NEG_INFINITY, |high, p| high.max(*p));
        let target = if points.is_empty() { DVec3::ZERO } else { low.midpoint(high) };
        let reach = points.iter().fold(0.0_f64, |reach, p| reach.max(p.distance(target)));
        let reach = if reach > 0.0 { reach } else { 1.0 };
        let mut orbit = Orbit { target, yaw: FIRST_YAW, pitch: 0.22, distance: reach, fov, reach };
        let tangent = (0.5 * fov).tan() / 1.06;
        let mut distance = 0.1 * reach;
        for yaw in sides {
            let turned = Orbit { yaw, ..orbit };
            let back = turned.back();
            let right = DVec3::Y.cross(back).normalize_or(DVec3::X);
            let up = back.cross(right);
            for p in points {
                let d = p - target;
                let wide = d.dot(right).abs() / (tangent * aspect);
                let high = d.dot(up).abs() / tangent;
                distance = distance.max(d.dot(back) + wide.max(high));
            }
        }
        orbit.distance = distance;
        orbit
    }

    /// The same camera, looking from the side that another one looks from.
    #[must_use]
    pub fn seen_from(self, other: &Orbit) -> Orbit {
        Orbit { yaw: other.yaw, pitch: other.pitch, ..self }
    }

    /// What another camera sees, turning around a point `distance` before it.
    #[must_use]
    pub fn before(self, camera: &Camera, distance: f64) -> Orbit {
        let (yaw, pitch) = angles(-camera.forward);
        let distance = self.limited(distance);
        let orbit = Orbit { yaw, pitch, distance, ..self };
        Orbit { target: camera.eye - distance * orbit.back(), ..orbit }
    }

    /// Unit vector from the target to the eye.
    fn back(&self) -> DVec3 {
        direction(self.yaw, self.pitch)
    }

    /// A distance within the limits.
    fn limited(&self, distance: f64) -> f64 {
        distance.clamp(1e-4 * self.reach, 1e4 * self.reach)
    }

    /// The camera.
    pub fn camera(&self) -> Camera {
        let back = self.back();
        Camera { eye: self.target + self.distance * back, forward: -back, up: DVec3::Y, fov: self.fov }
    }

    /// Turns around the target by angles in radians; the scene follows a dragging hand.
    pub fn turn(&mut self, right: f64, up: f64) {
        let (yaw, pitch) = (self.yaw - right, self.pitch + up);
        if yaw.is_finite() && pitch.is_finite() {
            self.yaw = yaw.rem_euclid(TAU);
            self.pitch = pitch.clamp(-STEEPEST, STEEPEST);
        }
    }

    /// Moves eye and target sideways, in picture heights.
    pub fn pan(&mut self, right: f64, up: f64) {
        let back = self.back();
        let across = DVec3::Y.cross(back).normalize_or(DVec3::X);
        let height = 2.0 * self.distance * (0.5 * self.fov).tan();
        let target = self.target - height * (right * across - up * back.cross(across));
        if target.is_finite() && target.length() < 1e6 * self.reach + self.target.length() {
            self.target = target;
        }
    }

    /// Multiplies the distance, within limits.
    pub fn zoom(&mut self, factor: f64) {
        let distance = self.distance * factor;
        if distance.is_finite() {
            self.distance = self.limited(distance);
        }
    }
}

/// The unit vector at an angle around the vertical axis, from +z toward +x, and one above the horizon, radians.
pub(crate) fn direction(yaw: f64, pitch: f64) -> DVec3 {
    let (sin_yaw, cos_yaw) = yaw.sin_cos();
    let (sin_pitch, cos_pitch) = pitch.sin_cos();
    DVec3::new(cos_pitch * sin_yaw, sin_pitch, cos_pitch * cos_yaw)
}

/// The angles of a unit vector, no steeper than a camera may climb.
pub(crate) fn angles(direction: DVec3) -> (f64, f64) {
    let pitch = direction.y.clamp(-1.0, 1.0).asin().clamp(-STEEPEST, STEEPEST);
    (direction.x.atan2(direction.z).rem_euclid(TAU), pitch)
}

/// A camera on a closed path through the box around `points`, `t` in 0..1, looking where it goes.
pub fn fly(points: &[DVec3], fov: f64, t: f64) -> Camera {
    let low = points.iter().fold(DVec3::INFINITY, |low, p| low.min(*p));
    let high = points.iter().fold(DVec3::NEG_INFINITY, |high, p| high.max(*p));
    let (middle, half) = if points.is_empty() {
        (DVec3::ZERO, DVec3::ONE)
    } else {
        (low.midpoint(high), 0.5 * (high - low).max(DVec3::splat(1e-6)))
    };
    let place = |t: f64| {
        let angle = TAU * t;
        // An ellipse that dives from the edge of the box toward its middle twice a round.
        let radius = 0.85 + 0.35 * (2.0 * angle).cos();
        middle + half * radius * DVec3::new(angle.sin(), 0.35 * (2.0 * angle + 0.6).sin(), angle.cos())
    };
    let eye = place(t);
    // Between where the path goes and the middle, so that the scene stays in sight.
    let ahead = (place(t + 0.02) - eye).normalize_or(DVec3::NEG_Z);
    let inward = (middle - eye).normalize_or(DVec3::NEG_Z);
    let forward = (ahead + 0.9 * inward).normalize_or(DVec3::NEG_Z);
    let up = if forward.y.abs() > 0.999 { DVec3::Z } else { DVec3::Y };
    Camera { eye, forward, up, fov }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn everything_is_in_the_picture_from_every_side() {
        let mut random = Random::new(2);
        let points: Vec<_> =
            (0..60).map(|_| 5.0 * random.direction() * DVec3::new(3.0, 1.0, 0.3) + DVec3::X).collect();
        for aspect in [0.5, 1.0, 1.8] {
            let mut orbit = Orbit::around(&points, 0.7, aspect);
            for step in 0..24 {
                orbit.yaw = TAU * f64::from(step) / 24.0;
                let view = orbit.camera().view([(200.0 * aspect) as u32, 200], 0.01).unwrap();
                for p in &points {
                    let clip = view.clip_from_world() * p.extend(1.0);
                    assert!(clip.x.abs() <= clip.w && clip.y.abs() <= clip.w, "{clip} at aspect {aspect}");
                }
            }
        }
    }

    #[test]
    fn facing_is_nearer_than_around_and_still_sees_everything() {
        let points = [DVec3::new(-3.0, 0.0, 0.0), DVec3::new(3.0, 0.5, 0.1), DVec3::new(0.0, 0.2, -0.4)];
        let facing = Orbit::facing(&points, 0.7, 1.5);
        assert!(facing.distance < Orbit::around(&points, 0.7, 1.5).distance);
        let view = facing.camera().view([300, 200], 0.01).unwrap();
        for p in &points {
            let clip = view.clip_from_world() * p.extend(1.0);
            assert!(clip.x.abs() <= clip.w && clip.y.abs() <= clip.w, "{clip}");
        }
    }

    #[test]
    fn no_motion_of_the_mouse_makes_a_camera_without_a_view() {
        let mut orbit = Orbit::around(&[DVec3::ZERO, DVec3::ONE], 0.7, 1.5);
        let mut random = Random::new(4);
        for _ in 0..2000 {
            let wild = [1e-9, 1.0, 1e9, f64::NAN, f64::INFINITY][random.below(5) as usize];
            orbit.turn(wild * (random.unit() - 0.5), wild * (random.unit() - 0.5));
            orbit.pan(wild * (random.unit() - 0.5), wild * (random.unit() - 0.5));
            orbit.zoom(wild * random.unit());
            assert!(orbit.camera().view([64, 64], 0.01).is_ok(), "{orbit:?}");
        }
    }

    #[test]
    fn another_camera_is_taken_over_where_it_is() {
        let mut random = Random::new(6);
        let orbit = Orbit::around(&[DVec3::ZERO, DVec3::ONE], 0.7, 1.5);
        for _ in 0..100 {
            let forward = (random.direction() * DVec3::new(1.0, 0.5, 1.0)).normalize_or(DVec3::X);
            let camera = Camera { eye: 3.0 * random.direction(), forward, up: DVec3::Y, fov: 0.7 };
            let taken = orbit.before(&camera, 0.5 + random.unit());
            assert!(taken.camera().eye.distance(camera.eye) < 1e-9, "{camera:?}");
            assert!(taken.camera().forward.distance(forward) < 1e-9, "{camera:?}");
        }
    }

    #[test]
    fn the_flight_always_has_a_view() {
        for points in [&[] as &[DVec3], &[DVec3::ONE], &[DVec3::ZERO, DVec3::ONE]] {
            for step in 0..100 {
                let camera = fly(points, 0.9, f64::from(step) / 100.0);
                assert!(camera.view([64, 64], 0.01).is_ok(), "{camera:?}");
            }
        }
    }
}
