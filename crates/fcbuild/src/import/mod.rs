//! Reading meshes from files that strangers made: PLY, OBJ, STL, glTF and GLB.
//!
//! Every reader checks a count against the bytes that are left before it allocates, checks every
//! index, and names the line or byte where a file is wrong. Harmless oddities are repaired and
//! counted in the [`Tally`]; nothing is dropped in silence.
#![cfg_attr(
    not(test),
    deny(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::unreachable,
        clippy::indexing_slicing,
        clippy::arithmetic_side_effects,
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss
    )
)]

mod faces;
mod format;
mod gltf;
mod number;
mod obj;
mod ply;
mod soup;
mod source;
mod stl;
pub(crate) mod tally;
#[cfg(test)]
mod testing;
#[allow(
    clippy::indexing_slicing,
    clippy::arithmetic_side_effects,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "indexes only arrays of its own making, below the number of corners"
)]
mod triangulate;
mod window;
mod words;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

pub use soup::{Group, Positions, Soup};
pub use tally::{DropReason, Drops, KEPT_IDS, Tally, Warning};

use crate::error::{Error, ErrorKind};
use format::Format;
use source::Source;

/// Limits of an import and where it reports its progress.
pub struct ImportOptions<'a> {
    /// The most triangles a mesh may have.
    pub max_faces: u64,
    /// Called now and then with the bytes read so far and the bytes in all.
    pub progress: &'a (dyn Fn(u64, u64) + Sync),
}

/// Reads a mesh; the format is told by the content first, then by the file's extension.
///
/// # Errors
/// [`ErrorKind::Io`] when the file cannot be read, [`ErrorKind::BadInput`] when its content cannot be
/// taken as a mesh, [`ErrorKind::Limit`] when a limit is reached, [`ErrorKind::Internal`] when a reader
/// fails by a bug.
pub fn import(path: &Path, options: &ImportOptions<'_>) -> Result<Soup, Error> {
    import_source(Source::open(path, options)?)
}

/// As [`import`], from the bytes of a file; `path` gives its name, extension and folder.
///
/// # Errors
/// As [`import`].
pub fn import_bytes(path: &Path, bytes: &[u8], options: &ImportOptions<'_>) -> Result<Soup, Error> {
    import_source(Source::from_bytes(path, bytes, options))
}

fn import_source(mut source: Source<'_>) -> Result<Soup, Error> {
    let path = source.path();
    let outcome = import_any(&mut source);
    // A file that is being written looks damaged: the change of size is the truer error.
    source.check_unchanged()?;
    let soup = outcome.map_err(|e| e.in_file(path))?;
    (source.progress())(source.size(), source.size());
    Ok(soup)
}

fn import_any(source: &mut Source<'_>) -> Result<Soup, Error> {
    let format = Format::detect(source)?;
    // The last net below readers of others and our own: a panic becomes an error that names the file.
    let caught = catch_unwind(AssertUnwindSafe(|| match format {
        Format::Ply => ply::read(source),
        Format::Obj => obj::read(source),
        Format::BinaryStl => stl::read_binary(source),
        Format::AsciiStl => stl::read_ascii(source),
        Format::Gltf => gltf::read_gltf(source),
        Format::Glb => gltf::read_glb(source),
    }));
    match caught {
        Ok(outcome) => outcome,
        Err(_) => Err(Error::new(
            ErrorKind::Internal,
            "FC901",
            format!("the {} reader failed by a bug of this program", format.name()),
        )
        .remedy("please report it with this file")),
    }
}

#[cfg(test)]
mod tests;
