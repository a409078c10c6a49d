//! A file that is read chunk by chunk.

use std::fs::{self, File};
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use zerocopy::{FromBytes, Immutable, IntoBytes};

use super::crown::Crown;
use super::load::{Chunk, broken};
use super::page::{Body, ChunkPage, OwnVertices, VertexRun};
use super::runs::{Runs, Wanted};
use crate::container::{Container, Spans, check_section_hash};
use crate::error::{Error, Violation};
use crate::header::{HEADER_LEN, Header};
use crate::meta::Meta;
use crate::octahedral::NormalRecord;
use crate::records::{FaceRecord, MAX_PAGE_VERTICES, NodeRecord, PageRecord, VertexRecord, WeldRecord};
use crate::rule::Rule;
use crate::section::Tag;
use crate::walk::to_index;

/// Bytes that can be read at any place, by many threads.
pub trait ReadAt: Send + Sync {
    /// Fills `out` with the bytes from `offset` on.
    ///
    /// # Errors
    /// Whatever the system says; [`io::ErrorKind::UnexpectedEof`] when there are too few.
    fn read_at(&self, offset: u64, out: &mut [u8]) -> io::Result<()>;

    /// How many bytes there are.
    ///
    /// # Errors
    /// Whatever the system says.
    fn length(&self) -> io::Result<u64>;
}

impl ReadAt for File {
    #[cfg(unix)]
    fn read_at(&self, offset: u64, out: &mut [u8]) -> io::Result<()> {
        std::os::unix::fs::FileExt::read_exact_at(self, out, offset)
    }

    #[cfg(windows)]
    fn read_at(&self, mut offset: u64, mut out: &mut [u8]) -> io::Result<()> {
        while !out.is_empty() {
            let read = std::os::windows::fs::FileExt::seek_read(self, out, offset)?;
            if read == 0 {
                return Err(io::ErrorKind::UnexpectedEof.into());
            }
            offset = offset.saturating_add(u64::try_from(read).unwrap_or(u64::MAX));
            out = out.get_mut(read..).unwrap_or_default();
        }
        Ok(())
    }

    fn length(&self) -> io::Result<u64> {
        Ok(self.metadata()?.len())
    }
}

impl ReadAt for Vec<u8> {
    fn read_at(&self, offset: u64, out: &mut [u8]) -> io::Result<()> {
        let start = usize::try_from(offset).unwrap_or(usize::MAX);
        let bytes = self.get(start..start.saturating_add(out.len())).ok_or(io::ErrorKind::UnexpectedEof)?;
        out.copy_from_slice(bytes);
        Ok(())
    }

    fn length(&self) -> io::Result<u64> {
        Ok(u64::try_from(self.len()).unwrap_or(u64::MAX))
    }
}

/// A tree whose crown is in memory, and whose chunks and pages are read one by one.
///
/// It is not mapped: a file that is truncated meanwhile gives an error and stops no program.
pub struct ChunkFile {
    input: Input,
    header: Header,
    meta: Meta,
    spans: Spans,
    crown: Crown,
    /// Section `CHTP`.
    copies: Range<usize>,
}

/// Where the bytes come from, and how many came.
struct Input {
    source: Arc<dyn ReadAt>,
    path: PathBuf,
    reads: AtomicU64,
    bytes_read: AtomicU64,
}

impl ChunkFile {
    /// Opens a file and reads its crown, which is a few hundredths of it.
    ///
    /// # Errors
    /// As [`crate::Tree::open`]; [`Rule::SectionRequired`] is broken when the file cannot be read in parts, being
    /// of a version before 1.3.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        // Asked by name first, since opening a pipe would wait for a writer.
        let kind = fs::metadata(path).map_err(Error::io(path, "cannot open"))?;
        if !kind.is_file() {
            return Err(Error::NotAFile { path: path.to_owned() });
        }
        let file = File::open(path).map_err(Error::io(path, "cannot open"))?;
        Self::new(Arc::new(file), path)
    }

    /// The same for bytes from anywhere; errors speak of `path`.
    ///
    /// # Errors
    /// As [`ChunkFile::open`].
    pub fn new(source: Arc<dyn ReadAt>, path: &Path) -> Result<Self, Error> {
        let length = source.length().map_err(Error::io(path, "cannot ask the length"))?;
        let head_len = length.min(u64::try_from(HEADER_LEN).unwrap_or(u64::MAX));
        let input =
            Input { source, path: path.to_owned(), reads: AtomicU64::new(0), bytes_read: AtomicU64::new(0) };
        let mut head = input.read::<u8>(0, usize::try_from(head_len).unwrap_or(0))?;
        let header = Header::parse(&head, length).map_err(|v| v.at(path))?;
        head.extend(input.read::<u8>(HEADER_LEN, header.table_len())?);
        let (sections, spans) = Container::parse_table(&head, &header).map_err(|v| v.at(path))?;
        let section = |tag| {
            sections.iter().find(|s| s.tag == tag).ok_or_else(|| {
                let mut violation = Violation::new(
                    Rule::SectionRequired,
                    format!("section {tag}"),
                    "it is missing, and the file cannot be read in parts without it".to_owned(),
                );
                violation.remedy = Some("build the file again with fcbuild");
                violation.at(path)
            })
        };
        let meta = section(Tag::META)?;
        let range = meta.range().map_err(|v| v.at(path))?;
        Container::check_meta_len(range.len()).map_err(|v| v.at(path))?;
        let bytes = input.read::<u8>(range.start, range.len())?;
        let meta = Container::read_meta(meta, &bytes).map_err(|v| v.at(path))?;

        let crown = section(Tag::CRPG)?;
        let copies = section(Tag::CHTP)?.range().map_err(|v| v.at(path))?;
        let range = crown.range().map_err(|v| v.at(path))?;
        let bytes = input.read::<u8>(range.start, range.len())?;
        check_section_hash(crown, &bytes).map_err(|v| v.at(path))?;
        let weld = spans.weld.clone();
        let welded = weld.len().checked_div(size_of::<WeldRecord>()).unwrap_or(0);
        let weld = input.read::<WeldRecord>(weld.start, welded)?;
        let counts = [header.vertex_count, header.face_count].map(|n| u32::try_from(n).unwrap_or(u32::MAX));
        let attributes = [spans.norm.is_some(), spans.colr.is_some()];
        let pages = spans.page.len().checked_div(size_of::<PageRecord>()).unwrap_or(0);
        let crown = Crown::parse(&bytes, &weld, counts, pages, attributes).map_err(|v| v.at(path))?;
        Ok(Self { input, header, meta, spans, crown, copies })
    }

    /// The path it was opened by.
    pub fn path(&self) -> &Path {
        &self.input.path
    }

    /// What the header says.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// What section `META` says.
    pub fn meta(&self) -> &Meta {
        &self.meta
    }

    /// The nodes above the chunks, and their roots.
    pub fn crown(&self) -> &Crown {
        &self.crown
    }

    /// Bytes of memory that the top of a chunk will take at most; none if there is no such chunk.
    pub fn chunk_bytes(&self, chunk: u32) -> Option<u64> {
        self.wanted(chunk).map(|wanted| wanted.memory())
    }

    /// Bytes of memory that a page of a chunk will take at most; none if the chunk has no such page.
    pub fn page_bytes(&self, chunk: &Chunk, page: u32) -> Option<u64> {
        let (record, _) = chunk.page_record(page)?;
        Some(ChunkPage::memory(record, self.vertex_size()))
    }

    /// Bytes of memory that the vertices of a page will take at most; none if there is no such page.
    pub fn run_bytes(&self, page: u32) -> Option<u64> {
        let count = u64::from(u32::try_from(self.crown.vertices_of(page)?.len()).ok()?);
        let size = u64::try_from(self.vertex_size()).ok()?;
        count.checked_mul(size)?.checked_add(u64::try_from(size_of::<VertexRun>()).ok()?)
    }

    /// How often the file was read from, and how many bytes in all.
    pub fn reads(&self) -> [u64; 2] {
        [&self.input.reads, &self.input.bytes_read].map(|n| n.load(Ordering::Relaxed))
    }

    /// Reads the top of a chunk and checks its hash and its references.
    ///
    /// # Errors
    /// [`Error::Io`] when the system refuses, [`Error::Invalid`] when the chunk is damaged.
    pub fn load(&self, chunk: u32) -> Result<Chunk, Error> {
        let place = format!("chunk {chunk}");
        let wanted = self.wanted(chunk);
        let wanted = wanted.ok_or_else(|| self.damaged(&place, "its runs leave their sections"))?;
        let runs = Runs {
            tops: self.run(&self.spans.topn, &wanted.tops)?,
            top_loops: self.run(&self.spans.topl, &wanted.top_loops)?,
            pages: self.run(&self.spans.page, &wanted.pages)?,
            links: self.run(&self.spans.link, &wanted.links)?,
            copies: self.run(&self.copies, &wanted.copies)?,
        };
        if runs.hash() != wanted.hash {
            return Err(self.damaged(&place, "its hash does not match"));
        }
        let vertices = u32::try_from(self.header.vertex_count).unwrap_or(u32::MAX);
        Chunk::new(&wanted, runs, self.attributes(), vertices, self.path())
            .map_err(|v| self.within(&place, &v))
    }

    /// The pages whose vertices a page of a chunk uses, itself among them, in order; none if it names vertices that are
    /// not there.
    pub fn runs_of(&self, chunk: &Chunk, page: u32) -> Option<Vec<u32>> {
        let (_, links) = chunk.page_record(page)?;
        let mut owners = vec![page];
        for link in links {
            owners.push(self.crown.owner_of(link.get())?);
        }
        owners.sort_unstable();
        owners.dedup();
        Some(owners)
    }

    /// Reads the vertices that a page owns and checks their hash.
    ///
    /// # Errors
    /// As [`ChunkFile::load`].
    pub fn load_run(&self, page: u32) -> Result<VertexRun, Error> {
        let place = format!("the vertices of page {page}");
        let lost = || self.damaged(&place, "it does not have so many");
        let range = self.crown.vertices_of(page).ok_or_else(lost)?;
        let entry = to_index(page).and_then(|page| self.crown.pages.get(page)).ok_or_else(lost)?;
        let elements = to_index(range.start).zip(to_index(range.end)).ok_or_else(lost)?;
        let elements = elements.0..elements.1;
        if range.len() > usize::try_from(MAX_PAGE_VERTICES).unwrap_or(0) {
            return Err(lost());
        }
        let run = VertexRun {
            first: range.start,
            vertices: self.run(&self.spans.vert, &elements)?,
            normals: self.attribute(self.spans.norm.as_ref(), &elements)?,
            colors: self.attribute(self.spans.colr.as_ref(), &elements)?,
        };
        if run.hash() != entry.vertex_hash.get() {
            return Err(self.damaged(&place, "their hash does not match"));
        }
        Ok(run)
    }

    /// Reads a page of a chunk and checks its hash and its references.
    ///
    /// `runs` are the vertices of the pages that [`ChunkFile::runs_of`] names, in that order.
    ///
    /// # Errors
    /// As [`ChunkFile::load`].
    pub fn load_page(&self, chunk: &Chunk, page: u32, runs: &[OwnVertices<'_>]) -> Result<ChunkPage, Error> {
        let place = format!("page {page}");
        let lost = || self.damaged(&place, "it leaves its sections");
        let (record, links) = chunk.page_record(page).ok_or_else(lost)?;
        let owners = self.runs_of(chunk, page).filter(|owners| owners.len() == runs.len());
        let owners = owners.ok_or_else(lost)?;
        let entry = to_index(page).and_then(|page| self.crown.pages.get(page)).ok_or_else(lost)?;
        let first_face = chunk.first_face().checked_add(record.first_face.get()).ok_or_else(lost)?;
        let first_node = first_face.checked_sub(page).ok_or_else(lost)?;
        let nodes = usize::from(record.faces).checked_sub(1).ok_or_else(lost)?;
        let range = |first: u32, count: usize, section: &Range<usize>, size: usize| {
            let start = to_index(first)?;
            let end = start.checked_add(count)?;
            (end <= section.len().checked_div(size)?).then_some(start..end)
        };
        let spans = &self.spans;
        let nodes = range(first_node, nodes, &spans.node, size_of::<NodeRecord>()).ok_or_else(lost)?;
        let faces = usize::from(record.faces);
        let faces = range(first_face, faces, &spans.face, size_of::<FaceRecord>()).ok_or_else(lost)?;
        let loops = usize::from(record.loop_bytes.get());
        let loops = range(record.first_loop.get(), loops, &spans.loops, 1).ok_or_else(lost)?;
        let body = Body {
            nodes: self.run(&spans.node, &nodes)?,
            faces: self.run(&spans.face, &faces)?,
            loops: self.run(&spans.loops, &loops)?,
        };
        if body.hash() != entry.hash.get() {
            return Err(self.damaged(&place, "its hash does not match"));
        }
        let of = |owner: u32| runs.get(owners.binary_search(&owner).ok()?).copied();
        let own = of(page).ok_or_else(lost)?;
        let made = ChunkPage::new(*record, body, links, own, |v| of(self.crown.owner_of(v)?), self.path());
        made.map_err(|v| self.within(&place, &v))
    }

    /// Which elements of the sections the top of a chunk takes; none if they leave them.
    fn wanted(&self, chunk: u32) -> Option<Wanted> {
        Wanted::of(&self.crown.chunks, chunk, &self.spans, self.copies.len())
    }

    fn damaged(&self, place: &str, found: &str) -> Error {
        broken(place, found).at(self.path())
    }

    /// A broken rule in a part of the file.
    fn within(&self, place: &str, violation: &Violation) -> Error {
        self.damaged(place, &format!("{}: {}", violation.place, violation.found))
    }

    fn attributes(&self) -> [bool; 2] {
        [self.spans.norm.is_some(), self.spans.colr.is_some()]
    }

    /// Bytes of a vertex with its attributes.
    fn vertex_size(&self) -> usize {
        let [normals, colors] = self.attributes();
        let normal = if normals { size_of::<NormalRecord>() } else { 0 };
        let color = if colors { size_of::<[u8; 4]>() } else { 0 };
        size_of::<VertexRecord>().saturating_add(normal).saturating_add(color)
    }

    fn attribute<T>(&self, section: Option<&Range<usize>>, elements: &Range<usize>) -> Result<Vec<T>, Error>
    where
        T: FromBytes + IntoBytes + Immutable + Default + Clone,
    {
        section.map_or(Ok(Vec::new()), |section| self.run(section, elements))
    }

    /// Some elements of a section, in which they lie.
    fn run<T>(&self, section: &Range<usize>, elements: &Range<usize>) -> Result<Vec<T>, Error>
    where
        T: FromBytes + IntoBytes + Immutable + Default + Clone,
    {
        let start = elements.start.saturating_mul(size_of::<T>()).saturating_add(section.start);
        self.input.read(start, elements.len())
    }
}

impl Input {
    /// Whoever asks has checked that so many elements are there.
    fn read<T>(&self, start: usize, count: usize) -> Result<Vec<T>, Error>
    where
        T: FromBytes + IntoBytes + Immutable + Default + Clone,
    {
        let mut elements = vec![T::default(); count];
        let bytes = elements.as_mut_bytes();
        if bytes.is_empty() {
            return Ok(elements);
        }
        self.reads.fetch_add(1, Ordering::Relaxed);
        self.bytes_read.fetch_add(u64::try_from(bytes.len()).unwrap_or(u64::MAX), Ordering::Relaxed);
        let what = format!("cannot read {} bytes at byte {start}", bytes.len());
        let offset = u64::try_from(start).unwrap_or(u64::MAX);
        self.source.read_at(offset, bytes).map_err(Error::io(&self.path, what))?;
        Ok(elements)
    }
}

impl std::fmt::Debug for ChunkFile {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ChunkFile")
            .field("path", &self.input.path)
            .field("header", &self.header)
            .finish_non_exhaustive()
    }
}
