//! One record per vertex that says when it is drawn.

use super::corners::{BOUND_ONLY, Registration};
use super::curves::CurveRecord;
use crate::bounds::NodeBounds;
use crate::clusters::PackedClusters;
use crate::partition::{Split, Subtree};
use crate::tree_order::TreeMesh;
use fcgeom::{Sphere, round_up};
use rayon::prelude::*;

/// A vertex is drawn when its record passes the test that refines nodes: its key is over the tolerance there.
///
/// The record is at least as eager as every node that registers the vertex: each key is the largest of theirs and
/// the sphere encloses theirs. So whenever one of them is refined, the vertex is drawn, on all sides of it alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Activity {
    /// Largest distance bound, in normal units; infinite if the vertex is in every mesh.
    pub bound: f32,
    /// Largest budget key, likewise.
    pub budget: f32,
    /// Encloses the spheres of the nodes that register the vertex.
    pub sphere: Sphere,
}

impl Activity {
    const NEVER: Activity = Activity { bound: 0.0, budget: 0.0, sphere: Sphere::EMPTY };

    fn add(&mut self, bound: f32, budget: f32, sphere: &Sphere) {
        self.bound = self.bound.max(bound);
        self.budget = self.budget.max(budget);
        if self.sphere.is_empty() {
            self.sphere = *sphere;
        } else if !self.sphere.contains_sphere(sphere) {
            self.sphere = Sphere::enclosing(&self.sphere, sphere);
        }
    }
}

/// What asks for vertices, and the numbers that they go by.
pub(crate) struct Asking<'a> {
    pub(crate) mesh: &'a TreeMesh,
    pub(crate) splits: &'a [Split],
    /// With ancestors before descendants, so a vertex's first sphere mostly holds the others.
    pub(crate) registrations: &'a [Vec<Registration>],
    pub(crate) curves: &'a [CurveRecord],
    pub(crate) nodes: &'a [NodeBounds],
    pub(crate) clusters: &'a PackedClusters,
}

/// Gathers the records of all welded vertices from what the splits register and curves ask for.
pub(crate) fn gather(asking: &Asking<'_>) -> Vec<Activity> {
    let Asking { mesh, splits, registrations, curves, nodes, clusters } = asking;
    let mut records = vec![Activity::NEVER; mesh.weld.len()];
    // Each thread goes through all registrations for some of the vertices: reading is the least of the work.
    let share = records.len().div_ceil(rayon::current_num_threads()).max(1);
    records.par_chunks_mut(share).enumerate().for_each(|(i, records)| {
        let mut spheres = clusters.spheres();
        let mut last = (0, spheres.of_node(0));
        let mut add = |vertex: u32, by: u32| {
            let node = by & !BOUND_ONLY;
            let place = (vertex as usize).checked_sub(i * share);
            if let Some(record) = place.and_then(|place| records.get_mut(place)) {
                if last.0 != node {
                    last = (node, spheres.of_node(node));
                }
                let bounds = &nodes[node as usize];
                let budget = if by == node { bounds.budget } else { 0.0 };
                record.add(bounds.bound, budget, &last.1);
            }
        };
        for r in registrations.iter().flatten() {
            add(r.vertex, r.node);
        }
        each_split_off(splits, mesh.faces.len(), |face, node| {
            for &vertex in &mesh.faces[face] {
                add(mesh.weld[vertex as usize], node);
            }
        });
    });
    raise(curves, &mut records);
    records
}

/// Shows each face and the node whose split leaves it alone, in the order of the faces; nothing if there is but one face.
fn each_split_off(splits: &[Split], faces: usize, mut show: impl FnMut(usize, u32)) {
    let mut stack = vec![(None, Subtree::whole(faces))];
    while let Some((parent, at)) = stack.pop() {
        if !at.is_face() {
            let node = at.node as u32;
            let [left, right] = at.children(splits);
            stack.push((Some(node), right));
            stack.push((Some(node), left));
        } else if let Some(node) = parent {
            show(at.faces.start, node);
        }
    }
}

/// Adds what curves ask for to the records.
pub fn raise(curves: &[CurveRecord], records: &mut [Activity]) {
    for c in curves {
        records[c.vertex as usize].add(round_up(c.bound), round_up(c.budget), &c.sphere);
    }
}

/// Copies of one welded vertex get the same record.
pub fn share(weld: &[u32], records: &mut [Activity]) {
    for v in 0..weld.len() {
        records[v] = records[weld[v] as usize];
    }
}

/// Every vertex is in every mesh: the tree is a single face.
pub fn always(positions: &[glam::Vec3], records: &mut [Activity]) {
    for (record, p) in records.iter_mut().zip(positions) {
        *record = Activity {
            bound: f32::INFINITY,
            budget: f32::INFINITY,
            sphere: Sphere { center: *p, radius: 0.0 },
        };
    }
}
