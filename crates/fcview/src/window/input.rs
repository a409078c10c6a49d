//! Mouse and keys to camera motion.

use crate::orbit::Orbit;
use winit::dpi::PhysicalPosition;
use winit::event::{ElementState, MouseButton, MouseScrollDelta};
use winit::keyboard::ModifiersState;

/// What the mouse holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Drag {
    Turn,
    Pan,
}

/// Follows the mouse and turns the camera.
#[derive(Debug, Default)]
pub(super) struct Mouse {
    position: Option<PhysicalPosition<f64>>,
    drag: Option<Drag>,
    pub(super) modifiers: ModifiersState,
}

/// Radians of turn for a drag over the height of the window.
const TURN: f64 = 3.4;

/// Change of distance for one notch of the wheel.
const NOTCH: f64 = 0.88;

impl Mouse {
    /// A button went down or up. `on_picture` is false where the panel has the mouse.
    pub(super) fn button(&mut self, button: MouseButton, state: ElementState, on_picture: bool) {
        self.drag = match (button, state) {
            (_, ElementState::Released) => None,
            (MouseButton::Left, _) if on_picture && !self.modifiers.shift_key() => Some(Drag::Turn),
            (MouseButton::Left | MouseButton::Right | MouseButton::Middle, _) if on_picture => {
                Some(Drag::Pan)
            }
            _ => self.drag,
        };
    }

    /// The mouse moved in a window of `height` pixels. True if the camera did.
    pub(super) fn moved(&mut self, to: PhysicalPosition<f64>, height: u32, orbit: &mut Orbit) -> bool {
        let from = self.position.replace(to);
        let (Some(from), Some(drag)) = (from, self.drag) else { return false };
        let height = f64::from(height.max(1));
        let (right, down) = ((to.x - from.x) / height, (to.y - from.y) / height);
        match drag {
            Drag::Turn => orbit.turn(TURN * right, TURN * down),
            Drag::Pan => orbit.pan(right, -down),
        }
        true
    }

    /// The wheel turned.
    pub(super) fn wheel(delta: MouseScrollDelta, orbit: &mut Orbit) {
        let notches = match delta {
            MouseScrollDelta::LineDelta(_, lines) => f64::from(lines),
            MouseScrollDelta::PixelDelta(pixels) => pixels.y / 60.0,
        };
        orbit.zoom(NOTCH.powf(notches.clamp(-20.0, 20.0)));
    }

    /// The mouse left the window.
    pub(super) fn left(&mut self) {
        self.position = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn orbit() -> Orbit {
        Orbit::around(&[DVec3::ZERO, DVec3::ONE], 0.7, 1.5)
    }

    fn at(x: f64, y: f64) -> PhysicalPosition<f64> {
        PhysicalPosition::new(x, y)
    }

    #[test]
    fn dragging_turns_shift_pans_and_the_panel_keeps_the_mouse() {
        let mut mouse = Mouse::default();
        let mut camera = orbit();
        assert!(!mouse.moved(at(10.0, 10.0), 100, &mut camera), "no button is down");
        mouse.button(MouseButton::Left, ElementState::Pressed, true);
        assert!(mouse.moved(at(30.0, 20.0), 100, &mut camera));
        assert!(camera.yaw != orbit().yaw && camera.pitch > orbit().pitch);
        assert_eq!(camera.target, orbit().target);
        mouse.button(MouseButton::Left, ElementState::Released, true);
        mouse.modifiers = ModifiersState::SHIFT;
        mouse.button(MouseButton::Left, ElementState::Pressed, true);
        let yaw = camera.yaw;
        assert!(mouse.moved(at(40.0, 20.0), 100, &mut camera));
        assert!(camera.target != orbit().target && camera.yaw == yaw);
        mouse.button(MouseButton::Left, ElementState::Released, true);
        mouse.button(MouseButton::Left, ElementState::Pressed, false);
        assert!(!mouse.moved(at(50.0, 20.0), 100, &mut camera), "the panel has the mouse");
    }

    #[test]
    fn the_wheel_comes_nearer_and_goes_back() {
        let mut camera = orbit();
        Mouse::wheel(MouseScrollDelta::LineDelta(0.0, 3.0), &mut camera);
        assert!(camera.distance < orbit().distance);
        Mouse::wheel(MouseScrollDelta::LineDelta(0.0, -3.0), &mut camera);
        assert!((camera.distance - orbit().distance).abs() < 1e-9);
        Mouse::wheel(MouseScrollDelta::LineDelta(0.0, f32::NAN), &mut camera);
        assert!(camera.distance.is_finite());
    }
}
