//! meshoptimizer's simplification by quadrics, to a number of triangles.

use meshopt::{
    SimplifyOptions, SimplifyVertex, VertexDataAdapter, simplify, simplify_with_attributes_and_locks,
    simplify_with_update,
};

use super::{over, positions};
use crate::data::ply_out::Mesh;

/// Relative to the mesh, and never reached: the number of triangles decides alone.
const ANY_ERROR: f32 = 1e9;

/// Simplifies to about so many triangles with vertices of the input; borders are free to move.
pub(crate) fn keep_vertices(mesh: &Mesh, triangles: u64) -> Mesh {
    let Some(vertices) = positions(mesh) else { return Mesh::default() };
    let indices = mesh.faces.as_flattened();
    let target = triangles as usize * 3;
    let kept = simplify(indices, &vertices, target, ANY_ERROR, SimplifyOptions::None, None);
    over(&mesh.positions, &kept)
}

/// The same, where colours count: a full step of a channel as so large a part of the mesh. Its faces, over the same
/// vertices.
pub(crate) fn keep_colors(
    at: &[[f32; 3]],
    faces: &[[u32; 3]],
    colors: &[[u8; 4]],
    weight: f32,
    triangles: u64,
) -> Vec<[u32; 3]> {
    let Ok(vertices) = VertexDataAdapter::new(meshopt::typed_to_bytes(at), size_of::<[f32; 3]>(), 0) else {
        return Vec::new();
    };
    let channels: Vec<[f32; 3]> = colors.iter().map(|c| [0, 1, 2].map(|i| f32::from(c[i]) / 255.0)).collect();
    let unlocked = vec![SimplifyVertex::None; at.len()];
    let kept = simplify_with_attributes_and_locks(
        faces.as_flattened(),
        &vertices,
        channels.as_flattened(),
        &[weight; 3],
        size_of::<[f32; 3]>(),
        &unlocked,
        triangles as usize * 3,
        ANY_ERROR,
        SimplifyOptions::None,
        None,
    );
    kept.as_chunks::<3>().0.to_vec()
}

/// The same with vertices moved to where the quadrics are least.
pub(crate) fn move_vertices(mesh: &Mesh, triangles: u64) -> Mesh {
    let mut indices = mesh.faces.as_flattened().to_vec();
    let mut moved = mesh.positions.clone();
    let count = simplify_with_update(
        &mut indices,
        &mut moved,
        &mut [],
        &[],
        0,
        None::<&[SimplifyVertex]>,
        triangles as usize * 3,
        ANY_ERROR,
        SimplifyOptions::None,
        None,
    );
    indices.truncate(count);
    over(&moved, &indices)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::distance::Reference;
    use crate::bench::input::open_edges;
    use crate::data::sculpture::sculpture;

    /// Both reach the number, stay closed, and moving helps; who got the arguments wrong would see it here.
    #[test]
    fn both_reach_the_number_and_moving_helps() {
        let mesh = sculpture(6_000).unwrap();
        let reference = Reference::new(&mesh, 20_000);
        let [kept, moved] = [keep_vertices(&mesh, 1_500), move_vertices(&mesh, 1_500)];
        for m in [&kept, &moved] {
            assert!((1_400..=1_500).contains(&m.faces.len()), "{}", m.faces.len());
            assert_eq!(open_edges(m), 0);
        }
        let of_input = |p: &[f32; 3]| mesh.positions.contains(p);
        assert!(kept.positions.iter().all(of_input) && !moved.positions.iter().all(of_input));
        let [kept, moved] = [&kept, &moved].map(|m| reference.distance(m).rms);
        assert!(0.0 < moved && moved < kept && kept < 100.0, "{moved} {kept}");
    }
}
