//! The file that is read: its size at the start, its name, and the limits that apply.

use std::io::{Cursor, Read as _, Seek as _, SeekFrom};
use std::path::Path;

use super::ImportOptions;
use super::window::{Stream, Window};
use crate::error::{Error, ErrorKind};

/// An opened input.
pub(super) struct Source<'a> {
    path: &'a Path,
    stream: Box<dyn Stream + 'a>,
    size: u64,
    options: &'a ImportOptions<'a>,
}

impl<'a> Source<'a> {
    /// Opens a regular file.
    pub(super) fn open(path: &'a Path, options: &'a ImportOptions<'a>) -> Result<Self, Error> {
        let meta = std::fs::metadata(path).map_err(|e| Error::io("FC401", path, "cannot open", &e))?;
        if !meta.is_file() {
            let what = if meta.is_dir() { "a directory" } else { "no regular file" };
            return Err(Error::new(ErrorKind::Io, "FC402", format!("is {what}"))
                .in_file(path)
                .remedy("name a mesh file (.ply, .obj, .stl, .gltf, .glb)"));
        }
        let file = std::fs::File::open(path).map_err(|e| Error::io("FC401", path, "cannot open", &e))?;
        Ok(Self { path, stream: Box::new(file), size: meta.len(), options })
    }

    /// Takes bytes in memory for the content of a file at `path`.
    pub(super) fn from_bytes(path: &'a Path, bytes: &'a [u8], options: &'a ImportOptions<'a>) -> Self {
        Self { path, stream: Box::new(Cursor::new(bytes)), size: bytes.len() as u64, options }
    }

    /// The path as the user gave it.
    pub(super) fn path(&self) -> &'a Path {
        self.path
    }

    /// The size in bytes when the file was opened.
    pub(super) fn size(&self) -> u64 {
        self.size
    }

    /// The name of the file without folder and extension.
    pub(super) fn stem(&self) -> String {
        self.path.file_stem().map_or_else(|| "mesh".to_owned(), |s| s.to_string_lossy().into_owned())
    }

    /// The most triangles that are allowed.
    pub(super) fn max_faces(&self) -> u64 {
        self.options.max_faces
    }

    /// Where progress goes.
    pub(super) fn progress(&self) -> &'a (dyn Fn(u64, u64) + Sync) {
        self.options.progress
    }

    /// A window from the current place on.
    pub(super) fn window(&mut self) -> Window<'_> {
        Window::new(&mut self.stream, self.size, self.options.progress)
    }

    /// Goes back to the start.
    pub(super) fn rewind(&mut self) -> Result<(), Error> {
        match self.stream.seek(SeekFrom::Start(0)) {
            Ok(_) => Ok(()),
            Err(e) => Err(self.read_error(&e)),
        }
    }

    /// The first bytes, at most `n`; afterwards the source stands at the start again.
    pub(super) fn first_bytes(&mut self, n: u64) -> Result<Vec<u8>, Error> {
        let mut bytes = Vec::new();
        if let Err(e) = (&mut self.stream).take(n).read_to_end(&mut bytes) {
            return Err(self.read_error(&e));
        }
        self.rewind()?;
        Ok(bytes)
    }

    /// All bytes, at most `limit`, with room made once.
    pub(super) fn all_bytes(&mut self, limit: u64) -> Result<Vec<u8>, Error> {
        let mut bytes = Vec::new();
        super::faces::reserve(&mut bytes, self.size.min(limit), "bytes of the file")?;
        match (&mut self.stream).take(self.size.min(limit)).read_to_end(&mut bytes) {
            Ok(_) => Ok(bytes),
            Err(e) => Err(self.read_error(&e)),
        }
    }

    /// An error of the operating system while reading.
    pub(super) fn read_error(&self, e: &std::io::Error) -> Error {
        Error::io("FC403", self.path, "cannot read", e)
    }

    /// Refuses when the file has another size than when it was opened.
    pub(super) fn check_unchanged(&mut self) -> Result<(), Error> {
        let now = match self.stream.seek(SeekFrom::End(0)) {
            Ok(now) => now,
            Err(e) => return Err(self.read_error(&e)),
        };
        if now == self.size {
            return Ok(());
        }
        Err(Error::new(
            ErrorKind::Io,
            "FC403",
            format!("the size changed from {} to {now} bytes while it was read", self.size),
        )
        .in_file(self.path)
        .remedy("wait until the file is complete")
        .limit(self.size, now))
    }
}
