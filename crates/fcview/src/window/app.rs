//! The application: events in, frames out.

use super::input::Mouse;
use super::panel::{Panel, Wishes};
use super::screen::{Overlay, Screen, Shown};
use crate::cli::Cli;
use crate::headless::software_warning;
use crate::orbit::Orbit;
use crate::recovery::{Recovery, Remedy};
use crate::stats::FrameStats;
use crate::{Error, Scene};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{ElementState, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow};
use winit::keyboard::{Key, NamedKey};
use winit::window::{Window, WindowId};

/// Radians that the camera turns by itself each frame.
const TURN_STEP: f64 = 0.012;

/// The running program.
pub(super) struct App<'a> {
    scene: Scene,
    title: String,
    size: [u32; 2],
    fov: f64,
    orbit: Orbit,
    mouse: Mouse,
    panel: Panel,
    stats: FrameStats,
    screen: Option<Screen>,
    recovery: Recovery,
    screenshots: u32,
    failure: Option<Error>,
    /// Where warnings go, until one is given.
    warn: Option<&'a mut dyn FnMut(&str)>,
}

impl<'a> App<'a> {
    pub(super) fn new(cli: &Cli, scene: Scene, warn: &'a mut dyn FnMut(&str)) -> App<'a> {
        let faces = |instance: &crate::Instance| {
            scene.models.get(instance.model).map_or(0, |model| model.tree.face_count() as u64)
        };
        let faces = scene.instances.iter().map(faces).sum();
        let [width, height] = cli.size.map(f64::from);
        App {
            title: title(&cli.files),
            size: cli.size,
            fov: cli.field_of_view(),
            orbit: Orbit::facing(&scene.extremes(), cli.field_of_view(), width / height),
            mouse: Mouse::default(),
            panel: Panel::new(cli.frame_options(), cli.pixels, faces),
            stats: FrameStats::default(),
            screen: None,
            recovery: Recovery::default(),
            screenshots: 0,
            failure: None,
            warn: Some(warn),
            scene,
        }
    }

    /// What ended the run, if it was not the user.
    pub(super) fn failure(&mut self) -> Option<Error> {
        self.failure.take()
    }

    fn fail(&mut self, event_loop: &ActiveEventLoop, error: Error) {
        self.failure.get_or_insert(error);
        event_loop.exit();
    }

    /// Opens the screen, in a window that is there already or a new one.
    fn open(&mut self, event_loop: &ActiveEventLoop, window: Option<Arc<Window>>) -> Result<(), Error> {
        let window = match window {
            Some(window) => window,
            None => {
                let monitor = event_loop.primary_monitor().or_else(|| event_loop.available_monitors().next());
                let attributes = Window::default_attributes()
                    .with_title(self.title.as_str())
                    .with_inner_size(fitting(self.size, monitor.map(|monitor| monitor.size())));
                let made = event_loop.create_window(attributes);
                Arc::new(made.map_err(|error| Error::NoWindow { reason: error.to_string() })?)
            }
        };
        let screen = Screen::open(window, &event_loop.owned_display_handle(), &self.scene)?;
        let info = screen.renderer.gpu().info();
        if screen.renderer.gpu().is_software()
            && let Some(warn) = self.warn.take()
        {
            warn(&software_warning(&info.name));
        }
        self.panel.adapter = format!("{} ({:?})", info.name, info.backend);
        screen.window.request_redraw();
        self.screen = Some(screen);
        Ok(())
    }

    /// Draws and shows a frame.
    fn frame(&mut self, event_loop: &ActiveEventLoop) -> Result<(), Error> {
        let Some(screen) = &mut self.screen else { return Ok(()) };
        let Some(size) = screen.size() else { return Ok(()) };
        if self.panel.turning {
            self.orbit.turn(-TURN_STEP, 0.0);
        }
        let camera = self.orbit.camera();
        self.panel.options.size = size;
        self.panel.options.frozen =
            if self.panel.frozen { self.panel.options.frozen.or(Some(camera)) } else { None };
        let drawn = screen.renderer.draw(&self.scene, &camera, &self.panel.options);
        match drawn {
            Ok(stats) => {
                self.panel.note(&stats);
                self.stats = stats;
            }
            // A camera without a view keeps the last picture.
            Err(Error::Camera { reason }) => self.panel.message = reason.to_owned(),
            Err(error) => return Err(error),
        }

        let context = screen.egui.egui_ctx().clone();
        let input = screen.egui.take_egui_input(&screen.window);
        let mut wishes = Wishes::default();
        let before = self.panel.options;
        let mut output = context.run_ui(input, |ui| wishes = self.panel.show(ui, &self.stats));
        let platform = std::mem::take(&mut output.platform_output);
        screen.egui.handle_platform_output(&screen.window, platform);
        let repaint = output.viewport_output.values().map(|viewport| viewport.repaint_delay).min();
        let overlay = Overlay {
            textures: std::mem::take(&mut output.textures_delta),
            shapes: context.tessellate(std::mem::take(&mut output.shapes), output.pixels_per_point),
            pixels_per_point: output.pixels_per_point,
        };
        let shown = screen.show(overlay)?;
        let animated = repaint.is_some_and(|delay| delay.is_zero());
        let again = self.panel.turning || animated || before != self.panel.options;
        if shown == Shown::Again || (shown == Shown::Yes && again) {
            screen.window.request_redraw();
        }
        match repaint.and_then(|delay| std::time::Instant::now().checked_add(delay)) {
            Some(time) => event_loop.set_control_flow(ControlFlow::WaitUntil(time)),
            None => event_loop.set_control_flow(ControlFlow::Wait),
        }
        if wishes.fit {
            self.fit();
        }
        if wishes.screenshot {
            self.screenshot();
        }
        Ok(())
    }

    /// Draws a frame, again after a failure for which there is a remedy.
    fn frame_or_remedy(&mut self, event_loop: &ActiveEventLoop) {
        let remedied = match self.frame(event_loop) {
            Ok(()) => {
                self.recovery.drawn();
                Ok(())
            }
            Err(failure) => self.recovery.remedy(failure).and_then(|remedy| match remedy {
                Remedy::Rebuild => {
                    let window = self.screen.take().map(|screen| Arc::clone(&screen.window));
                    self.open(event_loop, window)
                }
                Remedy::Evict => {
                    if let Some(screen) = &mut self.screen {
                        screen.renderer.evict();
                    }
                    self.redraw();
                    Ok(())
                }
            }),
        };
        if let Err(error) = remedied {
            self.fail(event_loop, error);
        }
    }

    /// Sees everything again.
    fn fit(&mut self) {
        let [width, height] = self.panel.options.size.map(f64::from);
        let fresh = Orbit::facing(&self.scene.extremes(), self.fov, width / height.max(1.0));
        self.orbit = fresh.seen_from(&self.orbit);
        self.redraw();
    }

    /// Saves the picture, without the panel, under the first free name.
    fn screenshot(&mut self) {
        let Some(screen) = &self.screen else { return };
        let path = loop {
            let path = PathBuf::from(format!("fcview-{}.png", self.screenshots));
            self.screenshots += 1;
            if !path.exists() || self.screenshots > 100_000 {
                break path;
            }
        };
        let saved = screen.renderer.image(false).and_then(|image| image.write_png(&path));
        self.panel.message = match saved {
            Ok(()) => format!("saved {}", path.display()),
            Err(error) => error.to_string(),
        };
        self.redraw();
    }

    fn redraw(&self) {
        if let Some(screen) = &self.screen {
            screen.window.request_redraw();
        }
    }
}

/// The window's title: what it shows, then the program.
fn title(files: &[PathBuf]) -> String {
    let name = |path: &Path| path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    match files {
        [] => "facetree".to_owned(),
        [only] => format!("{} - facetree", name(only)),
        [first, rest @ ..] => format!("{} and {} more - facetree", name(first), rest.len()),
    }
}

/// A window's size, pixels, no larger than the monitor: beyond it, its panel and its edges are out of reach.
fn fitting(size: [u32; 2], monitor: Option<PhysicalSize<u32>>) -> PhysicalSize<u32> {
    let [width, height] = size;
    match monitor {
        // Some systems know a monitor but not its size.
        Some(monitor) if monitor.width > 0 && monitor.height > 0 => {
            PhysicalSize::new(width.min(monitor.width), height.min(monitor.height))
        }
        _ => PhysicalSize::new(width, height),
    }
}

impl ApplicationHandler for App<'_> {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.screen.is_none()
            && let Err(error) = self.open(event_loop, None)
        {
            self.fail(event_loop, error);
        }
    }

    fn new_events(&mut self, _: &ActiveEventLoop, cause: winit::event::StartCause) {
        if matches!(cause, winit::event::StartCause::ResumeTimeReached { .. }) {
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
            WindowEvent::ModifiersChanged(modifiers) => self.mouse.modifiers = modifiers.state(),
            WindowEvent::CursorMoved { position, .. } => {
                let height = screen.window.inner_size().height;
                if self.mouse.moved(position, height, &mut self.orbit) {
                    screen.window.request_redraw();
                }
            }
            WindowEvent::CursorLeft { .. } => self.mouse.left(),
            WindowEvent::MouseInput { state, button, .. } => {
                self.mouse.button(button, state, !response.consumed);
            }
            WindowEvent::MouseWheel { delta, .. } if !response.consumed => {
                Mouse::wheel(delta, &mut self.orbit);
                screen.window.request_redraw();
            }
            WindowEvent::KeyboardInput { event, .. }
                if event.state == ElementState::Pressed && !response.consumed =>
            {
                match event.logical_key.as_ref() {
                    Key::Character("f" | "F") => self.fit(),
                    Key::Character("p" | "P") => self.screenshot(),
                    Key::Character("q" | "Q") | Key::Named(NamedKey::Escape) => event_loop.exit(),
                    _ => {}
                }
            }
            _ => {}
        }
    }

    fn exiting(&mut self, _: &ActiveEventLoop) {
        // The surface goes while its display is still there.
        self.screen = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_title_names_the_files_and_the_window_fits_the_monitor() {
        assert_eq!(title(&["a/scan.fct".into()]), "scan.fct - facetree");
        assert_eq!(title(&["a.fct".into(), "b.fct".into(), "c.fct".into()]), "a.fct and 2 more - facetree");
        let monitor = Some(PhysicalSize::new(1024, 768));
        assert_eq!(fitting([1280, 720], monitor), PhysicalSize::new(1024, 720));
        assert_eq!(fitting([1280, 720], None), PhysicalSize::new(1280, 720));
    }
}
