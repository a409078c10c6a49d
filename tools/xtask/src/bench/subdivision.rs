//! Large meshes in little time: a sculpture whose faces are cut in four again and again.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::data::noise;
use crate::data::ply_out::Mesh;
use crate::data::sculpture::sculpture;
use crate::data::{DataError, short};

/// The sculpture that is cut has at most so many faces; a larger one takes longer to make, and looks smoother.
const BASE: u64 = 80_000;

/// New vertices are off the smooth surface by up to this share of an edge, as those of a scan are: without it every
/// four faces were nearly flat and easier than what people have.
const ROUGHNESS: f64 = 0.04;

/// A closed mesh of about `faces` faces, the same on every run.
///
/// # Errors
/// As [`sculpture`].
pub(crate) fn large(faces: u64) -> Result<(String, Mesh), DataError> {
    let (mut base, mut cuts) = (faces, 0);
    while base > BASE {
        (base, cuts) = (base.div_ceil(4), cuts + 1);
    }
    let mesh = (0..cuts).fold(sculpture(base)?, |mesh, level| subdivide(&mesh, level));
    Ok((format!("sculpture-{}", short(faces)), mesh))
}

/// Every face in four; the middle of an edge is put on the arc that the normals at its ends ask for.
fn subdivide(mesh: &Mesh, level: u64) -> Mesh {
    let at = |v: u32| Vec3::from_array(mesh.positions[v as usize]).as_dvec3();
    let mut normals = vec![DVec3::ZERO; mesh.positions.len()];
    for f in &mesh.faces {
        let [a, b, c] = f.map(at);
        let n = (b - a).cross(c - a);
        f.iter().for_each(|v| normals[*v as usize] += n);
    }
    normals.par_iter_mut().for_each(|n| *n = n.normalize_or_zero());
    let edge = |a: u32, b: u32| (a.min(b), a.max(b));
    let mut edges: Vec<(u32, u32)> =
        mesh.faces.iter().flat_map(|[a, b, c]| [edge(*a, *b), edge(*b, *c), edge(*c, *a)]).collect();
    edges.par_sort_unstable();
    edges.dedup();
    let middles: Vec<[f32; 3]> = edges
        .par_iter()
        .map(|(a, b)| {
            let ([p, q], [m, n]) = ([*a, *b].map(at), [*a, *b].map(|v| normals[v as usize]));
            let (along, normal) = (q - p, (m + n).normalize_or_zero());
            // A circle's arc over a chord of length d, whose normals differ by n - m along it, rises by d (n - m) / 8.
            let rise = along.dot(n - m) / 8.0;
            let rough = noise::unit(i64::from(*a), i64::from(*b), 0, level) - 0.5;
            let middle = (p + q) / 2.0 + normal * (rise + rough * 2.0 * ROUGHNESS * along.length());
            middle.as_vec3().to_array()
        })
        .collect();
    let first = mesh.positions.len() as u32;
    // Every edge was put into the list above.
    let middle = |a: u32, b: u32| first + edges.binary_search(&edge(a, b)).unwrap_or(0) as u32;
    let faces = mesh
        .faces
        .par_iter()
        .flat_map_iter(|[a, b, c]| {
            let (ab, bc, ca) = (middle(*a, *b), middle(*b, *c), middle(*c, *a));
            [[*a, ab, ca], [ab, *b, bc], [ca, bc, *c], [ab, bc, ca]]
        })
        .collect();
    Mesh { positions: mesh.positions.iter().copied().chain(middles).collect(), faces }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::distance::Reference;
    use crate::data::topology::Topology;

    #[test]
    fn a_cut_mesh_has_four_times_the_faces_and_is_as_closed_and_near() {
        let mesh = sculpture(5_000).unwrap();
        let fine = subdivide(&mesh, 0);
        assert_eq!(fine.faces.len(), 4 * mesh.faces.len());
        let topology = Topology::of(&fine);
        assert!(topology.is_closed(), "{topology:?}");
        assert_eq!(topology.euler, Topology::of(&mesh).euler);
        // A surface of 20,000 faces of the same field: the arcs must not lead away from it.
        let truth = Reference::new(&sculpture(40_000).unwrap(), 20_000);
        let [coarse, fine] = [&mesh, &fine].map(|m| truth.distance(m).rms);
        assert!(fine < 1.1 * coarse, "{fine} {coarse}");
    }
}
