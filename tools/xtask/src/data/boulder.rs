//! A closed surface of as many faces as one likes, written without being held: to try what scans of a hundred million
//! polygons take.

use super::noise;
use glam::DVec3;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

/// What is written into the file.
const COMMENT: &str =
    "boulder, a cube's grid blown up to a rough ball; vertices along the edges of the cube repeat";

/// Half the edge of the cube, and about the radius of the boulder.
const RADIUS: f64 = 100.0;

/// Edges along a side of the cube, for at least so many faces.
fn edges_for(faces: u64) -> u64 {
    // Six sides of n^2 squares, two triangles each.
    let mut n = (faces as f64 / 12.0).sqrt() as u64;
    while 12 * n * n < faces {
        n += 1;
    }
    n.max(1)
}

/// Where a point of the cube lies on the boulder. Points that two sides share come out the same: nothing depends on the
/// side.
fn place(on_cube: DVec3) -> [f32; 3] {
    let direction = on_cube.normalize_or_zero();
    let height = noise::octaves(direction * 2.0, 10, 41);
    (direction * (RADIUS * (1.0 + 0.12 * height))).as_vec3().to_array()
}

/// A point of a side, by numbers in -1..1; the sides turn the same way around, seen from outside.
fn on_side(side: usize, u: f64, v: f64) -> DVec3 {
    match side {
        0 => DVec3::new(1.0, u, v),
        1 => DVec3::new(-1.0, v, u),
        2 => DVec3::new(v, 1.0, u),
        3 => DVec3::new(u, -1.0, v),
        4 => DVec3::new(u, v, 1.0),
        _ => DVec3::new(v, u, -1.0),
    }
}

/// Writes a boulder of at least so many faces as PLY. Returns how many faces and vertices it has.
///
/// # Errors
/// What the system says.
pub(super) fn write_file(path: &Path, faces: u64) -> std::io::Result<(u64, u64)> {
    let mut out = BufWriter::with_capacity(1 << 20, File::create(path)?);
    let counts = write_to(&mut out, edges_for(faces))?;
    out.flush()?;
    Ok(counts)
}

fn write_to(out: &mut impl Write, n: u64) -> std::io::Result<(u64, u64)> {
    let (faces, vertices) = (12 * n * n, 6 * (n + 1) * (n + 1));
    write!(
        out,
        "ply\nformat binary_little_endian 1.0\ncomment {COMMENT}\nelement vertex {vertices}\n\
         property float x\nproperty float y\nproperty float z\nelement face {faces}\n\
         property list uchar uint vertex_indices\nend_header\n"
    )?;
    // Symmetric about 0, so that the sides agree to the last bit.
    let along = |i: u64| (2.0 * i as f64 - n as f64) / n as f64;
    for side in 0..6 {
        for i in 0..=n {
            for j in 0..=n {
                for c in place(on_side(side, along(i), along(j))) {
                    out.write_all(&c.to_le_bytes())?;
                }
            }
        }
    }
    for side in 0..6 {
        for i in 0..n {
            for j in 0..n {
                let a = ((side * (n + 1) + i) * (n + 1) + j) as u32;
                let down = a + n as u32 + 1;
                for face in [[a, down, down + 1], [a, down + 1, a + 1]] {
                    out.write_all(&[3])?;
                    for v in face {
                        out.write_all(&v.to_le_bytes())?;
                    }
                }
            }
        }
    }
    Ok((faces, vertices))
}

#[cfg(test)]
mod tests {
    use super::*;
    use fcbuild::BuildOptions;

    #[test]
    fn it_is_closed_and_looks_outwards() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("boulder.ply");
        let (faces, vertices) = write_file(&path, 5_000).unwrap();
        assert!((5_000..6_000).contains(&faces) && vertices > faces / 2);
        let import = fcbuild::import::ImportOptions { max_faces: u64::MAX, progress: &|_, _| {} };
        let soup = fcbuild::import::import(&path, &import).unwrap();
        let options = BuildOptions::default();
        let built = fcbuild::Prepared::new(soup, &options).unwrap();
        assert!(!built.looks_inwards());
        assert_eq!(built.extent().border_edges, 0);
    }
}
