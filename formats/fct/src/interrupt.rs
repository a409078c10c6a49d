//! Signals: Ctrl-C, termination, a terminal that goes away and a limit on processor time end a program in good order.

use std::io;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::thread;
use std::time::Duration;

use signal_hook::{consts, flag};

/// How long a signal may wait to be noticed.
const LISTEN_EVERY: Duration = Duration::from_millis(50);

/// How long a signal has to be heard and its temporaries to be removed, before a further one ends the process.
const PATIENCE: Duration = Duration::from_secs(1);

/// Watches for signals that ask the program to stop: SIGINT, SIGTERM and, where the system has them, SIGHUP, SIGQUIT and
/// SIGXCPU.
///
/// The first one only raises a flag, so that temporaries can be removed. One that comes a second later or more ends the
/// process at once, in case the first is not heard; until then it changes nothing, since `timeout` and terminals send a
/// signal to a process and to its group. When all is removed, [`end_with`] ends the process.
#[derive(Debug)]
pub struct Interrupt {
    caught: Vec<(u8, Arc<AtomicBool>)>,
}

/// Why [`Interrupt::wait_for`] has no result.
#[derive(Debug)]
pub enum Stopped {
    /// By a signal; 128 and its number, as shells have it. The job's thread still runs and ends with the process.
    BySignal(u8),
    /// No thread can be had.
    NoThread(io::Error),
    /// The job has panicked.
    Panicked,
}

impl Interrupt {
    /// Watches from now on. Where the system does not allow it, signals keep their usual effect.
    ///
    /// A signal that the program was started to ignore stays ignored, as under `nohup`.
    /// A file that outgrows a limit ends nothing any more: writing it fails instead.
    pub fn watch() -> Self {
        let impatient = Arc::new(AtomicBool::new(false));
        let signals = watched().filter_map(|(exit, signal)| {
            let raised = Arc::new(AtomicBool::new(false));
            end_at_once_if(&impatient, exit, signal).ok()?;
            flag::register(signal, Arc::clone(&raised)).ok()?;
            Some((exit, raised))
        });
        let caught: Vec<(u8, Arc<AtomicBool>)> = signals.collect();
        let flags: Vec<_> = caught.iter().map(|(_, raised)| Arc::clone(raised)).collect();
        // Without the thread no signal ends the process before its temporaries are removed.
        let _ = thread::Builder::new().name("patience".to_owned()).spawn(move || {
            while !flags.iter().any(|raised| raised.load(Ordering::Relaxed)) {
                thread::sleep(LISTEN_EVERY);
            }
            thread::sleep(PATIENCE);
            impatient.store(true, Ordering::Relaxed);
        });
        // With a handler, whatever it does, the system says EFBIG to the one who writes.
        #[cfg(unix)]
        let _ = flag::register(consts::SIGXFSZ, Arc::default());
        Self { caught }
    }

    /// The exit code of the signal that was caught, if one was: 128 and its number.
    pub fn exit_code(&self) -> Option<u8> {
        self.caught.iter().find(|(_, raised)| raised.load(Ordering::Relaxed)).map(|(exit, _)| *exit)
    }

    /// Runs a job in a thread and waits for its end, or for a signal.
    ///
    /// What has to be removed when a signal comes belongs to the caller, not to the job.
    ///
    /// # Errors
    /// [`Stopped`] when the job has no result.
    pub fn wait_for<T: Send + 'static>(
        &self,
        thread: thread::Builder,
        job: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, Stopped> {
        let (sender, receiver) = sync_channel(1);
        thread
            .spawn(move || {
                // Nobody listens any more after a signal.
                let _ = sender.send(job());
            })
            .map_err(Stopped::NoThread)?;
        loop {
            let done = receiver.recv_timeout(LISTEN_EVERY);
            // A signal that comes as the job ends still finds everything as it was.
            if let Some(exit) = self.exit_code() {
                return Err(Stopped::BySignal(exit));
            }
            match done {
                Ok(done) => return Ok(done),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Err(Stopped::Panicked),
            }
        }
    }
}

/// Ends the process with the exit code of an error; to be called last of all in `main`.
///
/// After a signal the process dies by it: a shell that runs a script or a loop stops with the command only then, and
/// says 128 and the number itself.
/// SIGQUIT and SIGXCPU do not dump the memory, which may be many gigabytes, of a program that has ended in good order.
pub fn end_with(code: u8) -> ExitCode {
    #[cfg(unix)]
    if let Some((_, signal)) = SIGNALS.into_iter().find(|(exit, _)| *exit == code) {
        #[cfg(target_os = "linux")]
        let _ = rustix::process::set_dumpable_behavior(rustix::process::DumpableBehavior::NotDumpable);
        // Comes back only where the system refuses.
        let _ = signal_hook::low_level::emulate_default_handler(signal);
    }
    ExitCode::from(code)
}

/// Exit codes and signals.
#[cfg(unix)]
const SIGNALS: [(u8, i32); 5] = [
    (129, consts::SIGHUP),
    (130, consts::SIGINT),
    (131, consts::SIGQUIT),
    (143, consts::SIGTERM),
    (152, consts::SIGXCPU),
];
#[cfg(not(unix))]
const SIGNALS: [(u8, i32); 2] = [(130, consts::SIGINT), (143, consts::SIGTERM)];

/// The signals to watch for: those that the process was not started to ignore, as it is in the background of a shell
/// without job control, where Ctrl-C is for others, or under `nohup`.
fn watched() -> impl Iterator<Item = (u8, i32)> {
    #[cfg(unix)]
    let is_meant = |signal| match is_ignored(signal) {
        Some(ignored) => !ignored,
        // What people and systems send most is cleaned up after where nobody knows.
        None => [consts::SIGINT, consts::SIGTERM].contains(&signal),
    };
    #[cfg(not(unix))]
    let is_meant = |_| true;
    SIGNALS.into_iter().filter(move |(_, signal)| is_meant(*signal))
}

/// Lets the signal end the process if the flag is up: by its usual effect, but for those that dump the memory.
fn end_at_once_if(raised: &Arc<AtomicBool>, exit: u8, signal: i32) -> io::Result<()> {
    let raised = Arc::clone(raised);
    #[cfg(unix)]
    if ![consts::SIGQUIT, consts::SIGXCPU].contains(&signal) {
        return flag::register_conditional_default(signal, raised).map(drop);
    }
    flag::register_conditional_shutdown(signal, i32::from(exit), raised).map(drop)
}

/// Whether the process was started with the signal ignored; `None` where the system does not tell.
#[cfg(unix)]
fn is_ignored(signal: i32) -> Option<bool> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"))?;
    let mask = u64::from_str_radix(mask.trim(), 16).ok()?;
    let bit = u32::try_from(signal).ok()?.checked_sub(1)?;
    Some(mask.checked_shr(bit)? & 1 == 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_job_ends_with_its_result_or_its_panic() {
        let interrupt = Interrupt { caught: Vec::new() };
        let wait = |job: fn() -> u32| interrupt.wait_for(thread::Builder::new(), job);
        assert!(matches!(wait(|| 7), Ok(7)));
        assert!(matches!(wait(|| panic!("out of coffee")), Err(Stopped::Panicked)));
    }

    #[test]
    fn a_signal_ends_the_wait() {
        let raised = Arc::new(AtomicBool::new(true));
        let interrupt = Interrupt { caught: vec![(129, raised)] };
        let done = interrupt.wait_for(thread::Builder::new(), || thread::sleep(Duration::from_secs(3600)));
        assert!(matches!(done, Err(Stopped::BySignal(129))));
    }
}
