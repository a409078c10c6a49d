//! Merging neighbouring clusters from the faces up: the tree of best quality.
//!
//! The cheapest merge first would be a serial loop over the whole mesh. Instead faces are merged inside cells of a few
//! thousand, in parallel, only as far as cells can tell what is cheap; what is left of all cells is put into new
//! cells, whose borders run elsewhere, and so on until few enough clusters are left to be merged in one queue.
//!
//! # Paper
//! The clusters are merged as in Garland's hierarchical face clustering, which `[TsujiJa]` compares with; the error is
//! that of `[Tsuji07, eq. 8]`, weighed by what a merge saves: the triangles that are drawn no more.

mod cells;
mod cluster;
mod forest;
mod graph;
mod numbering;
mod queue;
mod rule;

#[cfg(test)]
mod tests;

pub(super) use rule::Rule;

use super::hierarchy::Hierarchy;
use super::{DEPTH_LIMIT, SplitMode, top};
use crate::mesh::{Components, Mesh, NONE, origin};
use cells::Faces;
use cluster::Cluster;
use glam::DVec3;
use graph::{Edge, LOCAL, Merge, Merged};
use rayon::prelude::*;

/// Faces, or clusters, of one cell: what it works on should stay in the processor's cache.
const CELL: usize = 4096;

/// One cluster of a cell in so many is left.
const SHRINK: usize = 8;

/// So many clusters are merged in one queue.
const LAST_ROUND: usize = 16_384;

/// The tree of `mesh`; none if it would be too deep.
pub(super) fn merge_all(
    mesh: &Mesh,
    components: &Components,
    rule: Rule,
    progress: &(dyn Fn(u64) + Sync),
) -> Option<Hierarchy> {
    let faces = mesh.faces.len();
    let mut forest = Forest { rule, faces, merges: Vec::with_capacity(faces - 1) };
    let (mut clusters, mut edges) = forest.merge_faces(mesh, components, progress);
    let boundary = boundary_vertices(mesh);
    while clusters.len() > LAST_ROUND && !edges.is_empty() {
        let before = clusters.len();
        (clusters, edges) = forest.merge_round(clusters, edges, &boundary);
        if clusters.len() * 8 > before * 7 {
            break;
        }
    }
    let degree = degrees(&edges, &boundary);
    let last = cells::merge_clusters(rule, clusters, edges, &degree, 1);
    let (clusters, _) = forest.add([last]);
    let root = forest.join(components, &clusters)?;
    let (splits, order) = forest::lay_out(&forest.merges, root, faces);
    let mode = if rule == Rule::Quality { SplitMode::Quality } else { SplitMode::Merge };
    Some(Hierarchy { splits, order, mode })
}

/// All merges so far.
struct Forest {
    rule: Rule,
    faces: usize,
    merges: Vec<Merge>,
}

impl Forest {
    /// The first round: cells of faces.
    fn merge_faces(
        &mut self,
        mesh: &Mesh,
        components: &Components,
        progress: &(dyn Fn(u64) + Sync),
    ) -> (Vec<Cluster>, Vec<Edge>) {
        let centroid =
            |f: &[u32; 3]| f.map(|v| mesh.positions[v as usize].as_dvec3()).into_iter().sum::<DVec3>();
        let order = cells::along_curve(mesh.faces.par_iter().map(centroid));
        let mut place = vec![0_u32; self.faces];
        for (i, &f) in order.iter().enumerate() {
            place[f as usize] = i as u32;
        }
        let component = if components.len() == 1 { Vec::new() } else { components.of_faces() };
        // A fan of n faces has n edges, and one more if it is open.
        let mut degree: Vec<u8> = boundary_vertices(mesh).into_iter().map(|b| b / BOUNDARY).collect();
        for &v in mesh.faces.iter().flatten() {
            degree[v as usize] = degree[v as usize].saturating_add(1);
        }
        let along = Faces { mesh, order: &order, place: &place, component: &component, degree: &degree };
        let rounds: Vec<Merged> = (0..order.len().div_ceil(CELL))
            .into_par_iter()
            .map(|i| {
                let len = CELL.min(order.len() - i * CELL);
                let merged = cells::merge_faces(self.rule, &along, i * CELL, len, len / SHRINK);
                progress(len as u64);
                merged
            })
            .collect();
        // Edges between cells, by the later of their faces.
        let crossing: Vec<(u32, u32, Edge)> = order
            .par_iter()
            .enumerate()
            .flat_map_iter(|(i, &face)| {
                let place = &place;
                (0..3).filter_map(move |e| {
                    let across = mesh.graph.opposite[face as usize * 3 + e];
                    let other = if across == NONE { i as u32 } else { place[across as usize / 3] };
                    (other as usize / CELL < i / CELL).then(|| {
                        let ends = [e, (e + 1) % 3].map(|k| mesh.faces[face as usize][k]);
                        let [a, b] = ends.map(|v| mesh.positions[v as usize]);
                        (other, i as u32, Edge { clusters: [NONE; 2], ends, length: a.distance(b) })
                    })
                })
            })
            .collect();
        self.collect(rounds, crossing)
    }

    /// A later round: cells of clusters.
    fn merge_round(
        &mut self,
        clusters: Vec<Cluster>,
        edges: Vec<Edge>,
        boundary: &[u8],
    ) -> (Vec<Cluster>, Vec<Edge>) {
        let order = cells::along_curve(clusters.par_iter().map(|c| c.centroid));
        let mut place = vec![0_u32; order.len()];
        for (i, &c) in order.iter().enumerate() {
            place[c as usize] = i as u32;
        }
        let degree = degrees(&edges, boundary);
        let mut inside: Vec<Vec<Edge>> = vec![Vec::new(); order.len().div_ceil(CELL)];
        let mut crossing = Vec::new();
        for mut edge in edges {
            let [a, b] = edge.clusters.map(|c| place[c as usize]);
            let cell = a as usize / CELL;
            if cell == b as usize / CELL {
                edge.clusters = [a, b].map(|c| c - (cell * CELL) as u32);
                inside[cell].push(edge);
            } else {
                crossing.push((a, b, edge));
            }
        }
        let rounds: Vec<Merged> = order
            .par_chunks(CELL)
            .zip(inside)
            .map(|(cell, edges)| {
                let own = cell.iter().map(|&c| clusters[c as usize]).collect();
                cells::merge_clusters(self.rule, own, edges, &degree, cell.len() / SHRINK)
            })
            .collect();
        self.collect(rounds, crossing)
    }

    /// Puts the cells of a round together, and the edges between them, which are given by places.
    fn collect(&mut self, rounds: Vec<Merged>, crossing: Vec<(u32, u32, Edge)>) -> (Vec<Cluster>, Vec<Edge>) {
        let mut first = Vec::with_capacity(rounds.len());
        let mut sum = 0;
        for r in &rounds {
            first.push(sum);
            sum += r.clusters.len() as u32;
        }
        let now = |place: u32| {
            let (cell, at) = (place as usize / CELL, place as usize % CELL);
            first[cell] + rounds[cell].now[at]
        };
        let mut crossing: Vec<Edge> = crossing
            .into_par_iter()
            .map(|(a, b, edge)| {
                let [a, b] = [now(a), now(b)];
                Edge { clusters: [a.min(b), a.max(b)], ..edge }
            })
            .collect();
        crossing.par_sort_by_key(|e| e.clusters);
        crossing.dedup_by(|piece, edge| {
            let same = piece.clusters == edge.clusters;
            if same {
                edge.absorb(piece);
            }
            same
        });
        let (clusters, mut edges) = self.add(rounds);
        edges.extend(crossing);
        (clusters, edges)
    }

    /// Appends the merges of a round; its clusters and edges come back numbered across cells.
    fn add(&mut self, rounds: impl IntoIterator<Item = Merged>) -> (Vec<Cluster>, Vec<Edge>) {
        let (mut clusters, mut edges) = (Vec::new(), Vec::new());
        for round in rounds {
            let first_merge = (self.faces + self.merges.len()) as u32;
            let first_cluster = clusters.len() as u32;
            let global = |r: u32| if r & LOCAL != 0 { first_merge + (r & !LOCAL) } else { r };
            self.merges.extend(round.merges.iter().map(|m| Merge { children: m.children.map(global), ..*m }));
            clusters.extend(round.clusters.iter().map(|c| Cluster { root: global(c.root), ..*c }));
            edges.extend(
                round.edges.iter().map(|e| Edge { clusters: e.clusters.map(|c| c + first_cluster), ..*e }),
            );
        }
        (clusters, edges)
    }

    /// Joins the trees of all components; none if the tree is too deep.
    fn join(&mut self, components: &Components, roots: &[Cluster]) -> Option<u32> {
        let mut of_component: Vec<&Cluster> = roots.iter().collect();
        of_component.sort_by_key(|c| c.component);
        let (list, joins) = top::order(components);
        // The joins are in preorder: those of a right side follow all those of the left.
        let mut stack = vec![Join::Open { low: 0, high: list.len(), join: 0, depth: 0 }];
        let mut done: Vec<u32> = Vec::new();
        while let Some(step) = stack.pop() {
            match step {
                Join::Open { low, high, join, depth } if high - low > 1 => {
                    let middle = low + joins[join] as usize;
                    stack.push(Join::Close);
                    stack.push(Join::Open {
                        low: middle,
                        high,
                        join: join + (middle - low),
                        depth: depth + 1,
                    });
                    stack.push(Join::Open { low, high: middle, join: join + 1, depth: depth + 1 });
                }
                Join::Open { low, depth, .. } => {
                    let root = of_component.get(*list.get(low)? as usize)?;
                    if depth + root.depth > DEPTH_LIMIT {
                        return None;
                    }
                    done.push(root.root);
                }
                Join::Close => {
                    let (right, left) = (done.pop()?, done.pop()?);
                    let faces = [left, right].map(|r| self.faces_of(r)).into_iter().sum();
                    done.push((self.faces + self.merges.len()) as u32);
                    self.merges.push(Merge::joining([left, right], faces));
                }
            }
        }
        done.pop()
    }

    fn faces_of(&self, reference: u32) -> u32 {
        let merge = (reference as usize).checked_sub(self.faces);
        merge.map_or(1, |m| self.merges[m].faces)
    }
}

enum Join {
    Open { low: usize, high: usize, join: usize, depth: u32 },
    Close,
}

/// Two boundary edges meet at a vertex of an open boundary.
const BOUNDARY: u8 = 2;

/// For each vertex, [`BOUNDARY`] if it lies on a boundary or a seam, else 0.
fn boundary_vertices(mesh: &Mesh) -> Vec<u8> {
    let mut on_boundary = vec![0; mesh.positions.len()];
    for (h, _) in mesh.graph.opposite.iter().enumerate().filter(|(_, o)| **o == NONE) {
        on_boundary[origin(&mesh.faces, h as u32) as usize] = BOUNDARY;
    }
    on_boundary
}

/// How many paths meet at each vertex.
fn degrees(edges: &[Edge], boundary: &[u8]) -> Vec<u8> {
    let mut degree = boundary.to_vec();
    for v in edges.iter().flat_map(|e| e.ends).filter(|v| *v != NONE) {
        degree[v as usize] = degree[v as usize].saturating_add(1);
    }
    degree
}
