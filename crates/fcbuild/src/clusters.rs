//! Measured nodes as the file's packer asks about them, and what it makes of them.

use crate::arcs::loops::{LAST, Loops};
use crate::bounds::NodeBounds;
use crate::error::{Error, ErrorKind};
use crate::mesh::units::too_large;
use crate::partition::Split;
use crate::tree_order::TreeMesh;
use fcgeom::{Sphere, round_up};
use fct::{ClusterData, Clusters, LOOP_END, MAX_PAGE_FACES, Node, PackError, Packed, Plan};
use glam::Vec3;
use rayon::prelude::*;

/// Lengths from normal units to the input's unit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scale(pub(crate) f64);

impl Scale {
    fn up(self, length: f32) -> f32 {
        round_up(f64::from(length) * self.0)
    }

    fn vector(self, v: Vec3) -> [f32; 3] {
        (v.as_dvec3() * self.0).as_vec3().to_array()
    }

    /// A stored sphere in normal units. Exact, since the scale is a power of two.
    fn sphere_back(self, node: &Node) -> Sphere {
        let center = Vec3::from(node.center).as_dvec3() / self.0;
        Sphere { center: center.as_vec3(), radius: round_up(f64::from(node.radius) / self.0) }
    }
}

/// A measured tree, for the packer.
struct Measurements<'a> {
    mesh: &'a TreeMesh,
    splits: &'a [Split],
    loops: &'a Loops,
    bounds: &'a [NodeBounds],
    scale: Scale,
}

impl Clusters for Measurements<'_> {
    fn faces(&self) -> &[[u32; 3]] {
        &self.mesh.faces
    }

    fn vertex_count(&self) -> usize {
        self.mesh.stored.len()
    }

    fn position(&self, vertex: u32) -> [f32; 3] {
        self.mesh.stored[vertex as usize].to_array()
    }

    fn left_faces(&self, node: u32) -> u32 {
        self.splits[node as usize].left_faces
    }

    fn cluster(&self, node: u32) -> ClusterData {
        let (bounds, split) = (&self.bounds[node as usize], &self.splits[node as usize]);
        ClusterData {
            center: self.scale.vector(bounds.sphere.center),
            bound: self.scale.up(bounds.bound),
            budget: self.scale.up(bounds.budget),
            axis: bounds.cone.axis.to_array(),
            cos: bounds.cone.cos,
            epsilon: (split.epsilon * self.scale.0 * self.scale.0) as f32,
            plane: split.normal.to_array(),
            offset: split.offset * self.scale.0,
        }
    }

    fn boundary(&self, node: u32, out: &mut Vec<u32>) {
        out.extend(self.loops.of_node(node as usize).iter().map(|h| {
            let vertex = self.mesh.origin(h & !LAST);
            if h & LAST != 0 { vertex | LOOP_END } else { vertex }
        }));
    }
}

/// Nodes, faces and loops as the file holds them.
#[derive(Debug)]
pub(crate) struct PackedClusters {
    pub(crate) packed: Packed,
    /// The nodes that are worth a bounding polygon, in preorder.
    pub(crate) outlined: Vec<Outlined>,
}

/// A node that is worth a bounding polygon.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outlined {
    /// Its place in preorder.
    pub(crate) index: u32,
    /// As a reader decodes it.
    pub(crate) node: Node,
    /// Normal of the cluster's plane.
    pub(crate) normal: Vec3,
}

/// Pages that one thread packs in a row.
const PAGES_AT_ONCE: usize = 64;

/// Packs the tree and puts the decoded numbers in the place of the measured ones: what vertices ask of nodes must hold
/// for what a reader will see.
///
/// `outline` gives the normals of the nodes that are worth a bounding polygon.
///
/// # Errors
/// Bad input when a sphere, or the square of a length, is too large for single precision; a limit when a section is too
/// long for the format.
pub(crate) fn pack(
    mesh: &TreeMesh,
    splits: &[Split],
    loops: &Loops,
    bounds: &mut [NodeBounds],
    outline: &dyn Fn(usize) -> Option<Vec3>,
) -> Result<PackedClusters, Error> {
    let scale = Scale(mesh.units.length());
    if splits.iter().any(|s| !((s.epsilon * scale.0 * scale.0) as f32).is_finite()) {
        return Err(too_large());
    }
    let clusters = Measurements { mesh, splits, loops, bounds, scale };
    let plan = Plan::new(&clusters, MAX_PAGE_FACES).map_err(pack_error)?;
    let count = plan.page_count();
    let runs: Result<Vec<_>, PackError> = (0..count.div_ceil(PAGES_AT_ONCE))
        .into_par_iter()
        .map(|run| {
            let first = run * PAGES_AT_ONCE;
            plan.pack_pages(&clusters, first..count.min(first + PAGES_AT_ONCE))
        })
        .collect();
    let packed = Packed::assemble(&clusters, &plan, runs.map_err(pack_error)?).map_err(pack_error)?;
    let mut outlined = Vec::new();
    for (index, node) in packed.decoded(&plan) {
        let measured = &mut bounds[index as usize];
        measured.bound = round_up(f64::from(node.bound) / scale.0);
        measured.budget = round_up(f64::from(node.budget) / scale.0);
        measured.sphere = scale.sphere_back(&node);
        if let Some(normal) = outline(index as usize) {
            outlined.push(Outlined { index, node, normal });
        }
    }
    outlined.sort_unstable_by_key(|o| o.index);
    Ok(PackedClusters { packed, outlined })
}

fn pack_error(error: PackError) -> Error {
    match error {
        PackError::Range(_) => too_large(),
        PackError::TooLong(section) => Error::new(
            ErrorKind::Limit,
            "FC571",
            format!("{section} would take more than 2^32 bytes; split the model"),
        ),
        other => Error::new(ErrorKind::Internal, "FC901", other.to_string()),
    }
}
