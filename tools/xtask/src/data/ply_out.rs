//! A triangle mesh and the binary PLY writer for it.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use super::DataError;

/// Triangles over shared vertices, as they are written.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Mesh {
    /// Positions, Y up.
    pub(crate) positions: Vec<[f32; 3]>,
    /// Counter-clockwise seen from outside.
    pub(crate) faces: Vec<[u32; 3]>,
}

impl Mesh {
    /// The mesh as it is measured.
    pub(crate) fn surface(&self) -> fcmeasure::Surface<'_> {
        fcmeasure::Surface { positions: &self.positions, faces: &self.faces, colors: &[] }
    }

    /// Adds a vertex and returns its index.
    pub(crate) fn vertex(&mut self, p: glam::DVec3) -> u32 {
        // The sample meshes stay far below 2^32 vertices.
        let index = self.positions.len() as u32;
        self.positions.push([p.x as f32, p.y as f32, p.z as f32]);
        index
    }

    /// Adds the two triangles of a quad given counter-clockwise, cut from `a` to `c`.
    pub(crate) fn quad(&mut self, a: u32, b: u32, c: u32, d: u32) {
        self.faces.push([a, b, c]);
        self.faces.push([a, c, d]);
    }

    /// The mesh without the vertices that no face uses, in the same order.
    pub(crate) fn drop_unused(self) -> Mesh {
        let mut place = vec![u32::MAX; self.positions.len()];
        for f in &self.faces {
            for v in f {
                place[*v as usize] = 0;
            }
        }
        let mut positions = Vec::with_capacity(self.positions.len());
        for (slot, p) in place.iter_mut().zip(&self.positions) {
            if *slot == 0 {
                *slot = positions.len() as u32;
                positions.push(*p);
            }
        }
        let faces = self.faces.iter().map(|f| f.map(|v| place[v as usize])).collect();
        Mesh { positions, faces }
    }

    /// Appends another mesh as separate pieces.
    pub(crate) fn append(&mut self, other: &Mesh) {
        let base = self.positions.len() as u32;
        self.positions.extend_from_slice(&other.positions);
        self.faces.extend(other.faces.iter().map(|f| f.map(|v| v + base)));
    }
}

/// Writes `mesh` as binary little-endian PLY with `float` positions and `uchar`/`int` lists.
///
/// `colors` are those of the vertices, or none.
pub(crate) fn write_to(
    out: &mut impl Write,
    mesh: &Mesh,
    colors: &[[u8; 3]],
    comment: &str,
) -> std::io::Result<()> {
    let channels = if colors.is_empty() {
        ""
    } else {
        "property uchar red\nproperty uchar green\nproperty uchar blue\n"
    };
    write!(
        out,
        "ply\nformat binary_little_endian 1.0\ncomment {comment}\nelement vertex {}\n\
         property float x\nproperty float y\nproperty float z\n{channels}element face {}\n\
         property list uchar int vertex_indices\nend_header\n",
        mesh.positions.len(),
        mesh.faces.len()
    )?;
    for (i, p) in mesh.positions.iter().enumerate() {
        for c in p {
            out.write_all(&c.to_le_bytes())?;
        }
        if let Some(color) = colors.get(i) {
            out.write_all(color)?;
        }
    }
    for f in &mesh.faces {
        out.write_all(&[3])?;
        for v in f {
            out.write_all(&v.to_le_bytes())?;
        }
    }
    Ok(())
}

/// Writes `mesh` to a file, buffered.
///
/// # Errors
/// [`DataError::Io`] with the path when the file cannot be created or written.
pub(crate) fn write_file(
    path: &Path,
    mesh: &Mesh,
    colors: &[[u8; 3]],
    comment: &str,
) -> Result<(), DataError> {
    let write = || {
        let mut out = BufWriter::with_capacity(1 << 20, File::create(path)?);
        write_to(&mut out, mesh, colors, comment)?;
        out.flush()
    };
    write().map_err(|source| DataError::io(path, source))
}
