//! The meshes that the figures show, and their trees.

use super::modes::{self, Mode};
use super::view::View;
use fcbuild::BuildOptions;
use fcbuild::import::{Group, ImportOptions, Positions, Soup, Tally, import};
use fcbuild::mesh::{Components, Mesh, Weld};
use fcbuild::partition::{self, Hierarchy};
use fct::Tree;
use glam::DVec3;
use std::error::Error;
use std::path::Path;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// A mesh, ready to be split.
#[derive(Debug)]
pub(crate) struct Model {
    /// For file names and tables.
    pub(crate) name: String,
    /// Where from pictures show it.
    pub(crate) view: View,
    /// As the file gives it.
    soup: Soup,
    /// As the builder sees it.
    pub(crate) mesh: Mesh,
    /// Its connected pieces.
    pub(crate) components: Components,
    /// Square of the box's diagonal, in square normal units.
    square_diagonal: f64,
    own_modes: OnceLock<Vec<Mode>>,
}

impl Model {
    /// Reads a mesh file.
    ///
    /// # Errors
    /// Those of the importer and the builder; they name the file.
    pub(crate) fn read(path: &Path) -> Result<Model, Box<dyn Error>> {
        let name = path.file_stem().map_or_else(|| "mesh".into(), |s| s.to_string_lossy()).into_owned();
        let soup = import(path, &ImportOptions { max_faces: u64::MAX, progress: &|_, _| {} })?;
        Model::new(&name, soup)
    }

    /// From triangles in memory.
    ///
    /// # Errors
    /// Those of the builder.
    pub(crate) fn of_triangles(
        name: &str,
        positions: Vec<[f32; 3]>,
        faces: Vec<[u32; 3]>,
    ) -> Result<Model, Box<dyn Error>> {
        let count = faces.len();
        let soup = Soup {
            positions: Positions::F32(positions),
            triangles: faces,
            normals: None,
            colors: None,
            groups: vec![Group { name: name.to_owned(), triangles: 0..count }],
            tally: Tally { polygons_in: count as u64, faces_in: count as u64, ..Tally::default() },
        };
        Model::new(name, soup)
    }

    fn new(name: &str, soup: Soup) -> Result<Model, Box<dyn Error>> {
        let mesh = Mesh::from_soup(soup.clone(), Weld::Exact)?;
        let components = Components::of(&mesh);
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for v in mesh.faces.as_flattened() {
            let p = mesh.positions[*v as usize].as_dvec3();
            (low, high) = (low.min(p), high.max(p));
        }
        Ok(Model {
            name: name.to_owned(),
            view: view_of(name),
            soup,
            mesh,
            components,
            square_diagonal: (high - low).length_squared(),
            own_modes: OnceLock::new(),
        })
    }

    /// Faces that the builder kept.
    pub(crate) fn faces(&self) -> usize {
        self.mesh.faces.len()
    }

    /// Corners of a face, in normal units.
    pub(crate) fn corners(&self, face: usize) -> [DVec3; 3] {
        self.mesh.faces[face].map(|v| self.mesh.positions[v as usize].as_dvec3())
    }

    /// Vertex normals at the corners of a face.
    pub(crate) fn normals(&self, face: usize) -> [DVec3; 3] {
        self.mesh.faces[face].map(|v| self.mesh.normals[v as usize].as_dvec3())
    }

    /// Area of a face, in square normal units.
    pub(crate) fn area(&self, face: usize) -> f64 {
        let [a, b, c] = self.corners(face);
        0.5 * (b - a).cross(c - a).length()
    }

    /// A square of a length in normal units, per square of the box's diagonal: a number without unit, the same for
    /// a model of any size.
    pub(crate) fn per_square_diagonal(&self, square: f64) -> f64 {
        square / self.square_diagonal
    }

    /// A length in normal units, per diagonal.
    pub(crate) fn per_diagonal(&self, length: f64) -> f64 {
        length / self.square_diagonal.sqrt()
    }

    /// The binary tree of clusters.
    pub(crate) fn hierarchy(&self, mode: Mode) -> Hierarchy {
        partition::partition(&self.mesh, &self.components, mode.split, None, &|_| {})
    }

    /// The modes that make a tree of their own of this model, in the order of figures.
    ///
    /// What would become too deep by merging is split as the paper does it; such a tree would say nothing of merging.
    pub(crate) fn modes(&self) -> &[Mode] {
        self.own_modes.get_or_init(|| {
            let paper = self.hierarchy(modes::PAPER);
            let falls_back = |mode: &Mode| {
                mode.merges() && {
                    let tree = self.hierarchy(*mode);
                    tree.order == paper.order && tree.splits == paper.splits
                }
            };
            modes::ALL.iter().copied().filter(|m| !falls_back(m)).collect()
        })
    }

    /// Whether a mode makes a tree of its own.
    pub(crate) fn has(&self, mode: Mode) -> bool {
        self.modes().iter().any(|m| m.split == mode.split)
    }

    /// How long the partition takes, from a welded mesh to a tree of clusters.
    pub(crate) fn partition_time(&self, mode: Mode) -> Duration {
        let start = Instant::now();
        let hierarchy = self.hierarchy(mode);
        let time = start.elapsed();
        drop(hierarchy);
        time
    }

    /// The whole tree, through the file format.
    ///
    /// # Errors
    /// Those of the builder and of the file format.
    pub(crate) fn tree(&self, mode: Mode) -> Result<Tree, Box<dyn Error>> {
        let options = BuildOptions { split: mode.split, ..BuildOptions::default() };
        let built = fcbuild::build(self.soup.clone(), &options)?;
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("tree.fct");
        fct::write(&path, &built.data(), &fct::WriteOptions { overwrite: true, source_id: 0 })?;
        // Not mapped: the file goes away with the folder.
        Ok(Tree::from_bytes(std::fs::read(&path)?)?)
    }
}

/// Models stand upright along Y, and each has a side that it is known by.
fn view_of(name: &str) -> View {
    View::from(match name {
        "bunny" => [0.1, 0.22, 1.0],
        "dragon" => [0.12, 0.2, 1.0],
        "armadillo" => [-0.25, 0.15, -1.0],
        _ => [-0.42, 0.32, 1.0],
    })
}
