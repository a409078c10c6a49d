//! How far a command is, on standard error.

use std::io::{IsTerminal as _, Write as _};
use std::str::FromStr;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// A part of a job, as the user sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stage {
    /// A number other than 0 that no other stage of the job has.
    pub number: usize,
    /// What is being done, a word.
    pub name: &'static str,
    /// Whether it tells of more than its begin.
    pub counts: bool,
}

/// When progress is shown: the values of a flag.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShowProgress {
    /// `auto`: when standard error is a terminal and messages are for people.
    Auto,
    /// `always`: also where it is none, as lines.
    Always,
    /// `never`.
    Never,
}

impl FromStr for ShowProgress {
    type Err = String;

    fn from_str(text: &str) -> Result<ShowProgress, String> {
        match text {
            "auto" => Ok(ShowProgress::Auto),
            "always" => Ok(ShowProgress::Always),
            "never" => Ok(ShowProgress::Never),
            _ => Err("expected auto, always or never".to_owned()),
        }
    }
}

/// How progress is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProgressForm {
    /// Not at all.
    Off,
    /// A bar that moves.
    Bar,
    /// A line now and then, for logs.
    Lines,
}

impl ProgressForm {
    /// What a flag comes to here. `for_programs`: messages are for programs, whose lines a bar would garble.
    pub fn here(show: ShowProgress, for_programs: bool) -> ProgressForm {
        match (show, std::io::stderr().is_terminal()) {
            (ShowProgress::Never, _) | (ShowProgress::Auto, false) => ProgressForm::Off,
            (ShowProgress::Auto, true) if for_programs => ProgressForm::Off,
            (_, true) => ProgressForm::Bar,
            (ShowProgress::Always, false) => ProgressForm::Lines,
        }
    }
}

/// Shows how far a job is; to be told from any thread, often.
#[derive(Debug)]
pub struct Progress {
    shown: AtomicUsize,
    form: Form,
}

#[derive(Debug)]
enum Form {
    Off,
    Bar(ProgressBar),
    /// The stage and the tenths that were last written down.
    Lines(Mutex<(usize, u64)>),
}

impl Progress {
    /// Shows nothing until it is told something.
    pub fn new(form: ProgressForm) -> Progress {
        let form = match form {
            ProgressForm::Off => Form::Off,
            ProgressForm::Lines => Form::Lines(Mutex::new((0, 0))),
            ProgressForm::Bar => {
                let bar = ProgressBar::with_draw_target(Some(1), ProgressDrawTarget::stderr());
                bar.set_style(style(true));
                // Some stages have no steps to tell of; the clock shows that they live.
                bar.enable_steady_tick(Duration::from_millis(200));
                Form::Bar(bar)
            }
        };
        Progress { shown: AtomicUsize::new(0), form }
    }

    /// Tells that `done` of `total` are done.
    pub fn tell(&self, stage: Stage, done: u64, total: u64) {
        match &self.form {
            Form::Off => {}
            Form::Bar(bar) => {
                // Setting a message takes a lock, which is worth it only when the stage is a new one.
                if self.shown.swap(stage.number, Ordering::Relaxed) != stage.number {
                    // First of all: the new stage has not begun where the last one ended.
                    bar.set_position(0);
                    bar.set_style(style(stage.counts));
                    bar.set_message(stage.name);
                    bar.set_length(total.max(1));
                }
                bar.set_position(done);
            }
            Form::Lines(last) => {
                let tenths = done.saturating_mul(10).checked_div(total).unwrap_or(0);
                let Ok(mut last) = last.lock() else { return };
                if *last != (stage.number, tenths) {
                    *last = (stage.number, tenths);
                    say(&match stage.counts {
                        true => format!("{} {} %", stage.name, tenths.saturating_mul(10)),
                        false => stage.name.to_owned(),
                    });
                }
            }
        }
    }

    /// Says a sentence between the steps.
    pub fn note(&self, sentence: &str) {
        match &self.form {
            Form::Off => {}
            Form::Bar(bar) => bar.suspend(|| say(sentence)),
            Form::Lines(_) => say(sentence),
        }
    }

    /// Takes the bar away, so that what follows stands alone.
    pub fn clear(&self) {
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
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flag_that_is_told_what_to_do_does_it() {
        assert_eq!("always".parse(), Ok(ShowProgress::Always));
        assert!("sometimes".parse::<ShowProgress>().is_err_and(|error| error.contains("never")));
        assert_eq!(ProgressForm::here(ShowProgress::Never, false), ProgressForm::Off);
        assert_ne!(ProgressForm::here(ShowProgress::Always, true), ProgressForm::Off);
    }
}
