//! Neighbouring clusters, merged cheapest first.

use super::Rule;
use super::cluster::Cluster;
use super::queue::Queue;
use crate::colors::Coloring;
use crate::mesh::NONE;
use glam::Vec3;

/// Set on the number of a merge that counts from the first of the same graph.
pub(super) const LOCAL: u32 = 1 << 31;

/// Two trees that became one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Merge {
    /// Faces of the mesh, or merges; see [`LOCAL`].
    pub(super) children: [u32; 2],
    pub(super) faces: u32,
    pub(super) epsilon: f32,
    /// Budget key, a length.
    pub(super) key: f32,
    pub(super) normal: Vec3,
    /// `normal . x` for points x of the plane.
    pub(super) offset: f32,
}

impl Merge {
    /// Above the roots of components, which have no surface in common: never drawn.
    pub(super) fn joining(children: [u32; 2], faces: u32) -> Merge {
        Merge { children, faces, epsilon: 0.0, key: f32::INFINITY, normal: Vec3::ZERO, offset: 0.0 }
    }
}

/// Two clusters that share part of their boundary.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    pub(super) clusters: [u32; 2],
    /// Vertices where the shared path ends; [`NONE`] for a closed one. Of several paths only one is known.
    pub(super) ends: [u32; 2],
    pub(super) length: f32,
}

impl Edge {
    /// Adds another piece of the boundary between the same two clusters: ends that meet are no ends any more.
    pub(super) fn absorb(&mut self, piece: &Edge) {
        self.length += piece.length;
        let [a, b] = self.ends;
        let [c, d] = piece.ends;
        let mut left = [(a, [c, d]), (b, [c, d]), (c, [a, b]), (d, [a, b])]
            .into_iter()
            .filter(|(v, others)| *v != NONE && !others.contains(v))
            .map(|(v, _)| v);
        self.ends = [left.next(), left.next()].map(|v| v.unwrap_or(NONE));
    }
}

/// What is left when a graph has been merged as far as wanted.
#[derive(Debug)]
pub(super) struct Merged<C> {
    pub(super) merges: Vec<Merge>,
    pub(super) clusters: Vec<Cluster<C>>,
    /// Between clusters of the list above; ends are as they came.
    pub(super) edges: Vec<Edge>,
    /// For each cluster at the start, where in the list above it is now.
    pub(super) now: Vec<u32>,
}

/// Clusters and the edges between them.
pub(super) struct Graph<'a, C> {
    rule: Rule,
    clusters: Vec<Cluster<C>>,
    edges: Vec<Edge>,
    /// How many cut paths meet at each vertex that an edge may end at.
    degree: &'a mut [u8],
    /// Heads of the lists of edges of each cluster: link `2 e + side`.
    head: Vec<u32>,
    next: Vec<u32>,
    /// While two clusters merge: the edge that leads from the first to each neighbour.
    edge_to: Vec<u32>,
    /// The cluster that each dead one went into.
    into: Vec<u32>,
    /// Edges whose cost was counted before one of their clusters grew. Nearly always it is more by now, so they are not
    /// counted again before they are first in the queue.
    stale: Vec<bool>,
    merges: Vec<Merge>,
}

impl<'a, C: Coloring> Graph<'a, C> {
    pub(super) fn new(rule: Rule, clusters: Vec<Cluster<C>>, edges: Vec<Edge>, degree: &'a mut [u8]) -> Self {
        let mut graph = Graph {
            rule,
            head: vec![NONE; clusters.len()],
            next: vec![NONE; 2 * edges.len()],
            edge_to: vec![NONE; clusters.len()],
            into: (0..clusters.len() as u32).collect(),
            stale: vec![false; edges.len()],
            merges: Vec::new(),
            clusters,
            edges,
            degree,
        };
        for (e, edge) in graph.edges.iter().enumerate() {
            for (side, c) in edge.clusters.iter().enumerate() {
                let link = (2 * e + side) as u32;
                graph.next[link as usize] = std::mem::replace(&mut graph.head[*c as usize], link);
            }
        }
        graph
    }

    /// Merges until `stop` clusters are left, or none has a neighbour.
    pub(super) fn run(mut self, stop: usize) -> Merged<C> {
        let mut queue = Queue::new(self.edges.iter().map(|e| self.cost(e)));
        let mut left = self.clusters.len();
        while left > stop
            && let Some((e, cost)) = queue.first()
        {
            let edge = self.edges[e as usize];
            if edge.clusters[0] == NONE {
                queue.take();
            } else if std::mem::take(&mut self.stale[e as usize]) {
                queue.put_back(self.cost(&edge));
            } else {
                queue.take();
                self.merge(e, cost);
                left -= 1;
            }
        }
        self.finish()
    }

    fn cost(&self, edge: &Edge) -> f64 {
        let [a, b] = edge.clusters.map(|c| &self.clusters[c as usize]);
        let union = a.union(b, edge.length);
        self.rule.cost(a, b, &union, self.triangles_removed(edge))
    }

    /// How many triangles fewer are drawn once the edge is gone: each corner that a polygon loses is one, and a
    /// polygon less gives two back.
    fn triangles_removed(&self, edge: &Edge) -> u32 {
        if edge.ends[0] == NONE {
            // A cluster inside another: three corners on either side.
            return 4;
        }
        let lost = |v: u32| match v {
            NONE => 1,
            v if self.degree[v as usize] <= 3 => 3,
            _ => 1,
        };
        (edge.ends.map(lost).iter().sum::<u32>()).saturating_sub(2)
    }

    fn merge(&mut self, e: u32, cost: f64) {
        let edge = self.edges[e as usize];
        let [a, b] = edge.clusters;
        let parts = [self.clusters[a as usize], self.clusters[b as usize]];
        let mut union = parts[0].union(&parts[1], edge.length);
        union.root = LOCAL | self.merges.len() as u32;
        let (epsilon, normal) = union.plane();
        self.merges.push(Merge {
            children: parts.map(|p| p.root),
            faces: union.faces,
            epsilon: epsilon as f32,
            key: self.rule.key(cost, &union),
            normal: normal.as_vec3(),
            offset: normal.dot(union.centroid) as f32,
        });
        self.clusters[a as usize] = union;
        self.into[b as usize] = a;
        for v in edge.ends.into_iter().filter(|v| *v != NONE) {
            let degree = &mut self.degree[v as usize];
            *degree = degree.saturating_sub(1);
        }
        self.edges[e as usize].clusters = [NONE; 2];

        let kept = self.join_edges([a, b]);
        self.head[a as usize] = kept;
        let mut link = kept;
        while link != NONE {
            let (f, side) = (link as usize / 2, link as usize % 2);
            self.edge_to[self.edges[f].clusters[1 - side] as usize] = NONE;
            self.stale[f] = true;
            link = self.next[link as usize];
        }
    }

    /// Relinks the edges of two clusters to the first. Of several that lead to the same neighbour one is left, and none
    /// of those between the two.
    fn join_edges(&mut self, [a, b]: [u32; 2]) -> u32 {
        let mut kept = NONE;
        for cluster in [a, b] {
            let mut link = self.head[cluster as usize];
            while link != NONE {
                let following = self.next[link as usize];
                let (f, side) = (link as usize / 2, link as usize % 2);
                let other = self.edges[f].clusters[1 - side];
                if other == a || other == b {
                    self.edges[f].clusters = [NONE; 2];
                } else if other != NONE {
                    let same = self.edge_to[other as usize];
                    if same == NONE {
                        self.edges[f].clusters[side] = a;
                        self.edge_to[other as usize] = f as u32;
                        self.next[link as usize] = std::mem::replace(&mut kept, link);
                    } else {
                        let piece = self.edges[f];
                        self.edges[same as usize].absorb(&piece);
                        self.edges[f].clusters = [NONE; 2];
                    }
                }
                link = following;
            }
        }
        kept
    }

    fn finish(mut self) -> Merged<C> {
        let mut place = vec![NONE; self.clusters.len()];
        let mut clusters = Vec::new();
        for (c, cluster) in self.clusters.iter().enumerate() {
            if self.into[c] == c as u32 {
                place[c] = clusters.len() as u32;
                clusters.push(*cluster);
            }
        }
        let now = (0..self.clusters.len() as u32)
            .map(|c| {
                let mut at = c;
                while self.into[at as usize] != at {
                    at = self.into[at as usize];
                }
                // Halves the way for those that come after.
                self.into[c as usize] = at;
                place[at as usize]
            })
            .collect();
        let alive = self.edges.iter().filter(|e| e.clusters[0] != NONE);
        let edges = alive.map(|e| Edge { clusters: e.clusters.map(|c| place[c as usize]), ..*e }).collect();
        Merged { merges: self.merges, clusters, edges, now }
    }
}
