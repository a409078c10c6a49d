//! Other programs that do the same job, on the same mesh in the same run.

mod cluster_lod;
mod meshlab;
mod simplify;

pub(crate) use cluster_lod::{ClusterLod, build_only};
pub(crate) use meshlab::{MeshLab, Nexus};
pub(crate) use simplify::{keep_colors, keep_vertices, move_vertices};

use crate::data::ply_out::Mesh;

/// The positions as meshoptimizer wants them; `None` when the mesh has none.
fn positions(mesh: &Mesh) -> Option<meshopt::VertexDataAdapter<'_>> {
    let bytes = meshopt::typed_to_bytes(&mesh.positions);
    meshopt::VertexDataAdapter::new(bytes, size_of::<[f32; 3]>(), 0)
        .ok()
        .filter(|_| !mesh.positions.is_empty())
}

/// A mesh of some triangles over the positions of another.
fn over(positions: &[[f32; 3]], indices: &[u32]) -> Mesh {
    Mesh { positions: positions.to_vec(), faces: indices.as_chunks::<3>().0.to_vec() }.drop_unused()
}
