//! From a node of the cut to triangles.
//!
//! The node's boundary loops are thinned to their active vertices and what remains is triangulated in the cluster's
//! plane, or in space where the cluster folds over. Whatever the triangulation, its border is exactly those loops:
//! that is what makes the mesh closed. So a loop of fewer than three vertices may be left out (its two edges cancel),
//! holes are bridged to the outline by an edge used in both directions, and triangles that come to nothing are
//! dropped.

mod best;
mod bridge;
mod diagonals;
mod grid;
mod least_turned;
mod page_polygon;
#[cfg(test)]
mod polygons;
mod top_polygon;
mod triangulate;

pub(crate) use page_polygon::PagePolygon;

use crate::criterion::Boundary;
use crate::eager::{Kept, Table};
use crate::{Error, Selection};
use best::{BEST_UP_TO, Best};
use bridge::Bridge;
use diagonals::{DIAGONALS_UP_TO, Diagonals};
use fct::{Loops, Node, Reader, Subtree, VertexRecord};
use glam::{DVec2, DVec3};
use triangulate::{Triangulator, push};

/// Draws nodes; keeps its memory from one to the next.
#[derive(Debug, Default)]
pub(crate) struct Stitcher {
    loops: Loops,
    outline: Outline,
    /// Of the outline's vertices over the plane that fits the cluster best.
    heights: Vec<f64>,
    bridge: Bridge,
    triangulator: Triangulator,
    best: Best,
    /// The outline's vertices in space.
    corners: Vec<DVec3>,
    diagonals: Diagonals,
}

/// A polygon as vertex indices and their places in the cluster's plane.
#[derive(Debug, Default)]
pub(crate) struct Outline {
    vertices: Vec<u32>,
    points: Vec<DVec2>,
    /// Where each loop ends; after bridging there is one.
    loop_ends: Vec<usize>,
}

impl Outline {
    /// Makes it one of these loops; places are still to be found.
    fn set(&mut self, vertices: &[u32], loop_ends: &[usize]) {
        self.vertices.clear();
        self.vertices.extend_from_slice(vertices);
        self.loop_ends.clear();
        self.loop_ends.extend_from_slice(loop_ends);
    }
}

impl Stitcher {
    /// Appends the triangles of a node of the cut; returns how many of them fold over.
    pub(crate) fn draw(
        &mut self,
        reader: &Reader<'_>,
        selection: &Selection,
        subtree: &Subtree,
        node: &Node,
        out: &mut Vec<u32>,
    ) -> Result<u64, Error> {
        reader.read_loops(subtree, &mut self.loops)?;
        self.stitch(reader, &Boundary::of(selection, reader, node), subtree, node, out)
    }

    /// The same for a node above the pages, by what is known of it if anything is.
    pub(crate) fn draw_top(
        &mut self,
        reader: &Reader<'_>,
        selection: &Selection,
        eager: Option<&Table>,
        (subtree, node): (&Subtree, &Node),
        out: &mut Vec<u32>,
    ) -> Result<u64, Error> {
        let Some(eager) = eager else { return self.draw(reader, selection, subtree, node, out) };
        let boundary = Boundary::of(selection, reader, node);
        let mut kept = Kept::default();
        if eager.keep_of(reader, subtree, &boundary, &mut kept).is_some() {
            return self.draw_kept(reader, &kept, (subtree, node), out);
        }
        reader.read_loops(subtree, &mut self.loops)?;
        eager.fill(reader, (subtree, node), &self.loops)?;
        self.stitch(reader, &boundary, subtree, node, out)
    }

    /// Appends the triangles of a node of whose boundary it is known what is drawn.
    pub(crate) fn draw_kept(
        &mut self,
        reader: &Reader<'_>,
        kept: &Kept,
        (subtree, node): (&Subtree, &Node),
        out: &mut Vec<u32>,
    ) -> Result<u64, Error> {
        let (vertices, ends) = (kept.vertices(), kept.ends());
        let is_simple = (4..=BEST_UP_TO).contains(&vertices.len()) && ends.len() == 1 && node.cos() > 0.0;
        if is_simple && self.draw_best(reader.vertices(), kept, node, out) {
            return Ok(0);
        }
        self.outline.set(vertices, ends);
        self.show(reader, subtree, node, out)
    }

    /// Appends the best triangulation of a polygon of few corners; false, and nothing, if none is valid.
    fn draw_best(&mut self, records: &[VertexRecord], kept: &Kept, node: &Node, out: &mut Vec<u32>) -> bool {
        let vertices = kept.vertices();
        top_polygon::lay(records, vertices, (node, kept.first_corner), &mut self.best);
        self.best.show(vertices.len(), |triangle| push(out, triangle.map(|corner| vertices[corner])))
    }

    /// The same for a node of whose boundary these loops are drawn.
    pub(crate) fn draw_loops(
        &mut self,
        reader: &Reader<'_>,
        loops: &Loops,
        (subtree, node): (&Subtree, &Node),
        out: &mut Vec<u32>,
    ) -> Result<u64, Error> {
        self.outline.set(&loops.vertices, &loops.ends);
        self.show(reader, subtree, node, out)
    }

    /// Appends the triangles of a node whose loops were read.
    fn stitch(
        &mut self,
        reader: &Reader<'_>,
        boundary: &Boundary<'_>,
        subtree: &Subtree,
        node: &Node,
        out: &mut Vec<u32>,
    ) -> Result<u64, Error> {
        let outline = &mut self.outline;
        outline.vertices.clear();
        outline.loop_ends.clear();
        for ring in self.loops.iter() {
            let start = outline.vertices.len();
            outline.vertices.extend(ring.iter().copied().filter(|vertex| boundary.draws(*vertex)));
            if outline.vertices.len() < start + 3 {
                outline.vertices.truncate(start);
            } else {
                outline.loop_ends.push(outline.vertices.len());
            }
        }
        self.show(reader, subtree, node, out)
    }

    /// Appends the triangles of the outline.
    fn show(
        &mut self,
        reader: &Reader<'_>,
        subtree: &Subtree,
        node: &Node,
        out: &mut Vec<u32>,
    ) -> Result<u64, Error> {
        let records = reader.vertices();
        let outline = &self.outline;
        if outline.vertices.is_empty() {
            return Ok(0);
        }
        let first = out.len();
        // All faces of a cluster that does not fold over face its cone's axis.
        let axis = DVec3::from_array(node.axis().map(f64::from));
        let facing = (node.cos() > 0.0).then_some(axis);
        if let [a, b, c] = outline.vertices[..] {
            out.extend([a, b, c]);
        } else {
            let first_corner = reader.first_corner(subtree)?;
            let (normal, height) = node.plane();
            let normal = DVec3::from_array(normal);
            let level = normal.dot(position(records, first_corner)) + height;
            self.fill(records, axis, facing, (normal, level), out);
        }
        Ok(facing.map_or(0, |axis| count_folded(records, axis, &out[first..])))
    }

    /// Triangulates a polygon of more than three vertices, or with holes.
    ///
    /// `facing` is a direction that all faces of the cluster face, if there is one; `plane` fits it best, as a normal and
    /// what its points have along that.
    fn fill(
        &mut self,
        records: &[VertexRecord],
        axis: DVec3,
        facing: Option<DVec3>,
        plane: (DVec3, f64),
        out: &mut Vec<u32>,
    ) {
        let outline = &mut self.outline;
        let position = |v: u32| position(records, v);
        // Where the cluster folds over, the polygon's own area decides.
        let normal = facing.unwrap_or_else(|| area_vector(outline, position).try_normalize().unwrap_or(axis));
        let (x, y) = fcgeom::tangent_frame(normal);
        let origin = position(outline.vertices[0]);
        outline.points.clear();
        outline.points.extend(outline.vertices.iter().map(|&v| {
            let p = position(v) - origin;
            DVec2::new(p.dot(x), p.dot(y))
        }));
        let leaves_plane = facing.is_none() && is_tube(outline, position);
        let scale = grid::snap(&mut outline.points);
        self.bridge.join_loops(outline, facing.is_some());
        let (normal, level) = plane;
        self.heights.clear();
        self.heights.extend(outline.vertices.iter().map(|&v| scale * (normal.dot(position(v)) - level)));
        if self.triangulator.find_best(&outline.vertices, &outline.points, &self.heights, out) {
            return;
        }
        if leaves_plane && outline.vertices.len() <= DIAGONALS_UP_TO {
            self.corners.clear();
            self.corners.extend(outline.vertices.iter().map(|&v| position(v)));
            self.diagonals.show(&self.corners, |t| push(out, t.map(|k| outline.vertices[k])));
        } else {
            let in_plane = facing.is_some();
            self.triangulator.find_any(&outline.vertices, &outline.points, &self.heights, in_plane, out);
        }
    }
}

fn position(records: &[VertexRecord], vertex: u32) -> DVec3 {
    records.get(vertex as usize).map_or(DVec3::ZERO, |r| DVec3::from_array(r.position().map(f64::from)))
}

/// Triangles that turn their back on the axis that all faces of the cluster face.
fn count_folded(records: &[VertexRecord], axis: DVec3, triangles: &[u32]) -> u64 {
    let folds = |t: &&[u32]| {
        let [a, b, c] = [0, 1, 2].map(|k| position(records, t[k]));
        (b - a).cross(c - a).dot(axis) < 0.0
    };
    triangles.chunks_exact(3).filter(folds).count() as u64
}

/// How far from the largest loop, of its own width, a loop lies that is the end of a tube.
const APART: f64 = 0.5;

/// Whether each loop but the largest lies off that along its own normal: then the cluster is a tube, and better closed at
/// its ends than bridged. A cluster with one loop counts as one.
fn is_tube(outline: &Outline, position: impl Fn(u32) -> DVec3) -> bool {
    let center_and_area = |ring: &[u32]| {
        let center = ring.iter().map(|&v| position(v)).sum::<DVec3>() / ring.len() as f64;
        let sides = ring.iter().zip(ring.iter().cycle().skip(1));
        let twice_area: DVec3 =
            sides.map(|(a, b)| (position(*a) - center).cross(position(*b) - center)).sum();
        (center, twice_area)
    };
    let starts = std::iter::once(&0).chain(&outline.loop_ends);
    let mut loops =
        starts.zip(&outline.loop_ends).map(|(start, end)| center_and_area(&outline.vertices[*start..*end]));
    let larger = |a: (DVec3, DVec3), b: (DVec3, DVec3)| if b.1.length() > a.1.length() { b } else { a };
    let Some((center, _)) = loops.clone().reduce(larger) else { return true };
    loops.all(|(at, twice_area)| {
        let off = (at - center).dot(twice_area.normalize_or_zero());
        at == center || off * off > APART * APART * 0.5 * twice_area.length()
    })
}

/// Twice the vector area of all loops together.
fn area_vector(outline: &Outline, position: impl Fn(u32) -> DVec3) -> DVec3 {
    let mut sum = DVec3::ZERO;
    let mut start = 0;
    for &end in &outline.loop_ends {
        let ring = &outline.vertices[start..end];
        let origin = position(ring[0]);
        for pair in ring.windows(2) {
            sum += (position(pair[0]) - origin).cross(position(pair[1]) - origin);
        }
        start = end;
    }
    sum
}
