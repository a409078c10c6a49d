//! The first 128 bytes of a file.

use zerocopy::little_endian::{U16, U32, U64, U128};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

use crate::child::ChildRef;
use crate::error::Violation;
use crate::rule::Rule;

/// The first eight bytes. The first catches 7-bit transfers, the line ends after `FCT` catch text-mode ones.
pub const MAGIC: [u8; 8] = *b"\x8FFCT\r\n\x1A\n";

/// The major version that this crate writes and reads.
pub const MAJOR: u16 = 1;

/// The minor version that this crate writes, and the largest that it knows all of.
pub const MINOR: u16 = 3;

/// The byte order tag as a little-endian reader sees it.
pub const ENDIAN_TAG: u32 = 0x0102_0304;

/// Bytes of the header.
pub const HEADER_LEN: usize = 128;

/// The least size of a section entry, and the one that is written.
pub(crate) const ENTRY_LEN: usize = 64;

const MAX_ENTRY_LEN: u32 = 4096;

#[derive(Clone, Copy, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
struct RawHeader {
    magic: [u8; 8],
    major: U16,
    minor: U16,
    endian: U32,
    file_len: U64,
    required_features: U64,
    optional_features: U64,
    section_count: U32,
    section_entry_size: U32,
    section_table_offset: U64,
    node_count: U64,
    vertex_count: U64,
    face_count: U64,
    content_id: U128,
    source_id: U128,
    root: U32,
    reserved: U32,
    hash: U64,
}

const _: () = assert!(size_of::<RawHeader>() == HEADER_LEN);

/// Bytes of the header that its hash covers: all before the hash itself.
pub(crate) const HASHED_LEN: usize = HEADER_LEN - size_of::<U64>();

/// What the header of a file says.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Header {
    /// Major version.
    pub major: u16,
    /// Minor version.
    pub minor: u16,
    /// Length of the file in bytes.
    pub file_len: u64,
    /// Features without which the file cannot be read: none so far.
    pub required_features: u64,
    /// Features that a reader may ignore.
    pub optional_features: u64,
    /// Number of sections.
    pub section_count: u32,
    /// Bytes of an entry of the section table.
    pub section_entry_size: u32,
    /// Interior nodes: one less than faces.
    pub node_count: u64,
    /// Vertices.
    pub vertex_count: u64,
    /// Faces: leaves of the tree.
    pub face_count: u64,
    /// XXH3-128 of all sections in file order: equal for equal contents.
    pub content_id: u128,
    /// What the writer's caller gave to tell the input and the settings.
    pub source_id: u128,
    /// The root of the tree.
    pub root: ChildRef,
    /// XXH3-64 of the header before it and the section table.
    pub hash: u64,
}

impl Header {
    /// Reads the fields and checks what the header alone can tell, against the file's real length. `bytes` begin the file.
    pub(crate) fn parse(bytes: &[u8], length: u64) -> Result<Self, Box<Violation>> {
        check_signature(bytes)?;
        let Ok((raw, _)) = RawHeader::ref_from_prefix(bytes) else {
            return Err(Violation::new(
                Rule::TooShort,
                format!("byte {}", bytes.len()),
                "the file ends here".to_owned(),
            ));
        };
        check_byte_order(raw.endian.get())?;
        check_version(raw.major.get(), raw.minor.get())?;
        let file_len = raw.file_len.get();
        if length != file_len {
            return Err(Violation::in_header(
                Rule::FileLength,
                16,
                format!("it announces {file_len} bytes and the file has {length}"),
            ));
        }
        if raw.required_features.get() != 0 {
            return Err(Violation::in_header(
                Rule::Features,
                24,
                format!("required features {:#x}", raw.required_features.get()),
            ));
        }
        check_table(raw)?;
        if raw.reserved.get() != 0 {
            return Err(Violation::in_header(
                Rule::ReservedZero,
                116,
                format!("found {:#x}", raw.reserved.get()),
            ));
        }
        Ok(Self {
            major: raw.major.get(),
            minor: raw.minor.get(),
            file_len,
            required_features: raw.required_features.get(),
            optional_features: raw.optional_features.get(),
            section_count: raw.section_count.get(),
            section_entry_size: raw.section_entry_size.get(),
            node_count: raw.node_count.get(),
            vertex_count: raw.vertex_count.get(),
            face_count: raw.face_count.get(),
            content_id: raw.content_id.get(),
            source_id: raw.source_id.get(),
            root: ChildRef::from_raw(raw.root.get()),
            hash: raw.hash.get(),
        })
    }

    /// Bytes of the section table.
    pub(crate) fn table_len(&self) -> usize {
        let bytes = u64::from(self.section_count).saturating_mul(u64::from(self.section_entry_size));
        usize::try_from(bytes).unwrap_or(usize::MAX)
    }

    /// The bytes of the header, with the hash as it stands in the field.
    pub(crate) fn to_bytes(&self) -> [u8; HEADER_LEN] {
        let raw = RawHeader {
            magic: MAGIC,
            major: self.major.into(),
            minor: self.minor.into(),
            endian: ENDIAN_TAG.into(),
            file_len: self.file_len.into(),
            required_features: self.required_features.into(),
            optional_features: self.optional_features.into(),
            section_count: self.section_count.into(),
            section_entry_size: self.section_entry_size.into(),
            section_table_offset: table_offset().into(),
            node_count: self.node_count.into(),
            vertex_count: self.vertex_count.into(),
            face_count: self.face_count.into(),
            content_id: self.content_id.into(),
            source_id: self.source_id.into(),
            root: self.root.raw().into(),
            reserved: 0.into(),
            hash: self.hash.into(),
        };
        zerocopy::transmute!(raw)
    }
}

const fn table_offset() -> u64 {
    HEADER_LEN as u64
}

fn check_signature(bytes: &[u8]) -> Result<(), Box<Violation>> {
    let start = bytes.get(..MAGIC.len()).unwrap_or(bytes);
    if MAGIC.starts_with(start) {
        return Ok(());
    }
    // The commonest wrong files are told by name, since "bad magic" helps nobody.
    const BUILD: &str = "build a tree of it first: `fcbuild MESH -o OUT.fct`";
    const OTHERS: &[(&[u8], &str, &str)] = &[
        (b"ply", "the file starts with `ply`: a PLY mesh", BUILD),
        (b"glTF", "the file starts with `glTF`: a GLB scene", BUILD),
        (b"solid", "the file starts with `solid`: an STL mesh", BUILD),
        (&[0x1F, 0x8B], "the file starts like gzip", "unpack it first"),
        (
            b"\x8FFCT",
            "the file starts like a .fct file whose line ends were changed",
            "copy it again in binary mode",
        ),
        (b"\x0FFCT", "the file starts like a .fct file cut to 7 bits", "copy it again in binary mode"),
    ];
    let Some((_, found, remedy)) = OTHERS.iter().find(|(prefix, ..)| bytes.starts_with(prefix)) else {
        let found = format!("this is no .fct file: it starts with {}", in_words(start));
        return Err(Violation::in_header(Rule::Signature, 0, found));
    };
    let mut violation = Violation::in_header(Rule::Signature, 0, *found);
    violation.remedy = Some(remedy);
    Err(violation)
}

/// Bytes as the text that they are, else as numbers.
fn in_words(bytes: &[u8]) -> String {
    let is_text = |byte: &u8| byte.is_ascii_graphic() || byte.is_ascii_whitespace();
    match std::str::from_utf8(bytes) {
        Ok(text) if bytes.iter().all(is_text) => format!("the text {text:?}"),
        _ => format!(
            "the bytes {}",
            bytes.iter().map(|byte| format!("{byte:02X}")).collect::<Vec<_>>().join(" ")
        ),
    }
}

fn check_byte_order(tag: u32) -> Result<(), Box<Violation>> {
    if tag == ENDIAN_TAG {
        return Ok(());
    }
    let found = if tag == ENDIAN_TAG.swap_bytes() {
        "the file is big-endian".to_owned()
    } else {
        format!("found {tag:#010x}")
    };
    Err(Violation::in_header(Rule::ByteOrder, 12, found))
}

fn check_version(major: u16, minor: u16) -> Result<(), Box<Violation>> {
    if major == MAJOR {
        return Ok(());
    }
    let mut violation = Violation::in_header(
        Rule::Version,
        8,
        format!(
            "the file has version {major}.{minor}, this program reads {MAJOR}.0 and later ones of {MAJOR}"
        ),
    );
    if major < MAJOR {
        violation.remedy =
            Some("the file is of a trial version: build it again from its mesh, `fcbuild MESH -o OUT.fct`");
    }
    Err(violation)
}

fn check_table(raw: &RawHeader) -> Result<(), Box<Violation>> {
    let count = raw.section_count.get();
    if !(1..=crate::section::MAX_SECTIONS).contains(&count) {
        return Err(Violation::in_header(Rule::SectionCount, 40, format!("found {count}")));
    }
    let size = raw.section_entry_size.get();
    let offset = raw.section_table_offset.get();
    let least = u32::try_from(ENTRY_LEN).unwrap_or(u32::MAX);
    let sized = (least..=MAX_ENTRY_LEN).contains(&size) && size.is_multiple_of(8);
    // Both factors are small by now, so the product cannot overflow.
    let end = u64::from(count).saturating_mul(u64::from(size)).saturating_add(table_offset());
    if sized && offset == table_offset() && end <= raw.file_len.get() {
        return Ok(());
    }
    Err(Violation::in_header(
        Rule::TablePlace,
        44,
        format!("{count} entries of {size} bytes at byte {offset}"),
    ))
}
