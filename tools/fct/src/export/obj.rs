//! Wavefront OBJ.

use super::mesh::Mesh;
use std::io::{self, Write};

/// Writes `mesh`. Numbers have as many digits as it takes to read the same number again; colours follow the
/// coordinates, 0 to 1, without alpha, as most programs that know them expect. The
/// tree's groups become objects, with their names. `step` is called for each vertex and each triangle.
pub(crate) fn write(mesh: &Mesh, out: &mut impl Write, step: &mut dyn FnMut()) -> io::Result<()> {
    writeln!(out, "# written by fct {}", env!("CARGO_PKG_VERSION"))?;
    for corner in mesh.corners() {
        step();
        if mesh.is_at_origin() {
            let [x, y, z] = corner.position;
            write!(out, "v {x} {y} {z}")?;
        } else {
            let [x, y, z] = mesh.absolute(corner.position);
            write!(out, "v {x} {y} {z}")?;
        }
        if let Some([r, g, b, _]) = corner.color {
            let [r, g, b] = [r, g, b].map(|c| f32::from(c) / 255.0);
            write!(out, " {r} {g} {b}")?;
        }
        writeln!(out)?;
    }
    for [x, y, z] in &mesh.buffers.normals {
        writeln!(out, "vn {x} {y} {z}")?;
    }
    let mut groups = mesh.groups.iter().peekable();
    for (i, triangle) in mesh.triangles().iter().enumerate() {
        step();
        if let Some((_, name)) = groups.next_if(|(start, _)| *start == i) {
            // A name ends at the first space.
            let word = |c: char| if c.is_whitespace() || c.is_control() { '_' } else { c };
            let name: String = name.chars().map(word).collect();
            writeln!(out, "o {}", if name.is_empty() { "unnamed" } else { &name })?;
        }
        // Indices count from 1.
        let [a, b, c] = triangle.map(|v| u64::from(v) + 1);
        if !mesh.buffers.normals.is_empty() {
            writeln!(out, "f {a}//{a} {b}//{b} {c}//{c}")?;
        } else {
            writeln!(out, "f {a} {b} {c}")?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(mesh: &Mesh) -> String {
        let mut bytes = Vec::new();
        write(mesh, &mut bytes, &mut || ()).unwrap();
        String::from_utf8(bytes).unwrap()
    }

    #[test]
    fn numbers_come_back_and_indices_count_from_one() {
        let mut mesh = Mesh::default();
        mesh.buffers.positions.extend([[0.1, -2.5, 3e-7], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        mesh.buffers.colors.extend([[255, 0, 51, 9]; 3]);
        mesh.buffers.indices.extend([2, 0, 1]);
        let plain = text(&mesh);
        assert!(plain.contains("v 0.1 -2.5 0.0000003 1 0 0.2\n"), "{plain}");
        assert!(plain.ends_with("f 3 1 2\n"), "{plain}");

        mesh.buffers.normals = vec![[0.0, 0.0, 1.0]; 3];
        mesh.origin = [4e6, 0.0, 0.0];
        let moved = text(&mesh);
        assert!(moved.contains("v 4000001 0 0 "), "{moved}");
        assert!(!moved.contains("o "), "{moved}");
        mesh.groups = vec![(0, "left wing".to_owned())];
        assert!(text(&mesh).contains("vn 0 0 1\no left_wing\nf 3//3"), "{}", text(&mesh));
        assert!(moved.contains("vn 0 0 1\n") && moved.ends_with("f 3//3 1//1 2//2\n"), "{moved}");
    }
}
