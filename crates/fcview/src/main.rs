//! The command `fcview`: flags in, pictures or a window out. See `fcview --help`.

mod progress;

use fct::{Interrupt, Stopped, counted};
use fcview::Error;
use fcview::cli::{Cli, said};
use fcview::headless::{self, Watch};
use progress::Progress;
use std::io::Write;
use std::panic::{self, AssertUnwindSafe};
use std::process::ExitCode;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

fn main() -> ExitCode {
    fct::heap::keep_free_blocks();
    let cli = match Cli::parsed(std::env::args_os()) {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version are asked for and go to stdout, the rest to stderr; a closed pipe is no concern.
            let text = said(&error);
            let _ = if error.use_stderr() {
                std::io::stderr().lock().write_all(text.as_bytes())
            } else {
                std::io::stdout().lock().write_all(text.as_bytes())
            };
            return ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2));
        }
    };
    let run = || if cli.headless { run_headless(&cli) } else { run_window(&cli) };
    // The last net: what panics is our bug, and unwinding has removed the temporaries.
    match panic::catch_unwind(AssertUnwindSafe(run)).unwrap_or(Err(Error::Bug)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            say(&format!("error[{}]: {error}", error.code()));
            fct::end_with(error.exit_code())
        }
    }
}

fn run_headless(cli: &Cli) -> Result<(), Error> {
    let interrupt = Interrupt::watch();
    let (watch, progress) = (Arc::new(Watch::default()), Arc::new(Mutex::new(Progress::new(cli.frames))));
    let locked = |progress: &Mutex<Progress>, act: &dyn Fn(&mut Progress)| {
        act(&mut progress.lock().unwrap_or_else(PoisonError::into_inner));
    };
    // A frame may take minutes: drawn on a thread of its own it ends with the process when a signal comes.
    let done = {
        let (cli, watch, progress) = (cli.clone(), Arc::clone(&watch), Arc::clone(&progress));
        interrupt.wait_for(thread::Builder::new().name("frames".to_owned()), move || {
            headless::run_watched(&cli, &watch, &mut |frames| locked(&progress, &|line| line.tell(frames)))
        })
    };
    let outcome = match done {
        Ok(outcome) => outcome,
        Err(Stopped::BySignal(exit)) => {
            // Held until the process ends.
            std::mem::forget(watch.between_files());
            Err(Error::Interrupted { exit, frames: watch.frames(), of: cli.frames })
        }
        Err(Stopped::NoThread(source)) => Err(Error::NoThread { source }),
        Err(Stopped::Panicked) => Err(Error::Bug),
    };
    locked(&progress, &Progress::clear);
    let outcome = outcome?;
    if let Some(text) = &outcome.hollow {
        warn(text);
    }
    if outcome.software {
        warn(&headless::software_warning(&outcome.stats.adapter));
    }
    if let Some(text) = headless::memory_warning(&outcome.stats) {
        warn(&text);
    }
    if let Some(text) = headless::budget_warning(&outcome.stats) {
        warn(&text);
    }
    let mut lines =
        outcome.written.iter().map(|path| format!("wrote {}", path.display())).collect::<Vec<_>>();
    if let Some(last) = outcome.stats.frames.last() {
        let counts = &last.counts;
        lines.push(format!(
            "{}, median {:.1} ms; the last drew {} ({})",
            counted(outcome.stats.frames.len() as u64, "frame"),
            outcome.stats.milliseconds_median,
            counted(counts.triangles_drawn, "triangle"),
            counted(counts.instances, "instance"),
        ));
    }
    print(&lines)
}

/// Lines on standard output.
fn print(lines: &[String]) -> Result<(), Error> {
    let mut out = std::io::stdout().lock();
    match lines.iter().try_for_each(|line| writeln!(out, "{line}")).and_then(|()| out.flush()) {
        // A reader that went away, as `head` does, has seen enough.
        Err(e) if e.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        Err(e) => Err(Error::Stdout(e)),
        Ok(()) => Ok(()),
    }
}

fn warn(text: &str) {
    say(&format!("warning: {text}"));
}

/// A line on standard error, where anyone reads it.
fn say(line: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}

#[cfg(feature = "window")]
fn run_window(cli: &Cli) -> Result<(), Error> {
    fcview::window::run(cli, &mut warn)
}

#[cfg(not(feature = "window"))]
fn run_window(_: &Cli) -> Result<(), Error> {
    Err(Error::NoWindow { reason: "this fcview was built without the feature `window`".to_owned() })
}
