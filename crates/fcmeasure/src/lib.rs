//! How far two triangle meshes lie apart, and how far their colours, by samples of both and the nearest triangles of
//! the other.
//!
//! A bound promises that no point is farther off; this says how far points are. Samples are the same on every run and
//! sums have one order, so a figure does not depend on the number of threads.
//!
//! # Units
//! Lengths are those of the meshes. Opaque black and white are a colour distance of 1 apart.

mod color;
mod distance;
mod nearest;
mod sampling;

pub use distance::{Distance, Reference};
pub use nearest::{Hit, Nearest, squared_distance};
pub use sampling::sample;

use color::Color;
use glam::Vec3;

/// A mesh as it is looked at: its indices are in range, its positions finite.
#[derive(Clone, Copy, Debug)]
pub struct Surface<'a> {
    /// The vertices.
    pub positions: &'a [[f32; 3]],
    /// Three vertices each.
    pub faces: &'a [[u32; 3]],
    /// The colour of each vertex; empty if there are none.
    pub colors: &'a [[u8; 4]],
}

impl Surface<'_> {
    fn corners(&self, face: &[u32; 3]) -> [Vec3; 3] {
        face.map(|v| self.positions.get(v as usize).map_or(Vec3::NAN, |p| Vec3::from_array(*p)))
    }

    /// The colours of the corners, if there are any.
    fn colors(&self, face: &[u32; 3]) -> Option<[Color; 3]> {
        let [a, b, c] = face.map(|v| self.colors.get(v as usize).copied().map(Color::of));
        Some([a?, b?, c?])
    }
}

/// Meshes for tests.
#[cfg(test)]
mod tests {
    use super::Surface;
    use glam::DVec3;

    #[derive(Debug, Default)]
    pub(crate) struct Mesh {
        pub(crate) positions: Vec<[f32; 3]>,
        pub(crate) faces: Vec<[u32; 3]>,
        pub(crate) colors: Vec<[u8; 4]>,
    }

    impl Mesh {
        pub(crate) fn surface(&self) -> Surface<'_> {
            Surface { positions: &self.positions, faces: &self.faces, colors: &self.colors }
        }

        pub(crate) fn vertex(&mut self, p: DVec3) -> u32 {
            self.positions.push(p.as_vec3().to_array());
            self.positions.len() as u32 - 1
        }

        pub(crate) fn quad(&mut self, [a, b, c, d]: [u32; 4]) {
            self.faces.extend([[a, b, c], [a, c, d]]);
        }

        /// A grid of `n` by `n` squares over the unit square, at heights of a function.
        pub(crate) fn grid(n: u32, height: impl Fn(f64, f64) -> f64) -> Mesh {
            let mut mesh = Mesh::default();
            for (j, i) in (0..=n).flat_map(|j| (0..=n).map(move |i| (j, i))) {
                let (x, y) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
                mesh.vertex(DVec3::new(x, y, height(x, y)));
            }
            for (j, i) in (0..n).flat_map(|j| (0..n).map(move |i| (j, i))) {
                let at = j * (n + 1) + i;
                mesh.quad([at, at + 1, at + n + 2, at + n + 1]);
            }
            mesh
        }
    }
}
