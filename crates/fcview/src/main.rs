//! The command `fcview`: flags in, pictures or a window out. See `fcview --help`.

mod progress;

use clap::Parser;
use fct::{Interrupt, counted};
use fcview::cli::{Cli, said};
use fcview::{Error, headless};
use progress::Progress;
use std::io::Write;
use std::panic::{self, AssertUnwindSafe};
use std::process::ExitCode;

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
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
            ExitCode::from(error.exit_code())
        }
    }
}

fn run_headless(cli: &Cli) -> Result<(), Error> {
    let interrupt = Interrupt::watch();
    let mut progress = Progress::new(cli.frames);
    let outcome = headless::run_watched(cli, &mut |frames| {
        progress.tell(frames);
        interrupt.exit_code()
    });
    progress.clear();
    let outcome = outcome?;
    if let Some(text) = &outcome.hollow {
        warn(text);
    }
    if outcome.software {
        warn(&headless::software_warning(&outcome.stats.adapter.name));
    }
    if let Some(text) = headless::memory_warning(&outcome.stats) {
        warn(&text);
    }
    if let Some(text) = headless::budget_warning(&outcome.stats) {
        warn(&text);
    }
    let mut out = std::io::stdout().lock();
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
    for line in lines {
        // A reader that went away, as `head` does, has seen enough.
        if writeln!(out, "{line}").is_err() {
            break;
        }
    }
    Ok(())
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
