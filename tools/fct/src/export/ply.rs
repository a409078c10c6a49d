//! Binary little-endian PLY.

use super::mesh::Mesh;
use std::io::{self, Write};

/// Writes `mesh`. Coordinates are `double` when the tree has an origin of its own and `float`, as stored, when not.
/// `step` is called for each vertex and each triangle.
pub(crate) fn write(mesh: &Mesh, out: &mut impl Write, step: &mut dyn FnMut()) -> io::Result<()> {
    let number = if mesh.is_at_origin() { "float" } else { "double" };
    writeln!(
        out,
        "ply\nformat binary_little_endian 1.0\ncomment written by fct {}",
        env!("CARGO_PKG_VERSION")
    )?;
    writeln!(out, "element vertex {}", mesh.buffers.positions.len())?;
    for axis in ["x", "y", "z"] {
        writeln!(out, "property {number} {axis}")?;
    }
    if !mesh.buffers.normals.is_empty() {
        out.write_all(b"property float nx\nproperty float ny\nproperty float nz\n")?;
    }
    if !mesh.buffers.colors.is_empty() {
        for channel in ["red", "green", "blue", "alpha"] {
            writeln!(out, "property uchar {channel}")?;
        }
    }
    writeln!(
        out,
        "element face {}\nproperty list uchar int vertex_indices\nend_header",
        mesh.triangles().len()
    )?;
    for corner in mesh.corners() {
        step();
        if mesh.is_at_origin() {
            write_numbers(out, corner.position, f32::to_le_bytes)?;
        } else {
            write_numbers(out, mesh.absolute(corner.position), f64::to_le_bytes)?;
        }
        if let Some(normal) = corner.normal {
            write_numbers(out, normal, f32::to_le_bytes)?;
        }
        if let Some(color) = corner.color {
            out.write_all(&color)?;
        }
    }
    for triangle in mesh.triangles() {
        step();
        out.write_all(&[3])?;
        // Indices stay below 2^31, so the signed type that every reader knows holds them.
        write_numbers(out, *triangle, u32::to_le_bytes)?;
    }
    Ok(())
}

fn write_numbers<T, const N: usize>(
    out: &mut impl Write,
    numbers: [T; 3],
    bytes: impl Fn(T) -> [u8; N],
) -> io::Result<()> {
    out.write_all(numbers.map(bytes).as_flattened())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh(origin: [f64; 3]) -> Mesh {
        let mut mesh = Mesh { origin, ..Mesh::default() };
        mesh.buffers.positions.extend([[1.0, 2.0, 3.0]; 3]);
        mesh.buffers.normals.extend([[0.0, 0.0, 1.0]; 3]);
        mesh.buffers.colors.extend([[1, 2, 3, 4]; 3]);
        mesh.buffers.indices.extend([0, 1, 2]);
        mesh
    }

    fn body_len(mesh: &Mesh) -> usize {
        let mut bytes = Vec::new();
        write(mesh, &mut bytes, &mut || ()).unwrap();
        let end = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
        bytes.len() - end
    }

    #[test]
    fn records_have_the_declared_sizes() {
        assert_eq!(body_len(&mesh([0.0; 3])), 3 * (12 + 12 + 4) + 13);
        assert_eq!(body_len(&mesh([5e5, 0.0, 0.0])), 3 * (24 + 12 + 4) + 13);
    }

    #[test]
    fn the_origin_is_added() {
        let mut bytes = Vec::new();
        write(&mesh([5e5, 0.0, 0.0]), &mut bytes, &mut || ()).unwrap();
        let end = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
        assert_eq!(bytes[end..end + 8], 500_001.0_f64.to_le_bytes());
    }
}
