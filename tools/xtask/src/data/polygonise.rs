//! The zero surface of a field as triangles, by marching tetrahedra.
//!
//! Each cube of a grid is cut into six tetrahedra along its diagonal, the same way everywhere, so neighbouring cubes
//! agree on every face and the surface is a closed manifold by construction as long as it stays inside the grid.

use std::collections::HashMap;

use glam::DVec3;
use rayon::prelude::*;

/// Cubes along the side of a block; a block that is far from the surface is skipped as a whole.
const BLOCK: i64 = 8;

/// The six tetrahedra as their two middle corners; corner bits are x, y, z, and all run from 0 to 7.
///
/// The flag says whether the path 0, a, b, 7 is right-handed.
const TETRAHEDRA: [(usize, usize, bool); 6] =
    [(1, 3, true), (1, 5, false), (2, 3, false), (2, 6, true), (4, 5, true), (4, 6, false)];

/// Triangles of the surface `field = 0` in a cube from `low` with side `size`, on a grid of the given `step`.
///
/// The field is negative inside and its slope must stay below 2, or blocks may be skipped wrongly.
/// Triangles are wound counter-clockwise seen from outside.
pub(crate) fn polygonise(
    field: &(impl Fn(DVec3) -> f64 + Sync),
    low: DVec3,
    size: f64,
    step: f64,
) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let blocks = (size / (step * BLOCK as f64)).ceil() as i64;
    let mut made = Made { known: HashMap::new(), points: Vec::new(), faces: Vec::new() };
    let at = |c: [i64; 3]| low + DVec3::new(c[0] as f64, c[1] as f64, c[2] as f64) * step;
    let half = step * BLOCK as f64 * 0.5;
    let sample = |base: [i64; 3]| {
        if field(at(base) + DVec3::splat(half)).abs() > 2.0 * half * 3.0_f64.sqrt() {
            return Vec::new();
        }
        let side = 0..=BLOCK;
        side.clone()
            .flat_map(|z| side.clone().map(move |y| (y, z)))
            .flat_map(|(y, z)| side.clone().map(move |x| [base[0] + x, base[1] + y, base[2] + z]))
            .map(|cell| field(at(cell)))
            .collect()
    };
    // A layer of blocks is sampled in parallel and then walked in order, so the numbering never depends on threads.
    for layer in 0..blocks {
        let bases: Vec<[i64; 3]> =
            (0..blocks * blocks).map(|b| [b % blocks, b / blocks, layer].map(|c| c * BLOCK)).collect();
        let sampled: Vec<Vec<f64>> = bases.par_iter().map(|base| sample(*base)).collect();
        for (base, values) in bases.iter().zip(&sampled) {
            if !values.is_empty() {
                made.block(*base, values, &at);
            }
        }
    }
    (made.points, made.faces)
}

/// A grid point and the field there.
#[derive(Debug, Clone, Copy)]
struct Corner {
    cell: [i64; 3],
    value: f64,
}

struct Made {
    /// Vertex on each grid edge that the surface crosses; looked up only, never walked.
    known: HashMap<u64, u32>,
    points: Vec<DVec3>,
    faces: Vec<[u32; 3]>,
}

impl Made {
    /// Walks the cubes of a block with its lower corner at `base`.
    fn block(&mut self, base: [i64; 3], values: &[f64], at: &impl Fn([i64; 3]) -> DVec3) {
        for z in 0..BLOCK {
            for y in 0..BLOCK {
                for x in 0..BLOCK {
                    let corner = |k: usize| {
                        let d = [k & 1, k >> 1 & 1, k >> 2].map(|b| b as i64);
                        let [cx, cy, cz] = [x + d[0], y + d[1], z + d[2]];
                        let value = values[((cz * (BLOCK + 1) + cy) * (BLOCK + 1) + cx) as usize];
                        Corner { cell: [base[0] + cx, base[1] + cy, base[2] + cz], value }
                    };
                    self.cube(&[0, 1, 2, 3, 4, 5, 6, 7].map(corner), at);
                }
            }
        }
    }

    fn cube(&mut self, corners: &[Corner; 8], at: &impl Fn([i64; 3]) -> DVec3) {
        let inside = corners.iter().filter(|c| c.value < 0.0).count();
        if inside == 0 || inside == 8 {
            return;
        }
        for (a, b, right) in TETRAHEDRA {
            let t = [corners[0], corners[a], corners[b], corners[7]];
            let mut order = [0, 1, 2, 3];
            // Inside corners first; a stable sort of at most four keeps count of the swaps for the winding.
            let mut even = right;
            for i in 0..3 {
                for j in 0..3 - i {
                    if t[order[j]].value >= 0.0 && t[order[j + 1]].value < 0.0 {
                        order.swap(j, j + 1);
                        even = !even;
                    }
                }
            }
            let [p, q, r, s] = order.map(|k| t[k]);
            let mut face = |x: u32, y: u32, z: u32| {
                self.faces.push(if even { [x, y, z] } else { [x, z, y] });
            };
            match t.iter().filter(|c| c.value < 0.0).count() {
                1 => {
                    let [x, y, z] = [(p, q), (p, r), (p, s)]
                        .map(|(a, b)| crossing(&mut self.known, &mut self.points, a, b, at));
                    face(x, y, z);
                }
                2 => {
                    let [x, y, z, w] = [(p, r), (p, s), (q, s), (q, r)]
                        .map(|(a, b)| crossing(&mut self.known, &mut self.points, a, b, at));
                    face(x, y, z);
                    face(x, z, w);
                }
                3 => {
                    let [x, y, z] = [(p, s), (q, s), (r, s)]
                        .map(|(a, b)| crossing(&mut self.known, &mut self.points, a, b, at));
                    face(x, y, z);
                }
                _ => {}
            }
        }
    }
}

/// The vertex between two grid points of different sign.
fn crossing(
    known: &mut HashMap<u64, u32>,
    points: &mut Vec<DVec3>,
    a: Corner,
    b: Corner,
    at: &impl Fn([i64; 3]) -> DVec3,
) -> u32 {
    // Every edge climbs from its lower end in one of seven directions, so that end and the direction name it.
    let (low, high) = if a.cell < b.cell { (a, b) } else { (b, a) };
    let mut key = 0_u64;
    for k in 0..3 {
        key = key << 20 | low.cell[k].unsigned_abs();
    }
    let direction = (0..3).fold(0, |d, k| d << 1 | u64::from(high.cell[k] > low.cell[k]));
    *known.entry(key << 3 | direction).or_insert_with(|| {
        // Kept off the ends, so that no two vertices of a grid point coincide.
        let t = (low.value / (low.value - high.value)).clamp(0.02, 0.98);
        let (p, q) = (at(low.cell), at(high.cell));
        points.push(p + (q - p) * t);
        points.len() as u32 - 1
    })
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;
    use crate::data::ply_out::Mesh;
    use crate::data::topology::Topology;

    fn torus(p: DVec3, major: f64, minor: f64) -> f64 {
        DVec2::new(DVec2::new(p.x, p.z).length() - major, p.y).length() - minor
    }

    #[test]
    fn a_torus_is_closed_and_outward() {
        let (points, faces) = polygonise(&|p| torus(p, 1.0, 0.4), DVec3::splat(-1.6), 3.2, 0.11);
        let volume: f64 = faces
            .iter()
            .map(|f| {
                let [a, b, c] = f.map(|v| points[v as usize]);
                a.dot(b.cross(c)) / 6.0
            })
            .sum();
        // 2 pi^2 R r^2 = 3.158; the triangles cut the round a little short.
        assert!((3.0..3.17).contains(&volume), "{volume}");
        let t =
            Topology::of(&Mesh { positions: points.iter().map(|p| p.as_vec3().to_array()).collect(), faces });
        assert!(t.is_closed() && t.components == 1 && t.euler == 0, "{t:?}");
    }
}
