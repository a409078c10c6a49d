//! Holes become part of the outline.

use super::{Outline, grid};
use glam::DVec2;
use std::ops::Range;

/// Joins loops; keeps its memory from one polygon to the next.
#[derive(Debug, Default)]
pub(super) struct Bridge {
    /// The outline with what has been joined to it, and its points.
    joined: Vec<u32>,
    at: Vec<DVec2>,
    /// The loops still to be joined, and of each the nearest pair with the outline.
    rings: Vec<Range<usize>>,
    nearest: Vec<Pair>,
    /// Edges that may still be looked at for bridges that cross none.
    left: usize,
}

/// So many edges are looked at for bridges that cross none; then loops are joined where they are nearest. Polygons of
/// hundreds of corners need a small part of that; one of a million, from a strange file, must not take for ever.
const EDGES: usize = 1 << 24;

/// A vertex of the outline and one of a loop.
#[derive(Clone, Copy, Debug)]
struct Pair {
    squared: f64,
    on_outline: usize,
    /// Counts from the start of the loop.
    on_ring: usize,
}

impl Bridge {
    /// Joins all loops into one by edges that are walked there and back.
    ///
    /// The loop of largest area is the outline; each other one is joined where it comes nearest to it, nearest loops
    /// first. In a plane, `in_plane`, the loops go around the polygon with its inside on the left, their places are on
    /// the grid, and no bridge crosses an edge if it can be helped: then what comes out has a triangulation.
    pub(super) fn join_loops(&mut self, outline: &mut Outline, in_plane: bool) {
        if outline.loop_ends.len() < 2 {
            return;
        }
        let Outline { vertices, points, loop_ends } = outline;
        self.rings.clear();
        let mut start = 0;
        for &end in loop_ends.iter() {
            self.rings.push(start..end);
            start = end;
        }
        let area = |ring: &Range<usize>| -> f64 {
            let ring = &points[ring.clone()];
            (0..ring.len()).map(|i| ring[i].perp_dot(ring[(i + 1) % ring.len()])).sum()
        };
        let rings = &mut self.rings;
        let outer =
            (1..rings.len()).fold(0, |best, i| if area(&rings[i]) > area(&rings[best]) { i } else { best });
        let outer = rings.swap_remove(outer);
        self.joined.clear();
        self.joined.extend_from_slice(&vertices[outer.clone()]);
        self.at.clear();
        self.at.extend_from_slice(&points[outer]);
        self.left = if in_plane { EDGES } else { 0 };
        // Nearest pair of each remaining ring; updated by what each join adds, so the whole costs a product, not a cube.
        self.nearest.clear();
        self.nearest.extend(self.rings.iter().map(|r| closest(&self.at, 0, &points[r.clone()])));
        while let Some((next, pair)) = self.choose(points) {
            self.join(next, pair, vertices, points);
        }
        loop_ends.clear();
        loop_ends.push(self.joined.len());
        // Copied and not swapped: buffers that change places would grow again and again.
        vertices.clone_from(&self.joined);
        points.clone_from(&self.at);
    }

    /// The loop to be joined next, and where.
    fn choose(&mut self, points: &[DVec2]) -> Option<(usize, Pair)> {
        let nearer =
            |a: usize, b: usize| if self.nearest[b].squared < self.nearest[a].squared { b } else { a };
        let next = (0..self.rings.len()).reduce(nearer)?;
        let pair = self.nearest[next];
        if self.left == 0 || self.sees(next, pair, points) {
            return Some((next, pair));
        }
        // Loops may hide one another; not all can be hidden.
        let others = (0..self.rings.len()).filter(|ring| *ring != next);
        for ring in std::iter::once(next).chain(others) {
            if let Some(pair) = self.nearest_in_sight(ring, points) {
                return Some((ring, pair));
            }
        }
        Some((next, pair))
    }

    /// The nearest pair of the outline and a loop that sees one another.
    fn nearest_in_sight(&mut self, ring: usize, points: &[DVec2]) -> Option<Pair> {
        let mut found: Option<Pair> = None;
        for on_outline in 0..self.at.len() {
            for (on_ring, q) in self.rings[ring].clone().map(|i| points[i]).enumerate() {
                let squared = self.at[on_outline].distance_squared(q);
                let pair = Pair { squared, on_outline, on_ring };
                if self.left > 0
                    && found.is_none_or(|found| squared < found.squared)
                    && self.sees(ring, pair, points)
                {
                    found = Some(pair);
                }
            }
        }
        found
    }

    /// Whether the way between two vertices starts and ends inside and crosses no edge of the outline or of a loop that
    /// is still to be joined.
    fn sees(&mut self, ring: usize, pair: Pair, points: &[DVec2]) -> bool {
        let own = &points[self.rings[ring].clone()];
        let at = |ring: &[DVec2], i: usize, step: usize| ring[(i + step) % ring.len()];
        let around = |ring: &[DVec2], i: usize| [at(ring, i, ring.len() - 1), ring[i], at(ring, i, 1)];
        let (outside, inside) = (around(&self.at, pair.on_outline), around(own, pair.on_ring));
        let (p, q) = (outside[1], inside[1]);
        // Of a loop that touches the outline here, both sides have to lie inside.
        if p == q {
            return opens(outside, inside[0]) && opens(outside, inside[2]);
        }
        if !opens(outside, q) || !opens(inside, p) {
            return false;
        }
        let rings = self.rings.iter().map(|ring| &points[ring.clone()]);
        for ring in std::iter::once(&self.at[..]).chain(rings) {
            self.left = self.left.saturating_sub(ring.len());
            let edges = ring.iter().zip(ring.iter().cycle().skip(1));
            if edges.into_iter().any(|(a, b)| blocks((*a, *b), p, q)) {
                return false;
            }
        }
        true
    }

    /// Joins a loop to the outline.
    fn join(&mut self, next: usize, pair: Pair, vertices: &[u32], points: &[DVec2]) {
        let Bridge { joined, at, rings, nearest, .. } = self;
        let Pair { on_outline, on_ring, .. } = pair;
        let ring = rings.swap_remove(next);
        nearest.swap_remove(next);
        // outline ... a, [b ... around the ring ... b, a], ... rest of the outline
        let turned = (0..=ring.len()).map(|i| ring.start + (on_ring + i) % ring.len());
        let (a, a_place) = (joined[on_outline], at[on_outline]);
        let gap = on_outline + 1..on_outline + 1;
        joined.splice(gap.clone(), turned.clone().map(|i| vertices[i]).chain([a]));
        at.splice(gap, turned.map(|i| points[i]).chain([a_place]));
        let grown = ring.len() + 2;
        for (pair, other) in nearest.iter_mut().zip(rings.iter()) {
            if pair.on_outline > on_outline {
                pair.on_outline += grown;
            }
            let added = &at[on_outline + 1..on_outline + 1 + grown];
            let candidate = closest(added, on_outline + 1, &points[other.clone()]);
            if candidate.squared < pair.squared {
                *pair = candidate;
            }
        }
    }
}

/// The nearest pair; the first list counts from `first`.
fn closest(outline: &[DVec2], first: usize, ring: &[DVec2]) -> Pair {
    let mut best = Pair { squared: f64::INFINITY, on_outline: first, on_ring: 0 };
    for (i, p) in outline.iter().enumerate() {
        for (on_ring, q) in ring.iter().enumerate() {
            let squared = p.distance_squared(*q);
            if squared < best.squared {
                best = Pair { squared, on_outline: first + i, on_ring };
            }
        }
    }
    best
}

/// Whether the way from a corner to a place starts inside the polygon, which lies to the left of both edges.
pub(super) fn opens([before, corner, after]: [DVec2; 3], to: DVec2) -> bool {
    let (left_of_first, left_of_second) =
        (grid::area(before, corner, to) > 0.0, grid::area(corner, after, to) > 0.0);
    if grid::area(before, corner, after) > 0.0 {
        left_of_first && left_of_second
    } else {
        left_of_first || left_of_second
    }
}

/// Whether an edge, with the inside on its left, is in the way between two places. An end of the way on the edge is not if
/// the way comes from the left, nor is an end of both.
fn blocks((a, b): (DVec2, DVec2), p: DVec2, q: DVec2) -> bool {
    let (from_a, from_b) = (grid::area(p, q, a), grid::area(p, q, b));
    if from_a * from_b > 0.0 {
        return false;
    }
    let (from_p, from_q) = (grid::area(a, b, p), grid::area(a, b, q));
    if from_p * from_q > 0.0 {
        return false;
    }
    let between = |at: DVec2, p: DVec2, q: DVec2| at != p && at != q && (p - at).dot(q - at) < 0.0;
    // What is not on the way at all crosses it, or has an end of it between its own.
    (from_a != 0.0 && from_b != 0.0 && from_p != 0.0 && from_q != 0.0)
        || (from_a == 0.0 && between(a, p, q))
        || (from_b == 0.0 && between(b, p, q))
        || (from_p == 0.0 && between(p, a, b) && from_q < 0.0)
        || (from_q == 0.0 && between(q, a, b) && from_p < 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn holes_join_by_edges_walked_both_ways() {
        let square = [(0., 0.), (9., 0.), (9., 9.), (0., 9.)];
        let hole = [(1., 1.), (1., 2.), (2., 2.), (2., 1.)];
        let other = [(6., 6.), (6., 7.), (7., 7.), (7., 6.)];
        let points: Vec<DVec2> =
            hole.iter().chain(&square).chain(&other).map(|&(x, y)| DVec2::new(x, y)).collect();
        let mut outline = Outline { vertices: (0..12).collect(), points, loop_ends: vec![4, 8, 12] };
        Bridge::default().join_loops(&mut outline, true);
        assert_eq!(outline.loop_ends, [16]);
        assert_eq!(outline.vertices.len(), outline.points.len());
        let n = outline.vertices.len();
        let mut net = std::collections::BTreeMap::new();
        for i in 0..n {
            let (a, b) = (outline.vertices[i], outline.vertices[(i + 1) % n]);
            *net.entry((a.min(b), a.max(b))).or_insert(0) += if a < b { 1 } else { -1 };
        }
        // What is left over is the three rings, each edge once.
        assert_eq!(net.values().filter(|v| **v != 0).count(), 12);
    }
}
