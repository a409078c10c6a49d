//! An extraction as a mesh of its own: the vertices it uses, each once.

use crate::error::Error;
use fcextract::Extraction;
use fct::{Tree, unpack};

/// Not given a place in the mesh yet. No vertex index is as high.
const UNUSED: u32 = u32::MAX;

/// An indexed mesh in the input's coordinates.
#[derive(Debug)]
pub(crate) struct Mesh {
    /// Stored positions in order of first use.
    pub(crate) vertices: Vec<[f32; 3]>,
    /// To be added to the positions.
    pub(crate) origin: [f64; 3],
    /// A unit normal a vertex.
    pub(crate) normals: Option<Vec<[f32; 3]>>,
    /// Red, green, blue, alpha a vertex.
    pub(crate) colors: Option<Vec<[u8; 4]>>,
    /// Indices into the vertices, counter-clockwise.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Triangles left out because two of their corners are copies of one vertex.
    pub(crate) collapsed: u64,
}

impl Mesh {
    /// Collects what `cut` uses. Copies that the builder made along seams become one vertex again.
    ///
    /// # Errors
    /// An invalid file when a triangle names a vertex that is not there.
    pub(crate) fn new(tree: &Tree, cut: &Extraction) -> Result<Mesh, Error> {
        let stored = tree.vertices();
        let mut place = vec![UNUSED; stored.len()];
        let mut used: Vec<u32> = Vec::new();
        let mut triangles = Vec::with_capacity(cut.indices.len() / 3);
        let mut collapsed = 0;
        for corners in cut.indices.as_chunks::<3>().0 {
            let corners = corners.map(|v| original(tree, v));
            let [a, b, c] = corners;
            if a == b || b == c || c == a {
                collapsed += 1;
                continue;
            }
            let mut triangle = [0; 3];
            for (index, v) in triangle.iter_mut().zip(corners) {
                let Some(place) = place.get_mut(v as usize) else {
                    let path = tree.path().to_owned();
                    return Err(Error::VertexIndex { path, found: v, vertices: stored.len() });
                };
                if *place == UNUSED {
                    *place = used.len() as u32;
                    used.push(v);
                }
                *index = *place;
            }
            triangles.push(triangle);
        }
        drop(place);
        let vertices =
            used.iter().filter_map(|&v| stored.get(v as usize)).map(|r| unpack(r.position)).collect();
        let normals = tree
            .normals()
            .map(|all| used.iter().filter_map(|&v| all.get(v as usize)).map(|n| n.decode()).collect());
        let colors =
            tree.colors().map(|all| used.iter().filter_map(|&v| all.get(v as usize)).copied().collect());
        Ok(Mesh { vertices, origin: tree.meta().origin, normals, colors, triangles, collapsed })
    }

    /// Whether the stored positions are the input's coordinates.
    pub(crate) fn is_at_origin(&self) -> bool {
        self.origin == [0.0; 3]
    }

    /// A position in the input's coordinates.
    pub(crate) fn absolute(&self, position: [f32; 3]) -> [f64; 3] {
        let [x, y, z] = position.map(f64::from);
        let [ox, oy, oz] = self.origin;
        [x + ox, y + oy, z + oz]
    }

    /// Everything about the vertices, in order.
    pub(crate) fn corners(&self) -> impl Iterator<Item = Corner> + '_ {
        self.vertices.iter().enumerate().map(|(i, &position)| Corner {
            position,
            normal: self.normals.as_ref().and_then(|n| n.get(i)).copied(),
            color: self.colors.as_ref().and_then(|c| c.get(i)).copied(),
        })
    }
}

/// A vertex with its attributes.
pub(crate) struct Corner {
    /// The stored position.
    pub(crate) position: [f32; 3],
    /// The unit normal, if the mesh has normals.
    pub(crate) normal: Option<[f32; 3]>,
    /// The colour, if the mesh has colours.
    pub(crate) color: Option<[u8; 4]>,
}

/// The vertex that `v` is a copy of, or `v`.
fn original(tree: &Tree, v: u32) -> u32 {
    let copies = tree.weld();
    match copies.binary_search_by_key(&v, |w| w.vertex.get()) {
        Ok(found) => copies.get(found).map_or(v, |w| w.representative.get()),
        Err(_) => v,
    }
}
