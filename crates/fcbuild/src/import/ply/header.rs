//! The header of a PLY file: which elements follow, with which properties, in which encoding.

use std::collections::BTreeSet;

use super::super::number::shown;
use super::super::window::Window;
use crate::error::{Error, ErrorKind};

/// Longest header; real ones take a few hundred bytes.
const MAX_HEADER: u64 = 1 << 20;
/// Longest line of a header.
const MAX_LINE: usize = 64 * 1024;

/// How the values after the header are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    Little,
    Big,
}

/// The scalar types of the format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn parse(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes of a value in a binary file.
    pub(super) fn size(self) -> u64 {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// Whether values are whole numbers.
    pub(super) fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }

    /// Whether every value is one of `f32` exactly.
    pub(super) fn fits_f32(self) -> bool {
        !matches!(self, Self::I32 | Self::U32 | Self::F64)
    }
}

/// What a property holds per record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    One(Scalar),
    List { count: Scalar, item: Scalar },
}

#[derive(Clone, Debug)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) kind: Kind,
}

/// A run of records of one shape.
#[derive(Clone, Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
    /// Line of the header that declares it.
    pub(super) line: u64,
}

impl Element {
    /// Fewest bytes that a record takes.
    pub(super) fn smallest_record(&self, encoding: Encoding) -> u64 {
        self.properties.iter().fold(0u64, |sum, p| {
            sum.saturating_add(match (encoding, p.kind) {
                // A digit and what separates it from the next.
                (Encoding::Ascii, _) => 2,
                (_, Kind::One(scalar)) => scalar.size(),
                (_, Kind::List { count, .. }) => count.size(),
            })
        })
    }

    /// The names of the properties, for messages.
    pub(super) fn listed(&self) -> String {
        let names: Vec<&str> = self.properties.iter().take(20).map(|p| p.name.as_str()).collect();
        if names.is_empty() { "none".to_owned() } else { names.join(", ") }
    }
}

/// A header that has been read; the window stands at the first byte of the body.
#[derive(Clone, Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// Lines of the header, so that the body's first line is `lines + 1`.
    pub(super) lines: u64,
}

/// What ends a line, fixed by the first one: in a binary file the byte after `end_header` and its
/// line end may be anything, a line feed too.
#[derive(Clone, Copy, PartialEq, Eq)]
enum LineEnd {
    Lf,
    CrLf,
    Cr,
}

/// Reads the header.
pub(super) fn read(window: &mut Window<'_>) -> Result<Header, Error> {
    let style = line_end(window)?;
    let mut lines = 0u64;
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    let mut names = BTreeSet::new();
    loop {
        let start = window.offset();
        let line = next_line(window, style)?;
        lines = lines.saturating_add(1);
        let line_number = lines;
        let here = |e: Error| e.at_line(line_number).at_byte(start);
        let bad = |what: String| here(Error::bad_input("FC202", what).remedy("export the file again"));
        // Comments may be in any encoding and are never looked at.
        let text = String::from_utf8_lossy(&line);
        let words: Vec<&str> = text.split_ascii_whitespace().take(6).collect();
        match *words.as_slice() {
            ["ply"] if lines == 1 => {}
            [] | ["comment" | "obj_info", ..] => {}
            ["format", kind, version] => {
                if encoding.is_some() {
                    return Err(bad("the header has two format lines".into()));
                }
                encoding = Some(match (kind, version) {
                    ("ascii", "1.0") => Encoding::Ascii,
                    ("binary_little_endian", "1.0") => Encoding::Little,
                    ("binary_big_endian", "1.0") => Encoding::Big,
                    _ => {
                        return Err(bad(format!(
                            "unknown format {}; known are ascii, binary_little_endian and binary_big_endian 1.0",
                            shown(format!("{kind} {version}").as_bytes())
                        )));
                    }
                });
            }
            ["element", name, count] => {
                let count = count.parse().map_err(|_not_u64: std::num::ParseIntError| {
                    bad(format!("{} is no count of {name} records", shown(count.as_bytes())))
                })?;
                // Only these are searched for, so that a header of many elements costs no square of them.
                if matches!(name, "vertex" | "face" | "tristrips") && elements.iter().any(|e| e.name == name)
                {
                    return Err(bad(format!("element {name} is declared twice")));
                }
                names.clear();
                elements.push(Element { name: name.to_owned(), count, properties: Vec::new(), line: lines });
            }
            ["property", ref rest @ ..] => {
                let Some(element) = elements.last_mut() else {
                    return Err(bad("a property comes before the first element".into()));
                };
                let scalar = |name: &str| {
                    Scalar::parse(name).ok_or_else(|| bad(format!("unknown type {}", shown(name.as_bytes()))))
                };
                let (name, kind) = match *rest {
                    ["list", count, item, name] => {
                        let (count, item) = (scalar(count)?, scalar(item)?);
                        if !count.is_integer() {
                            return Err(bad(format!(
                                "the length of list {name} has a type that is no integer"
                            )));
                        }
                        (name, Kind::List { count, item })
                    }
                    [kind, name] => (name, Kind::One(scalar(kind)?)),
                    _ => return Err(bad(format!("malformed property line {}", shown(&line)))),
                };
                if !names.insert(name.to_owned()) {
                    return Err(bad(format!("element {} has two properties {name}", element.name)));
                }
                element.properties.push(Property { name: name.to_owned(), kind });
            }
            ["end_header"] => break,
            _ => return Err(bad(format!("unknown header line {}", shown(&line)))),
        }
    }
    let Some(encoding) = encoding else {
        return Err(
            Error::bad_input("FC202", "the header has no format line").remedy("export the file again")
        );
    };
    Ok(Header { encoding, elements, lines })
}

fn line_end(window: &mut Window<'_>) -> Result<LineEnd, Error> {
    match window.peek(5) {
        [b'p', b'l', b'y', b'\r', b'\n', ..] => Ok(LineEnd::CrLf),
        [b'p', b'l', b'y', b'\r', ..] => Ok(LineEnd::Cr),
        [b'p', b'l', b'y', b'\n' | b' ' | b'\t', ..] => Ok(LineEnd::Lf),
        other => Err(Error::bad_input(
            "FC201",
            format!("a PLY file begins with the line `ply`, this one with {}", shown(other)),
        )
        .at_byte(0)
        .remedy("give the file the extension of its format")),
    }
}

/// Takes the next line without its end.
fn next_line(window: &mut Window<'_>, style: LineEnd) -> Result<Vec<u8>, Error> {
    let start = window.offset();
    let end = if style == LineEnd::Cr { b'\r' } else { b'\n' };
    let mut need = 256;
    loop {
        let bytes = window.peek(need);
        let seen = bytes.len();
        let within = bytes.get(..seen.min(MAX_LINE)).unwrap_or_default();
        if let Some(at) = within.iter().position(|&b| b == end) {
            let mut line = within.get(..at).unwrap_or_default().to_vec();
            if line.last() == Some(&b'\r') {
                line.pop();
            }
            window.consume(at.saturating_add(1));
            if window.offset() > MAX_HEADER {
                return Err(limit("the header has no `end_header` in its first", MAX_HEADER, start));
            }
            return Ok(line);
        }
        if seen >= MAX_LINE {
            return Err(limit("a header line is longer than", MAX_LINE as u64, start));
        }
        if seen < need {
            return Err(Error::bad_input("FC204", "the file ends within the header, before `end_header`")
                .at_byte(start.saturating_add(seen as u64))
                .remedy("the file is cut off; copy or export it again"));
        }
        need = need.saturating_mul(4).min(MAX_LINE);
    }
}

fn limit(what: &str, limit: u64, byte: u64) -> Error {
    Error::new(ErrorKind::BadInput, "FC202", format!("{what} {limit} bytes"))
        .at_byte(byte)
        .limit(limit, limit)
        .remedy("this is no PLY file, or it is damaged")
}
