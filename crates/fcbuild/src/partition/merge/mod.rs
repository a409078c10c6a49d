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
use crate::colors::{Coloring, Weights};
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

/// Cells that each thread merges before their results are put away: more wait less for one another, and take memory.
const CELLS_AT_ONCE: usize = 8;

/// So many clusters are merged in one queue.
const LAST_ROUND: usize = 16_384;

/// The tree of `mesh`; none if it would be too deep.
///
/// Garland's rule does not look at `colors`.
pub(super) fn merge_all(
    mesh: &Mesh,
    components: &Components,
    rule: Rule,
    colors: Option<Weights>,
    progress: &(dyn Fn(u64) + Sync),
) -> Option<Hierarchy> {
    match colors.zip(mesh.colors.as_deref()) {
        Some((weights, colors)) if rule == Rule::Quality => {
            let colors = weights.for_budgets(colors);
            let of_face = |f: u32| colors.of_face(&mesh.positions, mesh.faces[f as usize]).colors;
            merge(mesh, components, rule, of_face, progress)
        }
        _ => merge(mesh, components, rule, |_| (), progress),
    }
}

fn merge<C: Coloring>(
    mesh: &Mesh,
    components: &Components,
    rule: Rule,
    colors: impl Fn(u32) -> C + Sync,
    progress: &(dyn Fn(u64) + Sync),
) -> Option<Hierarchy> {
    let faces = mesh.faces.len();
    let mut forest = Forest { rule, faces, merges: Vec::with_capacity(faces - 1) };
    let boundary = boundary_vertices(mesh);
    let (mut clusters, mut edges) = forest.merge_faces(mesh, components, &boundary, colors, progress);
    while clusters.len() > LAST_ROUND && !edges.is_empty() {
        let before = clusters.len();
        (clusters, edges) = forest.merge_round(clusters, edges, &boundary);
        if clusters.len() * 8 > before * 7 {
            break;
        }
    }
    let degree = degrees(&edges, &boundary);
    let last = cells::merge_clusters(rule, clusters, edges, &degree, 1);
    let mut round = Round::new();
    forest.add(&last, &mut round);
    drop(last);
    let (root, depth) = forest.join(components, &round.clusters)?;
    let (splits, order) = forest::lay_out(&forest.merges, root, faces);
    let mode = if rule == Rule::Quality { SplitMode::Quality } else { SplitMode::Merge };
    Some(Hierarchy { splits, order, mode, depth })
}

/// All merges so far.
struct Forest {
    rule: Rule,
    faces: usize,
    merges: Vec<Merge>,
}

impl Forest {
    /// The first round: cells of faces.
    fn merge_faces<C: Coloring>(
        &mut self,
        mesh: &Mesh,
        components: &Components,
        boundary: &[u8],
        colors: impl Fn(u32) -> C + Sync,
        progress: &(dyn Fn(u64) + Sync),
    ) -> (Vec<Cluster<C>>, Vec<Edge>) {
        let centroid =
            |f: &[u32; 3]| f.map(|v| mesh.positions[v as usize].as_dvec3()).into_iter().sum::<DVec3>();
        let (order, degree) = rayon::join(
            || cells::along_curve(mesh.faces.par_iter().map(centroid)),
            || {
                // A fan of n faces has n edges, and one more if it is open.
                let mut degree: Vec<u8> = boundary.iter().map(|b| b / BOUNDARY).collect();
                for &v in mesh.faces.as_flattened() {
                    degree[v as usize] = degree[v as usize].saturating_add(1);
                }
                degree
            },
        );
        let mut place = vec![0_u32; self.faces];
        for (i, &f) in order.iter().enumerate() {
            place[f as usize] = i as u32;
        }
        let component = if components.len() == 1 { Vec::new() } else { components.of_faces() };
        let along =
            Faces { mesh, order: &order, place: &place, component: &component, colors, degree: &degree };
        let cells: Vec<usize> = (0..order.len()).step_by(CELL).collect();
        let rule = self.rule;
        let round = self.cells(cells, |first| {
            let len = CELL.min(order.len() - first);
            let merged = cells::merge_faces(rule, &along, first, len, len / SHRINK);
            progress(len as u64);
            merged
        });
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
        collect(round, crossing)
    }

    /// A later round: cells of clusters.
    fn merge_round<C: Coloring>(
        &mut self,
        clusters: Vec<Cluster<C>>,
        edges: Vec<Edge>,
        boundary: &[u8],
    ) -> (Vec<Cluster<C>>, Vec<Edge>) {
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
        let cells: Vec<_> = order.chunks(CELL).zip(inside).collect();
        let rule = self.rule;
        let round = self.cells(cells, |(cell, edges)| {
            let own = cell.iter().map(|&c| clusters[c as usize]).collect();
            cells::merge_clusters(rule, own, edges, &degree, cell.len() / SHRINK)
        });
        collect(round, crossing)
    }

    /// Merges inside cells, some of them at once, and appends their merges.
    fn cells<T: Send, C: Coloring>(
        &mut self,
        cells: Vec<T>,
        merge: impl Fn(T) -> Merged<C> + Sync,
    ) -> Round<C> {
        let mut round = Round::new();
        let mut rest = cells.into_iter();
        let mut done: Vec<Merged<C>> = Vec::new();
        loop {
            let some: Vec<T> = rest.by_ref().take(CELLS_AT_ONCE * rayon::current_num_threads()).collect();
            let is_last = some.is_empty();
            // What is done is put away while the next ones are merged.
            let (merged, ()) = rayon::join(
                || some.into_par_iter().map(&merge).collect(),
                || done.iter().for_each(|cell| self.add(cell, &mut round)),
            );
            if is_last {
                return round;
            }
            done = merged;
        }
    }

    /// Appends the merges of a cell; its clusters and edges go to the round's, numbered across cells.
    fn add<C: Coloring>(&mut self, cell: &Merged<C>, round: &mut Round<C>) {
        let first_merge = (self.faces + self.merges.len()) as u32;
        let first_cluster = round.clusters.len() as u32;
        let global = |r: u32| if r & LOCAL != 0 { first_merge + (r & !LOCAL) } else { r };
        self.merges.extend(cell.merges.iter().map(|m| Merge { children: m.children.map(global), ..*m }));
        round.clusters.extend(cell.clusters.iter().map(|c| Cluster { root: global(c.root), ..*c }));
        let clusters = |e: &Edge| e.clusters.map(|c| c + first_cluster);
        round.edges.extend(cell.edges.iter().map(|e| Edge { clusters: clusters(e), ..*e }));
        round.now.extend(cell.now.iter().map(|c| c + first_cluster));
    }

    /// Joins the trees of all components: the root and the depth of the tree; none if it is too deep.
    fn join<C>(&mut self, components: &Components, roots: &[Cluster<C>]) -> Option<(u32, u32)> {
        let mut of_component: Vec<&Cluster<C>> = roots.iter().collect();
        of_component.sort_by_key(|c| c.component);
        let (list, joins) = top::order(components);
        // The joins are in preorder: those of a right side follow all those of the left.
        let mut stack = vec![Join::Open { low: 0, high: list.len(), join: 0, depth: 0 }];
        let mut done: Vec<u32> = Vec::new();
        let mut deepest = 0;
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
                    deepest = deepest.max(depth + root.depth);
                    if deepest > DEPTH_LIMIT {
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
        Some((done.pop()?, deepest))
    }

    fn faces_of(&self, reference: u32) -> u32 {
        let merge = (reference as usize).checked_sub(self.faces);
        merge.map_or(1, |m| self.merges[m].faces)
    }
}

/// What is left of the cells of a round.
struct Round<C> {
    clusters: Vec<Cluster<C>>,
    /// Within cells.
    edges: Vec<Edge>,
    /// For each place at the start, which cluster it went into.
    now: Vec<u32>,
}

impl<C> Round<C> {
    fn new() -> Round<C> {
        Round { clusters: Vec::new(), edges: Vec::new(), now: Vec::new() }
    }
}

/// Puts together a round and the edges between its cells, which are given by places.
fn collect<C>(round: Round<C>, crossing: Vec<(u32, u32, Edge)>) -> (Vec<Cluster<C>>, Vec<Edge>) {
    let Round { clusters, mut edges, now } = round;
    let mut crossing: Vec<Edge> = crossing
        .into_par_iter()
        .map(|(a, b, edge)| {
            let [a, b] = [a, b].map(|place| now[place as usize]);
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
    edges.extend(crossing);
    (clusters, edges)
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
