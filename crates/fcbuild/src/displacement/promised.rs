//! How much of its displacement a vertex may be drawn with where distances are promised.
//!
//! A cluster's bound holds for polygons whose vertices lie on its border. Drawn beside their places, they take the
//! polygon's points with them: each moves by a mean of the steps of three vertices. So it is enough to look at one vertex
//! at a time: if none leaves what a cluster's bound allows, no point of the polygon does; `docs/bound.md` has the
//! argument. Each cluster allows a vertex a largest share of its steps, and the least of these is stored.

use super::Displacement;
use crate::arcs::ClusterTree;
use crate::arcs::activity::Activity;
use crate::arcs::loops::LAST;
use crate::bounds::{AllSupports, Gaze, NodeBounds, RIDGE, farther};
use crate::mesh::NONE;
use crate::tree_order::TreeMesh;
use fcgeom::{round_down, round_up};
use fct::ShortFloat;
use glam::DVec3;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU8, Ordering};

/// A vertex moves by at most this part of what is allowed there: a face is a cluster that is without error of its own.
const MOST: f64 = 0.25;

/// The share of each welded vertex before any cluster is asked: vertices of open edges and seams have none, because
/// nothing lies beyond them that would cover what they leave.
pub(crate) fn unasked(mesh: &TreeMesh) -> Vec<AtomicU8> {
    let shares: Vec<AtomicU8> = mesh.weld.iter().map(|_| AtomicU8::new(Displacement::WHOLE)).collect();
    for h in (0..mesh.opposite.len() as u32).filter(|h| mesh.opposite[*h as usize] == NONE) {
        for v in [mesh.origin(h), mesh.target(h)] {
            shares[mesh.weld[v as usize] as usize].store(0, Ordering::Relaxed);
        }
    }
    shares
}

/// Writes into each displacement the share that all clusters allow. The least of some numbers does not depend on the order
/// in which threads find them.
pub(crate) fn share_out(
    tree: ClusterTree<'_>,
    supports: &AllSupports,
    shares: &[AtomicU8],
    displaced: &mut [Displacement],
) {
    let mesh = tree.mesh;
    let limit = |v: usize, share: f64| {
        shares[v].fetch_min((share * f64::from(Displacement::WHOLE)) as u8, Ordering::Relaxed);
    };
    let mut reaches = vec![Reach::default(); displaced.len()];
    reaches.par_iter_mut().enumerate().for_each(|(v, reach)| {
        let vertex = Vertex::new(displaced[v], &tree.keys[v]);
        limit(v, vertex.share(0.0, |step, allowed| MOST * allowed / step.length()));
        if displaced[v].is_none() {
            shares[v].store(0, Ordering::Relaxed);
        }
        *reach = vertex.reach();
    });
    (0..tree.splits.len()).into_par_iter().for_each_init(Default::default, |memory: &mut Memory, node| {
        if tree.splits[node].joins_components || !tree.nodes[node].bound.is_finite() {
            return;
        }
        let Memory { border, heights, apart } = memory;
        let border = tree.loops.read(node, border);
        let cluster = Cluster::new(tree, supports, node, (border, heights), apart);
        for (h, apart) in border.iter().zip(apart) {
            let v = mesh.origin(h & !LAST) as usize;
            let now = shares[v].load(Ordering::Relaxed);
            if now > 0 && !cluster.allows_all(*apart, reaches[v], displaced[v], of_whole(now)) {
                let vertex = Vertex::new(displaced[v], &tree.keys[v]);
                let share = cluster.share(&vertex, *apart, of_whole(now));
                if share < of_whole(now) {
                    limit(v, share);
                }
            }
        }
    });
    // Copies along a seam go together.
    for (v, w) in mesh.weld.iter().enumerate().filter(|(v, w)| *v != **w as usize) {
        shares[*w as usize].fetch_min(shares[v].load(Ordering::Relaxed), Ordering::Relaxed);
    }
    displaced.par_iter_mut().zip(&mesh.weld).for_each(|(own, w)| {
        *own = own.with_share(shares[*w as usize].load(Ordering::Relaxed));
    });
}

fn of_whole(share: u8) -> f64 {
    f64::from(share) / f64::from(Displacement::WHOLE)
}

/// What is used again for each cluster: its border, how high the vertices of that lie, and how far each may be above the
/// surface and below it.
#[derive(Default)]
struct Memory {
    border: Vec<u32>,
    heights: Vec<f64>,
    apart: Vec<[f64; 2]>,
}

/// A cluster as its vertices see it.
struct Cluster<'a> {
    node: &'a NodeBounds,
    bound: f64,
    direction: DVec3,
    /// What is allowed is divided by that along the direction: more where planes lean.
    divided: f64,
    /// At its bound: how far from the surface a vertex may be along the direction, and how far it may go at all.
    most: f64,
    step: f64,
}

impl Cluster<'_> {
    /// Also fills in how far each vertex of its border is above the surface and below it, at most, where the vertex counts
    /// for points of the polygon. The heights are memory.
    fn new<'a>(
        tree: ClusterTree<'a>,
        supports: &AllSupports,
        node: usize,
        (border, heights): (&[u32], &mut Vec<f64>),
        apart: &mut Vec<[f64; 2]>,
    ) -> Cluster<'a> {
        let own = &tree.nodes[node];
        let (bound, slack) = (f64::from(own.bound), &own.slack);
        let direction = slack.direction();
        // The same of all of the border.
        let all = slack.room(bound, bound).map(|room| bound / RIDGE - room);
        apart.clear();
        if own.is_from_corners() {
            // Nothing is measured along a direction.
            apart.resize(border.len(), [0.0; 2]);
            return Cluster::around(own, 1.0);
        }
        let supports = supports.of_node(node);
        if supports.is_empty() {
            let [low, high] = look_along(tree.mesh, border, direction, heights);
            apart.extend(heights.iter().map(|height| [all[0] - (high - height), all[1] - (height - low)]));
            return Cluster::around(own, 1.0);
        }
        // Whatever is measured between a pair of planes must be near enough; the steps count as much as where planes lean
        // the most.
        apart.resize(border.len(), [f64::NEG_INFINITY; 2]);
        let gaze = Gaze::along(direction);
        for support in supports {
            let farther = farther(support.slope());
            let [low, high] = look_along(tree.mesh, border, gaze.leant(support.slope()), heights);
            let own = support.apart([all[1], all[0]]);
            for (apart, height) in apart.iter_mut().zip(&*heights) {
                apart[0] = apart[0].max(own[1] - farther * (high - height));
                apart[1] = apart[1].max(own[0] - farther * (height - low));
            }
        }
        let farthest = supports.iter().map(|support| farther(support.slope())).fold(1.0, f64::max);
        apart.iter_mut().flatten().for_each(|apart| *apart /= farthest);
        Cluster::around(own, farthest)
    }

    fn around(node: &NodeBounds, farthest: f64) -> Cluster<'_> {
        let (bound, slack) = (f64::from(node.bound), &node.slack);
        let divided = RIDGE * farthest;
        let (most, step) = (bound / divided, slack.step(bound, bound));
        Cluster { node, bound, direction: slack.direction(), divided, most, step }
    }

    /// Whether it is sure to allow this share of all steps to a vertex that is so far above the surface and below it: sooner
    /// seen than how much it allows.
    ///
    /// Where more is allowed than the bound, there is as much more room on all sides.
    #[inline]
    fn allows_all(
        &self,
        [above, below]: [f64; 2],
        reach: Reach,
        displacement: Displacement,
        share: f64,
    ) -> bool {
        let off = above.abs().max(below.abs());
        // Wherever the steps go.
        let allows_long = |length: f64, more: f64| {
            let length = length * (1.0 + ROUNDING);
            length <= self.step + more && off + length <= self.most + more / self.divided
        };
        let allows = |step: [f64; 3], unit: f64| {
            let step = DVec3::from_array(step) * unit;
            let (most, square, up) = (self.most, step.length_squared(), step.dot(self.direction));
            let across = (square - up * up).max(0.0);
            let (from_lowest, from_highest) = (above + up, below - up);
            let farthest = (from_lowest * from_lowest).max(from_highest * from_highest) + across;
            farthest * (1.0 + ROUNDING) <= most * most && square * (1.0 + ROUNDING) <= self.step * self.step
        };
        let (length, low) = (share * f64::from(reach.longest), f64::from(reach.low));
        let unit = share * f64::from(reach.budget);
        if self.bound < low {
            let shrunk = (self.bound / low) * (self.bound / low);
            let [_, at_low] = displacement.stored();
            (allows_long(length * shrunk, 0.0) || allows(at_low, unit * shrunk))
                && allows_long(length, low - self.bound)
        } else {
            allows_long(length, 0.0) || displacement.stored().into_iter().all(|step| allows(step, unit))
        }
    }

    /// The share that the cluster allows to a vertex of its border, at most 1; 1 for any from `now` on.
    fn share(&self, vertex: &Vertex, [above, below]: [f64; 2], now: f64) -> f64 {
        let slack = &self.node.slack;
        vertex.share(self.bound, |step, allowed| {
            let (length, most) = (step.length(), allowed / self.divided);
            let beside = slack.step(self.bound, allowed) / length;
            if self.node.is_from_corners() {
                return beside;
            }
            let up = step.dot(self.direction);
            let across = (length * length - up * up).max(0.0);
            // Most steps are allowed as they are: that is sooner seen than how far they might go.
            let ends = |off: f64, up: f64| (off + now * up).powi(2) + now * now * across;
            if ends(above, up).max(ends(below, -up)) <= most * most && now <= beside {
                return 1.0;
            }
            beside.min(reaching(most, above, up, across)).min(reaching(most, below, -up, across))
        })
    }
}

/// Fills in how high the vertices of a border lie along a vector; returns the lowest and the highest of the heights.
fn look_along(mesh: &TreeMesh, border: &[u32], along: DVec3, heights: &mut Vec<f64>) -> [f64; 2] {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    heights.clear();
    heights.extend(border.iter().map(|h| {
        let height = along.dot(mesh.positions[mesh.origin(h & !LAST) as usize].as_dvec3());
        low = if height < low { height } else { low };
        high = if height > high { height } else { high };
        height
    }));
    [low, high]
}

/// The largest share of a step, `up` high and across by this length squared, that ends within `most` of a point which is
/// `below` its start; 0 if the start is not.
fn reaching(most: f64, below: f64, up: f64, across: f64) -> f64 {
    let (square, left) = (up * up + across, most * most - below * below);
    if below > 0.0 && left < 0.0 {
        return 0.0;
    }
    let middle = below * up;
    ((middle * middle + square * left).max(0.0).sqrt() - middle) / square
}

/// A vertex as a reader will see it, but for a power of two.
struct Vertex {
    displacement: Displacement,
    bound: f64,
    budget: f64,
}

impl Vertex {
    #[inline]
    fn new(displacement: Displacement, activity: &Activity) -> Vertex {
        let [bound, budget] =
            [activity.bound, activity.budget].map(|key| f64::from(ShortFloat::up(f64::from(key)).get()));
        Vertex { displacement, bound, budget }
    }

    /// How far it goes.
    fn reach(&self) -> Reach {
        let length = |at: f64| DVec3::from_array(self.displacement.at(at)).length();
        let [high, low] = Displacement::AT;
        Reach {
            longest: round_up(length(high).max(length(low)) * self.budget),
            low: round_down(low * self.bound),
            budget: round_up(self.budget),
        }
    }

    /// The largest share, at most 1, that `allows` gives its steps at all tolerances from `bound` on. The smaller steps
    /// that it takes below, where its own sphere is nearer to an eye than the cluster's, are allowed then too.
    ///
    /// `allows` says how much of a step is allowed at a tolerance. It must describe a convex set that grows with the
    /// tolerance: between the places where displacements are stored, steps are means of these.
    fn share(&self, bound: f64, allows: impl Fn(DVec3, f64) -> f64) -> f64 {
        if self.displacement.is_none() || !(self.bound.is_finite() && self.budget.is_finite()) {
            return 1.0;
        }
        let [high, low] = Displacement::AT.map(|at| at * self.bound);
        let mut share = 1.0_f64;
        for tolerance in [bound, high, low] {
            let step = DVec3::from_array(self.displacement.at(tolerance / self.bound)) * self.budget;
            if step != DVec3::ZERO {
                share = share.min(allows(step, tolerance.max(bound)));
            }
        }
        share.max(0.0)
    }
}

/// More than all rounding of a comparison.
const ROUNDING: f64 = 1e-6;

/// How far a vertex goes at most.
#[derive(Clone, Copy, Debug, Default)]
struct Reach {
    /// No step that it takes at any tolerance is longer; NaN where it takes none.
    longest: f32,
    /// Its steps shrink with the square of the tolerance below this.
    low: f32,
    /// The unit of its steps.
    budget: f32,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounds::Fit;

    #[test]
    fn a_share_ends_where_the_distance_is_reached() {
        for (below, up, across) in [
            (0.0, 1.0, 0.0),
            (0.5, 1.0, 0.0),
            (0.5, -1.0, 0.3),
            (0.9, 0.2, 0.8),
            (-0.4, 0.7, 0.1),
            (1.0, -0.5, 0.1),
        ] {
            let share = reaching(1.0, below, up, across);
            let end = f64::hypot(below + share * up, share * f64::sqrt(across));
            assert!(share > 0.0 && (end - 1.0).abs() < 1e-12, "{below} {up} {across}: {share}, {end}");
        }
        assert_eq!(reaching(1.0, 1.1, -1.0, 0.0), 0.0);
        // Away from a point as far as is allowed.
        assert_eq!(reaching(1.0, 1.0, 0.5, 0.1), 0.0);
    }

    #[test]
    fn no_step_at_any_tolerance_is_longer_than_allowed() {
        let displacement = Displacement::encode([[0.3, -0.4, 0.2], [-0.1, 0.3, 0.3]], ShortFloat::up(1.0));
        let vertex = Vertex { displacement, bound: 1.3, budget: 1.0 };
        for bound in [0.0, 0.1, 0.4, 0.8, 1.5] {
            let share = vertex.share(bound, |step, allowed| 0.3 * allowed / step.length());
            assert!(share < 1.0);
            let reach = |i: u32| {
                let tolerance = f64::from(i) * 1e-3;
                let step = share * DVec3::from_array(displacement.at(tolerance / 1.3)).length();
                step / (0.3 * tolerance.max(bound))
            };
            let most = (1..2_000).map(reach).fold(0.0, f64::max);
            assert!((most - 1.0).abs() < 1e-6, "{bound}: {most}");
        }
    }

    /// What is seen at once is what a closer look comes to.
    #[test]
    fn a_share_that_is_allowed_without_a_closer_look_is_allowed() {
        let (mut at_once, mut no_more) = (0, 0);
        let mut state = 5_u32;
        let mut random = |low: f64, high: f64| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            low + (high - low) * f64::from(state >> 8) / 16_777_216.0
        };
        for _ in 0..20_000 {
            let fit = if random(0.0, 1.0) < 0.2 { Fit::Corners } else { Fit::Slab };
            let mut node = NodeBounds { bound: 1.0, fit, ..NodeBounds::UNKNOWN };
            node.raise_bound(random(1.0, 3.0) as f32);
            let cluster = Cluster::around(&node, random(1.0, 1.2));
            let apart =
                [0; 2].map(|_| if node.is_from_corners() { 0.0 } else { random(-0.5, 1.0) * cluster.most });
            let mut step = || [0; 3].map(|_| random(-0.5, 0.5));
            let displacement = Displacement::encode([step(), step()], ShortFloat::up(1.0));
            let vertex = Vertex { displacement, bound: random(0.5, 12.0), budget: random(0.1, 3.0) };
            let share = random(0.1, 1.0);
            let allowed = cluster.share(&vertex, apart, share);
            if cluster.allows_all(apart, vertex.reach(), displacement, share) {
                at_once += 1;
                assert!(allowed >= share, "{allowed} of {share}");
            } else if allowed < share {
                no_more += 1;
            }
        }
        assert!(at_once > 2_000 && no_more > 2_000, "{at_once} {no_more}");
    }
}
