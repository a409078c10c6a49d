//! Promise: frustum and cone culling remove only what cannot be seen, and most of what a test of every face would.

#![allow(clippy::print_stdout, reason = "the counts are part of the promise")]

use fcextract::{Extraction, Order, Perspective, Selection, extract};
use fcgeom::Frustum;
use fct::Tree;
use fctests::distance::position;
use fctests::random::Random;
use fctests::{meshes, trees};
use glam::{DMat4, DVec3};
use std::collections::BTreeMap;

/// A random camera that looks at a point near the model, from near or far.
struct Camera {
    eye: DVec3,
    axis: DVec3,
    projection: DMat4,
    frustum: Frustum,
}

fn random_camera(random: &mut Random, center: DVec3, size: f64) -> Camera {
    let eye = center + random.direction() * size * random.between(0.35, 2.0);
    let target = center + random.direction() * size * random.between(0.0, 0.5);
    let axis = (target - eye).normalize_or(DVec3::X);
    let up = if axis.y.abs() < 0.9 { DVec3::Y } else { DVec3::X };
    let view = glam::dcamera::rh::view::look_at_mat4(eye, target, up);
    let projection =
        glam::dcamera::rh::proj::directx::perspective(0.7, 16.0 / 9.0, size * 1e-3, size * 20.0) * view;
    Camera { eye, axis, projection, frustum: Frustum::from_view_projection(&projection) }
}

fn triangles(out: &Extraction) -> BTreeMap<[u32; 3], i64> {
    let mut counts = BTreeMap::new();
    for t in out.indices.chunks_exact(3) {
        *counts.entry([t[0], t[1], t[2]]).or_insert(0) += 1;
    }
    counts
}

/// Triangles of `all` that `some` lacks; panics if `some` has one that `all` lacks.
fn removed(all: &Extraction, some: &Extraction) -> Vec<[u32; 3]> {
    let mut counts = triangles(all);
    for (t, n) in triangles(some) {
        let left = counts.get_mut(&t).unwrap_or_else(|| panic!("culling drew another triangle: {t:?}"));
        *left -= n;
        assert!(*left >= 0, "culling drew {t:?} more often");
    }
    counts.into_iter().flat_map(|(t, n)| std::iter::repeat_n(t, n as usize)).collect()
}

/// All corners beyond one side of the image: certainly not to be seen.
fn is_outside(camera: &Camera, corners: [DVec3; 3]) -> bool {
    let clip = corners.map(|p| camera.projection * p.extend(1.0));
    (0..3).any(|k| clip.iter().all(|c| c[k] > c.w))
        || (0..2).any(|k| clip.iter().all(|c| c[k] < -c.w))
        || clip.iter().all(|c| c.z < 0.0)
}

fn is_backfacing(camera: &Camera, [a, b, c]: [DVec3; 3]) -> bool {
    (b - a).cross(c - a).dot(camera.eye - a) <= 0.0
}

#[derive(Default)]
struct Tally {
    removed: usize,
    oracle: usize,
    wrong: usize,
}

impl Tally {
    fn share(&self) -> f64 {
        self.removed as f64 / self.oracle.max(1) as f64
    }
}

fn look(name: &str, tree: &Tree, views: u64) -> [Tally; 2] {
    let [low, high] =
        [tree.meta().bounds_min, tree.meta().bounds_max].map(|b| DVec3::from_array(b.map(f64::from)));
    let (center, size) = ((low + high) * 0.5, (high - low).length());
    let mut random = Random::new(21);
    let (mut all, mut some) = (Extraction::default(), Extraction::default());
    let [mut frustum, mut cone] = [Tally::default(), Tally::default()];
    for view in 0..views {
        let camera = random_camera(&mut random, center, size);
        let slope =
            if view % 5 == 4 { 0.0 } else { 2.0 * (0.35_f64).tan() / 720.0 * random.between(0.5, 4.0) };
        let tolerance = Perspective { eye: camera.eye, axis: camera.axis, slope, corner_cos: 0.8 };
        let plain = Selection::perspective(tolerance, Order::Bound);
        let corners = |t: &[u32; 3]| t.map(|v| position(tree, v));
        let run = |selection: &Selection, out: &mut Extraction| {
            extract(tree, selection, out).unwrap_or_else(|e| panic!("{name}: {e}"));
        };
        run(&plain, &mut all);
        run(&Selection { frustum: Some(camera.frustum), ..plain.clone() }, &mut some);
        let gone = removed(&all, &some);
        frustum.removed += gone.len();
        frustum.wrong += gone.iter().filter(|t| !is_outside(&camera, corners(t))).count();
        let drawn = |out: &Extraction| -> Vec<[u32; 3]> {
            out.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect()
        };
        frustum.oracle += drawn(&all).iter().filter(|t| is_outside(&camera, corners(t))).count();
        run(&Selection { backface_eye: Some(camera.eye), ..plain.clone() }, &mut some);
        let gone = removed(&all, &some);
        cone.removed += gone.len();
        // Triangles that face the eye though no face of their cluster does: folded ones.
        cone.wrong += gone.iter().filter(|t| !is_backfacing(&camera, corners(t))).count();
        cone.oracle += drawn(&all).iter().filter(|t| is_backfacing(&camera, corners(t))).count();
    }
    println!(
        "{name}: frustum removes {:.1} % of {} outside, {} wrong; cones {:.1} % of {} backfacing, {} folded",
        100.0 * frustum.share(),
        frustum.oracle,
        frustum.wrong,
        100.0 * cone.share(),
        cone.oracle,
        cone.wrong
    );
    [frustum, cone]
}

fn check(name: &str, tree: &Tree, views: u64) {
    let [frustum, cone] = look(name, tree, views);
    assert_eq!(frustum.wrong, 0, "{name}: frustum culling removed what may be seen");
    assert!(
        frustum.share() >= 0.7,
        "{name}: frustum culling removes {:.2} of what it could",
        frustum.share()
    );
    assert!(cone.share() >= 0.7, "{name}: cone culling removes {:.2} of what it could", cone.share());
    assert!(cone.wrong * 200 <= cone.removed, "{name}: {} of {} folded", cone.wrong, cone.removed);
}

#[test]
fn sample_meshes() {
    for name in ["sculpture.ply", "terrain.ply"] {
        check(name, &trees::tree_of(trees::read(&trees::data(name))), 30);
    }
}

#[test]
fn made_in_memory() {
    check("torus", &trees::tree_of(meshes::torus(160, 90, 3)), 40);
}

#[test]
#[ignore = "needs the scans that FCT_DATA names; cargo xtask campaign runs it"]
fn scans() {
    for name in ["bunny.ply", "armadillo.ply", "dragon.ply"] {
        check(name, &trees::tree_of(trees::scan(name)), 10);
    }
}
