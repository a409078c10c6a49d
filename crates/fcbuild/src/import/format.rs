//! Tells what a file is, by its content before its name.

use super::number::shown;
use super::source::Source;
use super::stl;
use crate::error::Error;

/// What a file turns out to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    Ply,
    Obj,
    BinaryStl,
    AsciiStl,
    Gltf,
    Glb,
}

/// Files that are often given by mistake, by their first bytes.
const STRANGERS: [(&[u8], &str, &str); 8] = [
    (b"\x1f\x8b", "a gzip archive", "unpack it first"),
    (b"PK\x03\x04", "a zip archive", "unpack it first"),
    (b"\x28\xb5\x2f\xfd", "a zstd archive", "unpack it first"),
    (b"\xfd7zXZ", "an xz archive", "unpack it first"),
    (b"BZh", "a bzip2 archive", "unpack it first"),
    (
        b"\x8fFCT",
        "a face-cluster tree (.fct) already",
        "look at it with `fct info`, draw it with fcview, or turn it into a mesh with `fct export`",
    ),
    (b"Kaydara FBX", "an FBX file", "export it as PLY, OBJ, STL or glTF"),
    (b"# vtk DataFile", "a VTK file", "export it as PLY, OBJ, STL or glTF"),
];

impl Format {
    /// Tells the format by the content first, then by the extension.
    pub(super) fn detect(source: &mut Source<'_>) -> Result<Self, Error> {
        let head = source.first_bytes(1024)?;
        if head.is_empty() {
            return Err(Error::bad_input("FC200", "the file is empty").remedy("export or copy it again"));
        }
        for (magic, what, remedy) in STRANGERS {
            if head.starts_with(magic) {
                return Err(Error::bad_input("FC201", format!("this is {what}")).at_byte(0).remedy(remedy));
            }
        }
        if head.starts_with(b"\xff\xfe") || head.starts_with(b"\xfe\xff") {
            return Err(Error::bad_input("FC210", "the text is encoded as UTF-16")
                .at_byte(0)
                .remedy("save it as UTF-8 or ASCII"));
        }
        if head.starts_with(b"glTF") {
            return Ok(Self::Glb);
        }
        if matches!(head.as_slice(), [b'p', b'l', b'y', b'\n' | b'\r' | b' ' | b'\t', ..]) {
            return Ok(Self::Ply);
        }
        if stl::size_fits(&head, source.size()) {
            return Ok(Self::BinaryStl);
        }
        let text = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&head).trim_ascii_start();
        let extension = source.path().extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        match extension.as_deref() {
            Some("ply") => Ok(Self::Ply),
            Some("obj") => Ok(Self::Obj),
            Some("stl") if stl::looks_like_text(text) => Ok(Self::AsciiStl),
            Some("stl") => Ok(Self::BinaryStl),
            Some("gltf") => Ok(Self::Gltf),
            Some("glb") => Ok(Self::Glb),
            _ if text.starts_with(b"solid") && stl::looks_like_text(text) => Ok(Self::AsciiStl),
            _ if text.starts_with(b"{") => Ok(Self::Gltf),
            _ => Err(Error::bad_input(
                "FC201",
                format!(
                    "neither the content, which begins with {}, nor the extension tells a mesh format",
                    shown(&head)
                ),
            )
            .at_byte(0)
            .remedy(
                "fcbuild reads PLY, OBJ, STL, glTF and GLB; give a file of these its extension, such as .obj",
            )),
        }
    }

    /// The name in messages.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Ply => "PLY",
            Self::Obj => "OBJ",
            Self::BinaryStl | Self::AsciiStl => "STL",
            Self::Gltf => "glTF",
            Self::Glb => "GLB",
        }
    }
}
