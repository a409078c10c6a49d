//! A file that is read chunk by chunk.

use std::fs::{self, File};
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use zerocopy::{FromBytes, Immutable, IntoBytes};

use super::crown::Crown;
use super::load::{Chunk, Runs, Wanted};
use crate::container::{Container, Spans, check_section_hash};
use crate::error::{Error, Violation};
use crate::header::{HEADER_LEN, Header};
use crate::meta::Meta;
use crate::records::WeldRecord;
use crate::rule::Rule;
use crate::section::Tag;

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

/// A tree whose crown is in memory and whose chunks are read one by one.
///
/// It is not mapped: a file that is truncated meanwhile gives an error and stops no program.
pub struct ChunkFile {
    input: Input,
    header: Header,
    meta: Meta,
    spans: Spans,
    crown: Crown,
    kins: Range<usize>,
    kin_size: usize,
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
    /// As [`crate::Tree::open`]; [`Rule::SectionRequired`] is broken when the file has no chunks, being of version 1.0.
    pub fn open(path: &Path) -> Result<Self, Error> {
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

        let crown = section(Tag::CRWN)?;
        let kins = section(Tag::KINS)?.range().map_err(|v| v.at(path))?;
        let range = crown.range().map_err(|v| v.at(path))?;
        let bytes = input.read::<u8>(range.start, range.len())?;
        check_section_hash(crown, &bytes).map_err(|v| v.at(path))?;
        let weld = spans.weld.clone();
        let copies = weld.len().checked_div(size_of::<WeldRecord>()).unwrap_or(0);
        let weld = input.read::<WeldRecord>(weld.start, copies)?;
        let counts = [header.vertex_count, header.face_count].map(|n| u32::try_from(n).unwrap_or(u32::MAX));
        let attributes = [spans.norm.is_some(), spans.colr.is_some()];
        let crown = Crown::parse(&bytes, &weld, counts, attributes).map_err(|v| v.at(path))?;
        let kin_size = Wanted::vertex_size(attributes);
        Ok(Self { input, header, meta, spans, crown, kins, kin_size })
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

    /// Bytes of memory that a chunk will take at most; none if there is no such chunk.
    pub fn chunk_bytes(&self, chunk: u32) -> Option<u64> {
        self.wanted(chunk).map(|wanted| wanted.memory())
    }

    /// How often the file was read from, and how many bytes in all.
    pub fn reads(&self) -> [u64; 2] {
        [&self.input.reads, &self.input.bytes_read].map(|n| n.load(Ordering::Relaxed))
    }

    /// Reads a chunk and checks its hash and its references.
    ///
    /// # Errors
    /// [`Error::Io`] when the system refuses, [`Error::Invalid`] when the chunk is damaged.
    pub fn load(&self, chunk: u32) -> Result<Chunk, Error> {
        let place = || format!("chunk {chunk}");
        let damaged = |found: &str| Violation::new(Rule::Chunk, place(), found.to_owned()).at(self.path());
        let wanted = self.wanted(chunk).ok_or_else(|| damaged("its runs leave their sections"))?;
        let runs = Runs {
            tops: self.run(&self.spans.topn, &wanted.tops)?,
            top_loops: self.run(&self.spans.topl, &wanted.top_loops)?,
            pages: self.run(&self.spans.page, &wanted.pages)?,
            nodes: self.run(&self.spans.node, &wanted.nodes)?,
            faces: self.run(&self.spans.face, &wanted.faces)?,
            loops: self.run(&self.spans.loops, &wanted.loops)?,
            links: self.run(&self.spans.link, &wanted.links)?,
            vertices: self.run(&self.spans.vert, &wanted.vertices)?,
            normals: self.attribute(self.spans.norm.as_ref(), &wanted.vertices)?,
            colors: self.attribute(self.spans.colr.as_ref(), &wanted.vertices)?,
            kins: self.run(&self.kins, &wanted.kin_bytes(self.kin_size))?,
        };
        if runs.hash() != wanted.hash {
            return Err(damaged("its hash does not match"));
        }
        Chunk::new(&wanted, runs, self.path()).map_err(|violation| {
            Violation::new(Rule::Chunk, place(), format!("{}: {}", violation.place, violation.found))
                .at(self.path())
        })
    }

    /// Which elements of the sections a chunk takes; none if they leave them.
    fn wanted(&self, chunk: u32) -> Option<Wanted> {
        Wanted::of(&self.crown.chunks, chunk, &self.spans, self.kins.len().checked_div(self.kin_size)?)
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
