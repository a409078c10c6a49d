//! What a ray meets: the point of the surface under the mouse.

use crate::scene::{Instance, Scene};
use fct::{Child, Subtree, Tree};
use glam::DVec3;

/// The nearest point at which a ray from `eye` meets a face of a scene at full resolution, or `None` where it meets
/// none. Faces seen from behind are passed unless `backs`. `direction` is a unit vector. Where a tree is damaged, what
/// cannot be read is not met.
pub fn pick(scene: &Scene, eye: DVec3, direction: DVec3, backs: bool) -> Option<DVec3> {
    let mut nearest = f64::INFINITY;
    for instance in &scene.instances {
        if let Some(model) = scene.models.get(instance.model) {
            nearest = along_instance(&model.tree, instance, eye, direction, backs, nearest);
        }
    }
    nearest.is_finite().then(|| eye + nearest * direction)
}

/// The distance to the nearest face of an instance, if that is below `nearest`, else `nearest`.
fn along_instance(
    tree: &Tree,
    instance: &Instance,
    eye: DVec3,
    direction: DVec3,
    backs: bool,
    nearest: f64,
) -> f64 {
    let eye = instance.to_model(eye);
    let direction = instance.direction_to_model(direction);
    let reader = tree.reader();
    let mut nearest = nearest / instance.scale;
    // As deep as a path may be long, with a sibling on each step.
    let mut stack: Vec<(f64, Subtree)> = vec![(0.0, reader.whole())];
    while let Some((entry, subtree)) = stack.pop() {
        if entry >= nearest {
            continue;
        }
        if let Child::Face(_) = subtree.child.kind() {
            if let Some(distance) = reader.face(&subtree).ok().and_then(|face| {
                let corners = face.map(|vertex| {
                    let record = usize::try_from(vertex).ok().and_then(|v| reader.vertices().get(v))?;
                    Some(DVec3::from_array(record.position().map(f64::from)))
                });
                let [Some(a), Some(b), Some(c)] = corners else { return None };
                meet(eye, direction, [a, b, c], backs)
            }) {
                nearest = nearest.min(distance);
            }
            continue;
        }
        let Ok(children) = reader.children(&subtree) else { continue };
        let entries = children.map(|child| match child.child.kind() {
            Child::Face(_) => Some(0.0),
            Child::Node(_) => reader.node(&child).ok().and_then(|node| {
                let center = DVec3::from_array(node.center.map(f64::from));
                enter(eye, direction, center, f64::from(node.radius))
            }),
        });
        // The nearer one is looked at first, and often makes the other one needless.
        let [left, right] = [0, 1].map(|k| entries[k].map(|entry| (entry, children[k])));
        let nearer_left = left.is_some_and(|l| right.is_none_or(|r| l.0 <= r.0));
        stack.extend(if nearer_left { [right, left] } else { [left, right] }.into_iter().flatten());
    }
    nearest * instance.scale
}

/// The distance at which a ray comes into a sphere, 0 inside it, `None` if it never does.
fn enter(eye: DVec3, direction: DVec3, center: DVec3, radius: f64) -> Option<f64> {
    let to_center = center - eye;
    let along = to_center.dot(direction);
    let beside = (to_center - along * direction).length_squared();
    // A little more than the sphere, for the rounding of all this.
    let square = radius * radius * (1.0 + 1e-9) + 1e-18 * to_center.length_squared();
    if beside > square {
        return None;
    }
    let half = (square - beside).sqrt();
    (along + half >= 0.0).then(|| (along - half).max(0.0))
}

/// The distance at which a ray meets a triangle.
fn meet(eye: DVec3, direction: DVec3, [a, b, c]: [DVec3; 3], backs: bool) -> Option<f64> {
    let normal = (b - a).cross(c - a);
    let facing = -normal.dot(direction);
    if facing == 0.0 || (facing < 0.0 && !backs) {
        return None;
    }
    let distance = (eye - a).dot(normal) / facing;
    let point = eye + distance * direction;
    // On the inner side of each edge, seen along the normal.
    let inside = |p: DVec3, q: DVec3| (q - p).cross(point - p).dot(normal) >= 0.0;
    (distance >= 0.0 && inside(a, b) && inside(b, c) && inside(c, a)).then_some(distance)
}
