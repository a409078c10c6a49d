//! What can go wrong, said so that the reader knows what, where and what to do.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use crate::rule::Rule;

/// Why a file could not be read, verified or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The system refused.
    #[error("{}: {what}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What was being done, as "cannot ...".
        what: String,
        /// What the system said.
        source: io::Error,
    },
    /// The output is there already and may not be replaced.
    #[error("{}: the file exists; give --force to replace it", path.display())]
    Exists {
        /// The output.
        path: PathBuf,
    },
    /// The output is there already, may be replaced, and is something else than a tree.
    #[error("{}: the file is no .fct file and is left alone; give the output another name", path.display())]
    NotATree {
        /// The output.
        path: PathBuf,
    },
    /// No file can be made in the folder of the output.
    #[error("{}: {problem}; {remedy}", path.display())]
    Folder {
        /// The output.
        path: PathBuf,
        /// What is wrong, with the folder's name.
        problem: String,
        /// What the user can do about it.
        remedy: &'static str,
    },
    /// The path names a directory, a pipe or a device.
    #[error("{}: not a regular file; give the path of a .fct file", path.display())]
    NotAFile {
        /// The path.
        path: PathBuf,
    },
    /// More than the format or this machine can hold.
    #[error("{}: {found}; the limit is {limit}", path.display())]
    Limit {
        /// The file.
        path: PathBuf,
        /// What was asked for.
        found: String,
        /// What is possible.
        limit: String,
    },
    /// The bytes break a rule of the format.
    #[error("{}: {violation}", path.display())]
    Invalid {
        /// The file.
        path: PathBuf,
        /// Which rule, where, and what stands there.
        violation: Box<Violation>,
    },
}

impl Error {
    /// The exit code of a program that ends with this error: 4 for the system, 5 for a limit, 7 for a broken or unsupported file.
    pub const fn exit_code(&self) -> u8 {
        match self {
            Self::Io { .. }
            | Self::Exists { .. }
            | Self::NotATree { .. }
            | Self::Folder { .. }
            | Self::NotAFile { .. } => 4,
            Self::Limit { .. } => 5,
            Self::Invalid { .. } => 7,
        }
    }

    /// A stable code for this kind of error, such as `FC705`.
    pub const fn code(&self) -> &'static str {
        match self {
            Self::Io { .. } | Self::Folder { .. } => "FC471",
            Self::Exists { .. } => "FC472",
            Self::NotAFile { .. } => "FC473",
            Self::NotATree { .. } => "FC474",
            Self::Limit { .. } => "FC571",
            Self::Invalid { violation, .. } => violation.rule.code(),
        }
    }

    /// The rule that a file breaks, if that is the error.
    pub const fn rule(&self) -> Option<Rule> {
        match self {
            Self::Invalid { violation, .. } => Some(violation.rule),
            _ => None,
        }
    }

    pub(crate) fn io(path: &Path, what: impl Into<String>) -> impl FnOnce(io::Error) -> Self {
        let (path, what) = (path.to_owned(), what.into());
        move |source| Self::Io { path, what, source }
    }

    pub(crate) fn limit(path: &Path, found: impl Into<String>, limit: impl Into<String>) -> Self {
        Self::Limit { path: path.to_owned(), found: found.into(), limit: limit.into() }
    }
}

/// A broken rule: which, where, and what was found there.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Violation {
    /// The rule.
    pub rule: Rule,
    /// The place: header field, section, record index, byte.
    pub place: String,
    /// What stands there, as a clause; says what was expected where the rule alone does not.
    pub found: String,
    /// What the user can do about it, where what was found tells more than the rule.
    pub remedy: Option<&'static str>,
}

impl Violation {
    pub(crate) fn new(rule: Rule, place: String, found: String) -> Box<Self> {
        Box::new(Self { rule, place, found, remedy: None })
    }

    /// For the fields of the header, which have fixed places.
    pub(crate) fn in_header(rule: Rule, byte: usize, found: impl Into<String>) -> Box<Self> {
        Self::new(rule, format!("header byte {byte}"), found.into())
    }

    pub(crate) fn at(self: Box<Self>, path: &Path) -> Error {
        Error::Invalid { path: path.to_owned(), violation: self }
    }
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { rule, place, found, remedy } = self;
        let (name, promise, remedy) = (rule.name(), rule.promise(), remedy.unwrap_or(rule.remedy()));
        write!(f, "{place}: {found} (rule {name}: {promise}); {remedy}")
    }
}
