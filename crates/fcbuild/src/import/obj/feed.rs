//! Checks an OBJ file and rewrites it for the parser: only positions, normals and faces, in a form
//! on which the parser cannot fail.
//!
//! The file is walked twice. The first pass passes on `v` and `vn`, so that the second, which passes
//! on `f` with absolute indices, knows how many there are in all.

use std::io::{BufRead, Read};
use std::path::{Path, PathBuf};

use super::lines::Lines;
use super::statements::{Findings, count, face, material_file, normal, oddity, vertex};
use crate::error::{Error, ErrorKind};

/// Bytes that are prepared at a time.
const BATCH: usize = 64 * 1024;

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
    /// Faces of the second pass, as the first one counts them.
    announced: u64,
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
            announced: 0,
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
                self.end_pass()?;
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
                (Pass::Faces, b"o" | b"g") => {
                    let at = line.iter().position(|&b| keyword.contains(&b)).unwrap_or(0).saturating_add(1);
                    let name = String::from_utf8_lossy(line.get(at..).unwrap_or_default()).trim().to_owned();
                    let polygons = self.findings.polygons;
                    match keyword {
                        b"o" => self.findings.parts.object(name, polygons),
                        _ => self.findings.parts.group(name, polygons),
                    }
                    Ok(())
                }
                // Counted beforehand, so that a mesh that is too large is told with all its faces.
                (Pass::Vertices, b"f") => {
                    let corners = words.count() as u64;
                    self.announced = self.announced.saturating_add(corners.saturating_sub(2).max(1));
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

    fn end_pass(&mut self) -> Result<(), Error> {
        if self.pass == Pass::Vertices {
            check_limit(self.announced, self.max_faces)?;
            // One more normal, of no direction, for the corners that have none.
            self.out.push_str("vn 0 0 0\n");
            self.lines.rewind();
            self.pass = Pass::Faces;
        } else {
            self.pass = Pass::Done;
        }
        Ok(())
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

fn check_limit(faces: u64, max_faces: u64) -> Result<(), Error> {
    if faces <= max_faces {
        return Ok(());
    }
    Err(Error::new(ErrorKind::Limit, "FC501", format!("more faces than the limit of {max_faces}"))
        .limit(max_faces, faces)
        .remedy("simplify or split the model, or raise the limit"))
}
