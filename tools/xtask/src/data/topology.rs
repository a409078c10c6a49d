//! Counts that say whether a mesh is closed, manifold and of one piece.

use super::ply_out::Mesh;

/// What the edges and the vertices of a mesh say about its shape.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Topology {
    /// Pieces connected by edges, not counting vertices without faces.
    pub(crate) components: usize,
    /// Directed edges used by more than one face: each is a wrong winding or a non-manifold edge.
    pub(crate) repeated_directed_edges: usize,
    /// Directed edges whose opposite no face uses: the length of the boundary.
    pub(crate) open_edges: usize,
    /// Edges with three or more faces.
    pub(crate) edges_with_three_or_more_faces: usize,
    /// Vertices whose faces do not form one fan.
    pub(crate) pinched_vertices: usize,
    /// Vertices of no face.
    pub(crate) unused_vertices: usize,
    /// V - E + F over the used vertices.
    pub(crate) euler: i64,
}

/// Finds the root of `i` and halves the path to it.
fn root(parent: &mut [u32], mut i: u32) -> u32 {
    while parent[i as usize] != i {
        parent[i as usize] = parent[parent[i as usize] as usize];
        i = parent[i as usize];
    }
    i
}

impl Topology {
    /// Examines a mesh by sorting its edges; the indices must be in range.
    pub(crate) fn of(mesh: &Mesh) -> Topology {
        // Each entry: the undirected edge, whether it is walked backwards, its face.
        let mut edges: Vec<(u32, u32, bool, u32)> = Vec::with_capacity(mesh.faces.len() * 3);
        for (i, f) in mesh.faces.iter().enumerate() {
            for k in 0..3 {
                let (a, b) = (f[k], f[(k + 1) % 3]);
                edges.push((a.min(b), a.max(b), a > b, i as u32));
            }
        }
        edges.sort_unstable();
        let mut piece: Vec<u32> = (0..mesh.faces.len() as u32).collect();
        // One node per face corner; corners that share a vertex and an edge belong to one fan.
        let mut fan: Vec<u32> = (0..mesh.faces.len() as u32 * 3).collect();
        let corner = |face: u32, vertex: u32| {
            let k = mesh.faces[face as usize].iter().position(|v| *v == vertex).unwrap_or(0);
            face * 3 + k as u32
        };
        let (mut repeated, mut open, mut crowded, mut distinct) = (0, 0, 0, 0_i64);
        for group in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let backward = group.iter().filter(|e| e.2).count();
            let forward = group.len() - backward;
            repeated += forward.saturating_sub(1) + backward.saturating_sub(1);
            open += forward.abs_diff(backward);
            crowded += usize::from(group.len() > 2);
            distinct += 1;
            for pair in group.windows(2) {
                let (first, second) = (pair[0], pair[1]);
                let (a, b) = (root(&mut piece, first.3), root(&mut piece, second.3));
                piece[a.max(b) as usize] = a.min(b);
                for v in [first.0, first.1] {
                    let (a, b) = (corner(first.3, v), corner(second.3, v));
                    let (a, b) = (root(&mut fan, a), root(&mut fan, b));
                    fan[a.max(b) as usize] = a.min(b);
                }
            }
        }
        let components = (0..piece.len() as u32).filter(|i| piece[*i as usize] == *i).count();
        let mut fans = vec![0_u32; mesh.positions.len()];
        for i in 0..fan.len() {
            if fan[i] as usize == i {
                fans[mesh.faces[i / 3][i % 3] as usize] += 1;
            }
        }
        let unused = fans.iter().filter(|n| **n == 0).count();
        Topology {
            components,
            repeated_directed_edges: repeated,
            open_edges: open,
            edges_with_three_or_more_faces: crowded,
            pinched_vertices: fans.iter().filter(|n| **n > 1).count(),
            unused_vertices: unused,
            euler: (mesh.positions.len() - unused) as i64 - distinct + mesh.faces.len() as i64,
        }
    }

    /// True for an oriented manifold, with or without boundary.
    pub(crate) fn is_manifold(&self) -> bool {
        self.repeated_directed_edges == 0
            && self.edges_with_three_or_more_faces == 0
            && self.pinched_vertices == 0
            && self.unused_vertices == 0
    }

    /// True for an oriented manifold without boundary.
    pub(crate) fn is_closed(&self) -> bool {
        self.is_manifold() && self.open_edges == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetra() -> Mesh {
        Mesh { positions: vec![[0.0; 3]; 4], faces: vec![[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]] }
    }

    #[test]
    fn tells_closed_open_pinched_and_crowded_apart() {
        assert!(Topology::of(&tetra()).is_closed());
        assert_eq!(Topology::of(&tetra()).euler, 2);
        let mut open = tetra();
        open.faces.pop();
        assert!(Topology::of(&open).is_manifold() && !Topology::of(&open).is_closed());
        // Two tetrahedra that share only a vertex.
        let mut pinched = tetra();
        pinched.positions.extend([[0.0; 3]; 3]);
        pinched.faces.extend([[0, 4, 5], [0, 6, 4], [0, 5, 6], [4, 6, 5]]);
        let t = Topology::of(&pinched);
        assert_eq!((t.pinched_vertices, t.components, t.is_manifold()), (1, 2, false));
        let mut crowded = tetra();
        crowded.positions.push([1.0; 3]);
        crowded.faces.push([0, 1, 4]);
        assert_eq!(Topology::of(&crowded).edges_with_three_or_more_faces, 1);
    }
}
