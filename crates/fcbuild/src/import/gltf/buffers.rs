//! The buffers of a scene: in the container, in the document as base64, or in files beside it.

use std::cell::OnceCell;
use std::io::Read as _;
use std::path::{Component, Path, PathBuf};

use gltf::json::Root;

use super::super::faces::reserve;
use super::super::number::shown;
use crate::error::{Error, ErrorKind};

/// Buffers, loaded when first asked for, so that what belongs to images alone is never opened.
pub(super) struct Buffers<'a> {
    root: &'a Root,
    path: &'a Path,
    binary: Option<&'a [u8]>,
    loaded: Vec<OnceCell<Vec<u8>>>,
}

impl<'a> Buffers<'a> {
    pub(super) fn new(root: &'a Root, path: &'a Path, binary: Option<&'a [u8]>) -> Self {
        Self { root, path, binary, loaded: root.buffers.iter().map(|_| OnceCell::new()).collect() }
    }

    /// The bytes of a buffer, exactly as many as it declares.
    pub(super) fn get(&self, index: usize) -> Result<&[u8], Error> {
        let pointer = format!("buffers[{index}]");
        let (Some(buffer), Some(cell)) = (self.root.buffers.get(index), self.loaded.get(index)) else {
            return Err(Error::bad_input("FC211", format!("there are {} buffers", self.root.buffers.len()))
                .at_pointer(pointer)
                .remedy("export the file again"));
        };
        let declared = buffer.byte_length.0;
        let bytes: &[u8] = match (&buffer.uri, self.binary, cell.get()) {
            (_, _, Some(bytes)) => bytes,
            (None, Some(binary), _) if index == 0 => binary,
            (None, ..) => {
                return Err(Error::bad_input(
                    "FC211",
                    "the buffer has neither a uri nor a chunk of the container",
                )
                .at_pointer(pointer)
                .remedy("export the file again"));
            }
            (Some(uri), ..) => {
                let bytes = self.load(uri, declared).map_err(|e| e.at_pointer(format!("{pointer}.uri")))?;
                cell.get_or_init(|| bytes)
            }
        };
        let length = usize::try_from(declared).ok();
        length.and_then(|n| bytes.get(..n)).ok_or_else(|| {
            Error::bad_input(
                "FC204",
                format!("the buffer declares {declared} bytes, there are {}", bytes.len()),
            )
            .at_pointer(format!("{pointer}.byteLength"))
            .limit(bytes.len() as u64, declared)
            .remedy("the file is cut off; copy or export it again")
        })
    }

    fn load(&self, uri: &str, declared: u64) -> Result<Vec<u8>, Error> {
        if let Some(data) = uri.strip_prefix("data:") {
            let Some((_, text)) = data.split_once(";base64,") else {
                return Err(
                    Error::bad_input("FC202", "the data uri is not base64").remedy("export the file again")
                );
            };
            return base64(text.as_bytes());
        }
        let file = self.locate(uri)?;
        let failed = |e: &std::io::Error| Error::io("FC401", &file, "cannot open the buffer", e);
        // Before it is opened: opening a pipe would wait for somebody to write into it.
        let meta = std::fs::metadata(&file).map_err(|e| failed(&e))?;
        if !meta.is_file() {
            return Err(Error::new(ErrorKind::Io, "FC402", "is no regular file")
                .in_file(&file)
                .remedy("export the file again"));
        }
        let mut open = std::fs::File::open(&file).map_err(|e| failed(&e))?;
        let mut bytes = Vec::new();
        let size = meta.len().min(declared);
        reserve(&mut bytes, size, "bytes of a buffer")?;
        let read = (&mut open).take(size).read_to_end(&mut bytes);
        read.map_err(|e| Error::io("FC403", &file, "cannot read the buffer", &e))?;
        Ok(bytes)
    }

    /// The file that a uri names, which must lie in the input's folder or below, links resolved.
    fn locate(&self, uri: &str) -> Result<PathBuf, Error> {
        let refuse = || {
            Error::bad_input(
                "FC212",
                format!("the uri {} leads out of the input's folder", shown(uri.as_bytes())),
            )
            .remedy("put the buffer beside the scene and name it by a relative path")
        };
        let decoded = percent_decoded(uri).ok_or_else(|| {
            Error::bad_input("FC202", format!("the uri {} is malformed", shown(uri.as_bytes())))
                .remedy("export the file again")
        })?;
        let relative = Path::new(&decoded);
        let plain = relative.components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir));
        if !plain || decoded.is_empty() || decoded.contains(['\\', ':', '\0']) {
            return Err(refuse());
        }
        let folder = match self.path.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        let named = folder.join(relative);
        let missing = |e: std::io::Error| {
            Error::io("FC401", &named, "cannot open the buffer", &e)
                .remedy("put it beside the scene, or export a GLB")
        };
        let folder = folder.canonicalize().map_err(missing)?;
        let file = named.canonicalize().map_err(missing)?;
        if file.starts_with(&folder) { Ok(file) } else { Err(refuse()) }
    }
}

fn percent_decoded(uri: &str) -> Option<String> {
    let mut out = Vec::with_capacity(uri.len());
    let mut bytes = uri.bytes();
    while let Some(b) = bytes.next() {
        if b != b'%' {
            out.push(b);
            continue;
        }
        let digit = |b: Option<u8>| char::from(b?).to_digit(16).and_then(|d| u8::try_from(d).ok());
        let (high, low) = (digit(bytes.next())?, digit(bytes.next())?);
        out.push((high << 4) | low);
    }
    String::from_utf8(out).ok()
}

fn base64(text: &[u8]) -> Result<Vec<u8>, Error> {
    let text = text.strip_suffix(b"==").or_else(|| text.strip_suffix(b"=")).unwrap_or(text);
    let mut out = Vec::new();
    reserve(&mut out, text.len() as u64, "bytes of a data uri")?;
    let mut bits = 0u32;
    let mut held = 0u32;
    for (at, &b) in text.iter().enumerate() {
        let value = match b {
            b'A'..=b'Z' => b.wrapping_sub(b'A'),
            b'a'..=b'z' => b.wrapping_sub(b'a').wrapping_add(26),
            b'0'..=b'9' => b.wrapping_sub(b'0').wrapping_add(52),
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            _ => {
                return Err(Error::bad_input(
                    "FC202",
                    format!("character {at} of the base64 data is {}", shown(&[b])),
                )
                .remedy("export the file again"));
            }
        };
        bits = ((bits << 6) | u32::from(value)) & 0xffff;
        held = held.saturating_add(6);
        if held >= 8 {
            held = held.saturating_sub(8);
            out.push(u8::try_from(bits.wrapping_shr(held) & 0xff).unwrap_or(0));
        }
    }
    if text.len() % 4 == 1 {
        return Err(Error::bad_input("FC204", "the base64 data is cut off").remedy("export the file again"));
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_agrees_with_the_standard_examples() {
        for (text, bytes) in [
            ("", ""),
            ("Zg==", "f"),
            ("Zm8=", "fo"),
            ("Zm9v", "foo"),
            ("Zm9vYmE", "fooba"),
            ("Zm9vYmFy", "foobar"),
        ] {
            assert_eq!(base64(text.as_bytes()).unwrap(), bytes.as_bytes());
        }
        assert_eq!(base64(b"Zm9vYg!=").unwrap_err().code(), "FC202");
        assert_eq!(base64(b"Zm9vY").unwrap_err().code(), "FC204");
    }

    #[test]
    fn percent_codes_are_decoded_or_refused() {
        assert_eq!(percent_decoded("a%20b%2e").as_deref(), Some("a b."));
        for bad in ["%", "%2", "%zz", "%FF"] {
            assert_eq!(percent_decoded(bad), None, "{bad}");
        }
    }
}
