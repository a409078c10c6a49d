//! An extraction as buffers of its own, for a GPU or a file.

use crate::{Error, Extraction, Selection};
use fct::Tree;
use glam::DVec3;

/// The vertices that an extraction uses, each once, with their attributes; reuse it to keep its memory.
///
/// Copies that the builder made along seams are one vertex again, so what was connected in the input is connected here.
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
    /// How far the farthest vertex is drawn beside its place, see [`Selection::position`].
    pub longest_step: f64,
    /// Triangles left out because two of their corners are copies of one vertex.
    pub collapsed: u64,
    /// Of each vertex of the tree, its place here; [`UNUSED`] between two fillings.
    places: Vec<u32>,
}

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
        self.longest_step = 0.0;
        self.positions.clear();
        for record in self.sources.iter().filter_map(|&v| stored.get(v as usize)) {
            let place = DVec3::from(record.position().map(f64::from));
            let drawn = selection.position(record);
            self.longest_step = self.longest_step.max(place.distance(drawn));
            self.positions.push(drawn.as_vec3().to_array());
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
                    return Err(Error::Selection("it was extracted from another tree"));
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
}
