//! A model for tests, made here: a bumpy torus as a tree of median splits, drawn at full resolution in every view.

#![allow(dead_code, reason = "each test file uses a part")]

use fcgeom::{Cone, Sphere};
use fct::{
    BoundingPolygonRecord, ChildRef, F32, FaceRecord, Meta, NodeRecord, NormalRecord, TreeData, U32,
    VertexRecord, WriteOptions, pack,
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

/// Writes any triangles as a tree.
pub(crate) fn write(path: &Path, positions: &[Vec3], faces: Vec<[u32; 3]>) {
    let mut builder = Builder { positions, nodes: Vec::new(), polygons: Vec::new() };
    let mut faces = faces;
    let count = faces.len();
    let (root, _) = builder.split(&mut faces, 0);
    let mut normals = vec![Vec3::ZERO; positions.len()];
    for face in &faces {
        for vertex in face {
            normals[*vertex as usize] += builder.normal(face);
        }
    }
    let normals: Vec<_> = normals.iter().map(|n| NormalRecord::encode(n.to_array())).collect();
    let low = positions.iter().fold(Vec3::INFINITY, |low, p| low.min(*p));
    let high = positions.iter().fold(Vec3::NEG_INFINITY, |high, p| high.max(*p));
    let infinite = F32::new(f32::INFINITY);
    let vertices: Vec<_> = positions
        .iter()
        .map(|p| VertexRecord {
            position: pack(p.to_array()),
            bound: infinite,
            budget: infinite,
            center: pack(p.to_array()),
            radius: F32::new(0.0),
        })
        .collect();
    let faces: Vec<FaceRecord> = faces.into_iter().map(FaceRecord::from).collect();
    let meta = Meta {
        faces_in: count as u64,
        faces_kept: count as u64,
        bounds_min: low.to_array(),
        bounds_max: high.to_array(),
        ..Meta::default()
    };
    let data = TreeData {
        root,
        meta: &meta,
        nodes: &builder.nodes,
        vertices: &vertices,
        faces: &faces,
        loops: &[],
        weld: &[],
        bounding_polygons: &builder.polygons,
        normals: Some(&normals),
        colors: None,
        groups: &[],
    };
    fct::write(path, &data, &WriteOptions { overwrite: true, source_id: 0 }).expect("the tree is written");
}

struct Builder<'a> {
    positions: &'a [Vec3],
    nodes: Vec<NodeRecord>,
    polygons: Vec<BoundingPolygonRecord>,
}

impl Builder<'_> {
    fn corners(&self, face: &[u32; 3]) -> [Vec3; 3] {
        face.map(|v| self.positions[v as usize])
    }

    fn normal(&self, face: &[u32; 3]) -> Vec3 {
        let [a, b, c] = self.corners(face);
        (b - a).cross(c - a)
    }

    /// Makes the subtree of a run of faces that begins at face `first`, and its sphere.
    fn split(&mut self, faces: &mut [[u32; 3]], first: u32) -> (ChildRef, Sphere) {
        if let [face] = faces {
            return (ChildRef::face(first), Sphere::of_points(self.corners(face)));
        }
        let points: Vec<Vec3> = faces.iter().flat_map(|face| self.corners(face)).collect();
        let low = points.iter().fold(Vec3::INFINITY, |low, p| low.min(*p));
        let high = points.iter().fold(Vec3::NEG_INFINITY, |high, p| high.max(*p));
        let axis = (high - low).max_position();
        faces.sort_by(|a, b| {
            let key = |face| self.corners(face).iter().map(|p| p[axis]).sum::<f32>();
            key(a).total_cmp(&key(b)).then(a.cmp(b))
        });
        let index = self.nodes.len();
        let cone = Cone::of_normals(faces.iter().map(|face| self.normal(face).normalize_or_zero()));
        self.nodes.push(NodeRecord {
            bound: F32::new(f32::INFINITY),
            budget: F32::new(f32::INFINITY),
            axis: pack(cone.axis.to_array()),
            cos: F32::new(cone.cos),
            first_face: U32::new(first),
            ..NodeRecord::default()
        });
        if faces.len() >= 64 {
            let polygon = self.bounding_polygon(index as u32, faces, &points);
            self.polygons.push(polygon);
        }
        let (left, right) = faces.split_at_mut(faces.len() / 2);
        let middle = first + left.len() as u32;
        let (left, left_sphere) = self.split(left, first);
        let (right, right_sphere) = self.split(right, middle);
        let sphere = Sphere::enclosing(&left_sphere, &right_sphere);
        let node = &mut self.nodes[index];
        node.left = U32::new(left.raw());
        node.right = U32::new(right.raw());
        node.center = pack(sphere.center.to_array());
        node.radius = F32::new(sphere.radius);
        (ChildRef::node(index as u32), sphere)
    }

    fn bounding_polygon(&self, node: u32, faces: &[[u32; 3]], points: &[Vec3]) -> BoundingPolygonRecord {
        let sum: Vec3 = faces.iter().map(|face| self.normal(face)).sum();
        let normal = sum.try_normalize().unwrap_or(Vec3::Z);
        let tangent = fcgeom::tangent_frame(normal.as_dvec3()).0.as_vec3();
        let (n, t) = (normal.as_dvec3(), tangent.as_dvec3());
        let b = n.cross(t);
        let origin = points[0];
        let mut low = f64::INFINITY;
        let mut high = f64::NEG_INFINITY;
        let mut support = [f64::NEG_INFINITY; 8];
        for p in points {
            let d = (p - origin).as_dvec3();
            low = low.min(d.dot(n));
            high = high.max(d.dot(n));
            for (k, s) in support.iter_mut().enumerate() {
                let angle = k as f64 * std::f64::consts::FRAC_PI_4;
                *s = s.max(d.dot(t) * angle.cos() + d.dot(b) * angle.sin());
            }
        }
        BoundingPolygonRecord {
            node: U32::new(node),
            flags: U32::new(0),
            origin: pack(origin.to_array()),
            normal: pack(normal.to_array()),
            tangent: pack(tangent.to_array()),
            low: F32::new(fcgeom::round_down(low)),
            high: F32::new(fcgeom::round_up(high)),
            support: support.map(|s| F32::new(fcgeom::round_up(s))),
        }
    }
}
