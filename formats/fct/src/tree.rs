//! A `.fct` file opened for reading.

use std::any::Any;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use zerocopy::{FromBytes, Immutable, KnownLayout, Unaligned};

use crate::child::ChildRef;
use crate::container::{Container, Spans};
use crate::error::Error;
use crate::header::Header;
use crate::map::Backing;
use crate::meta::Meta;
use crate::node::{BoundingPolygon, Node};
use crate::octahedral::NormalRecord;
use crate::records::{BoundingPolygonRecord, GroupRecord, VertexRecord, WeldRecord};
use crate::section::SectionInfo;
use crate::verify::{self, Verified};
use crate::walk::Reader;

/// A tree of face clusters, used in place.
///
/// Opening checks the container only: the slices hold whatever the file holds.
/// Walk down by [`Tree::whole`] and [`Tree::children`], or call [`Tree::verify`] first.
pub struct Tree {
    backing: Backing,
    path: PathBuf,
    header: Header,
    meta: Meta,
    sections: Vec<SectionInfo>,
    spans: Spans,
    derived: OnceLock<Box<dyn Any + Send + Sync>>,
}

impl Tree {
    /// Maps a file and checks its container: header, section table, counts, description. The cost does not grow with the file.
    ///
    /// The file must not be edited or truncated while it is open; replacing it by rename is fine.
    ///
    /// # Errors
    /// [`Error::Io`] and [`Error::NotAFile`] when the file cannot be mapped, [`Error::Invalid`] when a rule is broken.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Error> {
        Self::open_as(path.as_ref(), path.as_ref())
    }

    /// Opens the file at `path`; errors speak of `shown`.
    pub(crate) fn open_as(path: &Path, shown: &Path) -> Result<Self, Error> {
        // Asked by name first, since opening a pipe would wait for a writer.
        let kind = fs::metadata(path).map_err(Error::io(shown, "cannot open"))?;
        if !kind.is_file() {
            return Err(Error::NotAFile { path: shown.to_owned() });
        }
        let file = File::open(path).map_err(Error::io(shown, "cannot open"))?;
        let len = file.metadata().map_err(Error::io(shown, "cannot ask the length"))?.len();
        let backing = if len == 0 {
            // An empty range cannot be mapped everywhere.
            Backing::Bytes(Vec::new())
        } else {
            Backing::map(&file).map_err(Error::io(shown, "cannot map into memory"))?
        };
        Self::new(backing, shown)
    }

    /// The same for bytes in memory; errors speak of a file `<memory>`.
    ///
    /// # Errors
    /// [`Error::Invalid`] when a rule is broken.
    pub fn from_bytes(bytes: Vec<u8>) -> Result<Self, Error> {
        Self::new(Backing::Bytes(bytes), Path::new("<memory>"))
    }

    fn new(backing: Backing, path: &Path) -> Result<Self, Error> {
        let Container { header, meta, sections, spans } =
            Container::parse(backing.bytes()).map_err(|v| v.at(path))?;
        let derived = OnceLock::new();
        Ok(Self { backing, path: path.to_owned(), header, meta, sections, spans, derived })
    }

    /// Checks everything that [`Tree::open`] does not: hashes, padding, structure, values and geometry.
    ///
    /// Reads the whole file; the time grows with its size, the memory by a fortieth of it.
    ///
    /// # Errors
    /// The first broken rule, as [`Error::Invalid`].
    pub fn verify(&self) -> Result<Verified, Error> {
        verify::verify(self, &mut |_| ())
    }

    /// The same, told again and again how many faces it is done with, once damage is ruled out.
    ///
    /// # Errors
    /// As [`Tree::verify`].
    pub fn verify_watched(&self, done: &mut dyn FnMut(u64)) -> Result<Verified, Error> {
        verify::verify(self, done)
    }

    /// Checks hashes, padding and the vertices' numbers: what damage to the bytes changes, and the part of
    /// [`Tree::verify`] that no walk makes up for.
    ///
    /// Reads the whole file, at some gigabytes a second where it is in memory.
    ///
    /// # Errors
    /// The first broken rule, as [`Error::Invalid`].
    pub fn check_bytes(&self) -> Result<(), Error> {
        verify::check_bytes(self)
    }

    /// The path it was opened by.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The root: node 0, or face 0 when there is but one face.
    pub fn root(&self) -> ChildRef {
        self.header.root
    }

    /// What the header says.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// What section `META` says.
    pub fn meta(&self) -> &Meta {
        &self.meta
    }

    /// All sections, in file order, unknown ones too.
    pub fn sections(&self) -> &[SectionInfo] {
        &self.sections
    }

    /// Vertices in order of first use by the faces.
    pub fn vertices(&self) -> &[VertexRecord] {
        self.records(self.spans.vert.clone())
    }

    /// Whether the vertices say how they may be displaced where distances are promised: since version 1.2.
    pub fn promises_displaced(&self) -> bool {
        self.header.minor >= 2
    }

    /// What a program has derived from the tree and keeps beside it: made by `derive` when it is first asked for, on
    /// whatever thread, and dropped with the tree. None if something of another type is kept there.
    pub fn derived<T: Any + Send + Sync>(&self, derive: impl FnOnce() -> T) -> Option<&T> {
        self.derived.get_or_init(|| Box::new(derive())).downcast_ref()
    }

    /// The number of nodes above the pages, and of pages.
    pub fn top_and_page_counts(&self) -> (usize, usize) {
        let reader = self.reader();
        (reader.tops.len(), reader.pages.len())
    }

    /// The number of faces.
    pub fn face_count(&self) -> usize {
        // A face record has three bytes.
        self.spans.face.len() / 3
    }

    /// The sections that a walk reads, found once for many steps.
    pub fn reader(&self) -> Reader<'_> {
        let spans = &self.spans;
        Reader {
            tops: self.records(spans.topn.clone()),
            top_loops: self.records(spans.topl.clone()),
            top_corners: &[],
            pages: self.records(spans.page.clone()),
            nodes: self.records(spans.node.clone()),
            faces: self.records(spans.face.clone()),
            links: self.records(spans.link.clone()),
            loops: self.records(spans.loops.clone()),
            vertices: self.vertices(),
            path: &self.path,
        }
    }

    /// Copies made by cutting seams, sorted by vertex; may be empty.
    pub fn weld(&self) -> &[WeldRecord] {
        self.records(self.spans.weld.clone())
    }

    /// The vertex that `vertex` is a copy of, or `vertex` itself.
    #[inline]
    pub fn original(&self, vertex: u32) -> u32 {
        let copies = self.weld();
        if copies.is_empty() {
            return vertex;
        }
        let found = copies.binary_search_by_key(&vertex, |copy| copy.vertex.get());
        found.ok().and_then(|place| copies.get(place)).map_or(vertex, |copy| copy.representative.get())
    }

    /// Bounding polygons, sorted by node; may be empty.
    pub fn bounding_polygons(&self) -> &[BoundingPolygonRecord] {
        self.records(self.spans.bpol.clone())
    }

    /// The place of a node's bounding polygon among them, if it has one. `node` is the node's index in preorder.
    pub fn bounding_polygon_of(&self, node: u32) -> Option<usize> {
        self.bounding_polygons().binary_search_by_key(&node, |p| p.node.get()).ok()
    }

    /// The bounding polygon at a place, decoded; `node` is the node that it belongs to.
    pub fn bounding_polygon(&self, place: usize, node: &Node) -> Option<BoundingPolygon> {
        Some(BoundingPolygon::new(self.bounding_polygons().get(place)?, node))
    }

    /// A normal a vertex, if the file has them.
    pub fn normals(&self) -> Option<&[NormalRecord]> {
        Some(self.records(self.spans.norm.clone()?))
    }

    /// Red, green, blue (sRGB) and alpha a vertex, if the file has them.
    pub fn colors(&self) -> Option<&[[u8; 4]]> {
        Some(self.records(self.spans.colr.clone()?))
    }

    /// Component groups, sorted by first face; may be empty.
    pub fn groups(&self) -> &[GroupRecord] {
        self.records(self.spans.grup.clone())
    }

    /// Sections `CRPG` and `CHTP`, if the file has either.
    pub(crate) fn chunk_sections(&self) -> Option<(&[u8], &[u8])> {
        let (crown, tops) = (self.spans.crpg.clone(), self.spans.chtp.clone());
        let there = crown.is_some() || tops.is_some();
        there.then(|| (self.records(crown.unwrap_or_default()), self.records(tops.unwrap_or_default())))
    }

    /// The bytes of the whole file.
    pub(crate) fn bytes(&self) -> &[u8] {
        self.backing.bytes()
    }

    /// The range was checked on opening to lie in the file and to hold whole elements, so neither default is ever taken.
    fn records<T>(&self, range: std::ops::Range<usize>) -> &[T]
    where
        T: FromBytes + Immutable + KnownLayout + Unaligned,
    {
        let bytes = self.bytes().get(range).unwrap_or_default();
        <[T]>::ref_from_bytes(bytes).unwrap_or_default()
    }
}

impl std::fmt::Debug for Tree {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Tree").field("path", &self.path).field("header", &self.header).finish_non_exhaustive()
    }
}

// Cuts are taken by many threads from one tree.
const _: () = {
    const fn shared<T: Send + Sync>() {}
    shared::<Tree>();
};
