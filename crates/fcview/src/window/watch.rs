//! `--watch`: whether the files on display were replaced.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

/// Time between two looks. A build takes longer; looking is cheap, but on a network not free.
const PAUSE: Duration = Duration::from_secs(1);

/// What tells one file from the next of its name: when it was written, and its length.
type Stamp = Option<(SystemTime, u64)>;

/// Files that are looked at from time to time.
pub(super) struct Watch {
    files: Vec<(PathBuf, Stamp)>,
    next: Instant,
}

impl Watch {
    pub(super) fn new(files: &[PathBuf]) -> Watch {
        let files = files.iter().map(|file| (file.clone(), stamp(file))).collect();
        Watch { files, next: Instant::now() + PAUSE }
    }

    /// When to look again.
    pub(super) fn next(&self) -> Instant {
        self.next
    }

    /// Looks, if it is time. True if a file is another one than at the last look, and all are there.
    pub(super) fn changed(&mut self) -> bool {
        let now = Instant::now();
        if now < self.next {
            return false;
        }
        self.next = now + PAUSE;
        let stamps: Vec<Stamp> = self.files.iter().map(|(file, _)| stamp(file)).collect();
        // One that is gone will be there again: it is being replaced.
        if stamps.iter().any(Option::is_none) {
            return false;
        }
        let mut changed = false;
        for ((_, old), new) in self.files.iter_mut().zip(stamps) {
            changed |= *old != new;
            *old = new;
        }
        changed
    }
}

fn stamp(file: &Path) -> Stamp {
    let found = std::fs::metadata(file).ok()?;
    Some((found.modified().ok()?, found.len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_replaced_file_is_noticed_once_and_a_missing_one_not() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.fct");
        std::fs::write(&file, "one").unwrap();
        let mut watch = Watch::new(std::slice::from_ref(&file));
        let mut look = || {
            watch.next = Instant::now();
            watch.changed()
        };
        assert!(!look());
        std::fs::remove_file(&file).unwrap();
        assert!(!look(), "it may come back");
        std::fs::write(&file, "another").unwrap();
        assert!(look());
        assert!(!look());
    }
}
