//! Cells: runs of neighbouring faces or clusters that are merged by themselves, in parallel.

use super::Rule;
use super::cluster::Cluster;
use super::graph::{Edge, Graph, Merged};
use super::numbering::Numbering;
use crate::colors::Coloring;
use crate::mesh::{Mesh, NONE};
use fcgeom::FaceMoments;
use glam::DVec3;
use rayon::prelude::*;

/// The indices of `points` along a curve that keeps neighbours together; equal places in index order.
pub(super) fn along_curve(points: impl IndexedParallelIterator<Item = DVec3> + Clone) -> Vec<u32> {
    let empty = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    // Minimum and maximum do not depend on the order of the reduction.
    let (low, high) = points
        .clone()
        .fold(|| empty, |(low, high), p| (low.min(p), high.max(p)))
        .reduce(|| empty, |a, b| (a.0.min(b.0), a.1.max(b.1)));
    let size = (high - low).max_element();
    let scale = if size > 0.0 { 1023.0 / size } else { 0.0 };
    let mut keyed: Vec<u64> = points
        .enumerate()
        .map(|(i, p)| {
            let q = (p - low) * scale;
            let key = spread(q.x as u32) | spread(q.y as u32) << 1 | spread(q.z as u32) << 2;
            u64::from(key) << 32 | i as u64
        })
        .collect();
    keyed.par_sort_unstable();
    keyed.into_par_iter().map(|k| k as u32).collect()
}

/// Ten bits, two zeros between each.
fn spread(x: u32) -> u32 {
    let x = (x | x << 16) & 0x0300_00ff;
    let x = (x | x << 8) & 0x0300_f00f;
    let x = (x | x << 4) & 0x030c_30c3;
    (x | x << 2) & 0x0924_9249
}

/// The faces of a mesh along the curve.
pub(super) struct Faces<'a, F> {
    pub(super) mesh: &'a Mesh,
    pub(super) order: &'a [u32],
    /// Where each face stands in `order`.
    pub(super) place: &'a [u32],
    /// The component of each face; empty if there is one.
    pub(super) component: &'a [u32],
    /// The colours of each face.
    pub(super) colors: F,
    /// How many edges meet at each vertex.
    pub(super) degree: &'a [u8],
}

/// Merges the faces of one cell; edges that leave the cell are left to the next round.
pub(super) fn merge_faces<C: Coloring>(
    rule: Rule,
    faces: &Faces<'_, impl Fn(u32) -> C>,
    first_place: usize,
    len: usize,
    stop: usize,
) -> Merged<C> {
    let mesh = faces.mesh;
    let cell = &faces.order[first_place..first_place + len];
    let mut numbering = Numbering::with_capacity(3 * cell.len());
    let mut clusters = Vec::with_capacity(cell.len());
    let mut edges = Vec::with_capacity(cell.len() * 3 / 2);
    for (i, &face) in cell.iter().enumerate() {
        let vertices = mesh.faces[face as usize];
        let points = vertices.map(|v| mesh.positions[v as usize]);
        let mut perimeter = 0.0;
        for e in 0..3 {
            let length = points[e].distance(points[(e + 1) % 3]);
            perimeter += length;
            let across = mesh.graph.opposite[face as usize * 3 + e];
            if across == NONE {
                continue;
            }
            // Each edge once, by the later of its two faces.
            let other = (faces.place[across as usize / 3] as usize).wrapping_sub(first_place);
            if other < i {
                let ends = [vertices[e], vertices[(e + 1) % 3]].map(|v| numbering.number(v));
                edges.push(Edge { clusters: [other as u32, i as u32], ends, length });
            }
        }
        let [a, b, c] = points;
        let own = faces.component.get(face as usize).copied().unwrap_or(0);
        clusters.push(Cluster::of_face(
            face,
            &FaceMoments::of_triangle(a, b, c),
            (faces.colors)(face),
            perimeter,
            own,
        ));
    }
    merge(rule, clusters, edges, numbering, faces.degree, stop)
}

/// Merges some clusters along the edges between them.
pub(super) fn merge_clusters<C: Coloring>(
    rule: Rule,
    clusters: Vec<Cluster<C>>,
    mut edges: Vec<Edge>,
    degree: &[u8],
    stop: usize,
) -> Merged<C> {
    let mut numbering = Numbering::with_capacity(2 * edges.len());
    for edge in &mut edges {
        edge.ends = edge.ends.map(|v| if v == NONE { NONE } else { numbering.number(v) });
    }
    merge(rule, clusters, edges, numbering, degree, stop)
}

/// Ends are numbers of `numbering` on the way in and vertices on the way out.
fn merge<C: Coloring>(
    rule: Rule,
    clusters: Vec<Cluster<C>>,
    edges: Vec<Edge>,
    numbering: Numbering,
    degree: &[u8],
    stop: usize,
) -> Merged<C> {
    let mut own_degree: Vec<u8> = numbering.vertices.iter().map(|&v| degree[v as usize]).collect();
    let mut merged = Graph::new(rule, clusters, edges, &mut own_degree).run(stop);
    for edge in &mut merged.edges {
        edge.ends = edge.ends.map(|v| if v == NONE { NONE } else { numbering.vertices[v as usize] });
    }
    merged
}
