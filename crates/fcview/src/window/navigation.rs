//! The camera in the hand: around the scene or in flight.

use crate::Scene;
use crate::camera::Camera;
use crate::flight::{Flight, pace};
use crate::orbit::Orbit;
use glam::DVec3;

/// Radians of turn for a drag over the height of the window.
const TURN: f64 = 3.4;

/// Radians of looking around for the same drag: less, since here it is not the scene that follows the hand.
const LOOK: f64 = 1.8;

/// Change of distance for one notch of the wheel.
const NOTCH: f64 = 0.88;

/// Change of speed for one notch.
const FASTER: f64 = 1.25;

/// How much faster Shift flies.
const HURRY: f64 = 4.0;

/// Radians a second that the camera turns by itself.
const TURN_SPEED: f64 = 0.5;

/// The longest step in time, seconds: after a slow frame a flight must not jump through a wall.
const LONGEST: f64 = 0.25;

/// How the camera moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mode {
    Orbit,
    Fly,
}

/// A direction of flight, in the order of [`Held`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Toward {
    Right,
    Left,
    Up,
    Down,
    Ahead,
    Back,
}

/// The keys of flight that are down.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Held([bool; 6]);

impl Held {
    /// -1, 0 or 1 along each of right, up and ahead.
    fn way(self) -> [f64; 3] {
        let [right, left, up, down, ahead, back] = self.0.map(|held| f64::from(u8::from(held)));
        [right - left, up - down, ahead - back]
    }
}

/// The camera and what moves it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Navigation {
    mode: Mode,
    orbit: Orbit,
    flight: Flight,
    held: Held,
    /// How much faster or slower than the scene's pace a flight is.
    pub(super) speed: f64,
    /// Turn around the scene all the time.
    pub(super) turning: bool,
}

impl Navigation {
    /// In sight of all `points`, for a picture of `aspect`.
    pub(super) fn facing(points: &[DVec3], fov: f64, aspect: f64) -> Navigation {
        let orbit = Orbit::facing(points, fov, aspect);
        let flight = Flight::from_camera(&orbit.camera());
        Navigation { mode: Mode::Orbit, orbit, flight, held: Held::default(), speed: 1.0, turning: false }
    }

    /// The same, seen from the side that it is seen from now.
    pub(super) fn fitted(self, points: &[DVec3], fov: f64, aspect: f64) -> Navigation {
        let now = self.orbit.before(&self.camera(), self.orbit.distance);
        let orbit = Orbit::facing(points, fov, aspect).seen_from(&now);
        let flight = Flight::from_camera(&orbit.camera());
        Navigation { orbit, flight, ..self }
    }

    pub(super) fn camera(&self) -> Camera {
        match self.mode {
            Mode::Orbit => self.orbit.camera(),
            Mode::Fly => self.flight.camera(),
        }
    }

    pub(super) fn mode(&self) -> Mode {
        self.mode
    }

    /// Moves on in another way from where the camera is.
    pub(super) fn set_mode(&mut self, mode: Mode, scene: &Scene) {
        if mode == self.mode {
            return;
        }
        let camera = self.camera();
        match mode {
            Mode::Fly => self.flight = Flight::from_camera(&camera),
            Mode::Orbit => {
                // Around the point in the middle of the picture that is as far away as what was turned around last,
                // or, where that lies behind, as the nearest model.
                let ahead = (self.orbit.target - camera.eye).dot(camera.forward);
                let distance = if ahead > 0.0 { ahead } else { pace(scene, camera.eye) };
                self.orbit = self.orbit.before(&camera, distance);
            }
        }
        self.mode = mode;
    }

    /// Turns around a point from now on, which comes to the middle of the picture, as far away as it is.
    pub(super) fn turn_around(&mut self, point: DVec3) {
        let camera = self.camera();
        self.orbit = self.orbit.before(&camera, camera.eye.distance(point));
        self.orbit.target = point;
        self.mode = Mode::Orbit;
    }

    /// A key of flight went down or up; the first one takes off.
    pub(super) fn hold(&mut self, toward: Toward, down: bool, scene: &Scene) {
        if down {
            self.turning = false;
            self.set_mode(Mode::Fly, scene);
        }
        if let Some(held) = self.held.0.get_mut(toward as usize) {
            *held = down;
        }
    }

    /// All keys are up, as far as anyone knows.
    pub(super) fn let_go(&mut self) {
        self.held = Held::default();
    }

    /// A drag with the button that turns, in heights of the window.
    pub(super) fn turn(&mut self, right: f64, down: f64) {
        match self.mode {
            Mode::Orbit => self.orbit.turn(TURN * right, TURN * down),
            Mode::Fly => self.flight.look(LOOK * right, LOOK * down),
        }
    }

    /// A drag with the button that pans, in heights of the window.
    pub(super) fn pan(&mut self, right: f64, down: f64, scene: &Scene) {
        match self.mode {
            Mode::Orbit => self.orbit.pan(right, -down),
            Mode::Fly => {
                let way = self.speed * pace(scene, self.flight.eye);
                self.flight.go(-way * right, way * down, 0.0);
            }
        }
    }

    /// The wheel, in notches away from the user: nearer, or faster.
    pub(super) fn wheel(&mut self, notches: f64) {
        let notches = notches.clamp(-20.0, 20.0);
        match self.mode {
            Mode::Orbit => self.orbit.zoom(NOTCH.powf(notches)),
            Mode::Fly => {
                let speed = self.speed * FASTER.powf(notches);
                if speed.is_finite() {
                    self.speed = speed.clamp(1e-3, 1e3);
                }
            }
        }
    }

    /// Moves on by itself for some seconds. True if it has to go on.
    pub(super) fn advance(&mut self, seconds: f64, hurry: bool, scene: &Scene) -> bool {
        let seconds = seconds.clamp(0.0, LONGEST);
        let way = self.held.way();
        match self.mode {
            Mode::Orbit if self.turning => self.orbit.turn(-TURN_SPEED * seconds, 0.0),
            Mode::Fly if way != [0.0; 3] => {
                let pace = self.speed * pace(scene, self.flight.eye) * if hurry { HURRY } else { 1.0 };
                let [right, up, ahead] = way.map(|part| part * pace * seconds);
                self.flight.go(right, up, ahead);
            }
            _ => return false,
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn navigation() -> Navigation {
        Navigation::facing(&[DVec3::ZERO, DVec3::ONE], 0.7, 1.5)
    }

    fn same(a: &Camera, b: &Camera) -> bool {
        a.eye.distance(b.eye) < 1e-9 && a.forward.distance(b.forward) < 1e-9
    }

    #[test]
    fn a_change_of_mode_changes_nothing_in_sight() {
        let scene = Scene::default();
        let mut navigation = navigation();
        let before = navigation.camera();
        navigation.set_mode(Mode::Fly, &scene);
        assert!(same(&navigation.camera(), &before));
        navigation.turn(0.4, -0.2);
        navigation.hold(Toward::Ahead, true, &scene);
        assert!(navigation.advance(0.05, false, &scene));
        let flown = navigation.camera();
        assert!(!same(&flown, &before));
        navigation.set_mode(Mode::Orbit, &scene);
        assert!(same(&navigation.camera(), &flown));
        // Also with nothing but the void before it.
        navigation.set_mode(Mode::Fly, &scene);
        navigation.turn(std::f64::consts::PI / LOOK, 0.0);
        let away = navigation.camera();
        navigation.set_mode(Mode::Orbit, &scene);
        assert!(same(&navigation.camera(), &away));
    }

    #[test]
    fn keys_fly_while_they_are_down_and_against_one_another_stand_still() {
        let scene = Scene::default();
        let mut navigation = navigation();
        assert!(!navigation.advance(0.1, false, &scene), "nothing moves by itself");
        navigation.hold(Toward::Right, true, &scene);
        assert_eq!(navigation.mode(), Mode::Fly);
        let right = navigation.camera().view([64, 64], 0.1).unwrap().right;
        let before = navigation.camera().eye;
        navigation.advance(0.1, false, &scene);
        let way = navigation.camera().eye - before;
        assert!((way - 0.1 * right).length() < 1e-9, "{way}");
        navigation.advance(0.1, true, &scene);
        assert!((navigation.camera().eye - before - 0.5 * right).length() < 1e-9, "Shift is faster");
        navigation.hold(Toward::Left, true, &scene);
        assert!(!navigation.advance(0.1, false, &scene));
        navigation.hold(Toward::Left, false, &scene);
        navigation.let_go();
        assert!(!navigation.advance(0.1, false, &scene));
    }

    #[test]
    fn the_wheel_comes_nearer_or_flies_faster() {
        let mut navigation = navigation();
        let distance = |n: &Navigation| n.camera().eye.distance(DVec3::splat(0.5));
        let start = distance(&navigation);
        navigation.wheel(3.0);
        assert!(distance(&navigation) < start);
        navigation.wheel(-3.0);
        assert!((distance(&navigation) - start).abs() < 1e-9);
        navigation.set_mode(Mode::Fly, &Scene::default());
        navigation.wheel(1.0);
        assert!(navigation.speed > 1.0);
        for wild in [1e9, -1e9, f64::NAN] {
            navigation.wheel(wild);
            assert!(navigation.speed.is_finite() && navigation.speed > 0.0);
        }
    }

    #[test]
    fn a_point_to_turn_around_comes_to_the_middle_as_far_away_as_it_was() {
        let mut navigation = navigation();
        navigation.set_mode(Mode::Fly, &Scene::default());
        let before = navigation.camera();
        let point = DVec3::new(0.9, 0.2, 0.4);
        navigation.turn_around(point);
        let after = navigation.camera();
        assert!(after.forward.distance(before.forward) < 1e-9);
        assert!((after.eye.distance(point) - before.eye.distance(point)).abs() < 1e-9);
        assert!((point - after.eye).cross(after.forward).length() < 1e-9);
    }

    #[test]
    fn fitting_keeps_the_side_and_sees_everything() {
        let points = [DVec3::ZERO, DVec3::ONE];
        let mut navigation = navigation();
        navigation.turn(0.3, 0.1);
        let forward = navigation.camera().forward;
        navigation.wheel(-10.0);
        navigation.set_mode(Mode::Fly, &Scene::default());
        let fitted = navigation.fitted(&points, 0.7, 1.5);
        assert!(fitted.camera().forward.distance(forward) < 1e-9);
        let view = fitted.camera().view([150, 100], 0.01).unwrap();
        for p in points {
            let clip = view.clip_from_world() * p.extend(1.0);
            assert!(clip.x.abs() <= clip.w && clip.y.abs() <= clip.w, "{clip}");
        }
    }
}
