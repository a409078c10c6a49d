//! Connected components of the dual graph.

use super::{Mesh, NONE};
use glam::DVec3;

/// The faces of a mesh by connected component.
#[derive(Debug)]
pub struct Components {
    /// Faces, component by component, each in ascending order.
    pub faces: Vec<u32>,
    /// Where each component starts in `faces`, and a last entry at the end.
    pub start: Vec<u32>,
    /// Mean of the face centroids of each component, in normal units.
    pub centroid: Vec<DVec3>,
    /// Group of each component's first face.
    pub group: Vec<u32>,
}

impl Components {
    /// Finds the components, in the order of their first faces; a component never spans two groups.
    pub fn of(mesh: &Mesh) -> Components {
        let n = mesh.faces.len();
        let mut label = vec![u32::MAX; n];
        let mut count = 0;
        let mut stack = Vec::new();
        for seed in 0..n {
            if label[seed] != u32::MAX {
                continue;
            }
            label[seed] = count;
            stack.push(seed as u32);
            while let Some(face) = stack.pop() {
                for e in 0..3 {
                    let across = mesh.graph.opposite[face as usize * 3 + e];
                    if across != NONE && label[across as usize / 3] == u32::MAX {
                        label[across as usize / 3] = count;
                        stack.push(across / 3);
                    }
                }
            }
            count += 1;
        }
        let mut start = vec![0_u32; count as usize + 1];
        let mut centroid = vec![DVec3::ZERO; count as usize];
        for (face, &l) in label.iter().enumerate() {
            start[l as usize + 1] += 1;
            let [a, b, c] = mesh.faces[face].map(|v| mesh.positions[v as usize].as_dvec3());
            centroid[l as usize] += (a + b + c) / 3.0;
        }
        for l in 0..count as usize {
            centroid[l] /= f64::from(start[l + 1]);
            start[l + 1] += start[l];
        }
        let mut faces = vec![0_u32; n];
        let mut at = start.clone();
        for (face, &l) in label.iter().enumerate() {
            faces[at[l as usize] as usize] = face as u32;
            at[l as usize] += 1;
        }
        let group = (0..count as usize)
            .map(|l| mesh.face_group.get(faces[start[l] as usize] as usize).copied().unwrap_or(0))
            .collect();
        Components { faces, start, centroid, group }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.centroid.len()
    }

    /// True for a mesh without faces, which [`Mesh::from_soup`] refuses.
    pub fn is_empty(&self) -> bool {
        self.centroid.is_empty()
    }

    /// The component of each face of the mesh.
    pub fn of_faces(&self) -> Vec<u32> {
        let mut of_face = vec![0; self.faces.len()];
        for c in 0..self.len() {
            for &f in self.faces_of(c) {
                of_face[f as usize] = c as u32;
            }
        }
        of_face
    }

    /// The faces of component `i`.
    pub fn faces_of(&self, i: usize) -> &[u32] {
        &self.faces[self.start[i] as usize..self.start[i + 1] as usize]
    }
}
