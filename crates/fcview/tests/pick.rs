//! Promise: the point under the mouse is the nearest point of all faces on its ray.

mod model;

use fcview::random::Random;
use fcview::{Scene, pick::pick};
use glam::DVec3;

/// The slow way: all faces of all instances, in the scene.
fn slow(scene: &Scene, eye: DVec3, direction: DVec3, backs: bool) -> Option<DVec3> {
    let mut nearest: Option<f64> = None;
    for instance in &scene.instances {
        let tree = &scene.models[instance.model].tree;
        for face in tree.faces().unwrap() {
            let [a, b, c] = face.map(|v| {
                let place = tree.vertices()[v as usize].position().map(f64::from);
                instance.to_world(DVec3::from_array(place))
            });
            // Möller and Trumbore's way.
            let (u, v) = (b - a, c - a);
            let p = direction.cross(v);
            let det = u.dot(p);
            if det <= 0.0 && !backs {
                continue;
            }
            let from = eye - a;
            let (s, q) = (from.dot(p) / det, from.cross(u));
            let (t, distance) = (direction.dot(q) / det, v.dot(q) / det);
            if s >= 0.0 && t >= 0.0 && s + t <= 1.0 && distance >= 0.0 {
                nearest = Some(nearest.map_or(distance, |n| n.min(distance)));
            }
        }
    }
    nearest.map(|distance| eye + distance * direction)
}

#[test]
fn the_walk_meets_what_all_faces_meet() {
    let scene = Scene::placed(vec![model::torus(24, 12), model::torus(7, 5)], 5, 3);
    let mut random = Random::new(12);
    let (mut met, mut missed) = (0, 0);
    for step in 0..600 {
        let eye = 4.0 * random.unit() * random.direction();
        let direction = random.direction();
        let backs = step % 2 == 0;
        match (pick(&scene, eye, direction, backs), slow(&scene, eye, direction, backs)) {
            (Some(fast), Some(slow)) => {
                assert!(fast.distance(slow) < 1e-9, "{fast} is not {slow}");
                met += 1;
            }
            (None, None) => missed += 1,
            (fast, slow) => panic!("{fast:?} is not {slow:?} from {eye} along {direction}"),
        }
    }
    assert!(met > 100 && missed > 100, "{met} met, {missed} missed");
}

#[test]
fn nothing_is_met_in_an_empty_scene_or_by_a_ray_that_is_none() {
    assert_eq!(pick(&Scene::default(), DVec3::ZERO, DVec3::X, true), None);
    let scene = Scene::standing(vec![model::torus(7, 5)]);
    assert_eq!(pick(&scene, DVec3::NAN, DVec3::X, true), None);
    assert_eq!(pick(&scene, DVec3::ZERO, DVec3::NAN, true), None);
}
