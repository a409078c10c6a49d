//! The bytes of a file: mapped, or held in memory.

use std::fs::File;
use std::io;

use memmap2::Mmap;

/// Where a tree's bytes live.
pub(crate) enum Backing {
    /// A read-only map of a file.
    Map(Mmap),
    /// A buffer of our own.
    Bytes(Vec<u8>),
}

impl Backing {
    /// Maps a whole file, which must not be empty.
    #[allow(unsafe_code, reason = "mapping a file is the one thing that std cannot do safely")]
    pub(crate) fn map(file: &File) -> io::Result<Self> {
        // SAFETY: the bytes behind the slice must not change while it lives.
        // Published files are replaced by rename and never edited in place, so the mapped inode stays as it was.
        // A program that breaks this rule by truncating the file makes the kernel stop the process (SIGBUS);
        // one that writes into it can change values that were checked, which no reader takes for memory addresses:
        // every index that comes from the map is checked by safe code where it is used.
        let map = unsafe { Mmap::map(file)? };
        Ok(Self::Map(map))
    }

    /// All bytes.
    pub(crate) fn bytes(&self) -> &[u8] {
        match self {
            Self::Map(map) => map,
            Self::Bytes(bytes) => bytes,
        }
    }
}
