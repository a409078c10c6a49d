//! A painted vase: a smooth form whose colours have sharp borders, as scans of pottery do.

use glam::{DVec2, DVec3};

use super::circle;
use super::noise::octaves;
use super::ply_out::Mesh;

/// What the file says it is.
pub(crate) const COMMENT: &str = "a painted vase";

/// Height and radius along the outside, from the foot to the lip.
const OUTSIDE: [(f64, f64); 12] = [
    (0.0, 0.33),
    (0.04, 0.34),
    (0.1, 0.24),
    (0.2, 0.3),
    (0.5, 0.5),
    (0.9, 0.68),
    (1.25, 0.66),
    (1.5, 0.46),
    (1.65, 0.28),
    (1.8, 0.25),
    (1.95, 0.34),
    (2.0, 0.37),
];

/// How thick the wall is.
const WALL: f64 = 0.05;

/// Rows of the wall's inside for each one of the outside: nobody looks there.
const INSIDE_SHARE: f64 = 0.25;

/// A closed vase of about `faces` faces, two units high, and the colour of each vertex.
pub(crate) fn vase(faces: u64) -> (Mesh, Vec<[u8; 3]>) {
    // As long around the belly as along the outside, near enough.
    let around = ((faces as f64 / 2.0 * 1.6 / (1.0 + INSIDE_SHARE)).sqrt() as u32).max(16);
    let rows = ((faces as f64 / 2.0 / f64::from(around) / (1.0 + INSIDE_SHARE)) as u32).max(8);
    let inner = (f64::from(rows) * INSIDE_SHARE) as u32 + 1;
    let outside = (0..=rows).map(|i| (along(f64::from(i) / f64::from(rows)), true));
    let inside = (0..=inner).map(|i| {
        let (height, radius) = along(1.0 - f64::from(i) / f64::from(inner) * 0.9);
        ((height, (radius - WALL).max(0.05)), false)
    });
    let rings: Vec<((f64, f64), bool)> = outside.chain(inside).collect();
    let (mut mesh, mut colors) = (Mesh::default(), Vec::new());
    let pole = |mesh: &mut Mesh, colors: &mut Vec<[u8; 3]>, height: f64| {
        colors.push(GLAZE);
        mesh.vertex(DVec3::Y * height)
    };
    let bottom = pole(&mut mesh, &mut colors, 0.0);
    let first = bottom + 1;
    for ((height, radius), is_outside) in &rings {
        for i in 0..around {
            let turn = f64::from(i) / f64::from(around);
            let (c, s) = circle(turn);
            let point = DVec3::new(c * radius, *height, -s * radius);
            mesh.vertex(point);
            colors.push(if *is_outside {
                shaded(painted(turn, *height), point)
            } else {
                shaded(CLAY, point)
            });
        }
    }
    let lowest = rings.last().map_or(0.0, |((height, _), _)| *height);
    let top = pole(&mut mesh, &mut colors, lowest);
    let ring = |k: usize, i: u32| first + k as u32 * around + i % around;
    let last = rings.len() - 1;
    for i in 0..around {
        mesh.faces.push([bottom, ring(0, i + 1), ring(0, i)]);
        mesh.faces.push([top, ring(last, i), ring(last, i + 1)]);
        for k in 0..last {
            mesh.quad(ring(k, i), ring(k, i + 1), ring(k + 1, i + 1), ring(k + 1, i));
        }
    }
    (mesh, colors)
}

/// Height and radius after a share of the outside's height, smooth through the points of [`OUTSIDE`].
fn along(share: f64) -> (f64, f64) {
    let height = share * OUTSIDE[OUTSIDE.len() - 1].0;
    let k = OUTSIDE.partition_point(|p| p.0 <= height).clamp(1, OUTSIDE.len() - 1) - 1;
    let slope = |i: usize| {
        let (low, high) = (OUTSIDE[i.saturating_sub(1)], OUTSIDE[(i + 1).min(OUTSIDE.len() - 1)]);
        (high.1 - low.1) / (high.0 - low.0)
    };
    let ((h0, r0), (h1, r1)) = (OUTSIDE[k], OUTSIDE[k + 1]);
    let (width, t) = (h1 - h0, (height - h0) / (h1 - h0));
    let (a, b) = (slope(k) * width, slope(k + 1) * width);
    let u = 1.0 - t;
    let radius = r0 * u * u * (1.0 + 2.0 * t) + r1 * t * t * (3.0 - 2.0 * t) + a * t * u * u - b * t * t * u;
    (height, radius)
}

const CLAY: [u8; 3] = [201, 112, 62];
const GLAZE: [u8; 3] = [32, 26, 24];

/// One turn of a meander, rows from above.
const MEANDER: [&[u8; 8]; 7] =
    [b"########", b"#......#", b"#.####.#", b"#.#..#.#", b"#.##.#.#", b"#....#.#", b"######.#"];

/// What stands at a place of the outside.
fn painted(turn: f64, height: f64) -> [u8; 3] {
    let within = |low: f64, high: f64| (low..high).contains(&height);
    let part = |n: f64| (turn * n).fract();
    let is_dark = if within(0.2, 0.42) {
        // Rays that rise from the stem.
        (part(18.0) - 0.5).abs() * 2.0 < 1.0 - (height - 0.2) / 0.22
    } else if within(0.52, 0.72) {
        let (column, row) = ((part(22.0) * 8.0) as usize, ((0.72 - height) / 0.2 * 7.0) as usize);
        MEANDER[row.min(6)][column.min(7)] == b'#'
    } else if within(0.8, 1.2) {
        rosette(DVec2::new((part(9.0) - 0.5) * 0.47, height - 1.0))
    } else if within(1.28, 1.36) {
        DVec2::new((part(40.0) - 0.5) * 0.1, height - 1.32).length() < 0.028
    } else if within(1.5, 1.62) {
        part(26.0) < 0.5
    } else {
        let lines = [0.46, 0.76, 1.24, 1.4, 1.46];
        !within(0.1, 1.66) || lines.iter().any(|at| (height - at).abs() < 0.011)
    };
    if is_dark { GLAZE } else { CLAY }
}

/// A flower of eight petals, and a drop beside it.
fn rosette(p: DVec2) -> bool {
    let petals = (0..8).any(|i| {
        let (c, s) = circle(f64::from(i) / 8.0);
        (p - DVec2::new(c, s) * 0.1).length() < 0.034
    });
    let drop = DVec2::new(p.x.abs() - 0.2, p.y * 0.4).length() < 0.02;
    petals || p.length() < 0.045 || drop || (p.length() - 0.16).abs() < 0.012
}

/// As fired: a little lighter here and darker there.
fn shaded(color: [u8; 3], p: DVec3) -> [u8; 3] {
    let light = 1.0 + 0.08 * octaves(p * 3.0, 3, 71);
    color.map(|c| (f64::from(c) * light).round().clamp(0.0, 255.0) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::topology::Topology;

    #[test]
    fn the_vase_is_closed_painted_and_as_large_as_asked_for() {
        for faces in [2_000, 60_000] {
            let (mesh, colors) = vase(faces);
            assert_eq!(mesh.positions.len(), colors.len());
            let found = mesh.faces.len() as u64;
            assert!(found.abs_diff(faces) * 10 < faces, "{found}");
            let topology = Topology::of(&mesh);
            assert_eq!(topology.open_edges, 0);
        }
        let (mesh, colors) = vase(60_000);
        let dark = colors.iter().filter(|c| c[0] < 100).count();
        assert!((colors.len() / 5..colors.len() * 4 / 5).contains(&dark));
        let volume: f64 = mesh
            .faces
            .iter()
            .map(|f| {
                let [a, b, c] = f.map(|v| DVec3::from(mesh.positions[v as usize].map(f64::from)));
                a.dot(b.cross(c)) / 6.0
            })
            .sum();
        assert!(volume > 0.1, "faces look outwards: {volume}");
    }
}
