//! What can go wrong, with the exit code and the message code of each case.
//!
//! # Codes
//!
//! | code | exit | meaning |
//! |------|------|---------|
//! | FC100 | 2 | wrong usage, as JSON alone has a code for it |
//! | FC101 | 2 | the output is the input |
//! | FC111 | 2 | flags that do not go together with each other or with the files |
//! | FC112 | 2 | the selection has no triangles |
//! | FC113 | 2 | the selection has a number that cannot be used |
//! | FC351 | 0 | warning: an error that is large beside the model |
//! | FC352 | 0 | warning: a budget that is missed by far, as no split that is left fits |
//! | FC353 | 0 | warning: a region in which nothing of the model lies |
//! | FC412 | 4 | the mesh cannot be written |
//! | FC413 | 4 | standard output cannot be written |
//! | FC471 | 4 | the tree cannot be read |
//! | FC472 | 4 | the output exists |
//! | FC473 | 4 | a path names no regular file |
//! | FC474 | 4 | the file to be replaced is no mesh that fct has written |
//! | FC507 | 5 | a thread cannot be started |
//! | FC511 | 5 | not even the coarsest mesh is within the budget |
//! | FC512 | 5 | the mesh is too large for 32-bit indices |
//! | FC571 | 5 | the tree is too large for this machine |
//! | FC701 to FC764 | 7 | a rule of the format is broken, see its specification |
//! | FC901 | 1 | a bug in this program |
//! | FC902 | 129, 130, 131, 143, 152 | a signal stopped the program |

use crate::counted::counted;
use fct::grouped;
use std::io;
use std::path::PathBuf;

/// An error of the command; its text says what happened, where, and what to do.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Error {
    /// Flags that make no sense together with each other or with the files.
    #[error("{0}")]
    Usage(String),
    /// The output is the input.
    #[error("{}: the output is the input; give the output another name", path.display())]
    Same {
        /// The output.
        path: PathBuf,
    },
    /// The selection has no triangles.
    #[error("the selection has no triangles at all, so nothing is written; allow a smaller error")]
    Empty,
    /// The output is there already.
    #[error("{}: the file exists; give --force to replace it", path.display())]
    Exists {
        /// The output.
        path: PathBuf,
    },
    /// The output is there, may be replaced, and is something else than what this program has written.
    #[error("{}: the file was not written by fct and is left alone; give the output another name", path.display())]
    NotAnExport {
        /// The output.
        path: PathBuf,
    },
    /// The output is a directory, a pipe or a device.
    #[error("{}: not a regular file; give the path of a .ply, .obj or .glb file", path.display())]
    NotAFile {
        /// The output.
        path: PathBuf,
    },
    /// The system refused to write.
    #[error("{}: {what}: {source}", path.display())]
    Write {
        /// The output.
        path: PathBuf,
        /// What was being done, as "cannot ...".
        what: &'static str,
        /// What the system said.
        source: io::Error,
    },
    /// The place of the output cannot be used, or the system refuses to fill it.
    #[error(transparent)]
    Place(fct::Error),
    /// No thread can be had.
    #[error("a thread cannot be started: {0}; end other programs or raise their limit")]
    Thread(io::Error),
    /// A signal asked the program to stop.
    #[error("stopped by a signal; nothing was written")]
    Interrupted {
        /// 128 + the signal's number, as shells have it.
        exit: u8,
    },
    /// A signal asked the program to stop when it was about to end.
    #[error("stopped by a signal; all that was asked for is complete and in its place")]
    InterruptedLate {
        /// 128 + the signal's number, as shells have it.
        exit: u8,
    },
    /// Standard output cannot be written.
    #[error("cannot write to standard output: {0}")]
    Stdout(io::Error),
    /// Not even the coarsest mesh is within the budget.
    #[error(
        "{}: even the coarsest mesh has {}, more than the {} asked for; ask for {found} or more",
        path.display(),
        counted(*found, things, &format!("{things}s")),
        grouped(*asked)
    )]
    Budget {
        /// The tree.
        path: PathBuf,
        /// `triangle` or `cluster`.
        things: &'static str,
        /// The number asked for.
        asked: u64,
        /// The number there is at least.
        found: u64,
    },
    /// The mesh is too large for 32-bit indices.
    #[error(transparent)]
    Extract(fcextract::Error),
    /// The tree cannot be read or breaks a rule.
    #[error(transparent)]
    Tree(#[from] fct::Error),
    /// A panic was caught.
    #[error(
        "fct failed by a bug of its own; please report it with the command, the file and the lines above"
    )]
    Bug,
}

impl From<fct::Stopped> for Error {
    fn from(stopped: fct::Stopped) -> Error {
        match stopped {
            fct::Stopped::BySignal(exit) => Error::Interrupted { exit },
            fct::Stopped::NoThread(error) => Error::Thread(error),
            // It has said so.
            fct::Stopped::Panicked => Error::Bug,
        }
    }
}

impl From<fcextract::Error> for Error {
    fn from(error: fcextract::Error) -> Error {
        match error {
            fcextract::Error::Tree(error) => Error::Tree(error),
            other => Error::Extract(other),
        }
    }
}

impl Error {
    /// The process's exit code: 1 our bug, 2 usage, 4 input or output, 5 a limit, 7 an invalid .fct file, and that of
    /// a signal.
    pub(crate) fn exit_code(&self) -> u8 {
        match self {
            Error::Bug => 1,
            Error::Usage(_) | Error::Same { .. } | Error::Empty => 2,
            Error::Extract(fcextract::Error::Selection(_)) => 2,
            Error::Exists { .. }
            | Error::NotAnExport { .. }
            | Error::NotAFile { .. }
            | Error::Write { .. }
            | Error::Stdout(_) => 4,
            Error::Place(error) => error.exit_code(),
            Error::Budget { .. } | Error::Extract(_) | Error::Thread(_) => 5,
            Error::Interrupted { exit } | Error::InterruptedLate { exit } => *exit,
            Error::Tree(error) => error.exit_code(),
        }
    }

    /// The stable code that stands in front of the message, such as `FC112`.
    pub(crate) fn code(&self) -> &'static str {
        match self {
            Error::Same { .. } => "FC101",
            Error::Usage(_) => "FC111",
            Error::Empty => "FC112",
            Error::Extract(fcextract::Error::Selection(_)) => "FC113",
            Error::Write { .. } | Error::Place(_) => "FC412",
            Error::Stdout(_) => "FC413",
            Error::Exists { .. } => "FC472",
            Error::NotAFile { .. } => "FC473",
            Error::NotAnExport { .. } => "FC474",
            Error::Thread(_) => "FC507",
            Error::Budget { .. } => "FC511",
            Error::Extract(_) => "FC512",
            Error::Tree(error) => error.code(),
            Error::Bug => "FC901",
            Error::Interrupted { .. } | Error::InterruptedLate { .. } => "FC902",
        }
    }
}
