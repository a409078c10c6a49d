//! The mesh renumbered into the order of the tree.

use crate::mesh::{DualGraph, EdgeKind, Mesh, NONE, Units};
use fct::NormalRecord;
use glam::Vec3;
use rayon::prelude::*;
use std::ops::Range;

/// A mesh whose faces stand in tree order and whose vertices stand in the order of first use.
///
/// A cluster is then a range of faces, and its vertices are one run, [`TreeMesh::own_vertices`], plus those on its
/// boundary: a vertex inside has all its faces in the cluster, so its first use is there too.
#[derive(Debug)]
pub struct TreeMesh {
    /// Units of the positions.
    pub units: Units,
    /// Position of each vertex, in normal units.
    pub positions: Vec<Vec3>,
    /// Position of each vertex as the file stores it; empty if it follows from the one in normal units, as it nearly
    /// always does.
    stored: Vec<Vec3>,
    /// Unit normal of each vertex, as the file stores it.
    pub normals: Vec<NormalRecord>,
    /// Colour of each vertex, if the input had colours.
    pub colors: Option<Vec<[u8; 4]>>,
    /// For each vertex the lowest vertex at the same welded position.
    pub weld: Vec<u32>,
    /// Vertex indices of each face.
    pub faces: Vec<[u32; 3]>,
    /// Unit normal of each face, zero where the area is zero.
    pub face_normals: Vec<Vec3>,
    /// Faces without area, whose normal is zero, ascending.
    flat_faces: Vec<u32>,
    /// The other side of each half-edge `3 f + e`, or [`NONE`].
    pub opposite: Vec<u32>,
    /// Half-edges without an opposite that lie on seams, ascending.
    pub seams: Vec<u32>,
    /// Vertices first used by a face before each face; one entry more than faces.
    first_vertex: Vec<u32>,
}

impl TreeMesh {
    /// Renumbers `mesh` by the order of a tree.
    ///
    /// Each list of the mesh is freed as soon as it is copied: the next copy may take its place.
    pub fn new(mesh: Mesh, order: Vec<u32>) -> TreeMesh {
        let Mesh { units, stored, positions, normals, colors, weld, faces: old_faces, graph, .. } = mesh;
        let n = order.len();
        let ((faces, old_name, first_vertex), (opposite, seams)) =
            rayon::join(|| name_vertices(old_faces, positions.len(), &order), || adjacency(graph, &order));
        drop(order);
        let weld = lowest_copies(weld, &old_name);
        let encode = |&old: &u32| NormalRecord::encode(normals[old as usize].to_array());
        let encoded = old_name.par_iter().map(encode).collect();
        drop(normals);
        let stored = in_order(stored, &old_name);
        let positions = in_order(positions, &old_name);
        let face_normals: Vec<Vec3> =
            faces.par_iter().map(|f| normal_of(f.map(|v| stored[v as usize]))).collect();
        let flat_faces = (0..n as u32).filter(|&f| face_normals[f as usize] == Vec3::ZERO).collect();
        let is_same = |(s, p): (&Vec3, &Vec3)| units.stored(*p) == *s;
        let stored = if stored.par_iter().zip(&positions).all(is_same) { Vec::new() } else { stored };
        TreeMesh {
            units,
            positions,
            stored,
            normals: encoded,
            colors: colors.map(|colors| in_order(colors, &old_name)),
            weld,
            faces,
            face_normals,
            flat_faces,
            opposite,
            seams,
            first_vertex,
        }
    }

    /// Frees the normals of faces, which [`TreeMesh::normal_of_face`] finds again.
    pub fn forget_normals(&mut self) {
        self.face_normals = Vec::new();
        self.flat_faces = Vec::new();
    }

    /// Frees who is adjacent to whom.
    pub fn forget_adjacency(&mut self) {
        self.opposite = Vec::new();
    }

    /// Position of a vertex as the file stores it.
    pub fn stored(&self, vertex: u32) -> Vec3 {
        let vertex = vertex as usize;
        self.stored.get(vertex).copied().unwrap_or_else(|| self.units.stored(self.positions[vertex]))
    }

    /// Unit normal of a face, zero if its area is zero: [`TreeMesh::face_normals`] once more.
    pub fn normal_of_face(&self, face: usize) -> Vec3 {
        normal_of(self.faces[face].map(|v| self.stored(v)))
    }

    /// The vertices that faces of a range use first: all inside the cluster, and some on its boundary.
    pub fn own_vertices(&self, faces: &Range<usize>) -> Range<usize> {
        self.first_vertex[faces.start] as usize..self.first_vertex[faces.end] as usize
    }

    /// Whether one of a range of faces has no area, and so no normal.
    pub fn has_flat_face(&self, faces: &Range<usize>) -> bool {
        let next = self.flat_faces.partition_point(|&f| (f as usize) < faces.start);
        self.flat_faces.get(next).is_some_and(|&f| (f as usize) < faces.end)
    }

    /// The vertex that a half-edge starts at.
    pub fn origin(&self, half_edge: u32) -> u32 {
        self.faces.as_flattened()[half_edge as usize]
    }

    /// The vertex that a half-edge ends at.
    pub fn target(&self, half_edge: u32) -> u32 {
        self.faces[half_edge as usize / 3][(half_edge as usize % 3 + 1) % 3]
    }

    /// What kind of edge a half-edge lies on.
    pub fn kind(&self, half_edge: u32) -> EdgeKind {
        if self.opposite[half_edge as usize] != NONE {
            EdgeKind::Interior
        } else if self.seams.binary_search(&half_edge).is_ok() {
            EdgeKind::Seam
        } else {
            EdgeKind::Boundary
        }
    }
}

/// From the stored positions, as a reader sees them: a tiny face may be crooked in normal units.
fn normal_of(stored: [Vec3; 3]) -> Vec3 {
    let [a, b, c] = stored.map(|p| p.as_dvec3());
    (b - a).cross(c - a).normalize_or_zero().as_vec3()
}

/// The faces in this order, by vertices named in the order of first use; the old name of each; and for each face how
/// many vertices those before it have used, with a last entry at the end.
fn name_vertices(
    old_faces: Vec<[u32; 3]>,
    vertices: usize,
    order: &[u32],
) -> (Vec<[u32; 3]>, Vec<u32>, Vec<u32>) {
    let mut new_name = vec![NONE; vertices];
    let mut old_name = Vec::with_capacity(vertices);
    let mut faces = Vec::with_capacity(order.len());
    let mut first_vertex = Vec::with_capacity(order.len() + 1);
    for &f in order {
        first_vertex.push(old_name.len() as u32);
        faces.push(old_faces[f as usize].map(|v| {
            let name = &mut new_name[v as usize];
            if *name == NONE {
                *name = old_name.len() as u32;
                old_name.push(v);
            }
            *name
        }));
    }
    first_vertex.push(old_name.len() as u32);
    (faces, old_name, first_vertex)
}

/// The opposite of each half-edge, and the half-edges on seams, for faces in this order.
fn adjacency(graph: DualGraph, order: &[u32]) -> (Vec<u32>, Vec<u32>) {
    let mut place = vec![0_u32; order.len()];
    for (i, &f) in order.iter().enumerate() {
        place[f as usize] = i as u32;
    }
    let half_edge = |old: u32| place[old as usize / 3] * 3 + old % 3;
    let across = |old: u32| if old == NONE { NONE } else { half_edge(old) };
    let opposite: Vec<[u32; 3]> =
        order.par_iter().map(|&f| [0, 1, 2].map(|e| across(graph.opposite[f as usize * 3 + e]))).collect();
    let mut seams: Vec<u32> = graph.seams.iter().map(|&h| half_edge(h)).collect();
    seams.sort_unstable();
    (opposite.into_flattened(), seams)
}

/// For each vertex in the new order the lowest vertex at the same welded position.
fn lowest_copies(weld: Vec<u32>, old_name: &[u32]) -> Vec<u32> {
    if weld.iter().enumerate().all(|(v, &w)| v == w as usize) {
        return (0..old_name.len() as u32).collect();
    }
    let mut lowest = vec![NONE; weld.len()];
    for (new, &old) in old_name.iter().enumerate() {
        let low = &mut lowest[weld[old as usize] as usize];
        *low = (*low).min(new as u32);
    }
    old_name.iter().map(|&old| lowest[weld[old as usize] as usize]).collect()
}

fn in_order<T: Copy + Send + Sync>(of_old: Vec<T>, old_name: &[u32]) -> Vec<T> {
    old_name.par_iter().map(|&old| of_old[old as usize]).collect()
}
