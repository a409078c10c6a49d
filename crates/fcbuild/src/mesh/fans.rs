//! One vertex per fan: pinch (bow-tie) vertices and seams are taken apart by copying vertices.

use super::dual_graph::{DualGraph, NONE, next_in_face, prev_in_face};
use super::shares::{share, shares};
use rayon::prelude::*;

/// Gives every fan of faces around a vertex a vertex of its own.
///
/// The first fan in face order keeps the vertex; each further one gets a copy, numbered from `vertex_count` on.
/// Returns the original vertex of each copy.
pub(super) fn split(faces: &mut [[u32; 3]], graph: &DualGraph, vertex_count: usize) -> Vec<u32> {
    let several = with_several_fans(faces, graph, vertex_count);
    let mut copies = Vec::new();
    if !several.contains(&true) {
        return copies;
    }
    let mut seen_corner = vec![false; faces.len() * 3];
    let mut seen_vertex = vec![false; vertex_count];
    for corner in 0..(faces.len() * 3) as u32 {
        let vertex = faces[corner as usize / 3][corner as usize % 3];
        // A copy has been seen, and its number is beyond the list.
        if seen_corner[corner as usize] || !several[vertex as usize] {
            continue;
        }
        let name = if std::mem::replace(&mut seen_vertex[vertex as usize], true) {
            copies.push(vertex);
            (vertex_count + copies.len() - 1) as u32
        } else {
            vertex
        };
        for corner in fan(&graph.opposite, corner) {
            seen_corner[corner as usize] = true;
            faces[corner as usize / 3][corner as usize % 3] = name;
        }
    }
    copies
}

/// The corners around a vertex that are reached from one of them across edges.
pub(crate) fn fan(opposite: &[u32], corner: u32) -> impl Iterator<Item = u32> {
    // Turns one way until the fan closes or ends; if it ended, turns the other way from the start.
    let (mut next, mut turns_back) = (corner, false);
    std::iter::from_fn(move || {
        if next == NONE {
            return None;
        }
        let at = next;
        if !turns_back {
            next = opposite[prev_in_face(at) as usize];
            turns_back = next == NONE;
        }
        if next == corner {
            next = NONE;
        } else if turns_back {
            let across = opposite[if next == NONE { corner } else { at } as usize];
            next = if across == NONE { NONE } else { next_in_face(across) };
        }
        Some(at)
    })
}

/// For each vertex, whether the fan of one of its corners leaves others out.
fn with_several_fans(faces: &[[u32; 3]], graph: &DualGraph, vertex_count: usize) -> Vec<bool> {
    let mut several = vec![false; vertex_count];
    several.par_chunks_mut(share(vertex_count)).zip(shares(vertex_count)).for_each(|(several, own)| {
        // Its first corner and how many it has.
        let mut corners = vec![(NONE, 0_u32); own.len()];
        for (corner, &v) in faces.as_flattened().iter().enumerate() {
            if let Some((first, count)) = (v as usize).checked_sub(own.start).and_then(|v| corners.get_mut(v))
            {
                *first = (*first).min(corner as u32);
                *count += 1;
            }
        }
        for (several, (first, mut left)) in several.iter_mut().zip(corners) {
            if first != NONE {
                left -= fan(&graph.opposite, first).count() as u32;
                *several = left > 0;
            }
        }
    });
    several
}

#[cfg(test)]
mod tests {
    use super::*;

    fn split_copy(faces: &[[u32; 3]], n: usize) -> (Vec<[u32; 3]>, Vec<u32>) {
        let mut faces = faces.to_vec();
        let graph = DualGraph::of(&faces, n, &[]);
        let copies = split(&mut faces, &graph, n);
        (faces, copies)
    }

    #[test]
    fn a_closed_fan_stays_whole() {
        let tetra = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        assert_eq!(split_copy(&tetra, 4), (tetra.to_vec(), vec![]));
    }

    #[test]
    fn a_bow_tie_is_taken_apart() {
        let (faces, copies) = split_copy(&[[0, 1, 2], [0, 3, 4]], 5);
        assert_eq!((faces, copies), (vec![[0, 1, 2], [5, 3, 4]], vec![0]));
    }

    #[test]
    fn every_sheet_of_a_seam_gets_its_own_vertices() {
        let (faces, copies) = split_copy(&[[0, 1, 2], [1, 0, 3], [1, 0, 4]], 5);
        assert_eq!(copies, [1, 0, 1, 0]);
        let mut ends: Vec<u32> = faces.iter().flat_map(|f| f[..2].to_vec()).collect();
        ends.sort_unstable();
        ends.dedup();
        assert_eq!(ends.len(), 6);
    }

    #[test]
    fn an_open_fan_is_walked_both_ways() {
        let (faces, copies) = split_copy(&[[0, 2, 3], [0, 1, 2], [0, 3, 4]], 5);
        assert_eq!((faces.len(), copies.len()), (3, 0));
    }
}
