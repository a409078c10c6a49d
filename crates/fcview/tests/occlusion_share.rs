//! Promise: occlusion queries remove most of what a test of every single triangle would, and change no pixel.
//!
//! The oracle draws the triangles' numbers: hidden are those that cover the centre of a pixel and show in none. Back
//! faces count nowhere; they are the cones' share.

mod model;

use fcbuild::import::{ImportOptions, import};
use fcbuild::{BuildOptions, SplitMode};
use fcview::options::FrameOptions;
use fcview::orbit::{Orbit, fly};
use fcview::{Camera, Detail, Model, Occlusion, Renderer, Scene};
use std::path::Path;

/// The sample sculpture as a model.
fn sculpture() -> Model {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/sculpture.ply");
    let soup = import(&file, &ImportOptions { max_faces: u64::MAX, progress: &|_, _| {} }).unwrap();
    let options = BuildOptions { split: SplitMode::Paper, ..BuildOptions::default() };
    let built = fcbuild::build(soup, &options).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sculpture.fct");
    fct::write(&path, &built.data(), &fct::WriteOptions { overwrite: true, source_id: 0 }).unwrap();
    // The map outlives the file's name.
    Model::open(&path).unwrap()
}

fn cameras(scene: &Scene) -> Vec<(&'static str, Camera)> {
    let points = scene.extremes();
    let around = Orbit::around(&points, 0.7, 640.0 / 360.0);
    let mut cameras = Vec::new();
    let mut orbit = |name, turn: f64, zoom: f64| {
        let mut orbit = around;
        orbit.turn(turn, 0.1);
        orbit.zoom(zoom);
        cameras.push((name, orbit.camera()));
    };
    orbit("whole", 0.0, 1.0);
    orbit("whole, other side", 2.2, 1.0);
    orbit("far", 1.1, 2.5);
    orbit("near", 4.0, 0.55);
    cameras.push(("inside", fly(&points, 0.9, 0.3)));
    cameras.push(("inside, on", fly(&points, 0.9, 0.62)));
    cameras
}

#[test]
fn queries_remove_seven_tenths_of_what_a_test_of_every_triangle_would() {
    // Fine pieces and many rounds: the most that the method does, not the fastest.
    let fine =
        FrameOptions { size: [640, 360], queries: Some(32_768), measure: true, ..FrameOptions::default() };
    let scene = Scene::placed(vec![sculpture()], 16, 3);
    let mut renderer = Renderer::new(model::gpu(), &scene).unwrap();
    for (level, detail) in [("1 pixel", Detail::Pixels(1.0)), ("full resolution", Detail::Full)] {
        for (view, camera) in cameras(&scene) {
            let on = FrameOptions { detail, ..fine };
            let (census, stats) = renderer.census(&scene, &camera, &on).unwrap();
            let culled = renderer.image(true).unwrap();
            let off = FrameOptions { occlusion: Occlusion::Off, depth: true, ..on };
            let (whole, plain) = renderer.render(&scene, &camera, &off).unwrap();
            let usual = FrameOptions { size: fine.size, detail, ..FrameOptions::default() };
            let (few, _) = renderer.census(&scene, &camera, &usual).unwrap();
            let usual = few.removed as f64 / few.oracle().max(1) as f64;
            let share = census.removed as f64 / census.oracle().max(1) as f64;
            println!(
                "{level}, {view}: {:.1} % ({:.1} % as usual) of {} hidden removed, of {} that cover a pixel, of {}; {} queries, {:.0} ms, without {:.0} ms",
                100.0 * share,
                100.0 * usual,
                census.oracle(),
                census.covering,
                plain.counts.triangles_drawn,
                stats.counts.queries,
                stats.milliseconds.total,
                plain.milliseconds.total,
            );
            assert!(census.oracle() > 1000, "{level}, {view}: too little is hidden to tell");
            assert_eq!(census.wrong + few.wrong, 0, "{level}, {view}: triangles that show were removed");
            assert_eq!(culled.differing_pixels(&whole), Some(0), "{level}, {view}: the pictures differ");
            assert_eq!(culled.depth, whole.depth, "{level}, {view}: the depths differ");
            let least = if detail == Detail::Full { 0.55 } else { 0.65 };
            assert!(usual >= least, "{level}, {view}: with the usual options the queries remove {usual:.2}");
            assert!(share >= 0.70, "{level}, {view}: the queries remove {share:.2} of what is hidden");
        }
    }
}
