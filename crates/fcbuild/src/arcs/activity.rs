//! One record per vertex that says when it is drawn.

use super::corners::Registration;
use super::curves::CurveRecord;
use crate::bounds::NodeBounds;
use fcgeom::Sphere;

/// A vertex is drawn when its record passes the test that refines nodes: its key is over the tolerance there.
///
/// The record is at least as eager as every node that registers the vertex: each key is the largest of theirs and
/// the sphere encloses theirs. So whenever one of them is refined, the vertex is drawn, on all sides of it alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Activity {
    /// Largest distance bound, in normal units; infinite if the vertex is in every mesh.
    pub bound: f64,
    /// Largest budget key, likewise.
    pub budget: f64,
    /// Encloses the spheres of the nodes that register the vertex.
    pub sphere: Sphere,
}

impl Activity {
    const NEVER: Activity = Activity { bound: 0.0, budget: 0.0, sphere: Sphere::EMPTY };

    fn add(&mut self, bound: f64, budget: f64, sphere: &Sphere) {
        self.bound = self.bound.max(bound);
        self.budget = self.budget.max(budget);
        if self.sphere.is_empty() {
            self.sphere = *sphere;
        } else if !self.sphere.contains_sphere(sphere) {
            self.sphere = Sphere::enclosing(&self.sphere, sphere);
        }
    }
}

/// Gathers the records of all vertices; copies of one welded vertex get the same record.
///
/// `registrations` come with ancestors before descendants, so a vertex's first sphere mostly holds the others.
pub fn gather(
    weld: &[u32],
    registrations: &[Registration],
    curves: &[CurveRecord],
    nodes: &[NodeBounds],
) -> Vec<Activity> {
    let mut records = vec![Activity::NEVER; weld.len()];
    for r in registrations {
        let node = &nodes[r.node as usize];
        records[weld[r.vertex as usize] as usize].add(node.bound, node.budget, &node.sphere);
    }
    raise(weld, curves, &mut records);
    records
}

/// Adds what curves ask for to the records.
pub fn raise(weld: &[u32], curves: &[CurveRecord], records: &mut [Activity]) {
    for c in curves {
        records[weld[c.vertex as usize] as usize].add(c.error, c.error, &c.sphere);
    }
    for v in 0..weld.len() {
        records[v] = records[weld[v] as usize];
    }
}

/// Every vertex is in every mesh: the tree is a single face.
pub fn always(positions: &[glam::Vec3], records: &mut [Activity]) {
    for (record, p) in records.iter_mut().zip(positions) {
        *record = Activity {
            bound: f64::INFINITY,
            budget: f64::INFINITY,
            sphere: Sphere { center: *p, radius: 0.0 },
        };
    }
}
