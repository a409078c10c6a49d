//! STL: binary and ASCII. Stored normals are ignored, since the winding says the same more reliably.

mod ascii;
mod binary;

pub(super) use ascii::looks_like_text;
pub(super) use ascii::read as read_ascii;
pub(super) use binary::read as read_binary;
pub(super) use binary::size_fits;

#[cfg(test)]
mod tests;
