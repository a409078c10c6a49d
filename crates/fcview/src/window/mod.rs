//! The window: the renderer's picture under a panel of counts and switches, and a camera in the hand.

mod app;
mod chooser;
mod history;
mod icon;
mod input;
mod navigation;
mod outline;
mod panel;
mod recording;
mod screen;
mod watch;

use crate::cli::Cli;
use crate::{Error, headless};
use winit::event_loop::{ControlFlow, EventLoop};

/// Opens a window on the files of a command line and returns when it is closed. `warn` is told what the user should
/// know beforehand.
///
/// # Errors
/// [`Error::NoWindow`] without a display, what [`fct::Tree::open`] says about the files, and what the driver says;
/// a lost device is rebuilt up to three times first.
pub fn run(cli: &Cli, warn: &mut dyn FnMut(&str)) -> Result<(), Error> {
    let scene = headless::open_scene(cli)?;
    // The windowing library puts a place in its own source in front of what it has to say.
    let no_window = |error: winit::error::EventLoopError| {
        let text = error.to_string();
        let reason = text.rsplit(": ").next().unwrap_or(&text).trim_end_matches('.').to_owned();
        Error::NoWindow { reason }
    };
    let event_loop = EventLoop::new().map_err(no_window)?;
    event_loop.set_control_flow(ControlFlow::Wait);
    let mut app = app::App::new(cli, scene, warn);
    let ran = event_loop.run_app(&mut app).map_err(no_window);
    // What stopped the app says more than the loop's own end.
    app.failure().map_or(ran, Err)
}
