//! Checks an OBJ file and rewrites it for the parser: only positions, normals and faces, in a form
//! on which the parser cannot fail.
//!
//! The file is walked twice. The first pass passes on `v` and `vn`, so that the second, which passes
//! on `f` with absolute indices, knows how many there are in all.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::{BufRead, Read};
use std::path::{Component, Path, PathBuf};

use super::super::faces::MAX_CORNERS;
use super::super::number::{self, shown};
use super::lines::Lines;
use crate::error::{Error, ErrorKind};

/// Bytes that are prepared at a time.
const BATCH: usize = 64 * 1024;

/// What the walk learns besides what it passes on.
#[derive(Default)]
pub(super) struct Findings {
    /// Vertices in the file.
    pub(super) vertices: u64,
    /// Names of the objects, each with the number of polygons before it.
    pub(super) objects: Vec<(String, u64)>,
    /// Whether the first vertex has a colour; the others follow suit.
    pub(super) colored: bool,
    /// Whether the first polygon has normals; the others follow suit.
    pub(super) with_normals: bool,
    /// Counts of oddities, by warning code.
    pub(super) oddities: BTreeMap<&'static str, u64>,
    polygons: u64,
    normals: u64,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Pass {
    Vertices,
    Faces,
    Done,
}

/// The rewritten file as a stream for the parser.
pub(super) struct Feed<'a> {
    lines: Lines<'a>,
    folder: PathBuf,
    max_faces: u64,
    pass: Pass,
    out: String,
    sent: usize,
    faces: u64,
    /// Vertices and normals before the current line of the second pass, for relative indices.
    so_far: (u64, u64),
    findings: Findings,
    error: Option<Error>,
}

impl<'a> Feed<'a> {
    pub(super) fn new(mut lines: Lines<'a>, folder: &Path, max_faces: u64) -> Self {
        lines.window.expect_passes(2);
        Self {
            lines,
            folder: folder.to_path_buf(),
            max_faces,
            pass: Pass::Vertices,
            out: String::new(),
            sent: 0,
            faces: 0,
            so_far: (0, 0),
            findings: Findings::default(),
            error: None,
        }
    }

    /// What was found, or why the walk stopped; an error of the operating system comes first.
    pub(super) fn finish(mut self) -> (Option<std::io::Error>, Result<Findings, Error>) {
        let outcome = match self.error {
            Some(e) => Err(e),
            None => Ok(self.findings),
        };
        (self.lines.window.take_failure(), outcome)
    }

    fn prepare(&mut self) -> Result<(), Error> {
        self.out.clear();
        self.sent = 0;
        while self.out.len() < BATCH && self.pass != Pass::Done {
            let Some(line) = self.lines.next()? else {
                self.end_pass();
                continue;
            };
            let mut words = line.split(|b| b.is_ascii_whitespace() || *b == 0x0b).filter(|w| !w.is_empty());
            let Some(keyword) = words.next() else { continue };
            let outcome = match (self.pass, keyword) {
                (Pass::Vertices, b"v") => vertex(words, &mut self.findings, &mut self.out),
                (Pass::Vertices, b"vn") => normal(words, &mut self.findings, &mut self.out),
                (Pass::Faces, b"v") => {
                    self.so_far.0 = self.so_far.0.saturating_add(1);
                    Ok(())
                }
                (Pass::Faces, b"vn") => {
                    self.so_far.1 = self.so_far.1.saturating_add(1);
                    Ok(())
                }
                (Pass::Faces, b"f") => {
                    face(words, &mut self.findings, self.so_far, &mut self.out).and_then(|n| {
                        self.faces = self.faces.saturating_add(n.saturating_sub(2).max(1));
                        check_limit(self.faces, self.max_faces)
                    })
                }
                (Pass::Faces, b"o") => {
                    let name =
                        line.get(line.iter().position(|&b| b == b'o').unwrap_or(0)..).unwrap_or_default();
                    let name = String::from_utf8_lossy(name.get(1..).unwrap_or_default()).trim().to_owned();
                    self.findings.objects.push((name, self.findings.polygons));
                    Ok(())
                }
                (Pass::Vertices, b"mtllib") => {
                    if let Some(code) = words.map(|w| material_file(&self.folder, w)).find_map(|code| code) {
                        count(&mut self.findings, code);
                    }
                    Ok(())
                }
                (Pass::Vertices, other) => {
                    if let Some(code) = oddity(other) {
                        count(&mut self.findings, code);
                    }
                    Ok(())
                }
                _ => Ok(()),
            };
            outcome.map_err(|e| self.lines.locate(e))?;
        }
        Ok(())
    }

    fn end_pass(&mut self) {
        if self.pass == Pass::Vertices {
            // One more normal, of no direction, for the corners that have none.
            self.out.push_str("vn 0 0 0\n");
            self.lines.rewind();
            self.pass = Pass::Faces;
        } else {
            self.pass = Pass::Done;
        }
    }
}

impl Read for Feed<'_> {
    fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
        let n = self.fill_buf()?.read(into)?;
        self.consume(n);
        Ok(n)
    }
}

impl BufRead for Feed<'_> {
    fn fill_buf(&mut self) -> std::io::Result<&[u8]> {
        if self.sent >= self.out.len()
            && let Err(e) = self.prepare()
        {
            self.error = Some(e);
            return Err(std::io::Error::other("the file is malformed"));
        }
        Ok(self.out.as_bytes().get(self.sent..).unwrap_or_default())
    }

    fn consume(&mut self, n: usize) {
        self.sent = self.sent.saturating_add(n);
    }
}

fn count(findings: &mut Findings, code: &'static str) {
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

fn vertex<'l>(
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

fn normal<'l>(
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
fn face<'l>(
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
                format!("face {id} has more than {MAX_CORNERS} corners"),
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
                "face {id} uses {what} {} of {total}",
                String::from_utf8_lossy(text.get(..text.len().min(40)).unwrap_or_default())
            ),
        )
        .remedy(format!("{what} numbers count from 1, or from -1 backwards; export the file again"))),
    }
}

fn check_limit(faces: u64, max_faces: u64) -> Result<(), Error> {
    if faces <= max_faces {
        return Ok(());
    }
    Err(Error::new(ErrorKind::Limit, "FC501", format!("more faces than the limit of {max_faces}"))
        .limit(max_faces, faces)
        .remedy("simplify or split the model, or raise the limit"))
}

/// Statements that are no part of a polygon mesh and are worth a warning.
fn oddity(keyword: &[u8]) -> Option<&'static str> {
    match keyword {
        b"f" | b"o" | b"g" | b"s" | b"vt" | b"vp" | b"usemtl" | b"usemap" | b"maplib" | b"mg" | b"bevel"
        | b"c_interp" | b"d_interp" | b"lod" | b"shadow_obj" | b"trace_obj" => None,
        b"l" | b"p" => Some("lines_and_points"),
        b"cstype" | b"deg" | b"bmat" | b"step" | b"curv" | b"curv2" | b"surf" | b"parm" | b"trim"
        | b"hole" | b"scrv" | b"sp" | b"end" | b"con" | b"ctech" | b"stech" => Some("free_form_geometry"),
        _ => Some("unknown_statements"),
    }
}

/// Looks whether a material file is there; it is never opened, and never sought outside the folder.
fn material_file(folder: &Path, name: &[u8]) -> Option<&'static str> {
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
