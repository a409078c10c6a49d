//! From measured nodes to the records of the file, in the input's unit.

use crate::arcs::activity::Activity;
use crate::arcs::loops::{LAST, Loops};
use crate::bounds::{BoundingPolygon, NodeBounds};
use crate::error::Error;
use crate::mesh::units::too_large;
use crate::partition::Split;
use crate::tree_order::TreeMesh;
use fcgeom::{Sphere, round_up};
use fct::{
    BoundingPolygonRecord, ChildRef, F32, FaceRecord, GroupRecord, LOOP_END, NodeRecord, NormalRecord, U32,
    VertexRecord, WeldRecord,
};
use glam::Vec3;

/// The sections of a tree file.
#[derive(Debug, Default)]
pub(crate) struct Records {
    pub(crate) nodes: Vec<NodeRecord>,
    pub(crate) vertices: Vec<VertexRecord>,
    pub(crate) faces: Vec<FaceRecord>,
    pub(crate) loops: Vec<U32>,
    pub(crate) weld: Vec<WeldRecord>,
    pub(crate) polygons: Vec<BoundingPolygonRecord>,
    pub(crate) normals: Vec<NormalRecord>,
    pub(crate) colors: Option<Vec<[u8; 4]>>,
    pub(crate) groups: Vec<GroupRecord>,
}

/// A vertex record is a little more eager than the nodes that register the vertex, so that the rounding of a test
/// can never refine the node and leave the vertex out.
const EAGER: f64 = 1.0 + 1.0 / (1 << 20) as f64;

/// What a coordinate may lose by underflow in normal units: spheres must hold the stored positions all the same.
const UNDERFLOW: f64 = 4.0 * f32::from_bits(1) as f64;

/// Lengths from normal units to the input's unit.
struct Scale(f64);

impl Scale {
    fn up(&self, length: f64) -> F32 {
        F32::new(round_up(length * self.0))
    }

    fn exact(&self, v: Vec3) -> [F32; 3] {
        (v.as_dvec3() * self.0).as_vec3().to_array().map(F32::new)
    }

    fn sphere(&self, s: &Sphere, factor: f64) -> ([F32; 3], F32) {
        (self.exact(s.center), self.up(f64::from(s.radius) * factor + UNDERFLOW))
    }
}

impl Records {
    /// Writes down everything but the groups.
    ///
    /// # Errors
    /// Bad input when a sphere, or the square of a length, is too large for single precision.
    pub(crate) fn new(
        mesh: TreeMesh,
        splits: &[Split],
        loops: Loops,
        bounds: &[NodeBounds],
        polygons: &[(u32, BoundingPolygon)],
        activity: &[Activity],
    ) -> Result<Records, Error> {
        let scale = Scale(mesh.units.length());
        let square = |s: &Split| (s.epsilon * scale.0 * scale.0) as f32;
        if bounds.iter().any(|b| !scale.up(f64::from(b.sphere.radius) * EAGER).get().is_finite())
            || splits.iter().any(|s| !square(s).is_finite())
        {
            return Err(too_large());
        }
        let nodes = node_records(&scale, mesh.faces.len(), splits, &loops, bounds);
        let polygons = polygons.iter().map(|(node, p)| polygon_record(&scale, *node, p)).collect();
        let loops = loops
            .half_edges
            .into_iter()
            .map(|h| {
                let vertex = mesh.origin(h & !LAST);
                U32::new(if h & LAST != 0 { vertex | LOOP_END } else { vertex })
            })
            .collect();
        let vertices = mesh
            .stored
            .iter()
            .zip(activity)
            .map(|(p, a)| {
                let (center, radius) = scale.sphere(&a.sphere, EAGER);
                let position = p.to_array().map(F32::new);
                VertexRecord {
                    position,
                    bound: scale.up(f64::from(a.bound) * EAGER),
                    budget: scale.up(f64::from(a.budget) * EAGER),
                    center,
                    radius,
                }
            })
            .collect();
        let weld = mesh
            .weld
            .iter()
            .enumerate()
            .filter(|(v, w)| *v != **w as usize)
            .map(|(v, w)| WeldRecord { vertex: U32::new(v as u32), representative: U32::new(*w) })
            .collect();
        Ok(Records {
            nodes,
            vertices,
            faces: mesh.faces.iter().map(|f| FaceRecord { vertices: f.map(U32::new) }).collect(),
            loops,
            weld,
            polygons,
            normals: mesh.normals.iter().map(|n| NormalRecord::encode(n.to_array())).collect(),
            colors: mesh.colors,
            groups: Vec::new(),
        })
    }
}

fn child_ref(node: usize, first_face: usize, faces: usize) -> ChildRef {
    if faces == 1 { ChildRef::face(first_face as u32) } else { ChildRef::node(node as u32) }
}

fn node_records(
    scale: &Scale,
    faces: usize,
    splits: &[Split],
    loops: &Loops,
    bounds: &[NodeBounds],
) -> Vec<NodeRecord> {
    let mut nodes = Vec::with_capacity(splits.len());
    // Preorder, so records are pushed in the order of their indices.
    let mut stack = vec![(0, 0, faces)];
    while let Some((node, first_face, faces)) = stack.pop() {
        if faces < 2 {
            continue;
        }
        let left = splits[node].left_faces as usize;
        let b = &bounds[node];
        let (center, radius) = scale.sphere(&b.sphere, 1.0);
        nodes.push(NodeRecord {
            center,
            radius,
            bound: scale.up(f64::from(b.bound)),
            budget: scale.up(f64::from(b.budget)),
            axis: b.cone.axis.to_array().map(F32::new),
            cos: F32::new(b.cone.cos),
            epsilon: F32::new((splits[node].epsilon * scale.0 * scale.0) as f32),
            left: U32::new(child_ref(node + 1, first_face, left).raw()),
            right: U32::new(child_ref(node + left, first_face + left, faces - left).raw()),
            first_face: U32::new(first_face as u32),
            loop_start: U32::new(loops.start[node]),
            loop_len: U32::new(loops.len[node]),
        });
        stack.push((node + left, first_face + left, faces - left));
        stack.push((node + 1, first_face, left));
    }
    nodes
}

fn polygon_record(scale: &Scale, node: u32, p: &BoundingPolygon) -> BoundingPolygonRecord {
    let length = |x: f32| F32::new((f64::from(x) * scale.0) as f32);
    BoundingPolygonRecord {
        node: U32::new(node),
        flags: U32::new(0),
        origin: scale.exact(p.origin),
        normal: p.normal.to_array().map(F32::new),
        tangent: p.tangent.to_array().map(F32::new),
        low: length(p.low),
        high: length(p.high),
        support: p.support.map(length),
    }
}
