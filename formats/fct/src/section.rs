//! The section table: where each array of the file lies.

use std::fmt;
use std::ops::Range;

use zerocopy::little_endian::{U16, U32, U64};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

use crate::error::Violation;
use crate::header::ENTRY_LEN;
use crate::rule::Rule;

/// The most sections a file may have.
pub const MAX_SECTIONS: u32 = 64;

/// Sections lie at multiples of this at least, and that is what is written: a cache line.
pub(crate) const ALIGN_LOG2: u8 = 6;

/// Beyond this an alignment is no use and only a way to hide bytes in padding.
const MAX_ALIGN_LOG2: u8 = 20;

const MUST_UNDERSTAND: u32 = 1;

const XXH3_64: u8 = 1;

/// The four bytes that name a section.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Tag(pub [u8; 4]);

impl Tag {
    /// The description, see [`crate::Meta`].
    pub const META: Self = Self(*b"META");
    /// Nodes above the pages in preorder, see [`crate::TopRecord`].
    pub const TOPN: Self = Self(*b"TOPN");
    /// Boundary loops of the nodes above the pages.
    pub const TOPL: Self = Self(*b"TOPL");
    /// Pages in tree order, see [`crate::PageRecord`].
    pub const PAGE: Self = Self(*b"PAGE");
    /// Nodes of the pages in preorder, see [`crate::NodeRecord`].
    pub const NODE: Self = Self(*b"NODE");
    /// Faces in tree order, see [`crate::FaceRecord`].
    pub const FACE: Self = Self(*b"FACE");
    /// Boundary loops of the nodes of the pages.
    pub const LOOP: Self = Self(*b"LOOP");
    /// Vertices that pages share with pages before them.
    pub const LINK: Self = Self(*b"LINK");
    /// Vertices, see [`crate::VertexRecord`].
    pub const VERT: Self = Self(*b"VERT");
    /// Copies made by cutting seams, see [`crate::WeldRecord`].
    pub const WELD: Self = Self(*b"WELD");
    /// Bounding polygons, see [`crate::BoundingPolygonRecord`].
    pub const BPOL: Self = Self(*b"BPOL");
    /// Vertex normals, see [`crate::NormalRecord`].
    pub const NORM: Self = Self(*b"NORM");
    /// Vertex colours: red, green, blue in sRGB, and alpha.
    pub const COLR: Self = Self(*b"COLR");
    /// Component groups, see [`crate::GroupRecord`].
    pub const GRUP: Self = Self(*b"GRUP");
    /// The nodes above the chunks and where chunks and pages are, see [`crate::ChunkFile`].
    pub const CRPG: Self = Self(*b"CRPG");
    /// Copies that the tops of chunks are drawn with.
    pub const CHTP: Self = Self(*b"CHTP");

    /// Bytes of an element, or none for a section this version does not know.
    pub(crate) const fn element_size(self) -> Option<u32> {
        match &self.0 {
            b"META" | b"TOPL" | b"LOOP" | b"CRPG" | b"CHTP" => Some(1),
            b"TOPN" => Some(68),
            b"PAGE" => Some(40),
            b"NODE" => Some(16),
            b"FACE" => Some(3),
            b"LINK" | b"COLR" => Some(4),
            b"VERT" => Some(27),
            b"WELD" => Some(8),
            b"BPOL" => Some(28),
            b"GRUP" => Some(16),
            b"NORM" => Some(2),
            _ => None,
        }
    }

    /// Whether a reader that does not know the section must refuse the file. That holds for what a picture cannot be drawn without.
    pub(crate) const fn must_understand(self) -> bool {
        matches!(
            &self.0,
            b"META" | b"TOPN" | b"TOPL" | b"PAGE" | b"NODE" | b"FACE" | b"LOOP" | b"LINK" | b"VERT"
        )
    }
}

impl fmt::Display for Tag {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.0.escape_ascii())
    }
}

impl fmt::Debug for Tag {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

#[derive(Clone, Copy, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
struct RawEntry {
    tag: [u8; 4],
    flags: U32,
    offset: U64,
    length: U64,
    elem_size: U32,
    align_log2: u8,
    hash_kind: u8,
    zero: U16,
    elem_count: U64,
    hash: U64,
    reserved: [u8; 16],
}

const _: () = assert!(size_of::<RawEntry>() == ENTRY_LEN);

/// One section of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct SectionInfo {
    /// Its name.
    pub tag: Tag,
    /// Whether a reader that does not know it must refuse the file.
    pub must_understand: bool,
    /// Its first byte in the file.
    pub offset: u64,
    /// Its length in bytes, without padding.
    pub length: u64,
    /// Bytes of an element.
    pub elem_size: u32,
    /// Number of elements.
    pub elem_count: u64,
    /// Its offset is a multiple of 2 to this.
    pub align_log2: u8,
    /// XXH3-64 of its bytes.
    pub hash: u64,
}

impl SectionInfo {
    /// One past its last byte. Saturates, which only an entry that was not checked can meet.
    pub const fn end(&self) -> u64 {
        self.offset.saturating_add(self.length)
    }

    /// The section as a range of memory.
    pub(crate) fn range(&self) -> Result<Range<usize>, Box<Violation>> {
        match (usize::try_from(self.offset), usize::try_from(self.end())) {
            (Ok(start), Ok(end)) => Ok(start..end),
            _ => Err(Violation::new(
                Rule::SectionPlace,
                format!("section {}", self.tag),
                "it lies beyond the memory of this machine".to_owned(),
            )),
        }
    }

    /// Reads entry `index` of the table and checks what it alone can tell.
    pub(crate) fn parse(index: usize, entry: &[u8]) -> Result<Self, Box<Violation>> {
        let Ok((raw, _)) = RawEntry::ref_from_prefix(entry) else {
            return Err(Violation::new(
                Rule::TablePlace,
                format!("section entry {index}"),
                format!("only {} bytes are left for it", entry.len()),
            ));
        };
        let tag = Tag(raw.tag);
        let broken = |rule: Rule, found: String| {
            Err(Violation::new(rule, format!("section {tag} (entry {index})"), found))
        };
        let flags = raw.flags.get();
        if flags & !MUST_UNDERSTAND != 0 || raw.zero.get() != 0 || raw.reserved != [0; 16] {
            return broken(
                Rule::ReservedZero,
                format!("flags {flags:#x}, reserved {:#x} and {:02X?}", raw.zero.get(), raw.reserved),
            );
        }
        if raw.hash_kind != XXH3_64 {
            return broken(Rule::HashKind, format!("its hash is of kind {}", raw.hash_kind));
        }
        let must_understand = flags & MUST_UNDERSTAND != 0;
        if must_understand && tag.element_size().is_none() {
            return broken(Rule::SectionKnown, "it is not known".to_owned());
        }
        let (size, count, length) = (raw.elem_size.get(), raw.elem_count.get(), raw.length.get());
        let expected = tag.element_size().unwrap_or(size);
        if u64::from(size).checked_mul(count) != Some(length) || size != expected || size == 0 {
            return broken(
                Rule::SectionSize,
                format!("{count} elements of {size} bytes (expected {expected}) in {length} bytes"),
            );
        }
        if !(ALIGN_LOG2..=MAX_ALIGN_LOG2).contains(&raw.align_log2) {
            return broken(
                Rule::SectionPlace,
                format!(
                    "its alignment is 2^{}, expected 2^{ALIGN_LOG2} to 2^{MAX_ALIGN_LOG2}",
                    raw.align_log2
                ),
            );
        }
        Ok(Self {
            tag,
            must_understand,
            offset: raw.offset.get(),
            length,
            elem_size: size,
            elem_count: count,
            align_log2: raw.align_log2,
            hash: raw.hash.get(),
        })
    }

    pub(crate) fn to_bytes(&self) -> [u8; ENTRY_LEN] {
        let raw = RawEntry {
            tag: self.tag.0,
            flags: if self.must_understand { MUST_UNDERSTAND.into() } else { 0.into() },
            offset: self.offset.into(),
            length: self.length.into(),
            elem_size: self.elem_size.into(),
            align_log2: self.align_log2,
            hash_kind: XXH3_64,
            zero: 0.into(),
            elem_count: self.elem_count.into(),
            hash: self.hash.into(),
            reserved: [0; 16],
        };
        zerocopy::transmute!(raw)
    }
}

/// The first multiple of 2 to `align_log2` from `offset` on, if there is one.
pub(crate) fn align_up(offset: u64, align_log2: u8) -> Option<u64> {
    offset.checked_next_multiple_of(1_u64.checked_shl(u32::from(align_log2))?)
}

/// Checks that the sections fill the file from `start` to `file_len`, in order, with nothing but padding between them.
pub(crate) fn check_places(
    sections: &[SectionInfo],
    start: u64,
    file_len: u64,
) -> Result<(), Box<Violation>> {
    let mut end = start;
    for section in sections {
        let expected = align_up(end, section.align_log2);
        let section_end = section.offset.checked_add(section.length);
        match section_end {
            Some(e) if expected == Some(section.offset) && e <= file_len => end = e,
            _ => {
                return Err(Violation::new(
                    Rule::SectionPlace,
                    format!("section {}", section.tag),
                    format!(
                        "{} bytes at byte {} of a file of {file_len} bytes, expected them at byte {}",
                        section.length,
                        section.offset,
                        expected.map_or_else(|| "(none)".to_owned(), |e| e.to_string()),
                    ),
                ));
            }
        }
    }
    if end != file_len {
        return Err(Violation::new(
            Rule::SectionPlace,
            format!("byte {end}"),
            format!("the last section ends here and the file at {file_len}"),
        ));
    }
    for (index, section) in sections.iter().enumerate() {
        if sections.iter().take(index).any(|earlier| earlier.tag == section.tag) {
            return Err(Violation::new(
                Rule::SectionTag,
                format!("section {} (entry {index})", section.tag),
                "an earlier section has this tag".to_owned(),
            ));
        }
    }
    Ok(())
}
