//! The folder that figures are written to.

use super::picture::Picture;
use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

/// A folder, and how large pictures are in it.
#[derive(Debug)]
pub(crate) struct Output {
    folder: PathBuf,
    /// Pixels of a picture, at most: across and down.
    pub(crate) size: [usize; 2],
}

impl Output {
    /// Makes the folder if it is not there.
    ///
    /// # Errors
    /// The system's, with the folder's name.
    pub(crate) fn create(folder: &Path, quick: bool) -> Result<Output, Box<dyn Error>> {
        fs::create_dir_all(folder).map_err(|e| format!("{}: {e}; choose another --out", folder.display()))?;
        let size = if quick { [240, 200] } else { [480, 440] };
        Ok(Output { folder: folder.to_owned(), size })
    }

    /// Writes a picture and names it on stderr.
    ///
    /// # Errors
    /// The system's, with the file's name.
    pub(crate) fn picture(&self, name: &str, picture: &Picture) -> Result<(), Box<dyn Error>> {
        self.write(name, &picture.to_png()?)
    }

    /// Writes a file and names it on stderr.
    ///
    /// # Errors
    /// The system's, with the file's name.
    pub(crate) fn write(&self, name: &str, bytes: &[u8]) -> Result<(), Box<dyn Error>> {
        let path = self.folder.join(name);
        fs::write(&path, bytes).map_err(|e| format!("{}: {e}; choose a writable --out", path.display()))?;
        eprintln!("{}: {} bytes", path.display(), bytes.len());
        Ok(())
    }
}
