//! A closed triangle surface that can be walked, flipped, split and collapsed without losing its topology.

use glam::DVec3;

/// Marks half-edges of removed faces and vertices that are gone.
const NONE: u32 = u32::MAX;

/// Half-edge `3 f + k` runs from corner k of face f to its next corner.
#[derive(Debug)]
pub(crate) struct Surface {
    /// Vertex positions.
    pub(crate) points: Vec<DVec3>,
    /// Where each half-edge starts.
    origin: Vec<u32>,
    /// The half-edge that runs the other way along the same edge.
    twin: Vec<u32>,
    /// For each vertex some half-edge that starts there.
    out: Vec<u32>,
}

/// The half-edge after `h` in its face.
pub(crate) fn next(h: u32) -> u32 {
    if h % 3 == 2 { h - 2 } else { h + 1 }
}

/// The half-edge before `h` in its face.
pub(crate) fn previous(h: u32) -> u32 {
    if h.is_multiple_of(3) { h + 2 } else { h - 1 }
}

/// Normal of a triangle, as long as twice its area.
pub(crate) fn area_normal(a: DVec3, b: DVec3, c: DVec3) -> DVec3 {
    (b - a).cross(c - a)
}

impl Surface {
    /// Pairs the half-edges of closed, oriented faces.
    ///
    /// # Errors
    /// The number of directed edges without an opposite.
    pub(crate) fn new(points: Vec<DVec3>, faces: &[[u32; 3]]) -> Result<Surface, usize> {
        let origin: Vec<u32> = faces.iter().flatten().copied().collect();
        // Half-edges grouped by where they start: start[v]..start[v + 1] in `leaving`.
        let mut start = vec![0_u32; points.len() + 1];
        for v in &origin {
            start[*v as usize + 1] += 1;
        }
        for v in 0..points.len() {
            start[v + 1] += start[v];
        }
        let mut fill = start.clone();
        let mut leaving = vec![0_u32; origin.len()];
        for (h, v) in origin.iter().enumerate() {
            leaving[fill[*v as usize] as usize] = h as u32;
            fill[*v as usize] += 1;
        }
        let mut twin = vec![NONE; origin.len()];
        let mut open = 0;
        for h in 0..origin.len() as u32 {
            let (a, b) = (origin[h as usize], origin[next(h) as usize]);
            let candidates = start[b as usize] as usize..start[b as usize + 1] as usize;
            let mut found = leaving[candidates].iter().filter(|g| origin[next(**g) as usize] == a);
            match (found.next(), found.next()) {
                (Some(g), None) => twin[h as usize] = *g,
                _ => open += 1,
            }
        }
        if open > 0 {
            return Err(open);
        }
        let mut out = vec![NONE; points.len()];
        for (h, v) in origin.iter().enumerate() {
            out[*v as usize] = h as u32;
        }
        Ok(Surface { points, origin, twin, out })
    }

    /// Number of half-edges, removed ones included.
    pub(crate) fn half_edges(&self) -> u32 {
        self.origin.len() as u32
    }

    /// True while the face of `h` exists.
    pub(crate) fn alive(&self, h: u32) -> bool {
        self.origin[h as usize] != NONE
    }

    /// Where `h` starts.
    pub(crate) fn from(&self, h: u32) -> u32 {
        self.origin[h as usize]
    }

    /// Where `h` ends.
    pub(crate) fn to(&self, h: u32) -> u32 {
        self.origin[next(h) as usize]
    }

    /// The opposite of `h`.
    pub(crate) fn twin(&self, h: u32) -> u32 {
        self.twin[h as usize]
    }

    /// Position of a vertex.
    pub(crate) fn point(&self, v: u32) -> DVec3 {
        self.points[v as usize]
    }

    /// The corners of face `f`.
    pub(crate) fn corners(&self, f: u32) -> [DVec3; 3] {
        [0, 1, 2].map(|k| self.point(self.origin[(3 * f + k) as usize]))
    }

    /// The half-edges that leave `v`, once around; none when the vertex is gone.
    pub(crate) fn around(&self, v: u32) -> impl Iterator<Item = u32> + '_ {
        let first = self.out[v as usize];
        let mut current = first;
        std::iter::from_fn(move || {
            if current == NONE {
                return None;
            }
            let h = current;
            let following = self.twin(previous(h));
            current = if following == first { NONE } else { following };
            Some(h)
        })
    }

    /// Number of edges at `v`.
    pub(crate) fn valence(&self, v: u32) -> usize {
        self.around(v).count()
    }

    /// True when the vertices share an edge.
    fn joined(&self, a: u32, b: u32) -> bool {
        self.around(a).any(|h| self.to(h) == b)
    }

    fn pair(&mut self, a: u32, b: u32) {
        self.twin[a as usize] = b;
        self.twin[b as usize] = a;
    }

    /// True when pulling the end of `h` into its start keeps the surface a manifold.
    pub(crate) fn can_collapse(&self, h: u32) -> bool {
        let (a, b) = (self.from(h), self.to(h));
        let (c, d) = (self.to(next(h)), self.to(next(self.twin(h))));
        let shared = self.around(a).filter(|g| self.joined(b, self.to(*g))).count();
        // Exactly the two apexes are neighbours of both; a third would be pinched into a fold.
        shared == 2 && self.valence(c) > 3 && self.valence(d) > 3
    }

    /// Pulls the end of `h` into its start, which moves to `p`; call only when [`Self::can_collapse`] allows.
    pub(crate) fn collapse(&mut self, h: u32, p: DVec3) {
        let g = self.twin(h);
        let (a, b) = (self.from(h), self.to(h));
        let leaving: Vec<u32> = self.around(b).collect();
        for e in leaving {
            self.origin[e as usize] = a;
        }
        self.points[a as usize] = p;
        for (inner, outer) in [(next(h), previous(h)), (next(g), previous(g))] {
            let (x, y) = (self.twin(inner), self.twin(outer));
            self.pair(x, y);
            for e in [x, y] {
                let v = self.from(e);
                self.out[v as usize] = e;
            }
        }
        for face in [h / 3, g / 3] {
            for k in 0..3 {
                self.origin[(3 * face + k) as usize] = NONE;
            }
        }
        self.out[b as usize] = NONE;
    }

    /// Cuts the edge of `h` at `p`, and with it the two faces beside it.
    pub(crate) fn split(&mut self, h: u32, p: DVec3) {
        let g = self.twin(h);
        let (b, c, d) = (self.to(h), self.from(previous(h)), self.from(previous(g)));
        let middle = self.points.len() as u32;
        self.points.push(p);
        // The old faces keep the half toward the start of `h`: (a, m, c) and (m, a, d).
        let (bc, db) = (self.twin(next(h)), self.twin(previous(g)));
        let new = self.origin.len() as u32;
        // New faces (m, b, c) and (b, m, d).
        self.origin.extend([middle, b, c, b, middle, d]);
        self.twin.extend([NONE; 6]);
        self.out.push(new);
        self.origin[next(h) as usize] = middle;
        self.origin[g as usize] = middle;
        self.out[b as usize] = new + 1;
        self.pair(new, new + 3);
        self.pair(new + 1, bc);
        self.pair(new + 2, next(h));
        self.pair(new + 4, previous(g));
        self.pair(new + 5, db);
    }

    /// True when the edge of `h` can be turned to join its two apexes.
    pub(crate) fn can_flip(&self, h: u32) -> bool {
        let (c, d) = (self.to(next(h)), self.to(next(self.twin(h))));
        c != d && self.valence(self.from(h)) > 3 && self.valence(self.to(h)) > 3 && !self.joined(c, d)
    }

    /// Turns the edge of `h` to join its two apexes; call only when [`Self::can_flip`] allows.
    pub(crate) fn flip(&mut self, h: u32) {
        let g = self.twin(h);
        let (h1, h2, g1, g2) = (next(h), previous(h), next(g), previous(g));
        let (a, b) = (self.from(h), self.from(g));
        let (c, d) = (self.from(h2), self.from(g2));
        let (bc, ca, ad, db) = (self.twin(h1), self.twin(h2), self.twin(g1), self.twin(g2));
        // The faces become (d, c, a) and (c, d, b).
        for (e, v) in [(h, d), (h1, c), (h2, a), (g, c), (g1, d), (g2, b)] {
            self.origin[e as usize] = v;
            self.out[v as usize] = e;
        }
        self.pair(h1, ca);
        self.pair(h2, ad);
        self.pair(g1, db);
        self.pair(g2, bc);
    }

    /// The faces that are left, over the points that are left, in the old order.
    pub(crate) fn into_faces(self) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let mut place = vec![NONE; self.points.len()];
        let mut points = Vec::new();
        for (v, slot) in place.iter_mut().enumerate() {
            if self.out[v] != NONE {
                *slot = points.len() as u32;
                points.push(self.points[v]);
            }
        }
        let live = self.origin.chunks_exact(3).filter(|c| c[0] != NONE);
        let faces = live.map(|c| [c[0], c[1], c[2]].map(|v| place[v as usize])).collect();
        (points, faces)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::noise;
    use crate::data::ply_out::Mesh;
    use crate::data::topology::Topology;

    fn octahedron_split() -> Surface {
        let ring = [DVec3::X, DVec3::Z, -DVec3::X, -DVec3::Z];
        let points: Vec<DVec3> = ring.into_iter().chain([DVec3::Y, -DVec3::Y]).collect();
        let mut faces = Vec::new();
        for i in 0..4 {
            let j = (i + 1) % 4;
            faces.push([j, i, 4]);
            faces.push([i, j, 5]);
        }
        Surface::new(points, &faces).unwrap()
    }

    #[test]
    fn an_open_surface_is_refused() {
        assert_eq!(Surface::new(vec![DVec3::ZERO; 3], &[[0, 1, 2]]).unwrap_err(), 3);
    }

    /// Whatever order the edges come in, splits and allowed flips and collapses keep a sphere a sphere.
    #[test]
    fn allowed_operations_keep_the_topology() {
        let grid =
            crate::data::polygonise::polygonise(&|p: DVec3| p.length() - 1.0, DVec3::splat(-1.3), 2.6, 0.2);
        let mut surface = Surface::new(grid.0, &grid.1).unwrap();
        let mut done = (0, 0, 0);
        for step in 0..6000 {
            let h = (noise::hash(step, 0, 0, 9) % u64::from(surface.half_edges())) as u32;
            if !surface.alive(h) {
                continue;
            }
            if step % 7 == 0 {
                surface.split(h, (surface.point(surface.from(h)) + surface.point(surface.to(h))) * 0.5);
                done.2 += 1;
            } else if step % 3 == 0 && surface.can_collapse(h) {
                surface.collapse(h, surface.point(surface.from(h)));
                done.0 += 1;
            } else if step % 3 != 0 && surface.can_flip(h) {
                surface.flip(h);
                done.1 += 1;
            }
        }
        assert!(done.0 > 100 && done.1 > 100 && done.2 > 100, "{done:?}");
        let (points, faces) = surface.into_faces();
        let mesh = Mesh { positions: points.iter().map(|p| p.as_vec3().to_array()).collect(), faces };
        let t = Topology::of(&mesh);
        assert!(t.is_closed() && t.components == 1 && t.euler == 2, "{t:?}");
    }

    #[test]
    fn a_flip_joins_the_apexes() {
        let mut s = octahedron_split();
        let h = (0..s.half_edges()).find(|h| (s.from(*h), s.to(*h)) == (0, 4)).unwrap();
        assert!(s.can_flip(h));
        s.flip(h);
        assert_eq!((s.valence(0), s.valence(4), s.valence(1), s.valence(3)), (3, 3, 5, 5));
    }
}
