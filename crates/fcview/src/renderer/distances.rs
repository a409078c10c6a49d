//! How far away what is in sight lies: the span of the colours for distances.

use crate::camera::View;
use crate::frame::pieces::sphere;
use crate::frame::plan::Plan;
use crate::scene::Scene;
use fcgeom::{Cone, Containment, Frustum, Sphere};
use fct::{Child, Subtree};
use glam::DVec3;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Spheres that are taken apart, the largest first: enough for a span that is true to a few hundredths, in a millisecond.
/// More would find little, since the spheres shrink with the root of their number.
const STEPS: usize = 4096;

/// Where a sphere around the eye, or one that holds it, begins, over its radius: colours of its inside would else take
/// the whole span.
const INSIDE: f64 = 0.25;

/// A part of an instance that is in sight, for all that is known.
struct Seen {
    /// Of its sphere, in the scene's unit.
    radius: f64,
    near: f64,
    far: f64,
    /// The number of the placed instance.
    placed: usize,
    subtree: Subtree,
}

/// The distances from the eye of the nearest and the farthest that is in sight, about, and no less apart than they are:
/// spheres of clusters that lie in the view, and that do not turn their back unless `backs` are drawn. Nothing is known of
/// what hides what. The near plane and twice that where nothing is in sight.
pub(super) fn in_sight(scene: &Scene, plan: &Plan, view: &View, backs: bool) -> [f64; 2] {
    let world = Frustum::from_view_projection(&view.clip_from_world());
    let mut waiting = BinaryHeap::new();
    for (number, placed) in plan.placed.iter().enumerate() {
        let Some(instance) = scene.instances.get(placed.instance) else { continue };
        let Some((center, radius)) = scene.sphere(instance) else { continue };
        let Some(model) = scene.models.get(placed.model) else { continue };
        let local = world.in_local_space(&instance.matrix());
        let around = Sphere { center: model.center.as_vec3(), radius: fcgeom::round_up(model.radius) };
        if local.classify_sphere(&around) != Containment::Outside {
            waiting.push(Seen::new(view, center, radius, number, model.tree.whole()));
        }
    }
    let [mut near, mut far] = [f64::INFINITY, 0.0_f64];
    for _ in 0..STEPS {
        let Some(seen) = waiting.pop() else { break };
        let placed = plan.placed.get(seen.placed);
        let instance = placed.and_then(|placed| scene.instances.get(placed.instance));
        let model = placed.and_then(|placed| scene.models.get(placed.model));
        let (Some(instance), Some(model)) = (instance, model) else { continue };
        let reader = model.tree.reader();
        let local = world.in_local_space(&instance.matrix());
        let eye = instance.to_model(view.eye);
        let parts = match seen.subtree.child.kind() {
            Child::Face(_) => vec![seen.subtree],
            // What is damaged is told by who cuts it.
            Child::Node(_) => reader.children(&seen.subtree).map_or_else(|_| Vec::new(), Vec::from),
        };
        for subtree in parts {
            let (center, radius) = sphere(&model.tree, &subtree);
            let around = Sphere { center: center.as_vec3(), radius: fcgeom::round_up(radius) };
            if local.classify_sphere(&around) == Containment::Outside {
                continue;
            }
            if let Child::Face(_) = subtree.child.kind() {
                // Of a face its corners tell: a sphere around a large one says little.
                for vertex in reader.face(&subtree).unwrap_or_default() {
                    let Some(record) = model.tree.vertices().get(vertex as usize) else { continue };
                    let place = instance.to_world(DVec3::from(record.position().map(f64::from)));
                    let distance = place.distance(view.eye);
                    (near, far) = (near.min(distance), far.max(distance));
                }
                continue;
            }
            let turns_away = || {
                reader.node(&subtree).is_ok_and(|node| {
                    Cone { axis: node.axis().into(), cos: node.cos() }.is_backfacing(&around, eye)
                })
            };
            if backs || !turns_away() {
                let (center, radius) = (instance.to_world(center), radius * instance.scale);
                waiting.push(Seen::new(view, center, radius, seen.placed, subtree));
            }
        }
    }
    for seen in &waiting {
        near = near.min(seen.near);
        far = far.max(seen.far);
    }
    if near > far {
        return [view.near, 2.0 * view.near];
    }
    let near = near.max(view.near);
    [near, far.max(near)]
}

impl Seen {
    fn new(view: &View, center: DVec3, radius: f64, placed: usize, subtree: Subtree) -> Seen {
        let distance = center.distance(view.eye);
        let near = (distance - radius).max(INSIDE * radius);
        Seen { radius, near, far: distance + radius, placed, subtree }
    }
}

impl Ord for Seen {
    fn cmp(&self, other: &Seen) -> Ordering {
        let place = |seen: &Seen| (seen.placed, seen.subtree.first_face);
        self.radius.total_cmp(&other.radius).then_with(|| place(other).cmp(&place(self)))
    }
}

impl PartialOrd for Seen {
    fn partial_cmp(&self, other: &Seen) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Seen {
    fn eq(&self, other: &Seen) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Seen {}
