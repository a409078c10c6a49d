//! Holes become part of the outline.

use super::Outline;
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
    nearest: Vec<(f64, usize, usize)>,
}

impl Bridge {
    /// Joins all loops into one by edges that are walked there and back.
    ///
    /// The loop of largest area is the outline; each other one is joined where it comes nearest to it, nearest loops
    /// first.
    pub(super) fn join_loops(&mut self, outline: &mut Outline) {
        if outline.loop_ends.len() < 2 {
            return;
        }
        let Outline { vertices, points, loop_ends } = outline;
        let Bridge { joined, at, rings, nearest } = self;
        rings.clear();
        let mut start = 0;
        for &end in loop_ends.iter() {
            rings.push(start..end);
            start = end;
        }
        let area = |ring: &Range<usize>| -> f64 {
            let ring = &points[ring.clone()];
            (0..ring.len()).map(|i| ring[i].perp_dot(ring[(i + 1) % ring.len()])).sum()
        };
        let outer =
            (1..rings.len()).fold(0, |best, i| if area(&rings[i]) > area(&rings[best]) { i } else { best });
        let outer = rings.swap_remove(outer);
        joined.clear();
        joined.extend_from_slice(&vertices[outer.clone()]);
        at.clear();
        at.extend_from_slice(&points[outer]);
        // Nearest pair of each remaining ring; updated by what each join adds, so the whole costs a product, not a cube.
        nearest.clear();
        nearest.extend(rings.iter().map(|r| closest(at, 0, &points[r.clone()])));
        while let Some(next) = (0..rings.len()).reduce(|a, b| if nearest[b].0 < nearest[a].0 { b } else { a })
        {
            let ring = rings.swap_remove(next);
            let (_, on_outline, on_ring) = nearest.swap_remove(next);
            // outline ... a, [b ... around the ring ... b, a], ... rest of the outline
            let turned = (0..=ring.len()).map(|i| ring.start + (on_ring + i) % ring.len());
            let (a, a_place) = (joined[on_outline], at[on_outline]);
            let gap = on_outline + 1..on_outline + 1;
            joined.splice(gap.clone(), turned.clone().map(|i| vertices[i]).chain([a]));
            at.splice(gap, turned.map(|i| points[i]).chain([a_place]));
            let grown = ring.len() + 2;
            for (pair, other) in nearest.iter_mut().zip(rings.iter()) {
                if pair.1 > on_outline {
                    pair.1 += grown;
                }
                let added = &at[on_outline + 1..on_outline + 1 + grown];
                let candidate = closest(added, on_outline + 1, &points[other.clone()]);
                if candidate.0 < pair.0 {
                    *pair = candidate;
                }
            }
        }
        loop_ends.clear();
        loop_ends.push(joined.len());
        // Copied and not swapped: buffers that change places would grow again and again.
        vertices.clone_from(joined);
        points.clone_from(at);
    }
}

/// Squared distance and indices of the nearest pair; the first list counts from `first`.
fn closest(outline: &[DVec2], first: usize, ring: &[DVec2]) -> (f64, usize, usize) {
    let mut best = (f64::INFINITY, first, 0);
    for (i, p) in outline.iter().enumerate() {
        for (j, q) in ring.iter().enumerate() {
            let d = p.distance_squared(*q);
            if d < best.0 {
                best = (d, first + i, j);
            }
        }
    }
    best
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
        Bridge::default().join_loops(&mut outline);
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
