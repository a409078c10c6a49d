//! The rules for the output, checked before the work.

use crate::error::Error;
use fct::Pending;
use std::fs;
use std::io::{self, Read as _};
use std::path::Path;

/// Bytes in which an export has said what it is, if it is no GLB.
const HEADER: u64 = 256;

/// Checks the place and makes a temporary beside it, so that an unwritable place is known before the work.
///
/// # Errors
/// Usage when the output is the input, I/O when it exists and may not be replaced, is no export of ours, or its
/// folder is not writable.
pub(crate) fn prepare(target: &Path, input: &Path, overwrite: bool) -> Result<Pending, Error> {
    let path = target.to_owned();
    if is_same_file(target, input) {
        return Err(Error::Same { path });
    }
    match fs::metadata(target) {
        Ok(found) if !found.is_file() => Err(Error::NotAFile { path }),
        Ok(_) if overwrite && !is_export(target) => Err(Error::NotAnExport { path }),
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

/// Whether this program wrote the file: a scan in the place of an export is a slip, and may be the only copy.
fn is_export(path: &Path) -> bool {
    let start = || -> io::Result<Vec<u8>> {
        let file = fs::File::open(path)?;
        let mut start = Vec::new();
        (&file).take(HEADER).read_to_end(&mut start)?;
        // A GLB says who made it somewhere in its first chunk, whose length is the file's fourth number.
        if let (true, Some(length)) =
            (start.starts_with(b"glTF"), start.get(12..).and_then(<[u8]>::first_chunk))
        {
            (&file).take(u32::from_le_bytes(*length).into()).read_to_end(&mut start)?;
        }
        Ok(start)
    };
    let has = |start: &[u8], mark: &[u8]| start.windows(mark.len()).any(|words| words == mark);
    start().is_ok_and(|start| has(&start, b"written by fct ") || has(&start, b"\"generator\":\"fct "))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::mesh::Mesh;
    use crate::export::{glb, obj, ply};

    #[test]
    fn exports_are_told_from_other_meshes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mesh");
        let mut mesh = Mesh::default();
        mesh.buffers.positions.extend([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        mesh.buffers.indices.extend([0, 1, 2]);
        // Many groups move the name of the generator far back in a GLB.
        mesh.groups = vec![(0, "group".repeat(200)); 9];
        let bytes = |write: &dyn Fn(&mut Vec<u8>) -> io::Result<()>| {
            let mut bytes = Vec::new();
            write(&mut bytes).unwrap();
            bytes
        };
        for written in [
            bytes(&|out| ply::write(&mesh, out, &mut || ())),
            bytes(&|out| obj::write(&mesh, out, &mut || ())),
            bytes(&|out| glb::write(&mesh, out, &mut || ())),
        ] {
            fs::write(&path, &written).unwrap();
            assert!(is_export(&path));
            let other: Vec<u8> = String::from_utf8_lossy(&written).replace("fct ", "mlx ").into_bytes();
            fs::write(&path, other).unwrap();
            assert!(!is_export(&path));
        }
        for other in [&b""[..], b"glTF", b"ply\nformat ascii 1.0\n"] {
            fs::write(&path, other).unwrap();
            assert!(!is_export(&path));
        }
    }
}
