//! An extraction as buffers of its own, for a GPU or a file.

use crate::{Error, Extraction, Selection};
use fct::Tree;
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
    /// The index that each vertex has in the tree.
    pub sources: Vec<u32>,
    /// How far the farthest vertex is drawn beside its place.
    pub longest_step: f64,
    /// Triangles left out because two of their corners are copies of one vertex.
    pub collapsed: u64,
    /// Where the vertices lie without a step, and whether they stay there.
    unmoved: Vec<[f32; 3]>,
    stays: Vec<bool>,
    /// Of each vertex of the tree, its place here; [`UNUSED`] between two fillings.
    places: Vec<u32>,
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
        let stored = tree.vertices();
        if self.places.len() < stored.len() {
            self.places.resize(stored.len(), UNUSED);
        }
        self.indices.clear();
        self.sources.clear();
        self.collapsed = 0;
        let renumbered = self.renumber(tree, &cut.indices);
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
        if let Some(all) = tree.normals() {
            let of = |v: &u32| all.get(*v as usize).map_or([0.0, 0.0, 1.0], |normal| normal.decode());
            self.normals.extend(self.sources.iter().map(of));
        }
        self.colors.clear();
        if let Some(all) = tree.colors() {
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
    fn renumber(&mut self, tree: &Tree, indices: &[u32]) -> Result<(), Error> {
        let vertices = tree.vertices().len();
        for corners in indices.as_chunks::<3>().0 {
            let corners = corners.map(|v| tree.original(v));
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
