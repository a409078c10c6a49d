//! The command `fcview`: flags in, pictures or a window out. See `fcview --help`.

mod progress;

use fct::{Interrupt, MessageFormat, Stopped, counted, tell, usage_sentence};
use fcview::Error;
use fcview::cli::{Cli, said};
use fcview::headless::{self, Watch};
use progress::Progress;
use serde_json::json;
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
            if !error.use_stderr() {
                let _ = std::io::stdout().lock().write_all(text.as_bytes());
            } else if MessageFormat::asked_for(std::env::args_os()) == MessageFormat::Json {
                tell(&error_as_json("FC100", 2, &usage_sentence(&text)));
            } else {
                let _ = std::io::stderr().lock().write_all(text.as_bytes());
            }
            return ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2));
        }
    };
    let run = || if cli.headless { run_headless(&cli) } else { run_window(&cli) };
    // The last net: what panics is our bug, and unwinding has removed the temporaries.
    match panic::catch_unwind(AssertUnwindSafe(run)).unwrap_or(Err(Error::Bug)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            tell(&match cli.message_format {
                MessageFormat::Human => format!("error[{}]: {error}", error.code()),
                MessageFormat::Json => error_as_json(error.code(), error.exit_code(), &error.to_string()),
            });
            fct::end_with(error.exit_code())
        }
    }
}

fn run_headless(cli: &Cli) -> Result<(), Error> {
    let interrupt = Interrupt::watch();
    let (watch, progress) = (Arc::new(Watch::default()), Arc::new(Mutex::new(Progress::new(cli))));
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
    for warning in &outcome.warnings {
        tell(&warning.line(cli.message_format));
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

/// The line for an error, for programs.
fn error_as_json(code: &str, exit: u8, message: &str) -> String {
    json!({ "level": "error", "code": code, "exit": exit, "message": message }).to_string()
}

#[cfg(feature = "window")]
fn run_window(cli: &Cli) -> Result<(), Error> {
    fcview::window::run(cli, &mut |warning| tell(&warning.line(cli.message_format)))
}

#[cfg(not(feature = "window"))]
fn run_window(_: &Cli) -> Result<(), Error> {
    Err(Error::NoWindow { reason: "this fcview was built without the feature `window`".to_owned() })
}
