//! The hashes of the format: XXH3-64 for sections, XXH3-128 for the content id.
//!
//! They find damage, not forgery: whoever edits a file on purpose can set them right again.

use xxhash_rust::xxh3::{Xxh3, xxh3_64};

/// XXH3-64 with seed 0 of one piece of bytes.
pub(crate) fn hash64(bytes: &[u8]) -> u64 {
    xxh3_64(bytes)
}

/// XXH3-64 with seed 0 of the concatenation of pieces.
pub(crate) fn hash64_of(pieces: &[&[u8]]) -> u64 {
    let mut hasher = Xxh3::new();
    for piece in pieces {
        hasher.update(piece);
    }
    hasher.digest()
}

/// XXH3-128 with seed 0 of the concatenation of pieces.
pub(crate) fn hash128_of<'a>(pieces: impl IntoIterator<Item = &'a [u8]>) -> u128 {
    let mut hasher = Xxh3::new();
    for piece in pieces {
        hasher.update(piece);
    }
    hasher.digest128()
}
