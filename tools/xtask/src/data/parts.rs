//! Many separate pieces of different kinds and sizes, closed and open, scattered over a table.

use glam::DVec3;

use super::circle;
use super::noise;
use super::ply_out::Mesh;

/// Number of pieces.
const COUNT: u32 = 40;

/// A closed ball made of a subdivided cube, pushed toward a rounded box by `square` in [0, 1] and dented by noise.
fn pebble(n: u32, square: f64, dents: f64, seed: u64) -> Mesh {
    let mut mesh = Mesh::default();
    let mut known = std::collections::HashMap::new();
    for axis in 0..3_usize {
        for far in [false, true] {
            for i in 0..n {
                for j in 0..n {
                    let ring = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(di, dj)| {
                        let mut key = [0_u32; 3];
                        key[axis] = if far { n } else { 0 };
                        key[(axis + 1) % 3] = i + di;
                        key[(axis + 2) % 3] = j + dj;
                        *known.entry(key).or_insert_with(|| {
                            let p = DVec3::from(key.map(|k| f64::from(k) / f64::from(n) * 2.0 - 1.0));
                            let round = p / p.length();
                            let bump = 1.0 + dents * noise::octaves(round * 2.0, 3, seed);
                            mesh.vertex((round + (p - round) * square) * bump)
                        })
                    });
                    let [a, b, c, d] = ring;
                    if far { mesh.quad(a, b, c, d) } else { mesh.quad(a, d, c, b) }
                }
            }
        }
    }
    mesh
}

/// A grid of `rows` by `columns` quads; either direction may close on itself.
fn sheet(rows: u32, columns: u32, close: (bool, bool), at: impl Fn(f64, f64) -> DVec3) -> Mesh {
    let mut mesh = Mesh::default();
    let (r, c) = (rows + u32::from(!close.0), columns + u32::from(!close.1));
    for i in 0..r {
        for j in 0..c {
            mesh.vertex(at(f64::from(i) / f64::from(rows), f64::from(j) / f64::from(columns)));
        }
    }
    for i in 0..rows {
        for j in 0..columns {
            let v = |di: u32, dj: u32| (i + di) % r * c + (j + dj) % c;
            mesh.quad(v(0, 0), v(0, 1), v(1, 1), v(1, 0));
        }
    }
    mesh
}

/// A ring of minor radius `r`, closed both ways.
fn ring(rows: u32, columns: u32, r: f64) -> Mesh {
    sheet(rows, columns, (true, true), |u, v| {
        let ((c, s), (d, t)) = (circle(u), circle(v));
        DVec3::new(c * (1.0 + r * d), r * t, s * (1.0 + r * d))
    })
}

/// A tube open at both ends, narrower in the middle.
fn tube(rows: u32, columns: u32, waist: f64) -> Mesh {
    sheet(rows, columns, (false, true), |u, v| {
        let (c, s) = circle(v);
        let w = 2.0 * u - 1.0;
        let r = 0.5 + waist * w * w;
        DVec3::new(s * r, 1.2 * w, c * r)
    })
}

/// An open wavy square.
fn cloth(rows: u32, columns: u32, seed: u64) -> Mesh {
    sheet(rows, columns, (false, false), |u, v| {
        let h = noise::octaves(DVec3::new(u * 3.0, 0.0, v * 3.0), 3, seed);
        DVec3::new(2.0 * v - 1.0, 0.25 * h, 1.0 - 2.0 * u)
    })
}

/// One piece by its number: the kinds take turns, the sizes fall from thousands of faces to one.
fn piece(k: u32) -> Mesh {
    let seed = u64::from(k) * 101 + 5;
    // From 1 for the largest to 0 for the smallest.
    let size = 1.0 - f64::from(k) / f64::from(COUNT - 1);
    let n = |least: f64, most: f64| (least + (most - least) * size * size * size) as u32;
    match k {
        39 => Mesh {
            positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.3, 0.9]],
            faces: vec![[0, 2, 1]],
        },
        38 => sheet(1, 1, (false, false), |u, v| DVec3::new(v, 0.0, -u)),
        37 => pebble(1, 1.0, 0.0, seed),
        _ => match k % 5 {
            0 => pebble(n(2.0, 14.0), 0.0, 0.12, seed),
            1 => ring(n(8.0, 52.0), n(4.0, 22.0), 0.32),
            2 => cloth(n(2.0, 36.0), n(2.0, 28.0), seed),
            3 => pebble(n(2.0, 13.0), 0.85, 0.02, seed),
            _ => tube(n(2.0, 25.0), n(5.0, 32.0), 0.3),
        },
    }
}

/// The scattered pieces; about 15,000 faces, none touching another.
pub(crate) fn parts() -> Mesh {
    let mut all = Mesh::default();
    for k in 0..COUNT {
        let mut mesh = piece(k);
        let random = |n: i64| noise::unit(i64::from(k), n, 0, 404);
        let (c, s) = circle(random(0));
        let (d, t) = circle(random(1));
        let scale = 0.25 + 0.45 * random(2);
        // Cells of a table of 8 by 5, far enough apart that no two pieces meet.
        let cell = DVec3::new(f64::from(k % 8), random(3) * 0.3, f64::from(k / 8)) * 2.6;
        for p in &mut mesh.positions {
            let [x, y, z] = p.map(f64::from);
            let (x, z) = (c * x + s * z, c * z - s * x);
            let (y, z) = (d * y + t * z, d * z - t * y);
            let q = DVec3::new(x, y, z) * scale + cell;
            *p = [q.x as f32, q.y as f32, q.z as f32];
        }
        all.append(&mesh);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::topology::Topology;

    #[test]
    fn parts_are_forty_manifold_pieces_closed_and_open() {
        let mesh = parts();
        let t = Topology::of(&mesh);
        assert!(t.is_manifold(), "{t:?}");
        assert_eq!(t.components, COUNT as usize);
        assert!((14_000..16_000).contains(&mesh.faces.len()), "{}", mesh.faces.len());
        let closed = (0..COUNT).filter(|k| Topology::of(&piece(*k)).is_closed()).count();
        assert!((15..30).contains(&closed), "{closed}");
    }
}
