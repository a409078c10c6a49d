//! Making a file of any kind appear all at once or not at all.
//!
//! A temporary in the same folder is filled, synced and checked, then renamed over the output; the folder is synced last.
//! Whatever fails before the rename, the output is as it was and the temporary is gone.

use std::fs::{self, File};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::time::Duration;

use tempfile::NamedTempFile;

use crate::error::Error;

/// Names are at most 255 bytes on common file systems: 200 leave room for dots, random characters and the suffix.
const MAX_STEM: usize = 200;

/// A younger leftover may belong to a run that has created its temporary but not locked it yet.
const LEFTOVER_AGE: Duration = Duration::from_secs(60);

/// The same for leftovers under other names, whose places may never be written again, as those of a chain of meshes.
/// A run that has synced its file holds no lock on it while it is checked and renamed: that takes no day.
const OTHERS_AGE: Duration = Duration::from_secs(24 * 60 * 60);

/// A file that is being written beside its final place. Dropping it leaves nothing behind.
///
/// [`crate::Writer`] uses it for trees; programs may use it for whatever else they write.
#[derive(Debug)]
pub struct Pending {
    temporary: NamedTempFile,
    target: PathBuf,
    overwrite: bool,
}

impl Pending {
    /// How the names of temporaries end.
    pub const SUFFIX: &str = ".fct-tmp";

    /// Makes the temporary, so that an unwritable place is known before the long work begins, and removes what
    /// killed runs left there.
    ///
    /// # Errors
    /// [`Error::Exists`] without `overwrite` when something is there, [`Error::NotAFile`] for a directory,
    /// [`Error::Folder`] when the folder is missing or not writable.
    pub fn create(target: &Path, overwrite: bool) -> Result<Self, Error> {
        match fs::symlink_metadata(target) {
            Ok(found) if found.is_dir() => {
                return Err(Error::NotAFile { path: target.to_owned() });
            }
            Ok(_) if !overwrite => {
                return Err(Error::Exists { path: target.to_owned() });
            }
            // Any other trouble with the place shows when the temporary is made.
            _ => {}
        }
        let Some(name) = target.file_name() else {
            return Err(Error::NotAFile { path: target.to_owned() });
        };
        let folder = folder_of(target);
        let prefix = temporary_prefix(&name.to_string_lossy());
        check_folder(&folder, target)?;
        remove_leftovers(&folder, &prefix);
        let temporary = temporary_builder(&prefix)
            .tempfile_in(&folder)
            .map_err(|source| unwritable(&folder, target, source))?;
        // Held until the file is closed: it tells other runs that the temporary is in use.
        // Not every file system can lock; without a lock the age of the temporary protects it.
        let _ = temporary.as_file().try_lock();
        Ok(Self { temporary, target: target.to_owned(), overwrite })
    }

    /// The final place, which errors speak of.
    pub fn target(&self) -> &Path {
        &self.target
    }

    /// The place until then.
    pub fn temporary_path(&self) -> &Path {
        self.temporary.path()
    }

    /// Whether a file that is there may be replaced.
    pub(crate) fn overwrites(&self) -> bool {
        self.overwrite
    }

    /// Where to write until then.
    pub fn file(&self) -> &File {
        self.temporary.as_file()
    }

    pub(crate) fn file_mut(&mut self) -> &mut File {
        self.temporary.as_file_mut()
    }

    /// Brings the bytes to the disk.
    ///
    /// # Errors
    /// [`Error::Io`] when the system refuses.
    pub fn sync(&self) -> Result<(), Error> {
        let file = self.temporary.as_file();
        // Never tried twice: after a failed sync the system may have dropped the pages and say that all is well.
        file.sync_all().map_err(Error::io(&self.target, "cannot bring the file to the disk"))?;
        // On Windows a lock keeps every other handle from reading, also the one that checks the file next.
        // The file was written a moment ago, so its age protects it now.
        let _ = file.unlock();
        Ok(())
    }

    /// Moves the file to its final place. A symbolic link there is replaced, not followed.
    ///
    /// # Errors
    /// [`Error::Exists`] when something has appeared there and may not be replaced, [`Error::Io`] when the system
    /// refuses.
    pub fn publish(self) -> Result<(), Error> {
        let Self { temporary, target, overwrite } = self;
        let result =
            if overwrite { temporary.persist(&target) } else { temporary.persist_noclobber(&target) };
        if let Err(failed) = result {
            return Err(match failed.error.kind() {
                ErrorKind::AlreadyExists => Error::Exists { path: target },
                _ => Error::io(&target, "cannot move the finished file to its place")(failed.error),
            });
        }
        sync_folder(&target)
    }
}

fn folder_of(target: &Path) -> PathBuf {
    match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_owned(),
        _ => PathBuf::from("."),
    }
}

fn check_folder(folder: &Path, target: &Path) -> Result<(), Error> {
    let (problem, remedy) = match fs::metadata(folder) {
        Ok(found) if !found.is_dir() => {
            (format!("{} is no folder", folder.display()), "give a path in a folder")
        }
        Err(e) if e.kind() == ErrorKind::NotFound => {
            (format!("the folder {} does not exist", folder.display()), "make it first")
        }
        // Any other trouble shows when the temporary is made, with what the system says about it.
        _ => return Ok(()),
    };
    Err(Error::Folder { path: target.to_owned(), problem, remedy })
}

/// The error speaks of the folder, not of the temporary, whose name the user has never seen.
fn unwritable(folder: &Path, target: &Path, source: io::Error) -> Error {
    let why = match source.kind() {
        ErrorKind::NotFound => "the system knows no such place".to_owned(),
        ErrorKind::PermissionDenied
        | ErrorKind::ReadOnlyFilesystem
        | ErrorKind::StorageFull
        | ErrorKind::QuotaExceeded => source.kind().to_string(),
        _ => source.to_string(),
    };
    let problem = format!("cannot create a file in the folder {}: {why}", folder.display());
    Error::Folder {
        path: target.to_owned(),
        problem,
        remedy: "choose a folder with room that you can write to",
    }
}

fn temporary_prefix(name: &str) -> String {
    let end = name.floor_char_boundary(MAX_STEM);
    format!(".{}.", name.get(..end).unwrap_or_default())
}

fn temporary_builder(prefix: &str) -> tempfile::Builder<'_, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(prefix).suffix(Pending::SUFFIX);
    #[cfg(unix)]
    {
        // The default is for the owner alone; a published file is like any other, as the umask says.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder
}

/// Removes temporaries of earlier runs that were killed. Best effort: what cannot be removed does no harm.
fn remove_leftovers(folder: &Path, prefix: &str) {
    let Ok(entries) = fs::read_dir(folder) else {
        return;
    };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        let is_temporary = name.starts_with('.') && name.ends_with(Pending::SUFFIX);
        let age = if name.starts_with(prefix) { LEFTOVER_AGE } else { OTHERS_AGE };
        if is_temporary && is_abandoned(&entry, age) {
            let _ = fs::remove_file(entry.path());
        }
    }
}

fn is_abandoned(entry: &fs::DirEntry, least_age: Duration) -> bool {
    let old = entry
        .metadata()
        .ok()
        .filter(fs::Metadata::is_file)
        .and_then(|m| m.modified().ok())
        .and_then(|t| t.elapsed().ok())
        .is_some_and(|age| age > least_age);
    old && File::options().write(true).open(entry.path()).is_ok_and(|file| file.try_lock().is_ok())
}

/// Makes the rename itself last.
#[cfg(unix)]
fn sync_folder(target: &Path) -> Result<(), Error> {
    let folder = folder_of(target);
    let sync = File::open(&folder).and_then(|f| f.sync_all());
    match sync {
        Ok(()) => Ok(()),
        // Some file systems cannot sync a folder; the file is complete and in its place all the same.
        Err(e)
            if matches!(
                e.kind(),
                ErrorKind::InvalidInput | ErrorKind::Unsupported | ErrorKind::PermissionDenied
            ) =>
        {
            Ok(())
        }
        Err(e) => {
            Err(Error::io(target, "the file is in its place, but cannot bring the folder to the disk")(e))
        }
    }
}

#[cfg(not(unix))]
fn sync_folder(_target: &Path) -> Result<(), Error> {
    Ok(())
}
