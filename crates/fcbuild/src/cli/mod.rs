//! The command line in three stages: flags as typed ([`flags`]), settings as meant ([`settings`]), the job as done
//! ([`job`]). This module strings them together and is the only one that prints messages.

mod bug;
mod distinct;
pub(crate) mod flags;
mod identity;
mod inputs;
mod job;
mod memory;
mod message;
mod output;
mod progress;
mod report;
mod settings;
mod summary;

use fcbuild::Error;
use fcbuild::error::ErrorKind;
use fct::{Interrupt, MessageFormat, Progress, tell, usage_sentence};
use flags::Flags;
use job::{Ended, Made};
use output::Outputs;
use progress::Stage;
use report::Report;
use settings::Settings;
use std::io::{self, Write as _};
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

/// Does what the flags ask for; the result is the program's exit code.
pub(crate) fn run(flags: &Flags) -> ExitCode {
    bug::remember_panics();
    match bug::caught(|| work(flags)) {
        Ok(exit) => exit,
        Err(error) => {
            tell(&message::error_line(flags.message_format, &error));
            fct::end_with(error.exit_code())
        }
    }
}

fn work(flags: &Flags) -> Result<ExitCode, Error> {
    let start = Instant::now();
    let settings = Settings::from_flags(flags)?;
    // Before the temporaries are made, so that no signal can leave one behind.
    let interrupt = Interrupt::watch();
    let outputs = Outputs::prepare(&settings)?;
    let progress = Arc::new(Progress::new(settings.progress));
    let ended = job::run(&settings, &progress, &interrupt);
    let made = match ended {
        Ended::Alone(made) => made.inspect_err(|_| progress.clear())?,
        Ended::BySignal(exit) => {
            progress.clear();
            drop(outputs);
            tell(&message::interrupted_line(flags.message_format, exit, "nothing was written"));
            return Ok(fct::end_with(exit));
        }
    };
    // The last step takes seconds and ends with a whole file, so it is not interrupted.
    progress.tell(Stage::Write.into(), 0, 1);
    let report = write(&settings, outputs, &made, start);
    progress.clear();
    let report = report?;

    warn(flags.message_format, &settings, &made);
    print(&report.to_text())?;
    if let Some(exit) = interrupt.exit_code() {
        // Whoever has pressed Ctrl-C does not want the next one of a loop either.
        tell(&message::interrupted_line(flags.message_format, exit, "the tree is complete and in its place"));
        return Ok(fct::end_with(exit));
    }
    Ok(ExitCode::SUCCESS)
}

/// Moves the tree and the report to their places, once both are on the disk.
fn write(settings: &Settings, outputs: Outputs, made: &Made, start: Instant) -> Result<Report, Error> {
    let before = Instant::now();
    let tree = outputs.tree.complete(&made.built.data(), made.source_id).map_err(output::writer_error)?;
    let report = Report::new(settings, made, tree.written(), before.elapsed(), start.elapsed());
    if let Some(pending) = &outputs.report {
        pending.write(&report.to_json())?;
    }
    tree.publish().map_err(output::writer_error)?;
    if let Some(pending) = outputs.report {
        pending.publish().map_err(|e| e.remedy("the tree is complete and in its place"))?;
    }
    Ok(report)
}

fn warn(format: MessageFormat, settings: &Settings, made: &Made) {
    let file = match settings.inputs.as_slice() {
        [only] => Some(only.as_path()),
        _ => None,
    };
    for notice in message::notices(&made.built.tally) {
        tell(&message::warning_line(format, file, &notice));
    }
}

/// Tells of wrong usage as JSON, out of the text that the flags' library has for people.
pub(crate) fn tell_usage(text: &str) {
    let error = Error::new(ErrorKind::Usage, "FC100", usage_sentence(text)).remedy("see fcbuild --help");
    tell(&message::error_line(MessageFormat::Json, &error));
}

/// Text on standard output.
fn print(text: &str) -> Result<(), Error> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        // A reader that went away, as `head` does, has seen enough.
        Err(e) if e.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        Err(e) => Err(Error::new(ErrorKind::Io, "FC413", format!("cannot write to standard output: {e}"))
            .remedy("the tree is complete and in its place")),
        Ok(()) => Ok(()),
    }
}
