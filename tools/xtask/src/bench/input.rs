//! The meshes to measure with, as every program of the benches is given them: welded, without what has no area.

use std::error::Error;
use std::path::{Path, PathBuf};

use fcbuild::import::{ImportOptions, Positions, import};
use rayon::prelude::*;

use crate::data::ply_out::Mesh;

/// The scans of the Stanford repository that the figures are about.
const SCANS: [&str; 3] = ["bunny.ply", "armadillo.ply", "dragon.ply"];

/// The samples of this project.
const SAMPLES: [&str; 3] = ["sculpture.ply", "terrain.ply", "parts.ply"];

/// A mesh file and what is in it.
#[derive(Debug)]
pub(crate) struct Input {
    /// The file's name without folder and extension.
    pub(crate) name: String,
    /// Its surface: equal positions joined, no unused vertex, no face twice or with a corner twice.
    pub(crate) mesh: Mesh,
    /// Whether every edge has a face on both sides.
    pub(crate) closed: bool,
}

impl Input {
    /// Reads a mesh as `fcbuild` does and welds it by code of its own, so that a lost face is found.
    ///
    /// Positions in double precision are taken relative to `origin`.
    ///
    /// # Errors
    /// When the file cannot be read as a mesh, or holds no face.
    pub(crate) fn read(path: &Path, origin: [f64; 3]) -> Result<Input, Box<dyn Error>> {
        let options = ImportOptions { max_faces: u64::from(u32::MAX >> 2), progress: &|_, _| {} };
        let soup = import(path, &options)?;
        let positions: Vec<[f32; 3]> = match soup.positions {
            Positions::F32(positions) => positions,
            Positions::F64(positions) => {
                positions.iter().map(|p| [0, 1, 2].map(|k| (p[k] - origin[k]) as f32)).collect()
            }
        };
        let mesh = without_doubles(weld(&positions, &soup.triangles));
        if mesh.faces.is_empty() {
            return Err(format!("{}: no face is left to measure; choose another mesh", path.display()).into());
        }
        let name = path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
        Ok(Input { closed: open_edges(&mesh) == 0, name, mesh })
    }
}

/// The meshes named, or the samples and the scans of the folder; the samples alone without one.
///
/// # Errors
/// When a scan is not in the folder.
pub(crate) fn paths(named: &[PathBuf], scans: Option<&Path>) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    if !named.is_empty() {
        return Ok(named.to_vec());
    }
    let home = super::workspace().join("data");
    let mut paths: Vec<PathBuf> = SAMPLES.iter().map(|name| home.join(name)).collect();
    if let Some(folder) = scans {
        for name in SCANS {
            let path = folder.join(name);
            if !path.is_file() {
                return Err(format!(
                    "{}: no such file; --scans names the folder of the scans",
                    path.display()
                )
                .into());
            }
            paths.push(path);
        }
    }
    Ok(paths)
}

/// The triangles over positions that occur once; without triangles that then have a corner twice.
///
/// Copies of a vertex that a program made along a seam become one again.
pub(crate) fn weld(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Mesh {
    let bits = |v: u32| positions[v as usize].map(|x| (x + 0.0).to_bits());
    let mut order: Vec<u32> = (0..positions.len() as u32).collect();
    order.par_sort_unstable_by_key(|v| (bits(*v), *v));
    let mut first = vec![0_u32; positions.len()];
    for run in order.chunk_by(|a, b| bits(*a) == bits(*b)) {
        for v in run {
            first[*v as usize] = run[0];
        }
    }
    let faces = triangles
        .iter()
        .map(|t| t.map(|v| first[v as usize]))
        .filter(|[a, b, c]| a != b && b != c && c != a)
        .collect();
    Mesh { positions: positions.to_vec(), faces }.drop_unused()
}

/// Keeps the first of the faces that have the same corners in the same direction.
fn without_doubles(mesh: Mesh) -> Mesh {
    let mut order: Vec<([u32; 3], u32)> =
        (0..).zip(&mesh.faces).map(|(i, f)| (lowest_first(*f), i)).collect();
    order.par_sort_unstable();
    order.dedup_by_key(|(face, _)| *face);
    order.par_sort_unstable_by_key(|(_, i)| *i);
    let faces = order.iter().map(|(_, i)| mesh.faces[*i as usize]).collect();
    Mesh { faces, ..mesh }.drop_unused()
}

fn lowest_first<T: Ord>(mut face: [T; 3]) -> [T; 3] {
    let lowest = (1..3).fold(0, |best, k| if face[k] < face[best] { k } else { best });
    face.rotate_left(lowest);
    face
}

/// Whether two meshes have the same faces at the same positions, in whatever order.
pub(crate) fn same_faces(a: &Mesh, b: &Mesh) -> bool {
    let faces = |mesh: &Mesh| {
        let bits = |v: u32| mesh.positions[v as usize].map(|x| (x + 0.0).to_bits());
        let mut faces: Vec<[[u32; 3]; 3]> = mesh.faces.iter().map(|f| lowest_first(f.map(bits))).collect();
        faces.par_sort_unstable();
        faces.dedup();
        faces
    };
    faces(a) == faces(b)
}

/// Directed edges that no opposite edge matches: zero for a closed surface, whatever else is odd about it.
pub(crate) fn open_edges(mesh: &Mesh) -> u64 {
    let mut edges: Vec<(u32, u32, bool)> = Vec::with_capacity(3 * mesh.faces.len());
    for [a, b, c] in &mesh.faces {
        edges.extend([(a, b), (b, c), (c, a)].map(|(u, v)| (*u.min(v), *u.max(v), u > v)));
    }
    edges.par_sort_unstable();
    let unmatched = |run: &[(u32, u32, bool)]| {
        let backward = run.iter().filter(|e| e.2).count();
        backward.abs_diff(run.len() - backward) as u64
    };
    edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)).map(unmatched).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tetrahedron whose faces share no vertex, with a face without area and one that is there twice.
    fn apart() -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
        let corner = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-0.0, 0.0, 1.0]];
        let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3], [3, 1, 2], [0, 1, 0]];
        let positions = faces.iter().flatten().map(|v: &usize| corner[*v]).collect();
        (positions, (0..6).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
    }

    #[test]
    fn a_soup_becomes_a_closed_mesh() {
        let (positions, triangles) = apart();
        let mesh = without_doubles(weld(&positions, &triangles));
        assert_eq!((mesh.positions.len(), mesh.faces.len(), open_edges(&mesh)), (4, 4, 0));
        assert_eq!(open_edges(&Mesh { positions: positions.clone(), faces: triangles[..4].to_vec() }), 12);
        let mut fewer = mesh.clone();
        fewer.faces.pop();
        assert_eq!(open_edges(&fewer), 3);
    }

    #[test]
    fn faces_are_the_same_in_any_order_but_not_in_any_place() {
        let (positions, triangles) = apart();
        let mesh = weld(&positions, &triangles);
        let mut other = mesh.clone();
        other.faces.reverse();
        other.faces.iter_mut().for_each(|f| f.rotate_left(1));
        assert!(same_faces(&mesh, &other));
        let mut turned = mesh.clone();
        turned.faces[0].swap(0, 1);
        assert!(!same_faces(&mesh, &turned));
        let mut moved = mesh.clone();
        moved.positions[0][0] = f32::EPSILON;
        assert!(!same_faces(&mesh, &moved));
    }
}
