//! The one error type of this crate: what went wrong, where, and what to do about it.
//!
//! # Codes
//! A code is stable: scripts may match on it, and the manual explains it.
//!
//! | code  | exit | meaning |
//! |-------|------|---------|
//! | FC100 | 2 | wrong usage, as JSON alone has a code for it (command) |
//! | FC101 | 2 | an output is an input, or two outputs are one file (command) |
//! | FC102 | 2 | standard input or output in place of a file (command) |
//! | FC103 | 2 | a tree is to be written under the name of a mesh (command) |
//! | FC200 | 3 | the input file is empty |
//! | FC201 | 3 | the content is no mesh format that can be read (gzip, .fct, text of another kind) |
//! | FC202 | 3 | a header or a file's framing is malformed |
//! | FC203 | 3 | an index points past the vertices |
//! | FC204 | 3 | the file ends before its content does |
//! | FC205 | 3 | a declared count is more than the file has room for |
//! | FC206 | 3 | a statement, record or number is malformed |
//! | FC207 | 3 | there are no faces, or none that can be used |
//! | FC208 | 3 | a coordinate property is missing or has a wrong type |
//! | FC209 | 3 | a feature of the format that is not supported |
//! | FC210 | 3 | a text encoding that is not supported |
//! | FC211 | 3 | a scene's structure is broken (cycle, reference to a missing object, bad transform) |
//! | FC212 | 3 | a file refers to another one outside its own folder |
//! | FC213 | 3 | `--strict` refuses what would be repaired (command) |
//! | FC290 | 3 | no face is left after welding and repair |
//! | FC291 | 0 | warning: welded vertices had different colours |
//! | FC292 | 3 | the model is too large or too small for single precision |
//! | FC293 | 0 | warning: the faces look inwards |
//! | FC294 | 0 | warning: the surface is cut at edges (command) |
//! | FC295 | 0 | warning: more groups than a file names |
//! | FC296 | 0 | warning: a merged tree was too deep and was split from the top |
//! | FC297 | 0 | warning: groups of which no face is left |
//! | FC298 | 0 | warning: faces are small beside the rounding to single precision |
//! | FC300 to FC325 | 0 | warnings of the readers (command) |
//! | FC331 to FC335 | 0 | faces dropped, by reason (command) |
//! | FC341 to FC343 | 0 | warnings: what a tree has no place for (command) |
//! | FC401 | 4 | a file cannot be opened |
//! | FC402 | 4 | the path is a directory or another thing that is no regular file |
//! | FC403 | 4 | reading failed, or the file changed while it was read |
//! | FC412 | 4 | the report cannot be written (command) |
//! | FC413 | 4 | standard output cannot be written (command) |
//! | FC471 to FC474 | 4 | an output cannot be written, exists, is no regular file, is something else than a tree |
//! | FC501 | 5 | more faces or vertices than allowed |
//! | FC502 | 5 | a line is too long |
//! | FC503 | 5 | a polygon has too many corners |
//! | FC504 | 5 | a scene is too large or too deep |
//! | FC505 | 5 | memory could not be had |
//! | FC506 | 5 | the job needs more memory than allowed (command) |
//! | FC507 | 5 | the threads cannot be started (command) |
//! | FC571 | 5 | the tree is too large for the format |
//! | FC901 | 1 | a bug in this program |
//! | FC902 | 129, 130, 131, 143, 152 | a signal stopped the job (command) |
//!
//! Those marked "command" are given by the program `fcbuild`, whose module of messages lists its warnings one by one.
//! Rules of the format, FC701 and up, stand in its specification.

use std::fmt;
use std::path::{Path, PathBuf};

/// The class of an [`Error`]; it decides the exit code of the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ErrorKind {
    /// A bug in this program.
    Internal = 1,
    /// Options that make no sense.
    Usage = 2,
    /// Input data that cannot be taken as a mesh.
    BadInput = 3,
    /// The operating system refused: missing file, permission, disk full.
    Io = 4,
    /// A limit on size, depth, memory or time was reached.
    Limit = 5,
    /// A `.fct` file is damaged or not supported.
    InvalidFct = 7,
}

/// Where in a file an error was found; every part may be unknown.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// Line number, from 1.
    pub line: Option<u64>,
    /// Byte offset from the start of the file, from 0.
    pub byte: Option<u64>,
    /// Path into a JSON document, such as `accessors[3].count`.
    pub pointer: Option<String>,
}

/// What went wrong, in which file and where, and what to do.
///
/// The content is boxed so that a `Result` stays small.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Error(Box<Content>);

#[derive(Clone, Debug, PartialEq, Eq)]
struct Content {
    kind: ErrorKind,
    code: &'static str,
    file: Option<PathBuf>,
    place: Place,
    message: String,
    remedy: Option<String>,
    limit: Option<u64>,
    found: Option<u64>,
}

impl Error {
    /// Makes an error of a class with a code from the table above; `message` says what is wrong.
    #[must_use]
    pub fn new(kind: ErrorKind, code: &'static str, message: impl Into<String>) -> Self {
        Self(Box::new(Content {
            kind,
            code,
            file: None,
            place: Place::default(),
            message: message.into(),
            remedy: None,
            limit: None,
            found: None,
        }))
    }

    /// Shorthand for [`ErrorKind::BadInput`].
    #[must_use]
    pub fn bad_input(code: &'static str, message: impl Into<String>) -> Self {
        Self::new(ErrorKind::BadInput, code, message)
    }

    /// An error of the operating system on `file`; `doing` reads like "cannot open".
    #[must_use]
    pub fn io(code: &'static str, file: &Path, doing: &str, error: &std::io::Error) -> Self {
        Self::new(ErrorKind::Io, code, format!("{doing}: {error}")).in_file(file)
    }

    /// Names the file, unless an inner layer has named one already.
    #[must_use]
    pub fn in_file(mut self, file: &Path) -> Self {
        self.0.file.get_or_insert_with(|| file.to_path_buf());
        self
    }

    /// Names the line, from 1.
    #[must_use]
    pub fn at_line(mut self, line: u64) -> Self {
        self.0.place.line = Some(line);
        self
    }

    /// Names the byte offset, from 0.
    #[must_use]
    pub fn at_byte(mut self, byte: u64) -> Self {
        self.0.place.byte = Some(byte);
        self
    }

    /// Names the place in a JSON document, such as `accessors[3].count`.
    #[must_use]
    pub fn at_pointer(mut self, pointer: impl Into<String>) -> Self {
        self.0.place.pointer = Some(pointer.into());
        self
    }

    /// Says what the user can do.
    #[must_use]
    pub fn remedy(mut self, remedy: impl Into<String>) -> Self {
        self.0.remedy = Some(remedy.into());
        self
    }

    /// Records the limit and what was found, for the JSON form.
    #[must_use]
    pub fn limit(mut self, limit: u64, found: u64) -> Self {
        self.0.limit = Some(limit);
        self.0.found = Some(found);
        self
    }

    /// The class.
    #[must_use]
    pub fn kind(&self) -> ErrorKind {
        self.0.kind
    }

    /// The stable code, such as `FC203`.
    #[must_use]
    pub fn code(&self) -> &'static str {
        self.0.code
    }

    /// The exit code of a program that fails with this error.
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        self.0.kind as u8
    }

    /// The file, if one is to blame.
    #[must_use]
    pub fn file(&self) -> Option<&Path> {
        self.0.file.as_deref()
    }

    /// The place in the file; its parts are `None` where unknown.
    #[must_use]
    pub fn place(&self) -> &Place {
        &self.0.place
    }

    /// What is wrong, without file, place and remedy.
    #[must_use]
    pub fn message(&self) -> &str {
        &self.0.message
    }

    /// What was found where a limit was reached.
    #[must_use]
    pub fn found(&self) -> Option<u64> {
        self.0.found
    }

    /// The error as one line of JSON with the keys code, exit, path, line, byte, pointer, message,
    /// remedy, limit and found; unknown ones are null.
    #[must_use]
    pub fn to_json(&self) -> String {
        let c = &self.0;
        serde_json::json!({
            "code": c.code,
            "exit": self.exit_code(),
            "path": c.file.as_ref().map(|p| p.to_string_lossy()),
            "line": c.place.line,
            "byte": c.place.byte,
            "pointer": c.place.pointer,
            "message": c.message,
            "remedy": c.remedy,
            "limit": c.limit,
            "found": c.found,
        })
        .to_string()
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let c = &self.0;
        if let Some(file) = &c.file {
            write!(f, "{}: ", file.display())?;
        }
        match (c.place.line, c.place.byte) {
            (Some(line), Some(byte)) => write!(f, "line {line} (byte {byte}): ")?,
            (Some(line), None) => write!(f, "line {line}: ")?,
            (None, Some(byte)) => write!(f, "byte {byte}: ")?,
            (None, None) => {}
        }
        if let Some(pointer) = &c.place.pointer {
            write!(f, "{pointer}: ")?;
        }
        f.write_str(&c.message)?;
        if let Some(remedy) = &c.remedy {
            write!(f, "; {remedy}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Error {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn display_names_file_place_and_remedy() {
        let e = Error::bad_input("FC203", "face 7 uses vertex 90000 of 35947")
            .in_file(Path::new("scan.ply"))
            .at_line(12)
            .at_byte(318)
            .remedy("export the file again");
        assert_eq!(
            e.to_string(),
            "scan.ply: line 12 (byte 318): face 7 uses vertex 90000 of 35947; export the file again"
        );
        assert_eq!((e.code(), e.exit_code()), ("FC203", 3));
    }

    #[test]
    fn the_inner_file_name_wins() {
        let e = Error::bad_input("FC204", "short").in_file(Path::new("a.bin")).in_file(Path::new("a.gltf"));
        assert_eq!(e.file(), Some(Path::new("a.bin")));
    }

    #[test]
    fn json_holds_every_key() {
        let e = Error::new(ErrorKind::Limit, "FC501", "too many faces").limit(10, 11).at_pointer("meshes[0]");
        let v: serde_json::Value = serde_json::from_str(&e.to_json()).unwrap();
        assert_eq!(v["code"], "FC501");
        assert_eq!((&v["exit"], &v["limit"], &v["found"]), (&5.into(), &10.into(), &11.into()));
        assert!(v["line"].is_null() && v["pointer"] == "meshes[0]");
    }
}
