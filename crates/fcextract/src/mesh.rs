//! An extraction as buffers of its own, for a GPU or a file.

use crate::{Error, Extraction, Selection, Streamed};
use fct::{Crown, NormalRecord, Tree, VertexRecord};
use glam::DVec3;

/// The vertices that an extraction uses, each once, with their attributes; reuse it to keep its memory.
///
/// Copies that the builder made along seams are one vertex again, so what was connected in the input is connected here.
/// Vertices are where [`Selection::position`] says, but for those whose step would turn a triangle around: they stay in
/// their places, which a vertex alone cannot know.
#[derive(Debug, Default)]
pub struct Mesh {
    /// Positions in order of first use, in the tree's coordinates: relative to [`fct::Meta::origin`].
    pub positions: Vec<[f32; 3]>,
    /// A unit normal a vertex; empty when the tree has none.
    pub normals: Vec<[f32; 3]>,
    /// Red, green, blue (sRGB) and alpha a vertex; empty when the tree has none.
    pub colors: Vec<[u8; 4]>,
    /// Indices into the vertices, three a triangle, counter-clockwise.
    pub indices: Vec<u32>,
    /// The index that each vertex has in the tree; that of one of its copies, if it has such.
    pub sources: Vec<u32>,
    /// How far the farthest vertex is drawn beside its place.
    pub longest_step: f64,
    /// Triangles left out because two of their corners are copies of one vertex.
    pub collapsed: u64,
    /// Where the vertices lie without a step, and whether they stay there.
    unmoved: Vec<[f32; 3]>,
    stays: Vec<bool>,
    /// Of each vertex of what is filled from, its place here; [`UNUSED`] between two fillings.
    places: Vec<u32>,
    /// Of streamed vertices: what they are called, copies alike, in order; and which ones stand for them.
    names: Vec<(u32, u32)>,
    first: Vec<u32>,
}

/// What a mesh is filled from.
struct Drawn<'a> {
    indices: &'a [u32],
    vertices: &'a [VertexRecord],
    normals: Option<&'a [NormalRecord]>,
    colors: Option<&'a [[u8; 4]]>,
}

/// Cosine of the angle by which steps may turn a triangle: at 60 degrees one vertex in twenty-five stays on a smooth scan
/// and one in six on a rough one, and folds are nearly as few as without steps.
const TURNED: f64 = 0.5;

/// How often steps are looked at.
const MOST_ROUNDS: usize = 4;

/// Not given a place in the mesh yet. No vertex index is as high.
const UNUSED: u32 = u32::MAX;

impl Mesh {
    /// Replaces the mesh by that of an extraction made with `selection`.
    ///
    /// # Errors
    /// [`Error::Selection`] when the extraction comes from another tree, one with more vertices.
    pub fn fill(&mut self, tree: &Tree, cut: &Extraction, selection: &Selection) -> Result<(), Error> {
        let drawn = Drawn {
            indices: &cut.indices,
            vertices: tree.vertices(),
            normals: tree.normals(),
            colors: tree.colors(),
        };
        self.fill_from(&drawn, selection, |vertex| tree.original(vertex))
    }

    /// The same for a mesh that was extracted with `selection` from the pieces in memory; `crown` is that of its file, as
    /// `cache.file().crown()` of a [`ChunkCache`](crate::ChunkCache).
    ///
    /// Vertices on the borders of pages are one too; of copies along a seam one that is there gives normal and colour. Memory
    /// follows the mesh, not the file.
    ///
    /// # Errors
    /// [`Error::Selection`] when indices and vertices do not belong together.
    pub fn fill_streamed(
        &mut self,
        crown: &Crown,
        streamed: &Streamed,
        selection: &Selection,
    ) -> Result<(), Error> {
        let name = |id: u32| crown.twins(id).fold(id, u32::min);
        let mut names = std::mem::take(&mut self.names);
        names.clear();
        names.extend(streamed.ids.iter().zip(0..).map(|(id, number)| (name(*id), number)));
        names.sort_unstable();
        let mut first = std::mem::take(&mut self.first);
        first.clear();
        first.resize(names.len(), UNUSED);
        for alike in names.chunk_by(|a, b| a.0 == b.0) {
            for (_, number) in alike {
                if let (Some(first), Some((_, stands))) = (first.get_mut(*number as usize), alike.first()) {
                    *first = *stands;
                }
            }
        }
        let drawn = Drawn {
            indices: &streamed.indices,
            vertices: &streamed.vertices,
            normals: Some(&*streamed.normals).filter(|normals| !normals.is_empty()),
            colors: Some(&*streamed.colors).filter(|colors| !colors.is_empty()),
        };
        let filled =
            self.fill_from(&drawn, selection, |number| first.get(number as usize).copied().unwrap_or(UNUSED));
        for source in &mut self.sources {
            *source = streamed.ids.get(*source as usize).map_or(UNUSED, |id| name(*id));
        }
        (self.names, self.first) = (names, first);
        filled
    }

    /// `original` says which one of several copies stands for a vertex.
    fn fill_from(
        &mut self,
        drawn: &Drawn<'_>,
        selection: &Selection,
        original: impl Fn(u32) -> u32,
    ) -> Result<(), Error> {
        let stored = drawn.vertices;
        if self.places.len() < stored.len() {
            self.places.resize(stored.len(), UNUSED);
        }
        self.indices.clear();
        self.sources.clear();
        self.collapsed = 0;
        let renumbered = self.renumber(drawn, original);
        for &vertex in &self.sources {
            if let Some(place) = self.places.get_mut(vertex as usize) {
                *place = UNUSED;
            }
        }
        renumbered?;
        self.positions.clear();
        self.unmoved.clear();
        let records = self.sources.iter().filter_map(|&v| stored.get(v as usize));
        for record in records {
            self.unmoved.push(record.position());
            self.positions.push(selection.position(record).as_vec3().to_array());
        }
        self.longest_step = 0.0;
        if self.positions != self.unmoved {
            self.keep_from_turning();
            self.longest_step = self.steps().map(|(_, step)| step).fold(0.0, f64::max);
        }
        self.normals.clear();
        if let Some(all) = drawn.normals {
            let of = |v: &u32| all.get(*v as usize).map_or([0.0, 0.0, 1.0], |normal| normal.decode());
            self.normals.extend(self.sources.iter().map(of));
        }
        self.colors.clear();
        if let Some(all) = drawn.colors {
            let of = |v: &u32| all.get(*v as usize).copied().unwrap_or([u8::MAX; 4]);
            self.colors.extend(self.sources.iter().map(of));
        }
        Ok(())
    }

    /// The vertices, as the tree counts them, each with how far it is drawn beside its place.
    pub(crate) fn steps(&self) -> impl Iterator<Item = (u32, f64)> + '_ {
        let far = |p: &[f32; 3]| DVec3::from(p.map(f64::from));
        let steps =
            self.unmoved.iter().zip(&self.positions).map(move |(from, to)| far(from).distance(far(to)));
        self.sources.iter().copied().zip(steps)
    }

    /// Gives each vertex its place in order of first use.
    fn renumber(&mut self, drawn: &Drawn<'_>, original: impl Fn(u32) -> u32) -> Result<(), Error> {
        let vertices = drawn.vertices.len();
        for corners in drawn.indices.as_chunks::<3>().0 {
            let corners = corners.map(&original);
            let [a, b, c] = corners;
            if a == b || b == c || c == a {
                self.collapsed += 1;
                continue;
            }
            for vertex in corners {
                let Some(place) =
                    self.places.get_mut(vertex as usize).filter(|_| (vertex as usize) < vertices)
                else {
                    return Err(Error::Selection("it was extracted from another tree".to_owned()));
                };
                if *place == UNUSED {
                    *place = self.sources.len() as u32;
                    self.sources.push(vertex);
                }
                self.indices.push(*place);
            }
        }
        Ok(())
    }

    /// Takes steps back that turn triangles around.
    ///
    /// A step back may turn another triangle, so it is looked at again, a few times at most.
    fn keep_from_turning(&mut self) {
        let Mesh { positions, unmoved, stays, indices, .. } = self;
        let normal = |places: &[[f32; 3]], corners: &[u32; 3]| {
            let [a, b, c] = corners
                .map(|v| places.get(v as usize).map_or(DVec3::ZERO, |p| DVec3::from(p.map(f64::from))));
            (b - a).cross(c - a)
        };
        for _ in 0..MOST_ROUNDS {
            stays.clear();
            stays.resize(positions.len(), false);
            for corners in indices.as_chunks::<3>().0 {
                let (before, after) = (normal(unmoved, corners), normal(positions, corners));
                if before.dot(after) < TURNED * before.length() * after.length() {
                    for vertex in corners {
                        if let Some(stays) = stays.get_mut(*vertex as usize) {
                            *stays = true;
                        }
                    }
                }
            }
            let mut stepped_back = false;
            for ((place, home), _) in
                positions.iter_mut().zip(&*unmoved).zip(&*stays).filter(|(_, stays)| **stays)
            {
                stepped_back |= place != home;
                *place = *home;
            }
            if !stepped_back {
                return;
            }
        }
    }
}
