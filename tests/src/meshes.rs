//! Small meshes made in memory, from well-behaved to hostile.

use crate::random::Random;
use fcbuild::import::{Group, Positions, Soup, Tally};

/// A soup of one group.
pub fn soup(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Soup {
    let faces = triangles.len();
    Soup {
        positions: Positions::F32(positions),
        triangles,
        normals: None,
        colors: None,
        groups: vec![Group { name: "mesh".to_owned(), triangles: 0..faces }],
        tally: Tally { polygons_in: faces as u64, faces_in: faces as u64, ..Tally::default() },
    }
}

/// A grid of `n` by `n` quads over the unit square, bumpy; open.
pub fn grid(n: u32, seed: u64) -> Soup {
    let mut random = Random::new(seed);
    let side = n + 1;
    let positions = (0..side * side)
        .map(|i| {
            [
                (i % side) as f32 / n as f32,
                (i / side) as f32 / n as f32,
                random.between(0.0, 0.6 / f64::from(n)) as f32,
            ]
        })
        .collect();
    let triangles = (0..n * n)
        .flat_map(|i| {
            let a = i / n * side + i % n;
            [[a, a + 1, a + side + 1], [a, a + side + 1, a + side]]
        })
        .collect();
    soup(positions, triangles)
}

/// A closed plate of `n` by `n` quads with square holes, two quads wide and as far apart; bumpy above by `bumps`.
pub fn plate(n: u32, bumps: f64, seed: u64) -> Soup {
    let mut random = Random::new(seed);
    let side = n + 1;
    let sheets = side * side;
    let place = |i: u32, z: f32| [(i % side) as f32 / n as f32, (i / side) as f32 / n as f32, z];
    let mut positions: Vec<[f32; 3]> =
        (0..sheets).map(|i| place(i, random.between(0.0, bumps) as f32)).collect();
    positions.extend((0..sheets).map(|i| place(i, -0.1)));
    let is_solid = |x: u32, y: u32| x < n && y < n && !(x % 4 > 1 && y % 4 > 1);
    let mut triangles = Vec::new();
    for (x, y) in (0..n).flat_map(|y| (0..n).map(move |x| (x, y))).filter(|(x, y)| is_solid(*x, *y)) {
        let a = y * side + x;
        let above = [a, a + 1, a + side + 1, a + side];
        let below = above.map(|v| v + sheets);
        let mut quad = |[a, b, c, d]: [u32; 4]| triangles.extend([[a, b, c], [a, c, d]]);
        quad(above);
        quad([below[0], below[3], below[2], below[1]]);
        let across = [(x, y.wrapping_sub(1)), (x + 1, y), (x, y + 1), (x.wrapping_sub(1), y)];
        for (i, (x, y)) in across.into_iter().enumerate() {
            let j = (i + 1) % 4;
            if !is_solid(x, y) {
                quad([above[j], above[i], below[i], below[j]]);
            }
        }
    }
    soup(positions, triangles)
}

/// A closed torus with `u` by `v` quads and noise on its radius.
pub fn torus(u: u32, v: u32, seed: u64) -> Soup {
    let mut random = Random::new(seed);
    let tau = std::f64::consts::TAU;
    let mut positions = Vec::new();
    for i in 0..u {
        for j in 0..v {
            let (a, b) = (tau * f64::from(i) / f64::from(u), tau * f64::from(j) / f64::from(v));
            let r = 0.35 + 0.02 * random.unit();
            positions.push([
                (a.cos() * (1.0 + r * b.cos())) as f32,
                (a.sin() * (1.0 + r * b.cos())) as f32,
                (r * b.sin()) as f32,
            ]);
        }
    }
    let at = |i: u32, j: u32| i % u * v + j % v;
    let triangles = (0..u)
        .flat_map(|i| (0..v).map(move |j| (i, j)))
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    soup(positions, triangles)
}

/// A thin ear: an upper and a lower sheet that meet along a ragged rim, open where it would grow from a head.
pub fn flap(n: u32, seed: u64) -> Soup {
    let mut random = Random::new(seed);
    let rows = n / 2 + 2;
    let thick = 0.02 + 0.06 * random.unit();
    // Rows from the open end of the upper sheet over the rim to that of the lower one.
    let rim: Vec<f64> = (0..=n).map(|_| 1.0 + 0.15 * random.unit()).collect();
    let mut positions = Vec::new();
    for row in 0..=2 * rows {
        for (i, reach) in rim.iter().enumerate() {
            let inward = f64::from(row.abs_diff(rows)) / f64::from(rows);
            let side = if row < rows { 1.0 } else { -1.0 };
            let x = i as f64 / f64::from(n) * 2.0;
            let bend = 0.4 * x * (2.0 - x);
            let height = side * thick * inward.sqrt() + 0.01 * random.unit() + bend * bend;
            positions.push([x as f32, (reach * (1.0 - inward) + bend) as f32, height as f32]);
        }
    }
    let side = n + 1;
    let triangles = (0..2 * rows)
        .flat_map(|row| (0..n).map(move |i| row * side + i))
        .flat_map(|a| [[a, a + 1, a + side + 1], [a, a + side + 1, a + side]])
        .collect();
    soup(positions, triangles)
}

/// A Moebius strip: its faces cannot be wound consistently.
pub fn moebius(n: u32) -> Soup {
    let tau = std::f64::consts::TAU;
    let mut positions = Vec::new();
    for i in 0..n {
        for j in 0..5 {
            let (a, w) = (tau * f64::from(i) / f64::from(n), (f64::from(j) - 2.0) * 0.1);
            let (r, z) = (1.0 + w * (a / 2.0).cos(), w * (a / 2.0).sin());
            positions.push([(r * a.cos()) as f32, (r * a.sin()) as f32, z as f32]);
        }
    }
    let at = |i: u32, j: u32| if i == n { 4 - j } else { i * 5 + j };
    let triangles = (0..n)
        .flat_map(|i| (0..4).map(move |j| (i, j)))
        .flat_map(|(i, j)| {
            [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
        })
        .collect();
    soup(positions, triangles)
}

/// Three bumpy sheets that share one edge line, and touch a fourth at its end.
pub fn three_sheets(n: u32) -> Soup {
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for sheet in 0..3_u32 {
        let a = f64::from(sheet) * 2.1;
        let base = positions.len() as u32;
        for i in 0..=n {
            for j in 0..=n {
                let (x, r) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
                let bump = 0.05 * (f64::from(i * 7 + j * 3) * 0.9).sin();
                positions.push([x as f32 + (bump * r) as f32, (r * a.cos()) as f32, (r * a.sin()) as f32]);
            }
        }
        for i in 0..n {
            for j in 0..n {
                let q = base + i * (n + 1) + j;
                triangles.push([q, q + n + 1, q + n + 2]);
                triangles.push([q, q + n + 2, q + 1]);
            }
        }
    }
    soup(positions, triangles)
}

/// Several separate pieces, some of a single face.
pub fn pieces(seed: u64) -> Soup {
    let mut random = Random::new(seed);
    let mut all = torus(12, 8, seed);
    for k in 0..12 {
        let other = match k % 4 {
            0 => torus(9, 5, seed + k),
            1 => grid(6, seed + k),
            2 => soup(vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]], vec![[0, 1, 2]]),
            _ => soup(
                vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]],
                vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
            ),
        };
        let offset =
            [random.between(-6., 6.) as f32, random.between(-6., 6.) as f32, random.between(-6., 6.) as f32];
        append(&mut all, &other, offset);
    }
    all
}

fn append(all: &mut Soup, other: &Soup, offset: [f32; 3]) {
    let (Positions::F32(to), Positions::F32(from)) = (&mut all.positions, &other.positions) else { return };
    let base = to.len() as u32;
    to.extend(from.iter().map(|p| [0, 1, 2].map(|k| p[k] + offset[k])));
    all.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + base)));
    all.tally.faces_in += other.triangles.len() as u64;
    all.groups[0].triangles.end = all.triangles.len();
}

/// Triangles between random vertices: non-manifold everywhere.
pub fn tangle(vertices: usize, faces: usize, seed: u64) -> Soup {
    let mut random = Random::new(seed);
    let positions = (0..vertices).map(|_| [0; 3].map(|_| random.unit() as f32)).collect();
    let triangles = (0..faces).map(|_| [0; 3].map(|_| random.below(vertices) as u32)).collect();
    soup(positions, triangles)
}

/// A torus whose coordinates are replaced, here and there, by random bits; those that are not finite become zero.
pub fn random_bits(seed: u64) -> Soup {
    let mut random = Random::new(seed);
    let mut soup = torus(14, 9, seed);
    if let Positions::F32(p) = &mut soup.positions {
        for x in p.iter_mut().flatten() {
            if random.below(4) == 0 {
                let bits = f32::from_bits(random.bits() as u32);
                // Beyond 1e18 a squared length leaves single precision when it is written back.
                *x = if bits.is_finite() && bits.abs() < 1e18 { bits } else { 0.0 };
            }
        }
    }
    soup
}

/// Many coincident and zero-area faces.
pub fn flat_garbage(seed: u64) -> Soup {
    let mut soup = grid(9, seed);
    if let Positions::F32(p) = &mut soup.positions {
        for (i, q) in p.iter_mut().enumerate() {
            q[2] = 0.0;
            if i % 3 == 0 {
                q[1] = 0.25;
            }
            if i % 7 == 0 {
                q[0] = 0.5;
            }
        }
    }
    soup
}
