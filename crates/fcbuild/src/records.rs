//! What stands beside the clusters: vertices, welds, bounding polygons, normals, in the input's unit.

use crate::arcs::activity::Activity;
use crate::arcs::loops::{LAST, Loops};
use crate::clusters::{Outlined, PackedClusters, Scale};
use crate::error::Error;
use crate::mesh::units::too_large;
use crate::partition::{Split, Subtree};
use crate::tree_order::TreeMesh;
use fct::{
    BoundingPolygonRecord, Displacement, GroupRecord, NormalRecord, Packed, U32, VertexRecord, WeldRecord,
};
use glam::Vec3;
use rayon::prelude::*;
use std::ops::Range;

/// The sections of a tree file.
#[derive(Debug, Default)]
pub(crate) struct Records {
    pub(crate) clusters: Packed,
    pub(crate) vertices: Vec<VertexRecord>,
    pub(crate) weld: Vec<WeldRecord>,
    pub(crate) polygons: Vec<BoundingPolygonRecord>,
    pub(crate) normals: Vec<NormalRecord>,
    pub(crate) colors: Option<Vec<[u8; 4]>>,
    pub(crate) groups: Vec<GroupRecord>,
    pub(crate) chunks: fct::ChunkData,
}

impl Records {
    /// Writes down everything but the groups.
    ///
    /// # Errors
    /// Bad input when the sphere of a vertex is too large for single precision.
    pub(crate) fn new(
        mesh: TreeMesh,
        splits: &[Split],
        loops: Loops,
        clusters: PackedClusters,
        activity: Vec<Activity>,
        displaced: Vec<Displacement>,
    ) -> Result<Records, Error> {
        let polygons = polygon_records(&mesh, splits, &loops, &clusters.outlined);
        let scale = Scale(mesh.units.length());
        drop(loops);
        let mut vertices = vec![VertexRecord::default(); mesh.positions.len()];
        let is_done = |(v, record): (usize, &mut VertexRecord)| {
            let found = vertex_record(scale, mesh.stored(v as u32), &activity[v], displaced[v]);
            *record = found.unwrap_or_default();
            found.is_some()
        };
        let are_all_done = vertices.par_iter_mut().enumerate().all(is_done);
        drop((activity, displaced));
        if !are_all_done {
            return Err(too_large());
        }
        let TreeMesh { normals, colors, weld, .. } = mesh;
        let weld = weld
            .iter()
            .enumerate()
            .filter(|(v, w)| *v != **w as usize)
            .map(|(v, w)| WeldRecord { vertex: U32::new(v as u32), representative: U32::new(*w) })
            .collect();
        Ok(Records {
            clusters: clusters.packed,
            vertices,
            weld,
            polygons,
            normals,
            colors,
            groups: Vec::new(),
            chunks: fct::ChunkData::default(),
        })
    }
}

/// None if the sphere is too large.
fn vertex_record(
    scale: Scale,
    position: Vec3,
    activity: &Activity,
    displacement: Displacement,
) -> Option<VertexRecord> {
    let center = (activity.sphere.center.as_dvec3() * scale.0).to_array();
    let radius = f64::from(activity.sphere.radius) * scale.0;
    let record = VertexRecord::eager(
        position.to_array(),
        f64::from(activity.bound) * scale.0,
        f64::from(activity.budget) * scale.0,
        (center, radius),
    )?;
    // In shares of the key, which a power of two changes as much.
    Some(VertexRecord { displacement, ..record })
}

/// The prisms of the outlined nodes, around their vertices as stored.
fn polygon_records(
    mesh: &TreeMesh,
    splits: &[Split],
    loops: &Loops,
    outlined: &[Outlined],
) -> Vec<BoundingPolygonRecord> {
    let ranges = face_ranges(splits, mesh.faces.len(), outlined);
    let record = |(outlined, faces): (&Outlined, Range<usize>)| {
        let Outlined { index, node, normal } = outlined;
        let mut memory = Vec::new();
        let border = loops.read(*index as usize, &mut memory).iter().map(|h| mesh.origin(h & !LAST));
        let own = mesh.own_vertices(&faces);
        let before = border.filter(|v| (*v as usize) < own.start);
        let points = own.clone().map(|v| v as u32).chain(before).map(|v| mesh.stored(v).to_array());
        BoundingPolygonRecord::around(*index, node, normal.to_array(), points)
    };
    outlined.par_iter().zip(ranges).map(record).collect()
}

/// The faces of some nodes, which stand in preorder.
fn face_ranges(splits: &[Split], faces: usize, wanted: &[Outlined]) -> Vec<Range<usize>> {
    let mut ranges = Vec::with_capacity(wanted.len());
    let mut stack = vec![Subtree::whole(faces)];
    while let Some(at) = stack.pop() {
        let Some(Outlined { index: next, .. }) = wanted.get(ranges.len()) else { break };
        // A subtree of k faces heads k - 1 nodes: those that are not wanted are stepped over whole.
        if at.is_face() || at.node + at.faces.len() - 1 <= *next as usize {
            continue;
        }
        let [left, right] = at.children(splits);
        if at.node == *next as usize {
            ranges.push(at.faces);
        }
        stack.push(right);
        stack.push(left);
    }
    ranges
}
