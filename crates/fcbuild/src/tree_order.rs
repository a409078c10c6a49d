//! The mesh renumbered into the order of the tree.

use crate::mesh::{EdgeKind, Mesh, NONE, Units};
use crate::partition::Hierarchy;
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
    /// Position of each vertex as the file stores it.
    pub stored: Vec<Vec3>,
    /// Position of each vertex, in normal units.
    pub positions: Vec<Vec3>,
    /// Unit normal of each vertex.
    pub normals: Vec<Vec3>,
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
    /// Renumbers `mesh` by `hierarchy`.
    pub fn new(mesh: Mesh, hierarchy: &Hierarchy) -> TreeMesh {
        let n = hierarchy.order.len();
        let mut place = vec![0_u32; n];
        for (i, &f) in hierarchy.order.iter().enumerate() {
            place[f as usize] = i as u32;
        }
        let mut new_name = vec![NONE; mesh.positions.len()];
        let mut old_name = Vec::with_capacity(mesh.positions.len());
        let mut faces = Vec::with_capacity(n);
        let mut first_vertex = Vec::with_capacity(n + 1);
        for &f in &hierarchy.order {
            first_vertex.push(old_name.len() as u32);
            faces.push(mesh.faces[f as usize].map(|v| {
                let name = &mut new_name[v as usize];
                if *name == NONE {
                    *name = old_name.len() as u32;
                    old_name.push(v);
                }
                *name
            }));
        }
        first_vertex.push(old_name.len() as u32);

        let half_edge = |old: u32| place[old as usize / 3] * 3 + old % 3;
        let old_opposite = &mesh.graph.opposite;
        let opposite = hierarchy
            .order
            .par_iter()
            .flat_map_iter(|&f| {
                let half_edge = &half_edge;
                (0..3).map(move |e| match old_opposite[f as usize * 3 + e] {
                    NONE => NONE,
                    across => half_edge(across),
                })
            })
            .collect();
        let mut seams: Vec<u32> = mesh.graph.seams.iter().map(|&h| half_edge(h)).collect();
        seams.sort_unstable();
        let is_welded = mesh.weld.iter().enumerate().any(|(v, &w)| v != w as usize);
        let weld = if is_welded {
            let mut lowest = vec![NONE; mesh.positions.len()];
            for (new, &old) in old_name.iter().enumerate() {
                let low = &mut lowest[mesh.weld[old as usize] as usize];
                *low = (*low).min(new as u32);
            }
            old_name.iter().map(|&old| lowest[mesh.weld[old as usize] as usize]).collect()
        } else {
            (0..old_name.len() as u32).collect()
        };
        let stored = in_order(&mesh.stored, &old_name);
        // From the stored positions, as a reader sees them: a tiny face may be crooked in normal units.
        let face_normals: Vec<Vec3> = faces
            .par_iter()
            .map(|f| {
                let [a, b, c] = f.map(|v: u32| stored[v as usize].as_dvec3());
                (b - a).cross(c - a).normalize_or_zero().as_vec3()
            })
            .collect();
        let flat_faces = (0..n as u32).filter(|&f| face_normals[f as usize] == Vec3::ZERO).collect();
        TreeMesh {
            units: mesh.units,
            stored,
            normals: in_order(&mesh.normals, &old_name),
            colors: mesh.colors.map(|colors| in_order(&colors, &old_name)),
            positions: in_order(&mesh.positions, &old_name),
            weld,
            faces,
            face_normals,
            flat_faces,
            opposite,
            seams,
            first_vertex,
        }
    }

    /// Frees what only the search for boundaries and bounds needs: adjacency, face normals and positions in normal
    /// units. What is left is what a file holds.
    pub fn keep_what_is_stored(&mut self) {
        self.positions = Vec::new();
        self.face_normals = Vec::new();
        self.flat_faces = Vec::new();
        self.opposite = Vec::new();
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

fn in_order<T: Copy + Send + Sync>(of_old: &[T], old_name: &[u32]) -> Vec<T> {
    old_name.par_iter().map(|&old| of_old[old as usize]).collect()
}
