//! The last net: a panic becomes an error that asks for a report.

use fcbuild::Error;
use fcbuild::error::ErrorKind;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Mutex;

/// The exit code and class of a bug.
pub(crate) const CODE: &str = "FC901";

static LAST_PANIC: Mutex<Option<String>> = Mutex::new(None);

/// Keeps what panics say for the one message at the end, instead of printing it where it happens.
///
/// With `RUST_BACKTRACE` set the usual text and backtrace appear as well.
pub(crate) fn remember_panics() {
    let usual = panic::take_hook();
    let print_too = std::env::var_os("RUST_BACKTRACE").is_some();
    panic::set_hook(Box::new(move |info| {
        let said = info.payload_as_str().unwrap_or("no message");
        let place = info.location().map_or_else(|| "unknown place".to_owned(), ToString::to_string);
        if let Ok(mut last) = LAST_PANIC.lock() {
            *last = Some(format!("{place}: {said}"));
        }
        if print_too {
            usual(info);
        }
    }));
}

/// Where the last panic happened and what it said.
pub(crate) fn last_panic() -> Option<String> {
    LAST_PANIC.lock().ok()?.clone()
}

/// Runs `job`; its panic is an error.
pub(crate) fn caught<T>(job: impl FnOnce() -> Result<T, Error>) -> Result<T, Error> {
    // Whatever the job leaves half done is dropped with it, so no broken state can be seen.
    panic::catch_unwind(AssertUnwindSafe(job)).unwrap_or_else(|_| {
        Err(Error::new(ErrorKind::Internal, CODE, "fcbuild failed by a bug of its own")
            .remedy("please report it with the command and the input"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_an_error_with_exit_code_1() {
        let error = caught::<()>(|| panic!("out of coffee")).unwrap_err();
        assert_eq!((error.exit_code(), error.code()), (1, CODE));
        assert!(error.to_string().contains("please report"));
        assert_eq!(caught(|| Ok(7)).unwrap(), 7);
    }
}
