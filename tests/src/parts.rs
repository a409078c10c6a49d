//! Models whose chunks and pages are all at hand, to be drawn from any of them.

use crate::trees;
use fcbuild::SplitMode;
use fcbuild::import::Soup;
use fcextract::{Piece, Resident, Selection, Streamed, extract_chunks};
use fct::{Chunk, ChunkFile, ChunkPage, CrownChild, OwnVertices, Tree, VertexRun};
use glam::DVec3;
use std::path::Path;
use std::sync::Arc;

/// A tree, and all its chunks and pages.
#[derive(Debug)]
pub struct Model {
    /// What errors call it.
    pub name: &'static str,
    /// The tree as a whole.
    pub tree: Tree,
    /// Its file.
    pub bytes: Vec<u8>,
    /// The tops of its chunks.
    pub chunks: Vec<Chunk>,
    /// Its pages.
    pub pages: Vec<ChunkPage>,
    /// The bounds of the chunks' roots, and of the pages'.
    chunk_roots: Vec<f32>,
    page_roots: Vec<f32>,
    /// What reads it in parts.
    pub file: ChunkFile,
}

/// Some of a model's pieces.
struct Present<'a> {
    model: &'a Model,
    there: &'a dyn Fn(Piece) -> bool,
}

impl<'a> Resident<'a> for Present<'a> {
    fn chunk(&self, chunk: u32) -> Option<&'a Chunk> {
        self.model.chunks.get(chunk as usize).filter(|_| (self.there)(Piece::Chunk(chunk)))
    }

    fn page(&self, page: u32) -> Option<&'a ChunkPage> {
        self.model.pages.get(page as usize).filter(|_| (self.there)(Piece::Page(page)))
    }
}

/// All pages of a file, which is sound.
fn all_pages(file: &ChunkFile, chunks: &[Chunk]) -> Result<Vec<ChunkPage>, fct::Error> {
    let mut pages = Vec::new();
    for chunk in chunks {
        for page in chunk.pages() {
            let owners = file.runs_of(chunk, page).unwrap_or_default();
            let runs: Vec<VertexRun> =
                owners.iter().map(|owner| file.load_run(*owner)).collect::<Result<_, _>>()?;
            let own: Vec<OwnVertices<'_>> = runs.iter().map(VertexRun::own).collect();
            pages.push(file.load_page(chunk, page, &own)?);
        }
    }
    Ok(pages)
}

impl Model {
    /// Builds a tree with chunks of so many faces, verifies it, and reads all of it in parts.
    pub fn new(name: &'static str, soup: Soup, chunk_faces: u32) -> Model {
        let bytes = trees::bytes_in_chunks(soup, SplitMode::Quality, chunk_faces);
        let tree = Tree::from_bytes(bytes.clone()).unwrap_or_else(|e| panic!("{name}: {e}"));
        tree.verify().unwrap_or_else(|e| panic!("{name}: {e}"));
        let file = open(bytes.clone()).unwrap_or_else(|e| panic!("{name}: {e}"));
        let load = |c| file.load(c).unwrap_or_else(|e| panic!("{name}: {e}"));
        let chunks: Vec<Chunk> = (0..file.crown().chunk_count()).map(load).collect();
        let pages = all_pages(&file, &chunks).unwrap_or_else(|e| panic!("{name}: {e}"));
        let (mut chunk_roots, mut page_roots) = (Vec::new(), Vec::new());
        for node in 0..2 * file.crown().chunk_count() {
            if let Some(CrownChild::Chunk(_)) = file.crown().below(node) {
                chunk_roots.push(file.crown().node(node).map_or(0.0, |root| root.bound));
            }
        }
        for chunk in &chunks {
            let mut stack = vec![chunk.root()];
            while let Some(subtree) = stack.pop() {
                match chunk.page(&subtree) {
                    Some(_) => page_roots.push(chunk.node(&subtree).map_or(0.0, |root| root.bound)),
                    None => {
                        let [left, right] =
                            chunk.children(&subtree).unwrap_or_else(|e| panic!("{name}: {e}"));
                        stack.extend([right, left]);
                    }
                }
            }
        }
        Model { name, tree, bytes, chunks, pages, chunk_roots, page_roots, file }
    }

    /// Whether a mesh can stand in for all of a piece: whether its root can be drawn.
    pub fn is_drawable(&self, piece: Piece) -> bool {
        match piece {
            Piece::Chunk(chunk) => self.chunk_roots[chunk as usize].is_finite(),
            Piece::Page(page) => self.page_roots[page as usize].is_finite(),
        }
    }

    /// The mesh from some of the pieces.
    pub fn streamed(&self, there: &dyn Fn(Piece) -> bool, selection: &Selection, out: &mut Streamed) {
        extract_chunks(self.file.crown(), &Present { model: self, there }, selection, out)
            .unwrap_or_else(|e| panic!("{}: {e}", self.name));
        assert!(out.damaged.is_empty(), "{}: {:?}", self.name, out.damaged);
        for (id, record) in out.ids.iter().zip(&out.vertices) {
            assert_eq!(record.position(), self.tree.vertices()[*id as usize].position());
        }
        assert_eq!(out.normals.len(), out.ids.len());
    }
}

/// Opens a file in memory, to be read in parts.
///
/// # Errors
/// As [`ChunkFile::new`].
pub fn open(bytes: Vec<u8>) -> Result<ChunkFile, fct::Error> {
    ChunkFile::new(Arc::new(bytes), Path::new("a.fct"))
}

/// Centre and diagonal of a tree's box.
pub fn size(tree: &Tree) -> (DVec3, f64) {
    let [low, high] =
        [tree.meta().bounds_min, tree.meta().bounds_max].map(|b| DVec3::from_array(b.map(f64::from)));
    ((low + high) * 0.5, (high - low).length())
}

/// The indices of a mesh by the names that the whole tree has for the vertices.
pub fn named(out: &Streamed) -> Vec<u32> {
    out.indices.iter().map(|i| out.ids[*i as usize]).collect()
}
