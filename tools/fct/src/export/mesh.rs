//! An extraction as a mesh of its own: the vertices it uses, each once.

use crate::error::Error;
use fcextract::Extraction;
use fct::{Child, ChildRef, Tree};

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
    /// Where the triangles of each group begin, with its name; empty when the tree has no groups.
    pub(crate) groups: Vec<(usize, String)>,
    /// Triangles left out because two of their corners are copies of one vertex.
    pub(crate) collapsed: u64,
}

impl Mesh {
    /// Collects what `cut` uses. Copies that the builder made along seams become one vertex again.
    ///
    /// # Errors
    /// An invalid file when a triangle names a vertex that is not there, or a group a face.
    pub(crate) fn new(tree: &Tree, cut: &Extraction) -> Result<Mesh, Error> {
        let stored = tree.vertices();
        let mut place = vec![UNUSED; stored.len()];
        let mut used: Vec<u32> = Vec::new();
        let mut triangles = Vec::with_capacity(cut.indices.len() / 3);
        let mut collapsed = 0;
        let group_of = group_of_vertices(tree)?;
        let (mut groups, mut group) = (Vec::new(), None);
        for corners in cut.indices.as_chunks::<3>().0 {
            let of_this = corners.first().and_then(|&v| group_of.get(v as usize)).copied();
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
            if of_this != group {
                group = of_this;
                groups.push((triangles.len(), group_name(tree, of_this)));
            }
            triangles.push(triangle);
        }
        drop(place);
        let vertices = used.iter().filter_map(|&v| stored.get(v as usize)).map(|r| r.position()).collect();
        let normals = tree
            .normals()
            .map(|all| used.iter().filter_map(|&v| all.get(v as usize)).map(|n| n.decode()).collect());
        let colors =
            tree.colors().map(|all| used.iter().filter_map(|&v| all.get(v as usize)).copied().collect());
        Ok(Mesh { vertices, origin: tree.meta().origin, normals, colors, triangles, groups, collapsed })
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

/// The group of each vertex; empty when the tree has no groups.
///
/// The builder cuts the surface where groups meet, so that no vertex belongs to two.
fn group_of_vertices(tree: &Tree) -> Result<Vec<u32>, Error> {
    if tree.groups().is_empty() {
        return Ok(Vec::new());
    }
    let mut group_of = vec![UNUSED; tree.vertices().len()];
    let reader = tree.reader();
    for (group, record) in (0..).zip(tree.groups()) {
        let mut stack = vec![reader.find(ChildRef::from_raw(record.root.get()))?];
        while let Some(subtree) = stack.pop() {
            if let Child::Node(_) = subtree.child.kind() {
                stack.extend(reader.children(&subtree)?);
                continue;
            }
            for v in reader.face(&subtree)? {
                if let Some(slot) = group_of.get_mut(v as usize) {
                    *slot = group;
                }
            }
        }
    }
    Ok(group_of)
}

fn group_name(tree: &Tree, group: Option<u32>) -> String {
    let record = group.and_then(|g| tree.groups().get(g as usize));
    let name = record.and_then(|r| tree.meta().group_names.get(r.name.get() as usize));
    name.cloned().unwrap_or_default()
}

/// The vertex that `v` is a copy of, or `v`.
fn original(tree: &Tree, v: u32) -> u32 {
    let copies = tree.weld();
    match copies.binary_search_by_key(&v, |w| w.vertex.get()) {
        Ok(found) => copies.get(found).map_or(v, |w| w.representative.get()),
        Err(_) => v,
    }
}
