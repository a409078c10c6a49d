//! What is written: the buffers of an extraction, in the input's coordinates and groups.

use crate::error::Error;
use fcextract::{Extraction, Selection};
use fcmeasure::Surface;
use fct::{Child, ChildRef, Tree};
use std::path::Path;

/// In no group. No group's index is as high.
const NO_GROUP: u32 = u32::MAX;

/// An indexed mesh in the input's coordinates.
#[derive(Debug, Default)]
pub(crate) struct Mesh {
    /// The vertices, each once, with their attributes, and the triangles.
    pub(crate) buffers: fcextract::Mesh,
    /// The input's name, without its ending.
    pub(crate) name: String,
    /// To be added to the positions.
    pub(crate) origin: [f64; 3],
    /// Where the triangles of each group begin, with its name; empty when the tree has no groups.
    pub(crate) groups: Vec<(usize, String)>,
}

impl Mesh {
    /// Collects what `cut` uses. Copies that the builder made along seams become one vertex again.
    ///
    /// # Errors
    /// An invalid file when a group names a face that is not there.
    pub(crate) fn new(tree: &Tree, cut: &Extraction, selection: &Selection) -> Result<Mesh, Error> {
        let mut buffers = fcextract::Mesh::default();
        buffers.fill(tree, cut, selection)?;
        let meta = tree.meta();
        let stem = Path::new(&meta.source).file_stem().unwrap_or_default();
        let name = stem.to_string_lossy().into_owned();
        Ok(Mesh { buffers, name, origin: meta.origin, groups: groups_of(tree, cut)? })
    }

    /// The triangles, counter-clockwise, as indices into the vertices.
    pub(crate) fn triangles(&self) -> &[[u32; 3]] {
        self.buffers.indices.as_chunks::<3>().0
    }

    /// The mesh as it is measured.
    pub(crate) fn surface(&self) -> Surface<'_> {
        Surface { positions: &self.buffers.positions, faces: self.triangles(), colors: &self.buffers.colors }
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
        let buffers = &self.buffers;
        buffers.positions.iter().enumerate().map(|(i, &position)| Corner {
            position,
            normal: buffers.normals.get(i).copied(),
            color: buffers.colors.get(i).copied(),
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

/// Where the triangles of each group begin, those that collapse not counted.
///
/// The builder cuts the surface where groups meet, so that no vertex belongs to two.
fn groups_of(tree: &Tree, cut: &Extraction) -> Result<Vec<(usize, String)>, Error> {
    let group_of = group_of_vertices(tree)?;
    let (mut groups, mut group, mut triangles) = (Vec::new(), None, 0);
    for corners in cut.indices.as_chunks::<3>().0 {
        let of_this = corners.first().and_then(|&v| group_of.get(v as usize)).copied();
        let [a, b, c] = corners.map(|v| tree.original(v));
        if a == b || b == c || c == a {
            continue;
        }
        if of_this != group {
            group = of_this;
            groups.push((triangles, group_name(tree, of_this)));
        }
        triangles += 1;
    }
    Ok(groups)
}

/// The group of each vertex; empty when the tree has no groups.
fn group_of_vertices(tree: &Tree) -> Result<Vec<u32>, Error> {
    if tree.groups().is_empty() {
        return Ok(Vec::new());
    }
    let mut group_of = vec![NO_GROUP; tree.vertices().len()];
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
