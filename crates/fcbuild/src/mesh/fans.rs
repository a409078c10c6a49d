//! One vertex per fan: pinch (bow-tie) vertices and seams are taken apart by copying vertices.

use super::dual_graph::{DualGraph, NONE, next_in_face, prev_in_face};

/// Gives every fan of faces around a vertex a vertex of its own.
///
/// The first fan in face order keeps the vertex; each further one gets a copy, numbered from `vertex_count` on.
/// Returns the original vertex of each copy.
pub(super) fn split(faces: &mut [[u32; 3]], graph: &DualGraph, vertex_count: usize) -> Vec<u32> {
    let mut copies = Vec::new();
    let mut seen_corner = vec![false; faces.len() * 3];
    let mut seen_vertex = vec![false; vertex_count];
    for corner in 0..(faces.len() * 3) as u32 {
        if seen_corner[corner as usize] {
            continue;
        }
        let vertex = faces[corner as usize / 3][corner as usize % 3];
        let name = if std::mem::replace(&mut seen_vertex[vertex as usize], true) {
            copies.push(vertex);
            (vertex_count + copies.len() - 1) as u32
        } else {
            vertex
        };
        let mut visit = |corner: u32| {
            seen_corner[corner as usize] = true;
            faces[corner as usize / 3][corner as usize % 3] = name;
        };
        // Turn one way until the fan closes or ends; if it ended, turn the other way from the start.
        let mut at = corner;
        let closed = loop {
            visit(at);
            at = graph.opposite[prev_in_face(at) as usize];
            if at == NONE || at == corner {
                break at == corner;
            }
        };
        if !closed {
            at = corner;
            loop {
                let across = graph.opposite[at as usize];
                if across == NONE {
                    break;
                }
                at = next_in_face(across);
                visit(at);
            }
        }
    }
    copies
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
