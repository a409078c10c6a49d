//! Measured nodes as the file's packer asks about them, and what it makes of them.

use crate::arcs::loops::{LAST, Loops};
use crate::bounds::NodeBounds;
use crate::error::{Error, ErrorKind};
use crate::mesh::units::too_large;
use crate::partition::Split;
use crate::tree_order::TreeMesh;
use fcgeom::{Cone, Sphere, round_up};
use fct::{ClusterData, Clusters, Decoded, LOOP_END, MAX_PAGE_FACES, Node, PackError, Packed, Plan};
use glam::Vec3;
use rayon::prelude::*;

/// Lengths from normal units to the input's unit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scale(pub(crate) f64);

impl Scale {
    fn up(self, length: f32) -> f32 {
        round_up(f64::from(length) * self.0)
    }

    fn square(self, area: f32) -> f32 {
        (f64::from(area) * self.0 * self.0) as f32
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
    cones: &'a [Cone],
    scale: Scale,
}

impl Clusters for Measurements<'_> {
    fn faces(&self) -> &[[u32; 3]] {
        &self.mesh.faces
    }

    fn vertex_count(&self) -> usize {
        self.mesh.positions.len()
    }

    fn position(&self, vertex: u32) -> [f32; 3] {
        self.mesh.stored(vertex).to_array()
    }

    fn left_faces(&self, node: u32) -> u32 {
        self.splits[node as usize].left_faces
    }

    fn cluster(&self, node: u32) -> ClusterData {
        let node = node as usize;
        let (bounds, cone, split) = (&self.bounds[node], &self.cones[node], &self.splits[node]);
        ClusterData {
            bound: self.scale.up(bounds.bound),
            budget: self.scale.up(bounds.budget),
            axis: cone.axis.to_array(),
            cos: cone.cos,
            epsilon: self.scale.square(split.epsilon),
            plane: split.normal.to_array(),
            offset: f64::from(split.offset) * self.scale.0,
        }
    }

    fn boundary(&self, node: u32, out: &mut Vec<u32>) {
        let before = out.len();
        self.loops.append(node as usize, out);
        for entry in &mut out[before..] {
            let vertex = self.mesh.origin(*entry & !LAST);
            *entry = if *entry & LAST != 0 { vertex | LOOP_END } else { vertex };
        }
    }
}

/// Nodes, faces and loops as the file holds them.
#[derive(Debug)]
pub(crate) struct PackedClusters {
    pub(crate) packed: Packed,
    /// The nodes that are worth a bounding polygon, in preorder.
    pub(crate) outlined: Vec<Outlined>,
    plan: Plan,
    scale: Scale,
}

impl PackedClusters {
    /// The spheres of nodes.
    pub(crate) fn spheres(&self) -> Spheres<'_> {
        Spheres { decoded: self.packed.decoded(&self.plan), scale: self.scale }
    }
}

/// The spheres of nodes as they are stored.
pub(crate) struct Spheres<'a> {
    decoded: Decoded<'a>,
    scale: Scale,
}

impl Spheres<'_> {
    /// In normal units; quick for nodes near one another. Empty for none.
    pub(crate) fn of_node(&mut self, node: u32) -> Sphere {
        self.decoded.node(node).map_or(Sphere::EMPTY, |node| self.scale.sphere_back(&node))
    }
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
const PAGES_AT_ONCE: usize = 16;

/// Packs the tree and puts the decoded numbers in the place of the measured ones: what vertices ask of nodes must hold
/// for what a reader will see.
///
/// # Errors
/// Bad input when a sphere, or the square of a length, is too large for single precision; a limit when a section is too
/// long for the format.
pub(crate) fn pack(
    mesh: &TreeMesh,
    splits: &[Split],
    loops: &Loops,
    bounds: &mut [NodeBounds],
    cones: Vec<Cone>,
) -> Result<PackedClusters, Error> {
    let scale = Scale(mesh.units.length());
    if splits.iter().any(|s| !scale.square(s.epsilon).is_finite()) {
        return Err(too_large());
    }
    let clusters = Measurements { mesh, splits, loops, bounds, cones: &cones, scale };
    let plan = Plan::new(&clusters, MAX_PAGE_FACES).map_err(pack_error)?;
    let count = plan.page_count();
    let firsts: Vec<usize> = (0..count).step_by(PAGES_AT_ONCE).collect();
    // A few runs at once, so that there is little memory in them.
    let runs = firsts.chunks(4 * rayon::current_num_threads()).flat_map(|firsts| {
        let pack = |first: &usize| plan.pack_pages(&clusters, *first..count.min(first + PAGES_AT_ONCE));
        firsts.par_iter().map(pack).collect::<Vec<_>>()
    });
    let packed = Packed::assemble(&clusters, &plan, runs).map_err(pack_error)?;
    let mut decoded = packed.decoded(&plan);
    let outlined = large_nodes(splits, mesh.faces.len()).into_iter().filter_map(|index| {
        let plane = splits[index as usize].normal;
        let normal = if plane == Vec3::ZERO { cones[index as usize].axis } else { plane };
        Some(Outlined { index, node: decoded.node(index)?, normal })
    });
    let outlined = outlined.collect();
    drop(cones);
    bounds.par_chunks_mut(DECODED_AT_ONCE).enumerate().for_each(|(i, bounds)| {
        let mut decoded = packed.decoded(&plan);
        for (index, measured) in (i * DECODED_AT_ONCE..).zip(bounds) {
            let Some(node) = decoded.node(index as u32) else { continue };
            measured.raise_bound(round_up(f64::from(node.bound) / scale.0));
            measured.budget = round_up(f64::from(node.budget) / scale.0);
        }
    });
    Ok(PackedClusters { packed, outlined, plan, scale })
}

/// Nodes whose numbers one thread decodes in a row.
const DECODED_AT_ONCE: usize = 1 << 14;

/// Clusters of fewer faces get no bounding polygon: a query costs as much as drawing them.
const POLYGON_FROM: usize = 64;

/// The nodes of at least [`POLYGON_FROM`] faces, in preorder.
fn large_nodes(splits: &[Split], faces: usize) -> Vec<u32> {
    let mut large = Vec::new();
    let mut stack = vec![(0, faces)];
    while let Some((node, faces)) = stack.pop() {
        if faces >= POLYGON_FROM {
            large.push(node as u32);
            let left = splits[node].left_faces as usize;
            stack.push((node + left, faces - left));
            stack.push((node + 1, left));
        }
    }
    large
}

pub(crate) fn pack_error(error: PackError) -> Error {
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
