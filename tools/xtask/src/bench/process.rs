//! What a program took: time, processor time and memory.

use std::error::Error;
use std::fs;
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Pause between looks at the memory: what is taken and returned within it is missed, and each look takes some
/// microseconds of a processor that is being measured.
const PAUSE: Duration = Duration::from_millis(5);

/// Ticks in a second of the times under /proc, for all of Linux's programs on the platforms that matter.
const TICKS: f64 = 100.0;

/// One run of a program.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Run {
    /// From start to end.
    pub(crate) seconds: f64,
    /// Of all its threads, in the program and in the system; where the system tells.
    pub(crate) processor: Option<f64>,
    /// The most memory that was resident at a time, in bytes; where the system tells.
    pub(crate) peak: Option<u64>,
}

/// Runs a program to its end. Nothing else may run programs meanwhile, or their processor time is counted too.
///
/// # Errors
/// When it cannot be started; what it says when it fails.
pub(crate) fn run(command: &mut Command) -> Result<Run, Box<dyn Error>> {
    let before = processor_of_children();
    let start = Instant::now();
    let child = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn()?;
    let (id, done) = (child.id(), AtomicBool::new(false));
    let (output, seconds, peak) = std::thread::scope(|scope| {
        let watch = scope.spawn(|| {
            let mut peak = None;
            while !done.load(Ordering::Relaxed) {
                // A process that has ended has no memory; the last look before counts.
                peak = peak_of(id).max(peak);
                std::thread::sleep(PAUSE);
            }
            peak
        });
        let output = child.wait_with_output();
        let seconds = start.elapsed().as_secs_f64();
        done.store(true, Ordering::Relaxed);
        (output, seconds, watch.join().unwrap_or(None))
    });
    let output = output?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr).trim().to_owned();
        return Err(format!("{}: {}: {said}", command.get_program().display(), output.status).into());
    }
    let processor = before.zip(processor_of_children()).map(|(before, after)| after - before);
    Ok(Run { seconds, processor, peak })
}

/// High-water mark of a process's resident memory, in bytes.
fn peak_of(process: u32) -> Option<u64> {
    let status = fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

/// Seconds of processor time of all programs that this one has run to their end.
fn processor_of_children() -> Option<f64> {
    let stat = fs::read_to_string("/proc/self/stat").ok()?;
    // The second field is a name in parentheses, which may hold anything; those after it are numbers.
    let (_, fields) = stat.rsplit_once(')')?;
    let ticks = |field: usize| fields.split_whitespace().nth(field - 3)?.parse::<f64>().ok();
    // Fields 16 and 17 count from 1; the first one here is the third.
    Some((ticks(16)? + ticks(17)?) / TICKS)
}

/// The value in the middle; of an even number the lower of the two, nothing of nothing.
pub(crate) fn median(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_unstable_by(f64::total_cmp);
    values.get(values.len().saturating_sub(1) / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_are_in_the_middle() {
        assert_eq!(median([3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!((median([2.0, 1.0]), median([])), (Some(1.0), None));
    }

    #[test]
    fn a_program_that_fails_is_an_error_with_its_words() {
        let error = run(Command::new("sh").args(["-c", "echo out of luck >&2; exit 3"])).unwrap_err();
        assert!(error.to_string().contains("out of luck"), "{error}");
        assert!(run(&mut Command::new("/nowhere/at/all")).is_err());
    }

    /// 64 MB of text in a variable for half a second, most of it at work.
    #[cfg(target_os = "linux")]
    #[test]
    fn time_and_memory_are_those_of_the_program() {
        let script = "x=$(head -c 64000000 /dev/zero | tr '\\0' a); sleep 0.3; : $x";
        let run = run(Command::new("sh").args(["-c", script])).unwrap();
        assert!((0.3..60.0).contains(&run.seconds), "{run:?}");
        assert!(run.peak.is_some_and(|b| (60_000_000..1_000_000_000).contains(&b)), "{run:?}");
        assert!(run.processor.is_some_and(|s| s > 0.0 && s < run.seconds * 4.0), "{run:?}");
    }
}
