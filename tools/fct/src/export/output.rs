//! The rules for the output, checked before the work.

use crate::error::Error;
use fct::Pending;
use std::fs;
use std::path::Path;

/// Checks the place and makes a temporary beside it, so that an unwritable place is known before the work.
///
/// # Errors
/// Usage when the output is the input, I/O when it exists and may not be replaced or its folder is not writable.
pub(crate) fn prepare(target: &Path, input: &Path, overwrite: bool) -> Result<Pending, Error> {
    let path = target.to_owned();
    if is_same_file(target, input) {
        return Err(Error::Same { path });
    }
    match fs::metadata(target) {
        Ok(found) if !found.is_file() => Err(Error::NotAFile { path }),
        _ => Pending::create(target, overwrite).map_err(refused),
    }
}

/// Brings what was written to the disk and moves the file to its place.
///
/// # Errors
/// I/O, with an old file untouched.
pub(crate) fn publish(pending: Pending) -> Result<(), Error> {
    pending.sync().and_then(|()| pending.publish()).map_err(refused)
}

/// What the format says about a place, as an error about a mesh.
fn refused(error: fct::Error) -> Error {
    match error {
        fct::Error::Exists { path } => Error::Exists { path },
        fct::Error::NotAFile { path } => Error::NotAFile { path },
        other => Error::Place(other),
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
