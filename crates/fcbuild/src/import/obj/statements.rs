//! The statements of an OBJ file: what they must be, and the form in which they are passed on.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Component, Path};

use super::super::faces::MAX_CORNERS;
use super::super::number::{self, shown};
use super::parts::Parts;
use crate::error::{Error, ErrorKind};

/// What the walk learns besides what it passes on.
#[derive(Default)]
pub(super) struct Findings {
    /// Vertices in the file.
    pub(super) vertices: u64,
    /// What the polygons belong to.
    pub(super) parts: Parts,
    /// Whether the first vertex has a colour; the others follow suit.
    pub(super) colored: bool,
    /// Whether the first polygon has normals; the others follow suit.
    pub(super) with_normals: bool,
    /// Counts of oddities, by warning code.
    pub(super) oddities: BTreeMap<&'static str, u64>,
    /// Polygons so far.
    pub(super) polygons: u64,
    /// Normals in the file.
    pub(super) normals: u64,
}

/// Counts an oddity.
pub(super) fn count(findings: &mut Findings, code: &'static str) {
    let n = findings.oddities.entry(code).or_default();
    *n = n.saturating_add(1);
}

fn float(word: &[u8]) -> Result<f64, Error> {
    number::coordinate(word).ok_or_else(|| {
        Error::bad_input("FC206", format!("{} is no number", shown(word))).remedy(number::advice(word))
    })
}

fn three<'l>(words: &mut impl Iterator<Item = &'l [u8]>, what: &str) -> Result<[&'l [u8]; 3], Error> {
    match (words.next(), words.next(), words.next()) {
        (Some(x), Some(y), Some(z)) => Ok([x, y, z]),
        _ => {
            Err(Error::bad_input("FC206", format!("{what} needs three numbers"))
                .remedy("export the file again"))
        }
    }
}

/// Passes numbers on as they are written, except what the parser would read otherwise than we do.
fn pass_on(keyword: &str, numbers: [&[u8]; 3], out: &mut String) -> Result<(), Error> {
    out.push_str(keyword);
    for word in numbers {
        out.push(' ');
        match std::str::from_utf8(word) {
            Ok(text) if float(word)?.is_finite() => out.push_str(text),
            _ => {
                float(word)?;
                out.push_str("nan");
            }
        }
    }
    Ok(())
}

/// Passes a vertex on.
pub(super) fn vertex<'l>(
    words: impl Iterator<Item = &'l [u8]>,
    findings: &mut Findings,
    out: &mut String,
) -> Result<(), Error> {
    let mut words = words;
    let position = three(&mut words, "a vertex")?;
    pass_on("v", position, out)?;
    let mut rest = Vec::new();
    for word in words.by_ref().take(5) {
        rest.push(float(word)?);
    }
    let first = findings.vertices == 0;
    findings.vertices = findings.vertices.saturating_add(1);
    if findings.vertices >= u64::from(u32::MAX) {
        return Err(Error::new(ErrorKind::Limit, "FC501", "more vertices than 32-bit indices reach")
            .limit(u64::from(u32::MAX - 1), findings.vertices)
            .remedy("split the model"));
    }
    // One more number is a weight, three are a colour, four a colour with opacity or after a weight.
    let color = match *rest.as_slice() {
        [] => None,
        [weight] => {
            if weight != 1.0 {
                count(findings, "vertex_weights");
            }
            None
        }
        [r, g, b] | [r, g, b, _] => Some([r, g, b]),
        _ => {
            return Err(Error::bad_input("FC206", "a vertex has 3, 4, 6 or 7 numbers")
                .remedy("export the file again"));
        }
    };
    if first {
        findings.colored = color.is_some();
    }
    if findings.colored != color.is_some() {
        count(findings, "partial_colors");
    }
    if findings.colored {
        for channel in color.unwrap_or([1.0; 3]) {
            let channel = if channel.is_finite() { channel.clamp(0.0, 1.0) } else { 1.0 };
            // Writing to a string cannot fail.
            let _ = write!(out, " {channel}");
        }
    }
    out.push('\n');
    Ok(())
}

/// Passes a normal on.
pub(super) fn normal<'l>(
    words: impl Iterator<Item = &'l [u8]>,
    findings: &mut Findings,
    out: &mut String,
) -> Result<(), Error> {
    let mut words = words;
    let direction = three(&mut words, "a normal")?;
    pass_on("vn", direction, out)?;
    out.push('\n');
    findings.normals = findings.normals.saturating_add(1);
    Ok(())
}

/// Passes a polygon on and returns its number of corners.
pub(super) fn face<'l>(
    words: impl Iterator<Item = &'l [u8]>,
    findings: &mut Findings,
    so_far: (u64, u64),
    out: &mut String,
) -> Result<u64, Error> {
    out.push('f');
    let id = findings.polygons;
    let mut corners = 0u64;
    for word in words {
        let mut parts = word.split(|&b| b == b'/');
        let (v, vt, vn) = (parts.next().unwrap_or_default(), parts.next(), parts.next());
        if parts.next().is_some() {
            return Err(malformed(word));
        }
        let v = resolve(word, v, so_far.0, findings.vertices, "vertex", id)?;
        if let Some(vt) = vt.filter(|t| !t.is_empty()) {
            // Texture coordinates are not kept, so that any number will do.
            number::integer(vt).ok_or_else(|| malformed(word))?;
        }
        let vn = match vn.filter(|t| !t.is_empty()) {
            Some(vn) => Some(resolve(word, vn, so_far.1, findings.normals, "normal", id)?),
            None => None,
        };
        if id == 0 && corners == 0 {
            findings.with_normals = vn.is_some();
        }
        corners = corners.saturating_add(1);
        if corners > MAX_CORNERS as u64 {
            return Err(Error::new(
                ErrorKind::Limit,
                "FC503",
                format!("face {}, counted from 1, has more than {MAX_CORNERS} corners", id.saturating_add(1)),
            )
            .limit(MAX_CORNERS as u64, corners)
            .remedy("split the polygon"));
        }
        let none = findings.normals.saturating_add(1);
        // Writing to a string cannot fail.
        let _ = match findings.with_normals {
            true => write!(out, " {v}//{}", vn.unwrap_or(none)),
            false => write!(out, " {v}"),
        };
    }
    out.push('\n');
    findings.polygons = id.saturating_add(1);
    Ok(corners)
}

fn malformed(word: &[u8]) -> Error {
    Error::bad_input("FC206", format!("{} is no corner of a face", shown(word)))
        .remedy("write corners as v, v/vt, v//vn or v/vt/vn")
}

/// The index from 1 that a number in a face means: from 1, or from -1 backwards from here.
fn resolve(word: &[u8], text: &[u8], so_far: u64, total: u64, what: &str, id: u64) -> Result<u64, Error> {
    let digits = text.strip_prefix(b"-").or_else(|| text.strip_prefix(b"+")).unwrap_or(text);
    if digits.is_empty() || !digits.iter().all(u8::is_ascii_digit) {
        return Err(malformed(word));
    }
    // Digits that no 64-bit number holds are a number all the same, far beyond every vertex.
    let resolved = number::integer(text).and_then(|index| {
        if index < 0 {
            so_far.checked_sub(index.unsigned_abs())?.checked_add(1)
        } else {
            u64::try_from(index).ok()
        }
    });
    match resolved {
        Some(index) if index >= 1 && index <= total => Ok(index),
        _ => Err(Error::bad_input(
            "FC203",
            format!(
                "face {} uses {what} {} of {total}",
                id.saturating_add(1),
                String::from_utf8_lossy(text.get(..text.len().min(40)).unwrap_or_default())
            ),
        )
        .remedy(match what {
            "vertex" => {
                "vertices and faces count from 1, vertices from -1 backwards too; export the file again"
            }
            _ => "normals and faces count from 1, normals from -1 backwards too; export the file again",
        })),
    }
}

/// Statements that are no part of a polygon mesh and are worth a warning.
pub(super) fn oddity(keyword: &[u8]) -> Option<&'static str> {
    match keyword {
        b"f" | b"o" | b"g" | b"s" | b"vp" | b"usemap" | b"maplib" | b"mg" | b"bevel" | b"c_interp"
        | b"d_interp" | b"lod" | b"shadow_obj" | b"trace_obj" => None,
        b"vt" => Some("texture_coordinates"),
        b"usemtl" => Some("materials"),
        b"l" | b"p" => Some("lines_and_points"),
        b"cstype" | b"deg" | b"bmat" | b"step" | b"curv" | b"curv2" | b"surf" | b"parm" | b"trim"
        | b"hole" | b"scrv" | b"sp" | b"end" | b"con" | b"ctech" | b"stech" => Some("free_form_geometry"),
        _ => Some("unknown_statements"),
    }
}

/// Looks whether a material file is there; it is never opened, and never sought outside the folder.
pub(super) fn material_file(folder: &Path, name: &[u8]) -> Option<&'static str> {
    let Ok(name) = std::str::from_utf8(name) else { return Some("missing_material_files") };
    let path = Path::new(name);
    let inside = !name.contains(['\\', ':'])
        && path.components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir));
    match inside {
        false => Some("outside_material_files"),
        true if folder.join(path).is_file() => None,
        true => Some("missing_material_files"),
    }
}
