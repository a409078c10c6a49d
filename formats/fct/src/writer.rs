//! Writing a file, all or nothing.

use std::fs::{self, File};
use std::io::{self, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::Path;
use std::thread;

use zerocopy::IntoBytes;

use crate::child::ChildRef;
use crate::chunk::ChunkData;
use crate::container::{Counts, check_counts};
use crate::error::Error;
use crate::hash::{hash64, hash64_of, hash128_of};
use crate::header::{ENTRY_LEN, HASHED_LEN, HEADER_LEN, Header, MAGIC, MAJOR, MINOR};
use crate::meta::{MAX_META_LEN, Meta};
use crate::octahedral::NormalRecord;
use crate::pack::Packed;
use crate::publish::Pending;
use crate::records::{BoundingPolygonRecord, GroupRecord, MAX_FACES, VertexRecord, WeldRecord};
use crate::section::{ALIGN_LOG2, SectionInfo, Tag, align_up};
use crate::tree::Tree;

/// Everything that a file holds.
#[derive(Clone, Copy, Debug)]
pub struct TreeData<'a> {
    /// The description.
    pub meta: &'a Meta,
    /// Nodes, faces and loops.
    pub clusters: &'a Packed,
    /// Vertices in order of first use by the faces.
    pub vertices: &'a [VertexRecord],
    /// Copies made by cutting seams, sorted by vertex. Left out of the file when empty.
    pub weld: &'a [WeldRecord],
    /// Bounding polygons sorted by node. Left out of the file when empty.
    pub bounding_polygons: &'a [BoundingPolygonRecord],
    /// A normal a vertex.
    pub normals: Option<&'a [NormalRecord]>,
    /// Red, green, blue (sRGB) and alpha a vertex.
    pub colors: Option<&'a [[u8; 4]]>,
    /// Component groups sorted by first face. Left out of the file when empty.
    pub groups: &'a [GroupRecord],
    /// What makes parts of the file readable alone; left out if none.
    pub chunks: Option<&'a ChunkData>,
}

/// How [`write()`] deals with the output.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WriteOptions {
    /// Replace an existing file.
    pub overwrite: bool,
    /// Any number that tells the input and the settings, such as a hash of both.
    pub source_id: u128,
}

/// What was written.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Written {
    /// Bytes of the file.
    pub bytes: u64,
    /// XXH3-128 of all sections: equal for equal contents.
    pub content_id: u128,
    /// Tag and bytes of each section, in file order.
    pub sections: Vec<(String, u64)>,
}

/// Writes a file: [`Writer::create`], then [`Writer::finish`].
///
/// # Errors
/// As those two.
pub fn write(path: &Path, data: &TreeData<'_>, options: &WriteOptions) -> Result<Written, Error> {
    Writer::create(path, options.overwrite)?.finish(data, options.source_id)
}

/// A file that is not there yet. Dropping it leaves nothing behind.
#[derive(Debug)]
pub struct Writer {
    pending: Pending,
}

impl Writer {
    /// Prepares to write `path`: makes a temporary in its folder, so that a builder learns of an unwritable place before the long work.
    ///
    /// # Errors
    /// [`Error::Exists`] without `overwrite` when something is there, [`Error::NotATree`] with it when what is there
    /// is no tree, [`Error::NotAFile`] for a directory, [`Error::Folder`] when the folder is missing or not writable.
    pub fn create(path: &Path, overwrite: bool) -> Result<Self, Error> {
        if overwrite {
            spare_others(path)?;
        }
        Ok(Self { pending: Pending::create(path, overwrite)? })
    }

    /// Writes everything and moves it to its place: [`Writer::complete`], then [`Complete::publish`].
    ///
    /// # Errors
    /// As those two; the output is then as it was and no temporary stays.
    pub fn finish(self, data: &TreeData<'_>, source_id: u128) -> Result<Written, Error> {
        self.complete(data, source_id)?.publish()
    }

    /// Writes everything, brings it to the disk, and opens it again as a check.
    ///
    /// Counts are checked here; for structure, values and geometry call [`Tree::verify`] on the result.
    ///
    /// # Errors
    /// [`Error::Limit`] for more than the format can hold, [`Error::Invalid`] for counts that do not agree,
    /// [`Error::Io`] when the system refuses; no temporary stays then.
    pub fn complete(mut self, data: &TreeData<'_>, source_id: u128) -> Result<Complete, Error> {
        let target = self.pending.target().to_owned();
        check_limits(data, &target)?;
        check_counts(&counts_of(data)).map_err(|v| v.at(&target))?;
        let meta = data
            .meta
            .encode()
            .map_err(|found| Error::limit(&target, found, format!("{MAX_META_LEN} bytes")))?;

        let payloads = payloads_of(data, &meta);
        let mut sections = place(&payloads)
            .ok_or_else(|| Error::limit(&target, "a file of 2^64 bytes or more", "2^64 bytes"))?;
        let bytes = sections.last().map_or(0, SectionInfo::end);
        let head_len = head_len(sections.len()).unwrap_or(0);
        let what = format!("cannot write the {bytes} bytes of the file");
        // The disk's share and the processor's at once.
        let (hashes, written) = thread::scope(|scope| {
            let hashing = thread::Builder::new().spawn_scoped(scope, || Hashes::of(&payloads));
            let written = write_sections(self.pending.file_mut(), head_len, &sections, &payloads);
            let hashes = hashing.ok().and_then(|hashing| hashing.join().ok());
            (hashes.unwrap_or_else(|| Hashes::of(&payloads)), written)
        });
        for (section, hash) in sections.iter_mut().zip(hashes.of_sections) {
            section.hash = hash;
        }
        let content_id = hashes.content_id;
        let head = head_of(data, &sections, content_id, source_id, bytes);
        written
            .and_then(|()| write_head(self.pending.file_mut(), &head))
            .map_err(Error::io(&target, what))?;
        self.pending.sync()?;
        // Catches mistakes of ours and of the disk while the old file is still in its place.
        let reopened = Tree::open_as(self.pending.temporary_path(), &target)?;
        drop(reopened);
        let sections = sections.iter().map(|s| (s.tag.to_string(), s.length)).collect();
        Ok(Complete { pending: self.pending, written: Written { bytes, content_id, sections } })
    }
}

/// A file that is whole and on the disk, but not in its place. Dropping it leaves nothing behind.
#[derive(Debug)]
pub struct Complete {
    pending: Pending,
    written: Written,
}

impl Complete {
    /// What was written.
    pub fn written(&self) -> &Written {
        &self.written
    }

    /// Moves the file to its place.
    ///
    /// # Errors
    /// [`Error::Exists`] and [`Error::NotATree`] when something has appeared there that may not be replaced,
    /// [`Error::Io`] when the system refuses.
    pub fn publish(self) -> Result<Written, Error> {
        let Complete { pending, written } = self;
        // Asked again, since the work between may have taken hours.
        if pending.overwrites() {
            spare_others(pending.target())?;
        }
        pending.publish()?;
        Ok(written)
    }
}

/// Refuses to replace a file that does not start as trees do: a slip of the keyboard must not cost a scan.
///
/// A symbolic link may be replaced, because what it leads to stays.
fn spare_others(target: &Path) -> Result<(), Error> {
    if !fs::symlink_metadata(target).is_ok_and(|found| found.is_file()) {
        return Ok(());
    }
    let mut start = Vec::new();
    File::open(target)
        .and_then(|file| file.take(MAGIC.len() as u64).read_to_end(&mut start))
        .map_err(Error::io(target, "cannot look what the file is that is to be replaced"))?;
    if start == MAGIC { Ok(()) } else { Err(Error::NotATree { path: target.to_owned() }) }
}

type Payload<'a> = (Tag, &'a [u8]);

/// The sections in file order: the description first, so that a look at the first page tells what the file is,
/// then what every cut reads, then what few do.
fn payloads_of<'a>(data: &TreeData<'a>, meta: &'a [u8]) -> Vec<Payload<'a>> {
    let mut payloads = vec![
        (Tag::META, meta),
        (Tag::TOPN, data.clusters.tops.as_bytes()),
        (Tag::TOPL, data.clusters.top_loops.as_bytes()),
        (Tag::PAGE, data.clusters.pages.as_bytes()),
        (Tag::NODE, data.clusters.nodes.as_bytes()),
        (Tag::FACE, data.clusters.faces.as_bytes()),
        (Tag::LOOP, data.clusters.loops.as_bytes()),
        (Tag::LINK, data.clusters.links.as_bytes()),
        (Tag::VERT, data.vertices.as_bytes()),
    ];
    let lists = [
        (Tag::WELD, data.weld.as_bytes()),
        (Tag::BPOL, data.bounding_polygons.as_bytes()),
        (Tag::GRUP, data.groups.as_bytes()),
    ];
    payloads.extend(lists.into_iter().filter(|(_, bytes)| !bytes.is_empty()));
    payloads.extend(data.normals.map(|n| (Tag::NORM, n.as_bytes())));
    payloads.extend(data.colors.map(|c| (Tag::COLR, c.as_bytes())));
    if let Some(chunks) = data.chunks {
        payloads.extend([(Tag::CRPG, chunks.crown.as_slice()), (Tag::CHTP, chunks.tops.as_slice())]);
    }
    payloads
}

/// Gives every section its place but no hash yet, or none if the file would be too long for a file.
fn place(payloads: &[Payload<'_>]) -> Option<Vec<SectionInfo>> {
    let mut end = head_len(payloads.len())?;
    let mut sections = Vec::with_capacity(payloads.len());
    for &(tag, bytes) in payloads {
        let offset = align_up(end, ALIGN_LOG2)?;
        let length = u64::try_from(bytes.len()).ok()?;
        end = offset.checked_add(length)?;
        let elem_size = tag.element_size()?;
        sections.push(SectionInfo {
            tag,
            must_understand: tag.must_understand(),
            offset,
            length,
            elem_size,
            elem_count: length.checked_div(u64::from(elem_size))?,
            align_log2: ALIGN_LOG2,
            hash: 0,
        });
    }
    Some(sections)
}

fn head_len(sections: usize) -> Option<u64> {
    let table = sections.checked_mul(ENTRY_LEN)?;
    u64::try_from(HEADER_LEN.checked_add(table)?).ok()
}

/// Header and section table.
fn head_of(
    data: &TreeData<'_>,
    sections: &[SectionInfo],
    content_id: u128,
    source_id: u128,
    file_len: u64,
) -> Vec<u8> {
    let mut header = Header {
        major: MAJOR,
        minor: MINOR,
        file_len,
        required_features: 0,
        optional_features: 0,
        section_count: u32::try_from(sections.len()).unwrap_or(u32::MAX),
        section_entry_size: u32::try_from(ENTRY_LEN).unwrap_or(u32::MAX),
        node_count: as_count(&data.clusters.tops).saturating_add(as_count(&data.clusters.nodes)),
        vertex_count: as_count(data.vertices),
        face_count: as_count(&data.clusters.faces),
        content_id,
        source_id,
        root: if data.clusters.faces.len() == 1 { ChildRef::face(0) } else { ChildRef::node(0) },
        hash: 0,
    };
    let table: Vec<u8> = sections.iter().flat_map(SectionInfo::to_bytes).collect();
    let hashed = header.to_bytes();
    header.hash = hash64_of(&[hashed.get(..HASHED_LEN).unwrap_or_default(), &table]);
    let mut head = header.to_bytes().to_vec();
    head.extend_from_slice(&table);
    head
}

/// What tells the contents of a file.
struct Hashes {
    of_sections: Vec<u64>,
    content_id: u128,
}

impl Hashes {
    fn of(payloads: &[Payload<'_>]) -> Hashes {
        Hashes {
            of_sections: payloads.iter().map(|(_, bytes)| hash64(bytes)).collect(),
            content_id: hash128_of(payloads.iter().map(|(_, bytes)| *bytes)),
        }
    }
}

/// Zeros in the header's place and all sections: until the header is there the file is not one.
fn write_sections(
    file: &mut File,
    head_len: u64,
    sections: &[SectionInfo],
    payloads: &[Payload<'_>],
) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 20, file);
    let zeros = |len: u64| usize::try_from(len).map(|len| vec![0; len]).map_err(io::Error::other);
    out.write_all(&zeros(head_len)?)?;
    let mut at = head_len;
    for (section, (_, bytes)) in sections.iter().zip(payloads) {
        out.write_all(&zeros(section.offset.saturating_sub(at))?)?;
        out.write_all(bytes)?;
        at = section.end();
    }
    out.flush()
}

fn write_head(file: &mut File, head: &[u8]) -> io::Result<()> {
    file.seek(SeekFrom::Start(0))?;
    file.write_all(head)
}

/// A sum too large for the format is the user's to know about; counts that contradict each other are a mistake of the caller's.
fn check_limits(data: &TreeData<'_>, target: &Path) -> Result<(), Error> {
    let faces = as_count(&data.clusters.faces);
    if faces > MAX_FACES {
        return Err(Error::limit(
            target,
            format!("{faces} faces"),
            format!("{MAX_FACES} faces; split the model"),
        ));
    }
    Ok(())
}

fn counts_of(data: &TreeData<'_>) -> Counts {
    Counts {
        tops: as_count(&data.clusters.tops),
        top_loops: as_count(&data.clusters.top_loops),
        pages: as_count(&data.clusters.pages),
        nodes: as_count(&data.clusters.nodes),
        faces: as_count(&data.clusters.faces),
        loops: as_count(&data.clusters.loops),
        links: as_count(&data.clusters.links),
        vertices: as_count(data.vertices),
        weld: as_count(data.weld),
        bounding_polygons: as_count(data.bounding_polygons),
        groups: as_count(data.groups),
        normals: data.normals.map(as_count),
        colors: data.colors.map(as_count),
    }
}

fn as_count<T>(items: &[T]) -> u64 {
    u64::try_from(items.len()).unwrap_or(u64::MAX)
}
