//! The closed sculpture: field, polygons, even triangles.

use glam::DVec3;

use super::DataError;
use super::field::{Field, LOW, SIZE};
use super::halfedge::{Surface, area_normal};
use super::ply_out::Mesh;
use super::polygonise::polygonise;
use super::relax::relax;

/// Faces of the committed sculpture.
pub(crate) const FACES: u64 = 70_000;

/// Comment in the file.
pub(crate) const COMMENT: &str = "elephant with a pavilion, polygonised from an implicit surface";

/// Faces times squared edge length over area, as [`relax`] leaves them; measured.
const DENSITY: f64 = 2.5;

/// Step of the grid that only measures the area.
const COARSE: f64 = 0.05;

/// Grid step over wanted edge length: fine enough that nearly every edge starts too short.
const GRID: f64 = 0.85;

/// A closed surface of about `faces` faces.
///
/// # Errors
/// [`DataError::Open`] when the grid missed a part of the surface.
pub(crate) fn sculpture(faces: u64) -> Result<Mesh, DataError> {
    let rough = Field::new(COARSE);
    let (points, triangles) = polygonise(&|p| rough.value(p), LOW, SIZE, COARSE);
    let area: f64 = triangles
        .iter()
        .map(|f| {
            let [a, b, c] = f.map(|v: u32| points[v as usize]);
            0.5 * area_normal(a, b, c).length()
        })
        .sum();
    let length = (area * DENSITY / faces as f64).sqrt();
    let field = Field::new(length);
    let value = |p: DVec3| field.value(p);
    let (points, triangles) = polygonise(&value, LOW, SIZE, GRID * length);
    let surface = Surface::new(points, &triangles).map_err(|edges| DataError::Open { edges })?;
    drop(triangles);
    let (points, faces) = relax(surface, &value, length).into_faces();
    Ok(Mesh { positions: points.iter().map(|p| p.as_vec3().to_array()).collect(), faces })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::data::ply_out::write_to;
    use crate::data::topology::Topology;

    fn bytes(mesh: &Mesh) -> Vec<u8> {
        let mut out = Vec::new();
        write_to(&mut out, mesh, &[], COMMENT).unwrap();
        out
    }

    /// The committed file is what the code writes, and it is what its README promises.
    #[test]
    fn the_committed_sculpture_is_reproduced_closed_and_of_one_piece() {
        let mesh = sculpture(FACES).unwrap();
        let found =
            std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/sculpture.ply")).unwrap();
        // assert_eq would print megabytes.
        assert!(found == bytes(&mesh), "data/sculpture.ply: run `cargo xtask data` and commit the result");
        let t = Topology::of(&mesh);
        assert!(t.is_closed(), "{t:?}");
        assert_eq!(t.components, 1);
        // Genus 7: the legs and the columns of the pavilion make six of the handles.
        assert_eq!(t.euler, 2 - 2 * 7);
        assert!(mesh.faces.len().abs_diff(FACES as usize) < 2_000, "{}", mesh.faces.len());
    }

    #[test]
    fn the_bytes_do_not_depend_on_the_threads() {
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| bytes(&sculpture(5_000).unwrap()))
        };
        let one = with(1);
        assert!(one == with(1) && one == with(3));
    }
}
