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
use crate::{Error, Warning, headless};
use std::panic::{self, AssertUnwindSafe};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use winit::event_loop::{ControlFlow, EventLoop};

/// Opens a window on the files of a command line and returns when it is closed. `warn` is told what the user should
/// know beforehand.
///
/// # Errors
/// [`Error::NoWindow`] without a display, what [`fct::Tree::open`] says about the files, and what the driver says;
/// a lost device is rebuilt up to three times first.
pub fn run(cli: &Cli, warn: &mut dyn FnMut(&Warning)) -> Result<(), Error> {
    let scene = headless::open_scene(cli)?;
    if let Some(hollow) = Warning::of_hollow(cli, &scene) {
        warn(&hollow);
    }
    // The windowing library puts a place in its own source in front of what it has to say.
    let no_window = |error: winit::error::EventLoopError| {
        let text = error.to_string();
        let reason = text.rsplit(": ").next().unwrap_or(&text).trim_end_matches('.').to_owned();
        Error::NoWindow { reason }
    };
    let event_loop = EventLoop::new().map_err(no_window)?;
    event_loop.set_control_flow(ControlFlow::Wait);
    let mut app = app::App::new(cli, scene, warn);
    let ran = while_there_is_a_display(|| event_loop.run_app(&mut app).map_err(no_window));
    // What stopped the app says more than the loop's own end.
    app.failure().map_or(ran, Err)
}

/// Runs the window's loop. winit panics where it asks a display that is gone; that is no bug to be reported, and becomes
/// an error. Other panics go their way.
fn while_there_is_a_display(run: impl FnOnce() -> Result<(), Error>) -> Result<(), Error> {
    let gone = Arc::new(AtomicBool::new(false));
    let seen = Arc::clone(&gone);
    let usual = Arc::new(panic::take_hook());
    let others = Arc::clone(&usual);
    panic::set_hook(Box::new(move |info| {
        if info.location().is_some_and(|place| place.file().contains("winit")) {
            seen.store(true, Ordering::Release);
        } else {
            others(info);
        }
    }));
    let ran = panic::catch_unwind(AssertUnwindSafe(run));
    panic::set_hook(Box::new(move |info| usual(info)));
    match ran {
        Ok(ran) => ran,
        Err(_) if gone.load(Ordering::Acquire) => {
            Err(Error::NoWindow { reason: "the display has gone away".to_owned() })
        }
        Err(bug) => panic::resume_unwind(bug),
    }
}
