//! Progress on standard error.

use super::settings::ProgressForm;
use fcbuild::Phase;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

/// A part of the job, as the user sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stage {
    /// Reading, in bytes.
    Import,
    /// Building, in faces.
    Build(Phase),
    /// Writing.
    Write,
}

impl Stage {
    fn name(self) -> &'static str {
        match self {
            Stage::Import => "import",
            Stage::Build(phase) => phase.as_str(),
            Stage::Write => "write",
        }
    }

    /// Whether it tells of more than its begin.
    fn counts(self) -> bool {
        matches!(self, Stage::Import | Stage::Build(Phase::Partition | Phase::Bounds))
    }

    /// A number other than 0 for each stage.
    fn number(self) -> usize {
        match self {
            Stage::Import => 1,
            Stage::Build(phase) => 2 + phase as usize,
            Stage::Write => usize::MAX,
        }
    }
}

/// Shows how far the job is; to be told from any thread, often.
pub(crate) struct Progress {
    shown: AtomicUsize,
    form: Form,
}

enum Form {
    Off,
    Bar(ProgressBar),
    /// The tenths that were last written down.
    Lines(Mutex<(usize, u64)>),
}

impl Progress {
    /// Shows nothing until it is told something.
    pub(crate) fn new(form: ProgressForm) -> Progress {
        let form = match form {
            ProgressForm::Off => Form::Off,
            ProgressForm::Lines => Form::Lines(Mutex::new((0, 0))),
            ProgressForm::Bar => {
                let bar = ProgressBar::with_draw_target(Some(1), ProgressDrawTarget::stderr());
                bar.set_style(style(true));
                // Some phases have no steps to tell of; the clock shows that they live.
                bar.enable_steady_tick(Duration::from_millis(200));
                Form::Bar(bar)
            }
        };
        Progress { shown: AtomicUsize::new(0), form }
    }

    /// Tells that `done` of `total` are done.
    pub(crate) fn tell(&self, stage: Stage, done: u64, total: u64) {
        match &self.form {
            Form::Off => {}
            Form::Bar(bar) => {
                // Setting a message takes a lock, which is worth it only when the stage is a new one.
                if self.shown.swap(stage.number(), Ordering::Relaxed) != stage.number() {
                    // First of all: the new stage has not begun where the last one ended.
                    bar.set_position(0);
                    bar.set_style(style(stage.counts()));
                    bar.set_message(stage.name());
                    bar.set_length(total.max(1));
                }
                bar.set_position(done);
            }
            Form::Lines(last) => {
                let tenths = done.saturating_mul(10).checked_div(total).unwrap_or(0);
                let Ok(mut last) = last.lock() else { return };
                if *last != (stage.number(), tenths) {
                    *last = (stage.number(), tenths);
                    say(&match stage.counts() {
                        true => format!("{} {} %", stage.name(), tenths * 10),
                        false => stage.name().to_owned(),
                    });
                }
            }
        }
    }

    /// Says a sentence between the steps.
    pub(crate) fn note(&self, sentence: &str) {
        match &self.form {
            Form::Off => {}
            Form::Bar(bar) => bar.suspend(|| say(sentence)),
            Form::Lines(_) => say(sentence),
        }
    }

    /// Takes the bar away, so that what follows stands alone.
    pub(crate) fn clear(&self) {
        if let Form::Bar(bar) = &self.form {
            bar.finish_and_clear();
        }
    }
}

/// A bar for what counts, the clock alone for what does not.
fn style(counts: bool) -> ProgressStyle {
    let template = match counts {
        true => "{msg:10} [{bar:40}] {percent:>3} % {elapsed}",
        false => "{msg:10} {spinner} {elapsed}",
    };
    let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
    style.progress_chars("=> ").tick_chars("-\\|/ ")
}

/// Progress is a courtesy: where standard error cannot be written the job goes on.
fn say(line: &str) {
    use std::io::Write as _;
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}
