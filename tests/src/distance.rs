//! Distances between surfaces, by search.

use fct::Tree;
use glam::DVec3;

/// The position of a vertex.
pub fn position(tree: &Tree, vertex: u32) -> DVec3 {
    DVec3::from_array(tree.vertices()[vertex as usize].position().map(f64::from))
}

/// The point of a triangle that is nearest to another.
pub fn nearest_on_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> DVec3 {
    let n = (b - a).cross(c - a);
    let inside = |u: DVec3, v: DVec3| (v - u).cross(p - u).dot(n) >= 0.0;
    if n.length_squared() > 0.0 && inside(a, b) && inside(b, c) && inside(c, a) {
        return p - n * ((p - a).dot(n) / n.length_squared());
    }
    let on_segment = |u: DVec3, v: DVec3| {
        let e = v - u;
        let t = if e.length_squared() > 0.0 {
            ((p - u).dot(e) / e.length_squared()).clamp(0.0, 1.0)
        } else {
            0.0
        };
        u + e * t
    };
    let nearer = |u: DVec3, v: DVec3| if p.distance_squared(v) < p.distance_squared(u) { v } else { u };
    nearer(nearer(on_segment(a, b), on_segment(b, c)), on_segment(c, a))
}

/// Nearest-triangle queries over a mesh, by a tree of boxes.
#[derive(Debug)]
pub struct Surface {
    triangles: Vec<[DVec3; 3]>,
    /// Boxes of a complete binary tree over the triangles in their order along the widest sides.
    boxes: Vec<(DVec3, DVec3)>,
}

impl Surface {
    /// Over the triangles of an index list into the tree's vertices.
    pub fn of(tree: &Tree, indices: &[u32]) -> Surface {
        Surface::of_triangles(
            indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]].map(|v| position(tree, v))).collect(),
        )
    }

    /// Over triangles.
    pub fn of_triangles(triangles: Vec<[DVec3; 3]>) -> Surface {
        let mut surface =
            Surface { boxes: vec![(DVec3::ZERO, DVec3::ZERO); 2 * triangles.len().max(1)], triangles };
        let n = surface.triangles.len();
        if n > 0 {
            surface.sort(0, n, 0);
        }
        surface
    }

    /// Orders a range of triangles and fills the boxes of its subtree; the subtree of `n` leaves at `slot` takes
    /// `2 n - 1` slots in preorder.
    fn sort(&mut self, low: usize, high: usize, slot: usize) {
        let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for p in self.triangles[low..high].iter().flatten() {
            min = min.min(*p);
            max = max.max(*p);
        }
        self.boxes[slot] = (min, max);
        if high - low > 1 {
            let size = (max - min).to_array();
            let axis = (0..3).fold(0, |best, k| if size[k] > size[best] { k } else { best });
            let middle = (low + high) / 2;
            let key = |t: &[DVec3; 3]| (t[0] + t[1] + t[2]).to_array()[axis];
            self.triangles[low..high].select_nth_unstable_by(middle - low, |a, b| key(a).total_cmp(&key(b)));
            self.sort(low, middle, slot + 1);
            self.sort(middle, high, slot + 2 * (middle - low));
        }
    }

    /// The point of the surface that is nearest to another; infinitely far away if there is none.
    pub fn nearest(&self, p: DVec3) -> DVec3 {
        self.search(p, f64::INFINITY).unwrap_or(DVec3::INFINITY)
    }

    /// Distance of a point that is known to be nearer than `limit`, which comes back if it is not.
    pub fn distance_below(&self, p: DVec3, limit: f64) -> f64 {
        self.search(p, limit).map_or(limit, |nearest| p.distance(nearest))
    }

    /// The nearest point within a distance.
    fn search(&self, p: DVec3, within: f64) -> Option<DVec3> {
        let (mut best, mut nearest) = (within, None);
        let mut stack = vec![(0, self.triangles.len(), 0)];
        while let Some((low, high, slot)) = stack.pop() {
            if low >= high || self.to_box(p, slot) >= best {
                continue;
            }
            if high - low == 1 {
                let candidate = nearest_on_triangle(p, self.triangles[low]);
                if p.distance(candidate) < best {
                    (best, nearest) = (p.distance(candidate), Some(candidate));
                }
                continue;
            }
            let middle = (low + high) / 2;
            let (left, right) = ((low, middle, slot + 1), (middle, high, slot + 2 * (middle - low)));
            if self.to_box(p, left.2) < self.to_box(p, right.2) {
                stack.extend([right, left]);
            } else {
                stack.extend([left, right]);
            }
        }
        nearest
    }

    fn to_box(&self, p: DVec3, slot: usize) -> f64 {
        let (min, max) = self.boxes[slot];
        (p - p.clamp(min, max)).length()
    }
}
