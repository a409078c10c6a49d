//! The application: events in, frames out.

mod actions;
mod events;
mod names;

use super::chooser::Chooser;
use super::input::Mouse;
use super::navigation::Navigation;
use super::outline;
use super::panel::{Panel, Wishes};
use super::recording::Recording;
use super::screen::{Overlay, Screen, Shown};
use super::watch::Watch;
use crate::cli::Cli;
use crate::recovery::{Misfortune, Recovery, Remedy};
use crate::renderer::Renderer;
use crate::{Camera, Error, Scene, Warning};
use names::{fitting, free_name, title};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;
use winit::event_loop::ActiveEventLoop;
use winit::window::Window;

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
    warn: Option<&'a mut dyn FnMut(&Warning)>,
}

impl<'a> App<'a> {
    pub(super) fn new(cli: &Cli, scene: Scene, warn: &'a mut dyn FnMut(&Warning)) -> App<'a> {
        let [width, height] = cli.size.map(f64::from);
        let navigation = Navigation::facing(&scene.extremes(), cli.field_of_view(), width / height);
        let mut panel = Panel::new(cli.frame_options(), cli.pixels, cli.fps, scene.face_count());
        panel.message = names::about(cli, &scene, "");
        App {
            navigation,
            good: navigation,
            mouse: Mouse::default(),
            panel,
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
            warn(&Warning::of_software(&info.clone().into()));
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

    fn redraw(&self) {
        if let Some(screen) = &self.screen {
            screen.window.request_redraw();
        }
    }
}

/// Saves the picture, without the panel, under the first free name. Returns what became of it.
fn save(renderer: &Renderer) -> String {
    let path = free_name("fcview-", "png");
    match renderer.image(false).and_then(|image| image.write_png(&path)) {
        Ok(()) => format!("saved {}", path.display()),
        Err(error) => error.to_string(),
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
