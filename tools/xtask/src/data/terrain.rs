//! An open height field with ridges, terraces and holes.

use glam::DVec3;

use super::noise;
use super::ply_out::Mesh;

/// Quads along each side before the holes are cut.
const SIDE: u32 = 104;

/// Holes as centre x, centre z and radius, in units of the side.
const HOLES: [(f64, f64, f64); 4] =
    [(0.22, 0.3, 0.075), (0.7, 0.22, 0.04), (0.62, 0.66, 0.11), (0.2, 0.78, 0.03)];

/// Height over the unit square.
fn height(x: f64, z: f64) -> f64 {
    let p = DVec3::new(x * 3.0 + 0.37, 0.5, z * 3.0 + 0.11);
    let swell = noise::octaves(p, 2, 11);
    let ridge = 1.0 - noise::octaves(p * 1.7, 3, 23).abs();
    let rough = swell * 0.10 + ridge * ridge * 0.10 + noise::octaves(p * 6.0, 3, 37) * 0.012;
    // Terraces over part of the land: flat steps with sharp rims.
    let step = 0.035;
    let level = (rough / step).floor();
    let t = rough / step - level;
    let stepped = (level + ((t - 0.7) / 0.3).max(0.0)) * step;
    let share = (noise::value(p * 0.8, 51) * 3.0 + 0.3).clamp(0.0, 1.0);
    rough + (stepped - rough) * share
}

/// True where the land is cut away; the rims are ragged by noise.
fn cut(x: f64, z: f64) -> bool {
    HOLES.iter().any(|(cx, cz, r)| {
        let (dx, dz) = (x - cx, z - cz);
        let rim = r * (1.0 + 0.25 * noise::value(DVec3::new(x * 14.0, 0.0, z * 14.0), 71));
        dx * dx + dz * dz < rim * rim
    })
}

/// The terrain; about 20,000 faces, one component, one outer rim and one rim per hole.
pub(crate) fn terrain() -> Mesh {
    let n = SIDE + 1;
    let mut mesh = Mesh::default();
    let mut index = vec![None; (n * n) as usize];
    let mut heights = vec![0.0; (n * n) as usize];
    for j in 0..n {
        for i in 0..n {
            let inner = i > 0 && j > 0 && i < SIDE && j < SIDE;
            let jitter = |seed| {
                let amount = if inner { 0.5 } else { 0.0 };
                (noise::unit(i64::from(i), 0, i64::from(j), seed) - 0.5) * amount
            };
            let x = (f64::from(i) + jitter(81)) / f64::from(SIDE);
            let z = (f64::from(j) + jitter(82)) / f64::from(SIDE);
            let at = (j * n + i) as usize;
            heights[at] = height(x, z);
            if !cut(x, z) {
                index[at] = Some(mesh.vertex(DVec3::new(x - 0.5, heights[at], z - 0.5) * 10.0));
            }
        }
    }
    for j in 0..SIDE {
        for i in 0..SIDE {
            let at = |di: u32, dj: u32| ((j + dj) * n + i + di) as usize;
            // Counter-clockwise seen from above, where z points toward the viewer.
            let ring = [at(0, 0), at(0, 1), at(1, 1), at(1, 0)];
            // The diagonal along the smaller step follows ridges and terraces.
            let straight = (heights[ring[0]] - heights[ring[2]]).abs();
            let crossed = (heights[ring[1]] - heights[ring[3]]).abs();
            let faces = if straight <= crossed { [[0, 1, 2], [0, 2, 3]] } else { [[1, 2, 3], [1, 3, 0]] };
            for f in faces {
                if let [Some(a), Some(b), Some(c)] = f.map(|k: usize| index[ring[k]]) {
                    mesh.faces.push([a, b, c]);
                }
            }
        }
    }
    mesh.drop_unused()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::topology::Topology;

    #[test]
    fn terrain_is_one_open_manifold_with_four_holes() {
        let mesh = terrain();
        let t = Topology::of(&mesh);
        assert!(t.is_manifold(), "{t:?}");
        assert_eq!(t.components, 1);
        // A disc with four holes.
        assert_eq!(t.euler, -3);
        assert!((19_000..21_500).contains(&mesh.faces.len()), "{}", mesh.faces.len());
    }
}
