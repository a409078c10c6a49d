//! One record per vertex that says when it is drawn.

use super::corners::Registration;
use super::curves::CurveRecord;
use crate::bounds::{NodeBounds, Slack};
use crate::clusters::PackedClusters;
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

/// Gathers the records of all welded vertices from what the splits register and curves ask for.
///
/// `registrations` come with ancestors before descendants, so a vertex's first sphere mostly holds the others.
pub(crate) fn gather(
    vertices: usize,
    registrations: &[Vec<Registration>],
    curves: &[CurveRecord],
    nodes: &[NodeBounds],
    clusters: &PackedClusters,
    slack: Slack,
) -> Vec<Activity> {
    let mut records = vec![Activity::NEVER; vertices];
    // Each thread goes through all registrations for some of the vertices: reading is the least of the work.
    let share = vertices.div_ceil(rayon::current_num_threads()).max(1);
    records.par_chunks_mut(share).enumerate().for_each(|(i, records)| {
        let mut spheres = clusters.spheres();
        let mut last = (0, spheres.of_node(0));
        for r in registrations.iter().flatten() {
            if let Some(record) =
                (r.vertex as usize).checked_sub(i * share).and_then(|place| records.get_mut(place))
            {
                if last.0 != r.node {
                    last = (r.node, spheres.of_node(r.node));
                }
                let node = &nodes[r.node as usize];
                record.add(node.bound, node.budget, &last.1);
            }
        }
    });
    raise(curves, slack, &mut records);
    records
}

/// Adds what curves ask for to the records.
pub fn raise(curves: &[CurveRecord], slack: Slack, records: &mut [Activity]) {
    for c in curves {
        records[c.vertex as usize].add(slack.raise(c.error), round_up(c.error), &c.sphere);
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
