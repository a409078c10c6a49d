//! The JSON document of a scene: bounded size and depth, a supported version and extensions.

use gltf::json::Root;

use crate::error::{Error, ErrorKind};

/// Largest document; geometry lies in buffers, so that real ones are far smaller.
pub(super) const MAX_SIZE: u64 = 64 << 20;
/// Deepest nesting; the parser recurses.
const MAX_DEPTH: u64 = 128;

/// Extensions that may be required without touching the shape of a mesh.
const HARMLESS: [&str; 7] = [
    "KHR_materials_",
    "KHR_texture_",
    "EXT_texture_",
    "KHR_lights_",
    "KHR_animation_",
    "KHR_xmp",
    "KHR_mesh_quantization",
];

/// Refuses a document that is too large.
pub(super) fn check_size(size: u64) -> Result<(), Error> {
    if size <= MAX_SIZE {
        return Ok(());
    }
    Err(Error::new(
        ErrorKind::Limit,
        "FC504",
        format!("the JSON document has {size} bytes, more than {MAX_SIZE}"),
    )
    .limit(MAX_SIZE, size)
    .remedy("store the geometry as GLB or in a .bin file"))
}

/// Parses and checks a document that begins at `byte` of the file.
pub(super) fn parse(text: &[u8], byte: u64) -> Result<Root, Error> {
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    check_depth(text, byte)?;
    let root: Root = match gltf::json::deserialize::from_slice(text) {
        Ok(root) => root,
        Err(e) => {
            let error = Error::bad_input("FC202", format!("the JSON document is no glTF scene: {e}"))
                .remedy("export the file again");
            // In a container the line number would mislead.
            return Err(if byte == 0 { error.at_line(e.line() as u64) } else { error.at_byte(byte) });
        }
    };
    let version = root.asset.version.as_str();
    let wanted = root.asset.min_version.as_deref().unwrap_or("2.0");
    if !version.starts_with("2.") || wanted != "2.0" {
        return Err(Error::bad_input(
            "FC209",
            format!("the scene needs version {version} (at least {wanted}) of glTF"),
        )
        .at_pointer("asset.version")
        .remedy("export the scene as glTF 2.0"));
    }
    for (i, name) in root.extensions_required.iter().enumerate() {
        if !HARMLESS.iter().any(|known| name.starts_with(known)) {
            return Err(Error::bad_input("FC209", format!("the required extension {name} is not supported"))
                .at_pointer(format!("extensionsRequired[{i}]"))
                .remedy("export the scene without it, for instance without compression"));
        }
    }
    Ok(root)
}

/// Refuses nesting on which the recursive parser would give up or run out of stack.
fn check_depth(text: &[u8], byte: u64) -> Result<(), Error> {
    let mut depth = 0u64;
    let mut in_string = false;
    let mut escaped = false;
    for (at, &b) in text.iter().enumerate() {
        if in_string {
            in_string = escaped || b != b'"';
            escaped = !escaped && b == b'\\';
            continue;
        }
        match b {
            b'"' => in_string = true,
            b'[' | b'{' => depth = depth.saturating_add(1),
            b']' | b'}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth >= MAX_DEPTH {
            return Err(Error::new(
                ErrorKind::Limit,
                "FC504",
                format!("the JSON document nests deeper than {MAX_DEPTH}"),
            )
            .at_byte(byte.saturating_add(at as u64))
            .limit(MAX_DEPTH, depth)
            .remedy("export the file again"));
        }
    }
    Ok(())
}
