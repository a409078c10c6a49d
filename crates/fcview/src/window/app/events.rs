//! What the system tells the application.

use super::App;
use super::names::names;
use crate::window::input::{self, Action};
use crate::window::watch::Watch;
use winit::application::ApplicationHandler;
use winit::event::{ElementState, KeyEvent, StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow};
use winit::window::WindowId;

impl ApplicationHandler for App<'_> {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.screen.is_none()
            && let Err(error) = self.open(event_loop, None)
        {
            self.fail(event_loop, error);
        }
    }

    fn new_events(&mut self, _: &ActiveEventLoop, cause: StartCause) {
        if matches!(cause, StartCause::ResumeTimeReached { .. }) {
            if self.watch.as_mut().is_some_and(Watch::changed) {
                // A failure is in the panel; the files may be whole the next time.
                let _ = self.load(self.cli.files.clone(), true);
            }
            self.redraw();
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(screen) = &mut self.screen else { return };
        let response = screen.egui.on_window_event(&screen.window, &event);
        if response.repaint && event != WindowEvent::RedrawRequested {
            screen.window.request_redraw();
        }
        match event {
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::RedrawRequested => self.frame_or_remedy(event_loop),
            WindowEvent::Resized(_) | WindowEvent::ScaleFactorChanged { .. } => {
                screen.resize();
                screen.window.request_redraw();
            }
            WindowEvent::Occluded(false) => screen.window.request_redraw(),
            WindowEvent::Focused(false) => {
                self.navigation.let_go();
                self.mouse.left();
            }
            WindowEvent::ModifiersChanged(modifiers) => self.mouse.modifiers = modifiers.state(),
            WindowEvent::CursorMoved { position, .. } => {
                let height = screen.window.inner_size().height;
                if self.mouse.moved(position, height, &mut self.navigation, &self.scene) {
                    screen.window.request_redraw();
                }
            }
            WindowEvent::MouseInput { state, button, .. } => {
                if let Some(place) = self.mouse.button(button, state, !response.consumed) {
                    self.turn_around(place);
                }
            }
            WindowEvent::MouseWheel { delta, .. } if !response.consumed => {
                self.navigation.wheel(input::notches(delta));
                screen.window.request_redraw();
            }
            WindowEvent::KeyboardInput { event, .. } => self.key(event_loop, &event, response.consumed),
            WindowEvent::HoveredFile(path) => {
                self.panel.message = format!("drop {} to open it", names(&[path]));
                screen.window.request_redraw();
            }
            WindowEvent::HoveredFileCancelled => {
                self.panel.message.clear();
                screen.window.request_redraw();
            }
            WindowEvent::DroppedFile(path) => self.dropped.push(path),
            _ => {}
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        if !self.dropped.is_empty() {
            let files = std::mem::take(&mut self.dropped);
            // A failure is in the panel, where the user looks.
            let _ = self.load(files, false);
            self.redraw();
        }
        let watch = self.watch.as_ref().map(Watch::next);
        event_loop.set_control_flow(match self.wake.into_iter().chain(watch).min() {
            Some(time) => ControlFlow::WaitUntil(time),
            None => ControlFlow::Wait,
        });
    }

    fn exiting(&mut self, _: &ActiveEventLoop) {
        // The surface goes while its display is still there.
        self.screen = None;
    }
}

impl App<'_> {
    /// A key went down or up.
    fn key(&mut self, event_loop: &ActiveEventLoop, event: &KeyEvent, consumed: bool) {
        let down = event.state == ElementState::Pressed;
        // What is typed for the list means nothing else, also before its line of text has the keyboard.
        let consumed = consumed || self.chooser.open;
        let plain = !self.mouse.modifiers.control_key() && !self.mouse.modifiers.alt_key();
        // A key that was held when the panel took the keyboard comes up all the same.
        if let Some(toward) = input::toward(event)
            && (!down || (plain && !consumed))
        {
            if !event.repeat {
                self.navigation.hold(toward, down, &self.scene);
            }
            return self.redraw();
        }
        let action = input::action(&event.logical_key.as_ref(), self.mouse.modifiers);
        if down && self.chooser.open && action == Some(Action::Quit) {
            return self.act(Action::Open);
        }
        if !down || consumed {
            return;
        }
        match action {
            Some(Action::Quit) => event_loop.exit(),
            // Held down, these change on and on; the others would flicker.
            Some(action @ (Action::Coarser | Action::Finer)) => self.act(action),
            Some(action) if !event.repeat => self.act(action),
            _ => {}
        }
    }
}
