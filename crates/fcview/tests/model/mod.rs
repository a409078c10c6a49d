//! A model for tests, made here: a bumpy torus as a tree of median splits, drawn at full resolution in every view.

#![allow(dead_code, reason = "each test file uses a part")]

use fcgeom::Cone;
use fct::{
    BoundingPolygonRecord, Child, ClusterData, Meta, NormalRecord, Packed, PlainClusters, TreeData,
    VertexRecord, WriteOptions,
};
use fcview::{Gpu, Model};
use glam::{DVec3, Vec3};
use std::path::Path;
use std::sync::Arc;

/// A device, or a failure that says what to install: a GPU test that passes unseen proves nothing.
pub(crate) fn gpu() -> Gpu {
    Gpu::headless().unwrap_or_else(|error| panic!("this test needs a graphics adapter: {error}"))
}

/// A torus of `2 * rings * sides` faces with bumps.
pub(crate) fn torus(rings: u32, sides: u32) -> Model {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("torus.fct");
    write_torus(&path, rings, sides);
    // The map outlives the file's name.
    let tree = fct::Tree::open(&path).expect("the torus opens");
    Model::new("torus", Arc::new(tree))
}

/// Writes the torus as a .fct file.
pub(crate) fn write_torus(path: &Path, rings: u32, sides: u32) {
    let mut positions = Vec::new();
    for i in 0..rings {
        for j in 0..sides {
            let u = std::f64::consts::TAU * f64::from(i) / f64::from(rings);
            let v = std::f64::consts::TAU * f64::from(j) / f64::from(sides);
            let r = 0.42 + 0.03 * (9.0 * u).sin() * (5.0 * v).cos();
            let p = DVec3::new((1.0 + r * v.cos()) * u.cos(), r * v.sin(), (1.0 + r * v.cos()) * u.sin());
            positions.push(p.as_vec3());
        }
    }
    let at = |i: u32, j: u32| (i % rings) * sides + j % sides;
    let mut faces = Vec::new();
    for i in 0..rings {
        for j in 0..sides {
            let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
            faces.push([a, b, c]);
            faces.push([a, c, d]);
        }
    }
    write(path, &positions, faces);
}

/// Writes any triangles as a tree. Vertices that no triangle uses are left out.
pub(crate) fn write(path: &Path, positions: &[Vec3], mut faces: Vec<[u32; 3]>) {
    let mut tree = PlainClusters::default();
    split(positions, &mut faces, &mut tree);
    let mut new_name = vec![None; positions.len()];
    for corner in faces.iter_mut().flatten() {
        let old = *corner as usize;
        *corner = *new_name[old].get_or_insert_with(|| {
            tree.positions.push(positions[old].to_array());
            tree.positions.len() as u32 - 1
        });
    }
    tree.faces = faces;
    let at = |v: u32| Vec3::from_array(tree.positions[v as usize]);
    let mut normals = vec![Vec3::ZERO; tree.positions.len()];
    for face in &tree.faces {
        for vertex in face {
            normals[*vertex as usize] += normal(&face.map(at));
        }
    }
    let normals: Vec<_> = normals.iter().map(|n| NormalRecord::encode(n.to_array())).collect();
    let places = || tree.positions.iter().copied().map(Vec3::from_array);
    let vertices: Vec<_> = tree
        .positions
        .iter()
        .map(|p| {
            let always = VertexRecord::eager(*p, f64::INFINITY, f64::INFINITY, ([0.0; 3], 0.0));
            always.expect("a sphere of no size fits")
        })
        .collect();
    let meta = Meta {
        faces_in: tree.faces.len() as u64,
        faces_kept: tree.faces.len() as u64,
        bounds_min: places().fold(Vec3::INFINITY, Vec3::min).to_array(),
        bounds_max: places().fold(Vec3::NEG_INFINITY, Vec3::max).to_array(),
        ..Meta::default()
    };
    let packed = Packed::new(&tree).expect("the tree can be packed");
    let mut data = TreeData {
        meta: &meta,
        clusters: &packed,
        vertices: &vertices,
        weld: &[],
        bounding_polygons: &[],
        normals: Some(&normals),
        colors: None,
        groups: &[],
        chunks: None,
    };
    let options = WriteOptions { overwrite: true, source_id: 0 };
    fct::write(path, &data, &options).expect("the tree is written");
    // Once more with the polygons, which are measured from the nodes as they are read.
    let polygons = polygons(&fct::Tree::open(path).expect("the tree opens"), &tree);
    data.bounding_polygons = &polygons;
    fct::write(path, &data, &options).expect("the tree is written");
}

fn normal([a, b, c]: &[Vec3; 3]) -> Vec3 {
    (b - a).cross(c - a)
}

/// Sorts a run of faces into the subtree of medians, nodes in preorder.
fn split(positions: &[Vec3], faces: &mut [[u32; 3]], tree: &mut PlainClusters) {
    if faces.len() < 2 {
        return;
    }
    let corners = |face: &[u32; 3]| face.map(|v| positions[v as usize]);
    let points: Vec<Vec3> = faces.iter().flat_map(corners).collect();
    let low = points.iter().copied().fold(Vec3::INFINITY, Vec3::min);
    let high = points.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
    let axis = (high - low).max_position();
    faces.sort_by(|a, b| {
        let key = |face| corners(face).iter().map(|p| p[axis]).sum::<f32>();
        key(a).total_cmp(&key(b)).then(a.cmp(b))
    });
    let cone = Cone::of_normals(faces.iter().map(|face| normal(&corners(face)).normalize_or_zero()));
    let left = faces.len() / 2;
    tree.left_faces.push(left as u32);
    tree.clusters.push(ClusterData {
        plane: [0.0; 3],
        offset: 0.0,
        bound: f32::INFINITY,
        budget: f32::INFINITY,
        axis: cone.axis.to_array(),
        cos: cone.cos,
        epsilon: 0.0,
    });
    let (left, right) = faces.split_at_mut(left);
    split(positions, left, tree);
    split(positions, right, tree);
}

/// The bounding polygons of all clusters of 64 faces or more.
fn polygons(tree: &fct::Tree, plain: &PlainClusters) -> Vec<BoundingPolygonRecord> {
    let mut out = Vec::new();
    let mut stack = vec![tree.whole()];
    while let Some(subtree) = stack.pop() {
        let Child::Node(index) = subtree.child.kind() else { continue };
        if subtree.face_count() < 64 {
            continue;
        }
        let corners = |face: &[u32; 3]| face.map(|v| Vec3::from_array(plain.positions[v as usize]));
        let faces = subtree.of(&plain.faces);
        let sum: Vec3 = faces.iter().map(|face| normal(&corners(face))).sum();
        let points = faces.iter().flat_map(corners).map(Vec3::into);
        let node = tree.node(&subtree).expect("the node is there");
        let along = sum.try_normalize().unwrap_or(Vec3::Z);
        out.push(BoundingPolygonRecord::around(index, &node, along.to_array(), points));
        let [left, right] = tree.children(&subtree).expect("the children are there");
        stack.extend([right, left]);
    }
    out
}
