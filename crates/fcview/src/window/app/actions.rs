//! What keys, buttons and files do to the application.

use super::App;
use super::names::{about, free_name, names, title};
use crate::cli::Cli;
use crate::headless::open_scene;
use crate::pick::pick;
use crate::renderer::Renderer;
use crate::window::input::Action;
use crate::window::navigation::{Mode, Navigation};
use crate::window::panel::Wishes;
use crate::window::recording::Recording;
use crate::window::watch::Watch;
use std::path::PathBuf;
use winit::dpi::PhysicalPosition;
use winit::window::Fullscreen;

impl App<'_> {
    /// Does what the panel's buttons ask for.
    pub(super) fn grant(&mut self, wishes: Wishes) {
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
    pub(super) fn act(&mut self, action: Action) {
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
    pub(super) fn turn_around(&mut self, place: PhysicalPosition<f64>) {
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
    pub(super) fn load(&mut self, files: Vec<PathBuf>, same: bool) -> Result<(), String> {
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
        let opened = format!("opened {}", names(&self.cli.files));
        self.panel.message = about(&self.cli, &self.scene, &opened);
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
}
