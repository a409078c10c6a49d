//! The container of a GLB file: a header and chunks, each of a stated length.

use super::super::number::shown;
use super::super::tally::Tally;
use crate::error::Error;

/// The two chunks that matter.
pub(super) struct Chunks<'a> {
    pub(super) json: &'a [u8],
    /// Where the JSON begins in the file.
    pub(super) json_byte: u64,
    pub(super) binary: Option<&'a [u8]>,
}

/// Finds the chunks.
pub(super) fn split<'a>(file: &'a [u8], tally: &mut Tally) -> Result<Chunks<'a>, Error> {
    let size = file.len() as u64;
    let cut_off = |what: String, byte: u64| {
        Error::bad_input("FC204", what).at_byte(byte).remedy("the file is cut off; copy or export it again")
    };
    let (Some(version), Some(length)) = (word(file, 4), word(file, 8)) else {
        return Err(cut_off(format!("a GLB file has a header of 12 bytes, this one has {size}"), size));
    };
    if version != 2 {
        return Err(Error::bad_input(
            "FC209",
            format!("the container has version {version}; only 2 is supported"),
        )
        .at_byte(4)
        .remedy("export the scene as glTF 2.0"));
    }
    if length < 20 {
        return Err(Error::bad_input("FC202", format!("the header declares a length of {length} bytes"))
            .at_byte(8)
            .remedy("export the file again"));
    }
    if length > size {
        return Err(cut_off(format!("the header declares {length} bytes, the file has {size}"), 8)
            .limit(size, length));
    }
    let (file, after) =
        file.split_at_checked(usize::try_from(length).unwrap_or(usize::MAX)).unwrap_or((file, &[]));
    if !after.is_empty() {
        tally.warn("trailing_bytes", 1, format!("{} bytes after the container are ignored", after.len()));
    }

    let mut json = None;
    let mut binary = None;
    let mut at = 12usize;
    let mut index = 0u64;
    while at < file.len() {
        let byte = at as u64;
        let (Some(size), Some(kind)) = (word(file, at), file.get(at.saturating_add(4)..at.saturating_add(8)))
        else {
            return Err(cut_off(format!("chunk {index} has no complete header"), byte));
        };
        let start = at.saturating_add(8);
        let end = usize::try_from(size).ok().and_then(|n| start.checked_add(n));
        let Some((content, end)) = end.and_then(|end| Some((file.get(start..end)?, end))) else {
            return Err(cut_off(
                format!("chunk {index} declares {size} bytes, {} are left", file.len().saturating_sub(start)),
                byte,
            ));
        };
        let broken =
            |what: String| Error::bad_input("FC202", what).at_byte(byte).remedy("export the file again");
        if size % 4 != 0 {
            return Err(broken(format!(
                "chunk {index} has a length of {size} bytes, which is no multiple of 4"
            )));
        }
        match (index, kind) {
            (0, b"JSON") => json = Some((content, start as u64)),
            (0, _) => return Err(broken(format!("the first chunk is {}, not JSON", shown(kind)))),
            (_, b"JSON") => return Err(broken("there are two JSON chunks".into())),
            (1, b"BIN\0") => binary = Some(content),
            (_, b"BIN\0") => return Err(broken(format!("chunk {index} is binary; only the second may be"))),
            // The format asks to pass over kinds that are not known.
            _ => {}
        }
        at = end;
        index = index.saturating_add(1);
    }
    match json {
        Some((json, json_byte)) => Ok(Chunks { json, json_byte, binary }),
        None => Err(cut_off("there is no JSON chunk".into(), 12)),
    }
}

fn word(bytes: &[u8], at: usize) -> Option<u64> {
    bytes.get(at..)?.first_chunk::<4>().map(|b| u32::from_le_bytes(*b).into())
}
