//! Mouse and keys: what they mean.

use super::navigation::{Navigation, Toward};
use crate::Scene;
use std::time::{Duration, Instant};
use winit::dpi::PhysicalPosition;
use winit::event::{ElementState, KeyEvent, MouseButton, MouseScrollDelta};
use winit::keyboard::{Key, KeyCode, ModifiersState, NamedKey, PhysicalKey};

/// What mouse and keys do, as the panel and the documentation list it.
pub(super) const KEYS: [(&str, &str); 19] = [
    ("drag", "turn; look around in flight"),
    ("Shift or right drag", "pan"),
    ("wheel", "zoom; speed of flight"),
    ("double click", "turn around that point"),
    ("W A S D", "fly"),
    ("Q E", "fly down, up"),
    ("Shift", "fly faster"),
    ("C", "around the scene, or fly"),
    ("F", "see everything"),
    ("Home", "the first view"),
    ("T", "turn all the time"),
    ("Space", "freeze the cut"),
    ("- +", "coarser, finer"),
    ("V, X", "next colours, wireframe"),
    ("P", "save a picture"),
    ("R", "record a path; save it"),
    ("O", "open a file"),
    ("H, F11", "panel, full screen"),
    ("Esc, Ctrl+Q", "quit"),
];

/// What a key asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Action {
    SwitchMode,
    Fit,
    Reset,
    Turn,
    Freeze,
    Coarser,
    Finer,
    NextColor,
    Wireframe,
    Screenshot,
    Record,
    Open,
    Panel,
    FullScreen,
    Quit,
}

/// What a key that went down asks for, if anything.
pub(super) fn action(key: &Key<&str>, modifiers: ModifiersState) -> Option<Action> {
    if modifiers.control_key() || modifiers.super_key() {
        return match key {
            Key::Character("q" | "Q") => Some(Action::Quit),
            Key::Character("o" | "O") => Some(Action::Open),
            _ => None,
        };
    }
    if modifiers.alt_key() {
        return None;
    }
    Some(match key {
        Key::Character("c" | "C") => Action::SwitchMode,
        Key::Character("f" | "F") => Action::Fit,
        Key::Named(NamedKey::Home) => Action::Reset,
        Key::Character("t" | "T") => Action::Turn,
        Key::Named(NamedKey::Space) => Action::Freeze,
        Key::Character("-" | "_") => Action::Coarser,
        Key::Character("+" | "=") => Action::Finer,
        Key::Character("v" | "V") => Action::NextColor,
        Key::Character("x" | "X") => Action::Wireframe,
        Key::Character("p" | "P") => Action::Screenshot,
        Key::Character("r" | "R") => Action::Record,
        Key::Character("o" | "O") => Action::Open,
        Key::Character("h" | "H") | Key::Named(NamedKey::F1) => Action::Panel,
        Key::Named(NamedKey::F11) => Action::FullScreen,
        Key::Named(NamedKey::Escape) => Action::Quit,
        _ => return None,
    })
}

/// Where a key flies to. By its place on the keyboard, whatever letter is on it.
pub(super) fn toward(event: &KeyEvent) -> Option<Toward> {
    let PhysicalKey::Code(code) = event.physical_key else { return None };
    Some(match code {
        KeyCode::KeyD => Toward::Right,
        KeyCode::KeyA => Toward::Left,
        KeyCode::KeyE => Toward::Up,
        KeyCode::KeyQ => Toward::Down,
        KeyCode::KeyW => Toward::Ahead,
        KeyCode::KeyS => Toward::Back,
        _ => return None,
    })
}

/// What the mouse holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Drag {
    Turn,
    Pan,
}

/// The longest time between the clicks of a double click.
const DOUBLE: Duration = Duration::from_millis(400);

/// Follows the mouse and moves the camera.
#[derive(Debug, Default)]
pub(super) struct Mouse {
    position: Option<PhysicalPosition<f64>>,
    drag: Option<Drag>,
    /// When and where the left button went down last.
    click: Option<(Instant, PhysicalPosition<f64>)>,
    pub(super) modifiers: ModifiersState,
}

impl Mouse {
    /// A button went down or up. `on_picture` is false where the panel has the mouse. Returns the place of a double
    /// click.
    pub(super) fn button(
        &mut self,
        button: MouseButton,
        state: ElementState,
        on_picture: bool,
    ) -> Option<PhysicalPosition<f64>> {
        self.drag = match (button, state) {
            (_, ElementState::Released) => None,
            (MouseButton::Left, _) if on_picture && !self.modifiers.shift_key() => Some(Drag::Turn),
            (MouseButton::Left | MouseButton::Right | MouseButton::Middle, _) if on_picture => {
                Some(Drag::Pan)
            }
            _ => self.drag,
        };
        if button != MouseButton::Left || state != ElementState::Pressed || !on_picture {
            return None;
        }
        let here = self.position?;
        let last = self.click.replace((Instant::now(), here));
        let twice = last.is_some_and(|(time, place)| {
            time.elapsed() < DOUBLE && (place.x - here.x).hypot(place.y - here.y) < 6.0
        });
        // A third click begins anew.
        twice.then(|| self.click.take().map_or(here, |(_, place)| place))
    }

    /// The mouse moved in a window of `height` pixels. True if the camera did.
    pub(super) fn moved(
        &mut self,
        to: PhysicalPosition<f64>,
        height: u32,
        navigation: &mut Navigation,
        scene: &Scene,
    ) -> bool {
        let from = self.position.replace(to);
        let (Some(from), Some(drag)) = (from, self.drag) else { return false };
        let height = f64::from(height.max(1));
        let (right, down) = ((to.x - from.x) / height, (to.y - from.y) / height);
        match drag {
            Drag::Turn => navigation.turn(right, down),
            Drag::Pan => navigation.pan(right, down, scene),
        }
        true
    }

    /// The mouse left the window, or the window lost the keyboard.
    pub(super) fn left(&mut self) {
        self.position = None;
        self.drag = None;
    }
}

/// A turn of the wheel in notches, away from the user.
pub(super) fn notches(delta: MouseScrollDelta) -> f64 {
    match delta {
        MouseScrollDelta::LineDelta(_, lines) => f64::from(lines),
        MouseScrollDelta::PixelDelta(pixels) => pixels.y / 60.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn at(x: f64, y: f64) -> PhysicalPosition<f64> {
        PhysicalPosition::new(x, y)
    }

    #[test]
    fn dragging_turns_shift_pans_and_the_panel_keeps_the_mouse() {
        let scene = Scene::default();
        let mut mouse = Mouse::default();
        let mut camera = Navigation::facing(&[DVec3::ZERO, DVec3::ONE], 0.7, 1.5);
        let start = camera.camera();
        assert!(!mouse.moved(at(10.0, 10.0), 100, &mut camera, &scene), "no button is down");
        mouse.button(MouseButton::Left, ElementState::Pressed, true);
        assert!(mouse.moved(at(30.0, 20.0), 100, &mut camera, &scene));
        let turned = camera.camera();
        // The scene follows the hand to the right and down: the camera goes left and up.
        let side = start.view([64, 64], 0.1).unwrap();
        assert!((turned.eye - start.eye).dot(side.right) < 0.0 && turned.eye.y > start.eye.y);
        mouse.button(MouseButton::Left, ElementState::Released, true);
        mouse.modifiers = ModifiersState::SHIFT;
        mouse.button(MouseButton::Left, ElementState::Pressed, true);
        assert!(mouse.moved(at(40.0, 20.0), 100, &mut camera, &scene));
        assert!(camera.camera().forward == turned.forward && camera.camera().eye != turned.eye);
        mouse.button(MouseButton::Left, ElementState::Released, true);
        mouse.button(MouseButton::Left, ElementState::Pressed, false);
        assert!(!mouse.moved(at(50.0, 20.0), 100, &mut camera, &scene), "the panel has the mouse");
    }

    #[test]
    fn two_clicks_in_one_place_are_a_double_click() {
        let scene = Scene::default();
        let mut mouse = Mouse::default();
        let mut camera = Navigation::facing(&[DVec3::ZERO, DVec3::ONE], 0.7, 1.5);
        let mut click = |x: f64| {
            mouse.moved(at(x, 10.0), 100, &mut camera, &scene);
            let double = mouse.button(MouseButton::Left, ElementState::Pressed, true);
            mouse.button(MouseButton::Left, ElementState::Released, true);
            double
        };
        assert_eq!(click(10.0), None);
        assert_eq!(click(12.0), Some(at(12.0, 10.0)));
        assert_eq!(click(12.0), None, "the third is a first");
        assert_eq!(click(40.0), None, "elsewhere");
    }

    #[test]
    fn keys_mean_what_the_list_says() {
        let none = ModifiersState::empty();
        for (key, modifiers, expected) in [
            (Key::Character("f"), none, Some(Action::Fit)),
            (Key::Character("F"), ModifiersState::SHIFT, Some(Action::Fit)),
            (Key::Character("q"), none, None),
            (Key::Character("q"), ModifiersState::CONTROL, Some(Action::Quit)),
            (Key::Character("f"), ModifiersState::CONTROL, None),
            (Key::Named(NamedKey::Escape), none, Some(Action::Quit)),
            (Key::Named(NamedKey::Home), none, Some(Action::Reset)),
        ] {
            assert_eq!(action(&key, modifiers), expected, "{key:?} {modifiers:?}");
        }
    }

    #[test]
    fn the_documentation_lists_every_key() {
        let page = include_str!("../../../../docs/viewer.md");
        for (keys, does) in KEYS {
            let row = format!("| {keys} | {does} |");
            assert!(page.contains(&row), "docs/viewer.md lacks: {row}");
        }
    }
}
