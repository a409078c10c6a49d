//! The rules that every file keeps before its contents are looked at, checked in constant time.

use std::ops::Range;

use crate::child::ChildRef;
use crate::error::Violation;
use crate::hash::{hash64, hash64_of};
use crate::header::{HASHED_LEN, HEADER_LEN, Header};
use crate::meta::{MAX_META_LEN, Meta};
use crate::records::MAX_FACES;
use crate::rule::Rule;
use crate::section::{SectionInfo, Tag, check_places};

/// Byte ranges of the known sections, inside the file and of whole elements.
///
/// Absent sections are empty ranges, but for those where "absent" and "empty" differ.
#[derive(Clone, Debug, Default)]
pub(crate) struct Spans {
    pub(crate) topn: Range<usize>,
    pub(crate) topl: Range<usize>,
    pub(crate) page: Range<usize>,
    pub(crate) node: Range<usize>,
    pub(crate) face: Range<usize>,
    pub(crate) loops: Range<usize>,
    pub(crate) link: Range<usize>,
    pub(crate) vert: Range<usize>,
    pub(crate) weld: Range<usize>,
    pub(crate) bpol: Range<usize>,
    pub(crate) grup: Range<usize>,
    pub(crate) norm: Option<Range<usize>>,
    pub(crate) colr: Option<Range<usize>>,
    pub(crate) crpg: Option<Range<usize>>,
    pub(crate) chtp: Option<Range<usize>>,
}

/// A file whose container rules hold.
#[derive(Debug)]
pub(crate) struct Container {
    pub(crate) header: Header,
    pub(crate) meta: Meta,
    pub(crate) sections: Vec<SectionInfo>,
    pub(crate) spans: Spans,
}

impl Container {
    /// Checks header, table, counts and description. Looks at no other section, so the cost does not grow with the file.
    pub(crate) fn parse(bytes: &[u8]) -> Result<Self, Box<Violation>> {
        let header = Header::parse(bytes, u64::try_from(bytes.len()).unwrap_or(u64::MAX))?;
        let (sections, spans) = Self::parse_table(bytes, &header)?;
        let section = find(&sections, Tag::META).ok_or_else(|| missing(Tag::META))?;
        let meta = Self::read_meta(section, bytes.get(section.range()?).unwrap_or_default())?;
        Ok(Self { header, meta, sections, spans })
    }

    /// The same but for the description; `bytes` begin the file and hold the table.
    pub(crate) fn parse_table(
        bytes: &[u8],
        header: &Header,
    ) -> Result<(Vec<SectionInfo>, Spans), Box<Violation>> {
        let table = table_bytes(bytes, header)?;
        check_header_hash(bytes, table, header)?;
        let entry_size = table
            .len()
            .checked_div(usize::try_from(header.section_count).unwrap_or(0))
            .filter(|size| *size > 0)
            .unwrap_or(1);
        // At most 64 entries: a table that passed the checks cannot make this large.
        let mut sections = Vec::new();
        for (index, entry) in table.chunks_exact(entry_size).enumerate() {
            sections.push(SectionInfo::parse(index, entry)?);
        }
        let table_end = HEADER_LEN.saturating_add(table.len());
        check_places(&sections, u64::try_from(table_end).unwrap_or(u64::MAX), header.file_len)?;
        check_counts(&Counts::of_file(header, &sections)?)?;
        check_root(header.root, header.face_count)?;
        let spans = Spans {
            topn: required(&sections, Tag::TOPN)?,
            topl: required(&sections, Tag::TOPL)?,
            page: required(&sections, Tag::PAGE)?,
            node: required(&sections, Tag::NODE)?,
            face: required(&sections, Tag::FACE)?,
            loops: required(&sections, Tag::LOOP)?,
            link: required(&sections, Tag::LINK)?,
            vert: required(&sections, Tag::VERT)?,
            weld: span(&sections, Tag::WELD)?.unwrap_or_default(),
            bpol: span(&sections, Tag::BPOL)?.unwrap_or_default(),
            grup: span(&sections, Tag::GRUP)?.unwrap_or_default(),
            norm: span(&sections, Tag::NORM)?,
            colr: span(&sections, Tag::COLR)?,
            crpg: span(&sections, Tag::CRPG)?,
            chtp: span(&sections, Tag::CHTP)?,
        };
        Ok((sections, spans))
    }

    /// Checks and decodes the description.
    pub(crate) fn read_meta(section: &SectionInfo, payload: &[u8]) -> Result<Meta, Box<Violation>> {
        Self::check_meta_len(payload.len())?;
        check_section_hash(section, payload)?;
        Meta::decode(payload)
    }

    pub(crate) fn check_meta_len(bytes: usize) -> Result<(), Box<Violation>> {
        if bytes <= MAX_META_LEN {
            return Ok(());
        }
        let found = format!("it has {bytes} bytes");
        Err(Violation::new(Rule::MetaReadable, "section META".to_owned(), found))
    }
}

/// The numbers of elements, from wherever they are known.
pub(crate) struct Counts {
    pub(crate) tops: u64,
    pub(crate) top_loops: u64,
    pub(crate) pages: u64,
    pub(crate) nodes: u64,
    pub(crate) faces: u64,
    pub(crate) loops: u64,
    pub(crate) links: u64,
    pub(crate) vertices: u64,
    pub(crate) weld: u64,
    pub(crate) bounding_polygons: u64,
    pub(crate) groups: u64,
    pub(crate) normals: Option<u64>,
    pub(crate) colors: Option<u64>,
}

impl Counts {
    /// The counts of the sections, which must be the header's.
    fn of_file(header: &Header, sections: &[SectionInfo]) -> Result<Self, Box<Violation>> {
        let count = |tag| find(sections, tag).map(|s| s.elem_count);
        let present = |tag| count(tag).ok_or_else(|| missing(tag));
        let announced = |what, byte, announced, found| {
            if found == announced {
                return Ok(());
            }
            let found = format!("it announces {announced} and {what} {found}");
            Err(Violation::in_header(Rule::Counts, byte, found))
        };
        let counts = Self {
            tops: present(Tag::TOPN)?,
            top_loops: present(Tag::TOPL)?,
            pages: present(Tag::PAGE)?,
            nodes: present(Tag::NODE)?,
            faces: present(Tag::FACE)?,
            loops: present(Tag::LOOP)?,
            links: present(Tag::LINK)?,
            vertices: present(Tag::VERT)?,
            weld: count(Tag::WELD).unwrap_or(0),
            bounding_polygons: count(Tag::BPOL).unwrap_or(0),
            groups: count(Tag::GRUP).unwrap_or(0),
            normals: count(Tag::NORM),
            colors: count(Tag::COLR),
        };
        let nodes = counts.tops.saturating_add(counts.nodes);
        announced("sections TOPN and NODE have", 56, header.node_count, nodes)?;
        announced("section VERT has", 64, header.vertex_count, counts.vertices)?;
        announced("section FACE has", 72, header.face_count, counts.faces)?;
        Ok(counts)
    }
}

/// Checks that the counts can belong to one tree. Used before writing and after reading.
pub(crate) fn check_counts(counts: &Counts) -> Result<(), Box<Violation>> {
    let Counts { pages, vertices, faces, .. } = *counts;
    let in_32_bits = |n: u64| u32::try_from(n).is_ok();
    let rules = [
        ((1..=MAX_FACES).contains(&faces), "FACE", faces, format!("1 to {MAX_FACES}")),
        ((1..=faces).contains(&pages), "PAGE", pages, format!("1 to the {faces} faces")),
        (
            counts.tops == pages.saturating_sub(1),
            "TOPN",
            counts.tops,
            format!("one less than the {pages} pages"),
        ),
        (
            counts.nodes == faces.saturating_sub(pages),
            "NODE",
            counts.nodes,
            format!("the {faces} faces less the {pages} pages"),
        ),
        (
            (1..=faces.saturating_mul(3)).contains(&vertices),
            "VERT",
            vertices,
            format!("1 to three times the {faces} faces"),
        ),
        (in_32_bits(counts.top_loops), "TOPL", counts.top_loops, format!("at most {}", u32::MAX)),
        (in_32_bits(counts.loops), "LOOP", counts.loops, format!("at most {}", u32::MAX)),
        (in_32_bits(counts.links), "LINK", counts.links, format!("at most {}", u32::MAX)),
        (counts.weld <= vertices, "WELD", counts.weld, format!("at most the {vertices} vertices")),
        (
            counts.bounding_polygons < faces,
            "BPOL",
            counts.bounding_polygons,
            format!("fewer than the {faces} faces"),
        ),
        (counts.groups <= faces, "GRUP", counts.groups, format!("at most the {faces} faces")),
        (
            counts.normals.is_none_or(|n| n == vertices),
            "NORM",
            counts.normals.unwrap_or(0),
            format!("the {vertices} vertices"),
        ),
        (
            counts.colors.is_none_or(|n| n == vertices),
            "COLR",
            counts.colors.unwrap_or(0),
            format!("the {vertices} vertices"),
        ),
    ];
    for (holds, section, found, expected) in rules {
        if !holds {
            return Err(Violation::new(
                Rule::Counts,
                format!("section {section}"),
                format!("{found} elements, expected {expected}"),
            ));
        }
    }
    Ok(())
}

/// Checks the root reference, which the number of faces determines. Used before writing and after reading.
pub(crate) fn check_root(root: ChildRef, faces: u64) -> Result<(), Box<Violation>> {
    let expected = if faces == 1 { ChildRef::face(0) } else { ChildRef::node(0) };
    if root == expected {
        return Ok(());
    }
    Err(Violation::in_header(Rule::RootPlace, 112, format!("the root of {faces} faces is {:?}", root.kind())))
}

fn table_bytes<'a>(bytes: &'a [u8], header: &Header) -> Result<&'a [u8], Box<Violation>> {
    u64::from(header.section_count)
        .checked_mul(u64::from(header.section_entry_size))
        .and_then(|len| usize::try_from(len).ok())
        .and_then(|len| bytes.get(HEADER_LEN..HEADER_LEN.checked_add(len)?))
        .ok_or_else(|| {
            Violation::in_header(Rule::TablePlace, 44, format!("{} entries do not fit", header.section_count))
        })
}

fn check_header_hash(bytes: &[u8], table: &[u8], header: &Header) -> Result<(), Box<Violation>> {
    let hash = hash64_of(&[bytes.get(..HASHED_LEN).unwrap_or_default(), table]);
    if hash == header.hash {
        return Ok(());
    }
    Err(Violation::in_header(
        Rule::HeaderHash,
        120,
        format!("it is {:#018x}, computed {hash:#018x}", header.hash),
    ))
}

fn find(sections: &[SectionInfo], tag: Tag) -> Option<&SectionInfo> {
    sections.iter().find(|s| s.tag == tag)
}

fn missing(tag: Tag) -> Box<Violation> {
    Violation::new(Rule::SectionRequired, format!("section {tag}"), "it is missing".to_owned())
}

fn span(sections: &[SectionInfo], tag: Tag) -> Result<Option<Range<usize>>, Box<Violation>> {
    find(sections, tag).map(SectionInfo::range).transpose()
}

fn required(sections: &[SectionInfo], tag: Tag) -> Result<Range<usize>, Box<Violation>> {
    span(sections, tag)?.ok_or_else(|| missing(tag))
}

/// Compares the bytes of a section with the hash in the table.
pub(crate) fn check_section_hash(section: &SectionInfo, payload: &[u8]) -> Result<(), Box<Violation>> {
    let hash = hash64(payload);
    if hash == section.hash {
        return Ok(());
    }
    Err(Violation::new(
        Rule::SectionHash,
        format!("section {} (bytes {} to {})", section.tag, section.offset, section.end()),
        format!("its hash is {hash:#018x}, announced {:#018x}", section.hash),
    ))
}
