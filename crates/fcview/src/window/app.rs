//! The application: events in, frames out.

use super::chooser::Chooser;
use super::input::{self, Action, Mouse};
use super::navigation::{Mode, Navigation};
use super::outline;
use super::panel::{Panel, Wishes};
use super::recording::Recording;
use super::screen::{Overlay, Screen, Shown};
use super::watch::Watch;
use crate::cli::Cli;
use crate::headless::{open_scene, software_warning};
use crate::pick::pick;
use crate::recovery::{Misfortune, Recovery, Remedy};
use crate::renderer::Renderer;
use crate::{Camera, Error, Scene};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;
use winit::application::ApplicationHandler;
use winit::dpi::{PhysicalPosition, PhysicalSize};
use winit::event::{ElementState, KeyEvent, StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow};
use winit::window::{Fullscreen, Window, WindowId};

/// Complaints of the driver in a row after which the run gives up: one may come of a moment's state of the window.
const COMPLAINTS: u32 = 3;

/// The running program.
pub(super) struct App<'a> {
    cli: Cli,
    scene: Scene,
    navigation: Navigation,
    /// The camera's state at the last frame that was drawn, for when the next makes no view.
    good: Navigation,
    mouse: Mouse,
    panel: Panel,
    chooser: Chooser,
    recording: Option<Recording>,
    /// Whether the next frame is to be saved.
    saving: bool,
    watch: Option<Watch>,
    /// Files dropped on the window; they come one by one.
    dropped: Vec<PathBuf>,
    screen: Option<Screen>,
    recovery: Recovery,
    complaints: u32,
    misfortune: Misfortune,
    last_frame: Instant,
    /// When the panel wants to be drawn again.
    wake: Option<Instant>,
    failure: Option<Error>,
    /// Where warnings go, until one is given.
    warn: Option<&'a mut dyn FnMut(&str)>,
}

impl<'a> App<'a> {
    pub(super) fn new(cli: &Cli, scene: Scene, warn: &'a mut dyn FnMut(&str)) -> App<'a> {
        let [width, height] = cli.size.map(f64::from);
        let navigation = Navigation::facing(&scene.extremes(), cli.field_of_view(), width / height);
        App {
            navigation,
            good: navigation,
            mouse: Mouse::default(),
            panel: Panel::new(cli.frame_options(), cli.pixels, cli.fps, scene.face_count()),
            chooser: Chooser::beside(cli.files.first()),
            recording: None,
            saving: false,
            watch: cli.watch.then(|| Watch::new(&cli.files)),
            dropped: Vec::new(),
            screen: None,
            recovery: Recovery::default(),
            complaints: 0,
            misfortune: Misfortune::new(cli),
            last_frame: Instant::now(),
            wake: None,
            failure: None,
            warn: Some(warn),
            scene,
            cli: cli.clone(),
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
                    .with_title(title(&self.cli.files))
                    .with_window_icon(super::icon::icon())
                    .with_inner_size(fitting(self.cli.size, monitor.map(|monitor| monitor.size())));
                let made = event_loop.create_window(attributes);
                Arc::new(made.map_err(|error| Error::NoWindow { reason: error.to_string() })?)
            }
        };
        let screen =
            Screen::open(window, &event_loop.owned_display_handle(), &self.scene, self.cli.gpu_memory)?;
        let info = screen.renderer.gpu().info();
        if screen.renderer.gpu().is_software()
            && let Some(warn) = self.warn.take()
        {
            warn(&software_warning(&info.clone().into()));
        }
        self.panel.adapter = format!("{} ({:?})", info.name, info.backend);
        screen.window.request_redraw();
        self.screen = Some(screen);
        Ok(())
    }

    /// Draws and shows a frame.
    fn frame(&mut self) -> Result<(), Error> {
        let Some(screen) = &mut self.screen else { return Ok(()) };
        let Some(size) = screen.size() else { return Ok(()) };
        let seconds = self.last_frame.elapsed().as_secs_f64();
        self.last_frame = Instant::now();
        let hurry = self.mouse.modifiers.shift_key();
        let moving = self.navigation.advance(seconds, hurry, &self.scene);
        let camera = self.navigation.camera();
        if let Some(recording) = &mut self.recording {
            recording.note(&camera);
            self.panel.message = format!("recording the path: {:.1} s", recording.seconds());
        }
        self.panel.options.size = size;
        self.panel.options.frozen =
            if self.panel.frozen { self.panel.options.frozen.or(Some(camera)) } else { None };
        self.misfortune.strike(screen.renderer.gpu());
        match screen.renderer.draw(&self.scene, &camera, &self.panel.options) {
            Ok(stats) => {
                if self.panel.note(&stats) {
                    screen.window.request_redraw();
                }
                self.good = self.navigation;
            }
            // A camera without a view gives way to the last that had one.
            Err(Error::Camera { reason }) => {
                self.panel.message = reason.to_owned();
                self.navigation = self.good;
            }
            Err(error) => return Err(error),
        }

        if std::mem::take(&mut self.saving) {
            self.panel.message = save(&screen.renderer);
        }
        let context = screen.egui.egui_ctx().clone();
        let input = screen.egui.take_egui_input(&screen.window);
        let mut wishes = Wishes::default();
        let mut chosen = None;
        let before = (self.panel.options, self.panel.frozen, self.navigation);
        let mut output = context.run_ui(input, |ui| {
            show_frozen(ui.ctx(), &self.scene, &camera, &self.panel);
            wishes = self.panel.show(ui, &mut self.navigation, self.recording.is_some());
            chosen = self.chooser.show(ui.ctx());
        });
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
        let changed = before != (self.panel.options, self.panel.frozen, self.navigation);
        let again = moving || self.recording.is_some() || animated || changed;
        if shown == Shown::Again || (shown == Shown::Yes && again) {
            screen.window.request_redraw();
        }
        self.wake = repaint.and_then(|delay| Instant::now().checked_add(delay));
        self.grant(wishes);
        if let Some(path) = chosen {
            let opened = self.load(vec![path], false);
            self.chooser.done(opened);
            self.redraw();
        }
        Ok(())
    }

    /// Draws a frame, again after a failure for which there is a remedy.
    fn frame_or_remedy(&mut self, event_loop: &ActiveEventLoop) {
        let failure = match self.frame() {
            Ok(()) => {
                self.complaints = 0;
                return self.recovery.drawn();
            }
            Err(failure) => failure,
        };
        let can_shrink = self.screen.as_ref().is_some_and(|screen| screen.renderer.can_shrink(&self.scene));
        let remedied = match self.recovery.remedy(failure, can_shrink) {
            Ok(Remedy::Rebuild) => {
                let window = self.screen.take().map(|screen| Arc::clone(&screen.window));
                self.open(event_loop, window)
            }
            Ok(Remedy::Evict) => {
                if let Some(screen) = &mut self.screen {
                    screen.renderer.evict();
                }
                Ok(())
            }
            Ok(Remedy::Shrink) => match &mut self.screen {
                Some(screen) => screen.renderer.shrink(&self.scene),
                None => Ok(()),
            },
            Err(Error::Device { message }) if self.complaints < COMPLAINTS => {
                self.complaints += 1;
                self.panel.message = message;
                Ok(())
            }
            Err(Error::DeviceMemory { .. }) if self.panel.coarsen(2.0) => {
                self.panel.message = "no graphics memory left: drawn more coarsely".to_owned();
                Ok(())
            }
            Err(error) => Err(error),
        };
        match remedied {
            Ok(()) => self.redraw(),
            Err(error) => self.fail(event_loop, error),
        }
    }

    /// Does what the panel's buttons ask for.
    fn grant(&mut self, wishes: Wishes) {
        if let Some(mode) = wishes.mode {
            self.navigation.set_mode(mode, &self.scene);
        }
        for (wished, action) in [
            (wishes.fit, Action::Fit),
            (wishes.reset, Action::Reset),
            (wishes.screenshot, Action::Screenshot),
            (wishes.record, Action::Record),
            (wishes.open, Action::Open),
        ] {
            if wished {
                self.act(action);
            }
        }
    }

    /// Does what a key or a button asks for.
    fn act(&mut self, action: Action) {
        match action {
            Action::SwitchMode => {
                let other = if self.navigation.mode() == Mode::Orbit { Mode::Fly } else { Mode::Orbit };
                self.navigation.set_mode(other, &self.scene);
            }
            Action::Fit => {
                let fitted =
                    self.navigation.fitted(&self.scene.extremes(), self.cli.field_of_view(), self.aspect());
                self.navigation = fitted;
            }
            Action::Reset => self.reset(),
            Action::Turn => {
                self.navigation.set_mode(Mode::Orbit, &self.scene);
                self.navigation.turning = !self.navigation.turning;
            }
            Action::Freeze => {
                self.panel.frozen = !self.panel.frozen;
                // At once: the next frame may see the camera elsewhere already.
                self.panel.options.frozen = self.panel.frozen.then(|| self.navigation.camera());
            }
            Action::Coarser => drop(self.panel.coarsen(1.25)),
            Action::Finer => drop(self.panel.coarsen(0.8)),
            Action::NextColor => self.panel.next_color(),
            Action::Wireframe => self.panel.options.wireframe = !self.panel.options.wireframe,
            Action::Screenshot => self.saving = true,
            Action::Record => self.record(),
            Action::Open => self.chooser.toggle(),
            Action::Panel => self.panel.shown = !self.panel.shown,
            Action::FullScreen => {
                if let Some(screen) = &self.screen {
                    let full = screen.window.fullscreen().is_none();
                    screen.window.set_fullscreen(full.then_some(Fullscreen::Borderless(None)));
                }
            }
            Action::Quit => {}
        }
        self.redraw();
    }

    /// Turns around what is under the mouse from now on.
    fn turn_around(&mut self, place: PhysicalPosition<f64>) {
        let size = self.panel.options.size;
        let camera = self.navigation.camera();
        let Ok(view) = camera.view(size, self.scene.near(camera.eye)) else { return };
        let [width, height] = size.map(f64::from);
        let right = view.pixel * (place.x - 0.5 * width);
        let up = view.pixel * (0.5 * height - place.y);
        let Some(ray) = (view.forward + right * view.right + up * view.up).try_normalize() else { return };
        if let Some(point) = pick(&self.scene, camera.eye, ray, self.panel.options.two_sided) {
            self.navigation.turn_around(point);
            self.redraw();
        }
    }

    /// The first view of the scene.
    fn reset(&mut self) {
        let fov = self.cli.field_of_view();
        self.navigation = Navigation::facing(&self.scene.extremes(), fov, self.aspect());
    }

    /// Width over height of the picture.
    fn aspect(&self) -> f64 {
        let [width, height] = self.panel.options.size.map(f64::from);
        width / height.max(1.0)
    }

    /// Shows other files, or the same ones anew with the camera where it is, unless their size or place is another. What is shown stays if they cannot be.
    fn load(&mut self, files: Vec<PathBuf>, same: bool) -> Result<(), String> {
        let cli = Cli { files, ..self.cli.clone() };
        let loaded = open_scene(&cli).and_then(|scene| {
            // The camera keeps its coordinates, so those of the scene begin where they did.
            let scene = if same { scene.about(self.scene.origin) } else { scene };
            if let Some(screen) = &mut self.screen {
                let gpu = screen.renderer.gpu().clone();
                screen.renderer = Renderer::with_memory(gpu, &scene, self.cli.gpu_memory)?;
            }
            Ok(scene)
        });
        let scene = loaded.map_err(|error| error.to_string()).inspect_err(|error| {
            self.panel.message.clone_from(error);
        })?;
        let same = same && scene.fills_the_view_of(&self.scene);
        self.scene = scene;
        self.cli = cli;
        self.panel.faces = self.scene.face_count();
        self.panel.message = format!("opened {}", names(&self.cli.files));
        self.watch = self.watch.is_some().then(|| Watch::new(&self.cli.files));
        if let Some(screen) = &self.screen {
            screen.window.set_title(&title(&self.cli.files));
        }
        if !same {
            self.panel.frozen = false;
            self.recording = None;
            self.reset();
        }
        Ok(())
    }

    /// Begins a recording, or ends it and saves the path under the first free name.
    fn record(&mut self) {
        let camera = self.navigation.camera();
        let Some(recording) = self.recording.take() else {
            self.recording = Some(Recording::start(&camera));
            return;
        };
        let path = free_name("fcview-path-", "json");
        let saved = recording.finish(&camera).and_then(|recorded| {
            let recorded = recorded.with_origin(self.scene.origin)?;
            recorded.write(&path).map_err(|error| error.to_string())?;
            Ok(format!("saved {}: {:.1} s", path.display(), recorded.seconds()))
        });
        self.panel.message = saved.unwrap_or_else(|error| error);
    }

    fn redraw(&self) {
        if let Some(screen) = &self.screen {
            screen.window.request_redraw();
        }
    }

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

/// The view that a frozen cut was chosen for, as lines.
fn show_frozen(context: &egui::Context, scene: &Scene, camera: &Camera, panel: &Panel) {
    let Some(frozen) = &panel.options.frozen else { return };
    let Ok(view) = camera.view(panel.options.size, scene.near(camera.eye)) else { return };
    let [width, height] = panel.options.size.map(f64::from);
    // As deep as the scene is from there.
    let depth = scene
        .instances
        .iter()
        .filter_map(|instance| scene.sphere(instance))
        .map(|(center, radius)| center.distance(frozen.eye) + radius)
        .fold(0.0, f64::max);
    let painter = context.layer_painter(egui::LayerId::background());
    outline::draw(&painter, context.content_rect(), &view, frozen, width / height, depth);
}

/// Saves the picture, without the panel, under the first free name. Returns what became of it.
fn save(renderer: &Renderer) -> String {
    let path = free_name("fcview-", "png");
    match renderer.image(false).and_then(|image| image.write_png(&path)) {
        Ok(()) => format!("saved {}", path.display()),
        Err(error) => error.to_string(),
    }
}

/// The first name that no file has, with a number from 0 on.
fn free_name(stem: &str, extension: &str) -> PathBuf {
    let name = |number: u32| PathBuf::from(format!("{stem}{number}.{extension}"));
    (0..100_000).map(name).find(|path| !path.exists()).unwrap_or_else(|| name(100_000))
}

/// What files are called in a title or a message.
fn names(files: &[PathBuf]) -> String {
    let name = |path: &Path| path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    match files {
        [] => "nothing".to_owned(),
        [only] => name(only),
        [first, rest @ ..] => format!("{} and {} more", name(first), rest.len()),
    }
}

/// The window's title: what it shows, then the program.
fn title(files: &[PathBuf]) -> String {
    format!("{} - facetree", names(files))
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
