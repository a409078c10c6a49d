//! Tiny hand-made files that are awkward for importers: a seam, a non-manifold edge, quads, instances.

use std::fmt::Write as _;

use glam::DVec3;

use super::circle;
use super::ply_out::{Mesh, write_to};

/// Every odd file as its name and its bytes.
pub(crate) fn files() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("moebius.ply", binary_ply(&moebius(48, 6), "Moebius strip: a seam where the winding meets itself")),
        ("nonmanifold.ply", binary_ply(&three_sheets(4), "three sheets that share one line of edges")),
        ("tetra.obj", tetra_obj().into_bytes()),
        ("quads.ply", quads_ply(6).into_bytes()),
        ("single.stl", single_stl()),
        ("cube.glb", cube_glb()),
    ]
}

fn binary_ply(mesh: &Mesh, comment: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    // Writing to a Vec cannot fail, so there is no error to pass on.
    let _ = write_to(&mut bytes, mesh, &[], comment);
    bytes
}

/// A band with one half twist, `along` quads long and `across` quads wide, closed on itself.
pub(crate) fn moebius(along: u32, across: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for i in 0..along {
        // The half angle turns the band while the full angle, by the double-angle formulas, carries it round.
        let (c, s) = circle(0.5 * f64::from(i) / f64::from(along));
        let round = DVec3::new(c * c - s * s, 0.0, 2.0 * c * s);
        for j in 0..=across {
            let w = (f64::from(j) / f64::from(across) - 0.5) * 0.7;
            mesh.vertex(round * (1.0 + w * c) + DVec3::Y * (w * s));
        }
    }
    let row = across + 1;
    for i in 0..along {
        for j in 0..across {
            let (a, b) = (i * row + j, i * row + j + 1);
            let (d, c) = if i + 1 < along {
                ((i + 1) * row + j, (i + 1) * row + j + 1)
            } else {
                // After one turn the band arrives upside down.
                (across - j, across - j - 1)
            };
            mesh.quad(a, b, c, d);
        }
    }
    mesh
}

/// Three square sheets of `n` by `n` quads that share one side.
pub(crate) fn three_sheets(n: u32) -> Mesh {
    let mut mesh = Mesh::default();
    let step = 1.0 / f64::from(n);
    for i in 0..=n {
        mesh.vertex(DVec3::Y * (f64::from(i) * step));
    }
    for (x, z) in [(1.0, 0.0), (-0.5, 0.8), (-0.5, -0.8)] {
        let base = mesh.positions.len() as u32;
        for j in 1..=n {
            for i in 0..=n {
                let r = f64::from(j) * step;
                mesh.vertex(DVec3::new(x * r, f64::from(i) * step, z * r));
            }
        }
        let at = |i: u32, j: u32| if j == 0 { i } else { base + (j - 1) * (n + 1) + i };
        for j in 0..n {
            for i in 0..n {
                mesh.quad(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            }
        }
    }
    mesh
}

fn tetra_obj() -> String {
    "# A regular tetrahedron, wound counter-clockwise.\n\
     o tetra\n\
     v 1 1 1\nv 1 -1 -1\nv -1 1 -1\nv -1 -1 1\n\
     f 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n"
        .to_owned()
}

/// A closed box of quads in ascii PLY, `n` by `n` on each side, with shared vertices.
fn quads_ply(n: u32) -> String {
    let mut points: Vec<[u32; 3]> = Vec::new();
    let mut quads: Vec<[usize; 4]> = Vec::new();
    let mut index = |p: [u32; 3]| {
        points.iter().position(|q| *q == p).unwrap_or_else(|| {
            points.push(p);
            points.len() - 1
        })
    };
    for axis in 0..3 {
        for far in [false, true] {
            for i in 0..n {
                for j in 0..n {
                    let corner = |di: u32, dj: u32| {
                        let mut p = [0; 3];
                        p[axis] = if far { n } else { 0 };
                        p[(axis + 1) % 3] = i + di;
                        p[(axis + 2) % 3] = j + dj;
                        p
                    };
                    let ring = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)].map(&mut index);
                    let [a, b, c, d] = ring;
                    quads.push(if far { [a, b, c, d] } else { [a, d, c, b] });
                }
            }
        }
    }
    let mut text = format!(
        "ply\nformat ascii 1.0\ncomment a box of quads\nelement vertex {}\nproperty float x\nproperty float y\n\
         property float z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        points.len(),
        quads.len()
    );
    // Writing to a String cannot fail.
    for [x, y, z] in &points {
        let _ = writeln!(text, "{} {} {}", f64::from(*x) / 4.0, f64::from(*y) / 4.0, f64::from(*z) / 8.0);
    }
    for [a, b, c, d] in &quads {
        let _ = writeln!(text, "4 {a} {b} {c} {d}");
    }
    text
}

fn single_stl() -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    let title = b"one triangle, binary STL";
    bytes[..title.len()].copy_from_slice(title);
    bytes.extend(1_u32.to_le_bytes());
    for v in [[0.0_f32, 0.0, 1.0], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] {
        bytes.extend(v.iter().flat_map(|c| c.to_le_bytes()));
    }
    bytes.extend(0_u16.to_le_bytes());
    bytes
}

/// One cube mesh drawn by two nodes: one moved, one turned by a quarter, scaled and hung below a moved parent.
fn cube_glb() -> Vec<u8> {
    let mut bin = Vec::new();
    for i in 0..8_u8 {
        for axis in 0..3 {
            let c = if i >> axis & 1 == 1 { 0.5_f32 } else { -0.5 };
            bin.extend(c.to_le_bytes());
        }
    }
    let quads: [[u16; 4]; 6] =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    for [a, b, c, d] in quads {
        bin.extend([a, b, c, a, c, d].iter().flat_map(|v| v.to_le_bytes()));
    }
    let mut json = concat!(
        r#"{"asset":{"version":"2.0","generator":"facetree xtask"},"scene":0,"scenes":[{"nodes":[0,1]}],"#,
        r#""nodes":[{"name":"near","mesh":0,"translation":[2,0,0]},"#,
        r#"{"name":"far","translation":[-2,1,0],"children":[2]},"#,
        r#"{"name":"turned","mesh":0,"rotation":[0,0.7071067811865476,0,0.7071067811865476],"scale":[2,1,0.5]}],"#,
        r#""meshes":[{"name":"cube","primitives":[{"attributes":{"POSITION":0},"indices":1,"mode":4}]}],"#,
        r#""accessors":[{"bufferView":0,"componentType":5126,"count":8,"type":"VEC3","min":[-0.5,-0.5,-0.5],"max":[0.5,0.5,0.5]},"#,
        r#"{"bufferView":1,"componentType":5123,"count":36,"type":"SCALAR"}],"#,
        r#""bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":96,"target":34962},"#,
        r#"{"buffer":0,"byteOffset":96,"byteLength":72,"target":34963}],"buffers":[{"byteLength":168}]}"#
    )
    .as_bytes()
    .to_vec();
    while !json.len().is_multiple_of(4) {
        json.push(b' ');
    }
    let total = 12 + 8 + json.len() + 8 + bin.len();
    let mut glb = Vec::with_capacity(total);
    glb.extend(b"glTF");
    glb.extend(2_u32.to_le_bytes());
    glb.extend((total as u32).to_le_bytes());
    glb.extend((json.len() as u32).to_le_bytes());
    glb.extend(b"JSON");
    glb.extend(json);
    glb.extend((bin.len() as u32).to_le_bytes());
    glb.extend(b"BIN\0");
    glb.extend(bin);
    glb
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::topology::Topology;

    #[test]
    fn moebius_has_one_rim_and_a_seam() {
        let t = Topology::of(&moebius(48, 6));
        assert_eq!(t.components, 1);
        // Consistent winding is impossible on a band with one side: six edges see the same direction twice.
        assert_eq!(t.repeated_directed_edges, 6);
        assert_eq!(t.edges_with_three_or_more_faces, 0);
    }

    #[test]
    fn three_sheets_share_their_edges() {
        let t = Topology::of(&three_sheets(4));
        assert_eq!((t.components, t.edges_with_three_or_more_faces), (1, 4));
    }

    #[test]
    fn the_glb_lengths_agree() {
        let glb = cube_glb();
        let word = |at: usize| u32::from_le_bytes([glb[at], glb[at + 1], glb[at + 2], glb[at + 3]]) as usize;
        assert_eq!(word(8), glb.len());
        assert_eq!(word(12) % 4, 0);
        assert_eq!(20 + word(12) + 8 + word(20 + word(12)), glb.len());
    }
}
