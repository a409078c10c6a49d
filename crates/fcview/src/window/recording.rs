//! A recording of the camera's way.

use crate::camera::Camera;
use crate::camera_path::{CameraPath, PathKey};
use std::time::{Duration, Instant};

/// The shortest time between two keys, seconds: closer ones would record the trembling of a hand.
const STEP: f64 = 0.1;

/// A recording under way.
pub(super) struct Recording {
    start: Instant,
    keys: Vec<PathKey>,
}

impl Recording {
    pub(super) fn start(camera: &Camera) -> Recording {
        Recording { start: Instant::now(), keys: vec![PathKey::new(0.0, camera)] }
    }

    /// Notes where the camera is now, unless it just was.
    pub(super) fn note(&mut self, camera: &Camera) {
        self.add(self.start.elapsed(), camera, STEP);
    }

    /// The time since the start, seconds.
    pub(super) fn seconds(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    /// The way, up to the camera's last place.
    pub(super) fn finish(mut self, camera: &Camera) -> Result<CameraPath, String> {
        self.add(self.start.elapsed(), camera, 1e-3);
        CameraPath::new(self.keys)
    }

    fn add(&mut self, elapsed: Duration, camera: &Camera, step: f64) {
        let seconds = elapsed.as_secs_f64();
        if self.keys.last().is_none_or(|last| seconds - last.seconds >= step) {
            self.keys.push(PathKey::new(seconds, camera));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn keys_are_apart_and_the_last_place_is_kept() {
        let at = |x: f64| Camera::look_at(DVec3::new(x, 0.0, 5.0), DVec3::ZERO, 0.7).unwrap();
        let mut recording = Recording::start(&at(0.0));
        for step in 1..=20_u32 {
            recording.add(Duration::from_millis(30 * u64::from(step)), &at(f64::from(step)), STEP);
        }
        assert_eq!(recording.keys.len(), 6);
        let count = recording.keys.len();
        recording.add(Duration::from_millis(605), &at(31.0), 1e-3);
        assert_eq!(recording.keys.len(), count + 1);
        let path = CameraPath::new(recording.keys).unwrap();
        assert_eq!(path.camera(1.0).eye, at(31.0).eye);
    }
}
