//! The command `fct`: looks into, verifies and exports face-cluster trees. See `fct --help`.

mod counted;
mod error;
mod export;
mod flags;
mod info;
mod message;
mod stage;
mod verify;

use clap::Parser as _;
use error::Error;
use fct::{MessageFormat, tell};
use flags::{Command, Flags};
use stage::Stage;
use std::io::{self, Write as _};
use std::panic::{self, AssertUnwindSafe};
use std::process::ExitCode;
use std::sync::Arc;
use std::thread;

/// The version of the JSON documents of this program: it rises when a member changes its meaning or goes away.
pub(crate) const SCHEMA: u32 = 1;

fn main() -> ExitCode {
    let flags = match Flags::try_parse() {
        Ok(flags) => flags,
        Err(error) => {
            // Help and version are asked for and go to stdout, the rest to stderr; a closed pipe is no concern.
            let text = flags::said(&error);
            if !error.use_stderr() {
                let _ = io::stdout().lock().write_all(text.as_bytes());
            } else if MessageFormat::asked_for(std::env::args_os()) == MessageFormat::Json {
                tell(&message::usage_line(&text));
            } else {
                let _ = io::stderr().lock().write_all(text.as_bytes());
            }
            return ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2));
        }
    };
    // The last net: what panics is our bug, and unwinding has removed the temporaries.
    let done = panic::catch_unwind(AssertUnwindSafe(|| run(&flags))).unwrap_or(Err(Error::Bug));
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            tell(&message::error_line(flags.message_format, &error));
            fct::end_with(error.exit_code())
        }
    }
}

fn run(flags: &Flags) -> Result<(), Error> {
    let format = flags.message_format;
    match &flags.command {
        Command::Info(flags) => {
            let tree = fct::Tree::open(&flags.file)?;
            print(&if flags.json { info::to_json(&tree) } else { info::to_text(&tree) })
        }
        Command::Verify(flags) => {
            let progress = flags.of_progress.shown(format);
            let (flags, watched) = (&flags.of_file, Arc::clone(&progress));
            let file = flags.file.clone();
            let thread = thread::Builder::new().name("verify".to_owned());
            let outcome = fct::Interrupt::watch().wait_for(thread, move || {
                let tree = fct::Tree::open(&file)?;
                watched.tell(Stage::Bytes.into(), 0, 1);
                let faces = tree.face_count() as u64;
                tree.verify_watched(&mut |done| watched.tell(Stage::Rules.into(), done, faces))
            });
            progress.clear();
            let outcome = outcome?;
            if flags.json {
                print(&verify::to_json(&flags.file, &outcome))?;
            }
            let verified = outcome?;
            if flags.json { Ok(()) } else { print(&verify::to_text(&flags.file, &verified)) }
        }
        Command::Export(flags) => {
            let settings = flags.settings()?;
            let progress = flags.of_progress.shown(format);
            // Before the temporaries are made, so that no signal can leave one behind.
            let interrupt = fct::Interrupt::watch();
            let done = export::run(&settings, &interrupt, &progress);
            progress.clear();
            let export::Done { meshes: done, large_error, empty_region } = done?;
            let missed = done.iter().filter_map(export::Exported::missed);
            let warnings = large_error
                .map(|text| ("FC351", "large_error", text))
                .into_iter()
                .chain(missed.map(|text| ("FC352", "missed_budget", text)))
                .chain(empty_region.map(|text| ("FC353", "empty_region", text)));
            for (code, name, text) in warnings {
                tell(&message::warning_line(format, &settings.input, code, name, &text));
            }
            print(&if flags.json {
                export::to_json(&settings.input, &done)
            } else {
                done.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
            })?;
            // Whoever has pressed Ctrl-C does not want the next one of a loop either.
            interrupt.exit_code().map_or(Ok(()), |exit| Err(Error::InterruptedLate { exit }))
        }
    }
}

/// Text on standard output.
fn print(text: &str) -> Result<(), Error> {
    let mut out = io::stdout().lock();
    match writeln!(out, "{text}").and_then(|()| out.flush()) {
        // A reader that went away, as `head` does, has seen enough.
        Err(e) if e.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        Err(e) => Err(Error::Stdout(e)),
        Ok(()) => Ok(()),
    }
}
