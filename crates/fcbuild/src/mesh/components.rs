//! Connected components of the dual graph.

use super::{Mesh, NONE};
use glam::DVec3;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

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
        let mut label = first_faces(&mesh.graph.opposite);
        let mut count = 0;
        for face in 0..n {
            // A component is known by its first face, which comes before the others.
            let first = label[face] as usize;
            label[face] = if first == face { count } else { label[first] };
            count += u32::from(first == face);
        }
        let mut start = vec![0_u32; count as usize + 1];
        let mut centroid = vec![DVec3::ZERO; count as usize];
        for (face, &l) in label.iter().enumerate() {
            start[l as usize + 1] += 1;
            // One alone needs no order.
            if count > 1 {
                let [a, b, c] = mesh.faces[face].map(|v| mesh.positions[v as usize].as_dvec3());
                centroid[l as usize] += (a + b + c) / 3.0;
            }
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

/// For each face the first one of its component.
///
/// Every face points to an earlier one of its component, or to itself. Threads join what they find in any order, and
/// whatever the order, the first face is the only one that is left pointing to itself.
fn first_faces(opposite: &[u32]) -> Vec<u32> {
    let earlier: Vec<AtomicU32> =
        (0..opposite.len() as u32 / 3).into_par_iter().map(AtomicU32::new).collect();
    (0..earlier.len()).into_par_iter().with_min_len(1024).for_each(|face| {
        for &across in &opposite[3 * face..3 * face + 3] {
            // Each edge once.
            if across != NONE && (across as usize) < 3 * face {
                join(&earlier, face as u32, across / 3);
            }
        }
    });
    let first = |face| follow(&earlier, face);
    (0..earlier.len() as u32).into_par_iter().map(first).collect()
}

/// Follows a face to the first one, and halves the way for those that come after.
fn follow(earlier: &[AtomicU32], mut face: u32) -> u32 {
    loop {
        let next = earlier[face as usize].load(Relaxed);
        if next == face {
            return face;
        }
        let after = earlier[next as usize].load(Relaxed);
        if after != next {
            // Whoever comes between has written an earlier face of the same component.
            let _ = earlier[face as usize].compare_exchange_weak(next, after, Relaxed, Relaxed);
        }
        face = after;
    }
}

fn join(earlier: &[AtomicU32], a: u32, b: u32) {
    let (mut a, mut b) = (a, b);
    loop {
        (a, b) = (follow(earlier, a), follow(earlier, b));
        if a == b {
            return;
        }
        let (low, high) = (a.min(b), a.max(b));
        if earlier[high as usize].compare_exchange(high, low, Relaxed, Relaxed).is_ok() {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Chains through faces in no order, so that threads meet at many places.
    #[test]
    fn first_faces_are_those_of_a_walk_through_each_component() {
        let mut state = 5_u64;
        let mut random = |n: usize| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as usize % n
        };
        let faces = 20_000;
        let mut order: Vec<u32> = (0..faces).collect();
        for i in (1..order.len()).rev() {
            order.swap(i, random(i + 1));
        }
        let mut opposite = vec![NONE; 3 * faces as usize];
        let mut expected: Vec<u32> = (0..faces).collect();
        let mut first = 0;
        for i in 1..order.len() {
            if random(3000) == 0 {
                first = i;
                continue;
            }
            let (here, there) = (3 * order[i - 1] + 1, 3 * order[i]);
            opposite[here as usize] = there;
            opposite[there as usize] = here;
            let low = order[first..=i].iter().copied().min().unwrap();
            for &face in &order[first..=i] {
                expected[face as usize] = low;
            }
        }
        for threads in [1, 2, 5] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            assert_eq!(pool.install(|| first_faces(&opposite)), expected);
        }
    }
}
