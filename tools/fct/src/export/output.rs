//! An output that appears all at once or not at all.

use crate::error::Error;
use std::fs::{self, File};
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// Fewer calls of the system than with the default, which shows on large meshes.
const BUFFER: usize = 1 << 20;

/// A file that is being written beside its final place. Dropping it leaves nothing behind.
pub(crate) struct PendingFile {
    temporary: NamedTempFile,
    target: PathBuf,
    overwrite: bool,
}

impl PendingFile {
    /// Checks the place and makes the temporary, so that an unwritable place is known before the work.
    ///
    /// # Errors
    /// Usage when the output is the input, I/O when it exists and may not be replaced or its folder is not writable.
    pub(crate) fn create(target: &Path, input: &Path, overwrite: bool) -> Result<PendingFile, Error> {
        let path = target.to_owned();
        if is_same_file(target, input) {
            return Err(Error::Same { path });
        }
        match fs::metadata(target) {
            Ok(found) if !found.is_file() => return Err(Error::NotAFile { path }),
            _ => {}
        }
        if !overwrite && fs::symlink_metadata(target).is_ok() {
            return Err(Error::Exists { path });
        }
        let folder = match target.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        let mut builder = tempfile::Builder::new();
        builder.prefix(".export.").suffix(".fct-tmp");
        #[cfg(unix)]
        {
            // The default is for the owner alone; an export is a file like any other, as the umask says.
            use std::os::unix::fs::PermissionsExt as _;
            builder.permissions(fs::Permissions::from_mode(0o666));
        }
        match builder.tempfile_in(folder) {
            Ok(temporary) => Ok(PendingFile { temporary, target: path, overwrite }),
            Err(source) => Err(Error::Write { path, what: "cannot create a file in this folder", source }),
        }
    }

    /// Where to write.
    pub(crate) fn writer(&mut self) -> BufWriter<&mut File> {
        BufWriter::with_capacity(BUFFER, self.temporary.as_file_mut())
    }

    /// Brings what was written to the disk and moves the file to its place, if the writing went well.
    ///
    /// # Errors
    /// I/O, with an old file untouched.
    pub(crate) fn finish(self, written: io::Result<()>) -> Result<(), Error> {
        let PendingFile { temporary, target: path, overwrite } = self;
        if let Err(source) = written.and_then(|()| temporary.as_file().sync_all()) {
            return Err(Error::Write { path, what: "cannot write the mesh", source });
        }
        let moved = if overwrite { temporary.persist(&path) } else { temporary.persist_noclobber(&path) };
        match moved {
            Ok(_) => Ok(()),
            Err(e) if e.error.kind() == io::ErrorKind::AlreadyExists => Err(Error::Exists { path }),
            Err(e) => Err(Error::Write {
                path,
                what: "cannot move the finished mesh to its place",
                source: e.error,
            }),
        }
    }
}

/// Whether two paths lead to one existing file, however they are spelled.
fn is_same_file(a: &Path, b: &Path) -> bool {
    #[cfg(unix)]
    if let (Ok(a), Ok(b)) = (fs::metadata(a), fs::metadata(b)) {
        use std::os::unix::fs::MetadataExt as _;
        return (a.dev(), a.ino()) == (b.dev(), b.ino());
    }
    matches!((fs::canonicalize(a), fs::canonicalize(b)), (Ok(a), Ok(b)) if a == b)
}
