//! Signals: Ctrl-C and termination end an export in good order.

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Watches for signals that ask the program to stop.
///
/// The first one raises a flag, so that the temporary can be removed; a second one of the same kind ends the process
/// at once, in case the first is not heard.
pub(crate) struct Interrupt {
    caught: Vec<(u8, Arc<AtomicBool>)>,
}

impl Interrupt {
    /// Watches from now on. Where the system does not allow it, signals keep their usual effect.
    pub(crate) fn watch() -> Interrupt {
        // Shells report a process that a signal ended as 128 + the signal's number.
        let caught = [(130_u8, SIGINT), (143, SIGTERM)]
            .into_iter()
            .filter_map(|(exit, signal)| {
                let raised = Arc::new(AtomicBool::new(false));
                // Handlers run in order: the first asks whether the flag is up already, the second raises it.
                flag::register_conditional_shutdown(signal, i32::from(exit), Arc::clone(&raised)).ok()?;
                flag::register(signal, Arc::clone(&raised)).ok()?;
                Some((exit, raised))
            })
            .collect();
        Interrupt { caught }
    }

    /// The exit code of the signal that was caught, if one was.
    pub(crate) fn exit_code(&self) -> Option<u8> {
        self.caught.iter().find(|(_, raised)| raised.load(Ordering::Relaxed)).map(|(exit, _)| *exit)
    }
}
