//! Promise: at one pixel of error no silhouette moves by more than a pixel and a half.
//!
//! What shows of the surface stays near: that follows from the bound. What the mesh adds beyond the surface has no bound
//! yet: five places in ten thousand are let pass, holes among them, and counted.
#![allow(clippy::print_stdout, reason = "the counts are part of the promise")]

mod model;

use fcbuild::import::{ImportOptions, import};
use fcbuild::{BuildOptions, SplitMode};
use fcview::options::FrameOptions;
use fcview::orbit::{Orbit, fly};
use fcview::{Detail, Image, Model, Renderer, Scene};
use std::path::{Path, PathBuf};

fn model_of(file: &Path) -> Model {
    let soup = import(file, &ImportOptions { max_faces: u64::MAX, progress: &|_, _| {} }).unwrap();
    let options = BuildOptions { split: SplitMode::Paper, ..BuildOptions::default() };
    let built = fcbuild::build(soup, &options).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.fct");
    fct::write(&path, &built.data(), &fct::WriteOptions { overwrite: true, source_id: 0 }).unwrap();
    // The map outlives the file's name.
    Model::open(&path).unwrap()
}

/// What a picture covers: where its depth is not that of the background.
struct Cover {
    width: usize,
    height: usize,
    covered: Vec<bool>,
}

impl Cover {
    fn of(image: &Image) -> Cover {
        let depth = image.depth.as_ref().unwrap();
        let [width, height] = [image.width, image.height].map(|n| n as usize);
        Cover { width, height, covered: depth.iter().map(|d| *d > 0.0).collect() }
    }

    /// Places covered here, or empty here, that the other picture shows so nowhere within one and a half pixels.
    fn lacking_in(&self, other: &Cover, covered: bool) -> usize {
        const REACH: i64 = (3 * FINER / 2) as i64;
        let stays = |i: usize| {
            let (x, y) = ((i % self.width) as i64, (i / self.width) as i64);
            (-REACH..=REACH).any(|dy| {
                (-REACH..=REACH).any(|dx| {
                    let (x, y) = (x + dx, y + dy);
                    let inside = x >= 0 && y >= 0 && x < self.width as i64 && y < self.height as i64;
                    dx * dx + dy * dy <= REACH * REACH
                        && inside
                        && other.covered[y as usize * self.width + x as usize] == self.covered[i]
                })
            })
        };
        let differs = |i: &usize| self.covered[*i] == covered && other.covered[*i] != covered;
        (0..self.covered.len()).filter(differs).filter(|&i| !stays(i)).count()
    }
}

/// Pictures are drawn so many times finer than the pixels that the promise speaks of: a spike or a gap thinner than a
/// pixel may fall between the centres of pixels, and would seem to have moved.
const FINER: u32 = 4;

/// By how much the colours of two pictures differ, of the whole range, in the mean over the pixels that either covers.
fn mean_difference(a: &Image, b: &Image) -> f64 {
    let (mut sum, mut pixels) = (0.0, 0_u32);
    let depths = a.depth.iter().flatten().zip(b.depth.iter().flatten());
    for ((p, q), (near, other)) in a.rgba.as_chunks::<4>().0.iter().zip(b.rgba.as_chunks::<4>().0).zip(depths)
    {
        if *near > 0.0 || *other > 0.0 {
            pixels += 1;
            sum += (0..3).map(|k| f64::from(p[k].abs_diff(q[k]))).sum::<f64>() / (3.0 * 255.0);
        }
    }
    sum / f64::from(pixels.max(1))
}

fn check(name: &str, file: &Path, instances: u32, size: [u32; 2]) {
    let scene = Scene::placed(vec![model_of(file)], instances, 1);
    let mut renderer = Renderer::new(model::gpu(), &scene).unwrap();
    let points = scene.extremes();
    let aspect = f64::from(size[0]) / f64::from(size[1]);
    let mut cameras = Vec::new();
    for (turn, zoom) in [(0.0, 1.0), (2.0, 0.5), (4.0, 2.0)] {
        let mut orbit = Orbit::around(&points, 0.7, aspect);
        orbit.turn(turn, 0.1);
        orbit.zoom(zoom);
        cameras.push(orbit.camera());
    }
    cameras.push(fly(&points, 0.9, 0.4));
    let coarse = FrameOptions {
        size,
        samples: 1,
        detail: Detail::Pixels(1.0),
        depth: true,
        ..FrameOptions::default()
    };
    let full = FrameOptions { detail: Detail::Full, ..coarse };
    for (view, camera) in cameras.iter().enumerate() {
        let (drawn, stats) = renderer.render(&scene, camera, &coarse).unwrap();
        let (exact, whole) = renderer.render(&scene, camera, &full).unwrap();
        let mean = mean_difference(&drawn, &exact);
        let (drawn, exact) = (Cover::of(&drawn), Cover::of(&exact));
        let lost = exact.lacking_in(&drawn, true);
        let added = drawn.lacking_in(&exact, true) + exact.lacking_in(&drawn, false);
        let holes = drawn.lacking_in(&exact, false);
        let differ = drawn.covered.iter().zip(&exact.covered).filter(|(a, b)| a != b).count();
        println!(
            "{name}, view {view}: {} triangles for {}, {differ} places differ, colours by {:.2} % in the mean; farther than a pixel and a half, {lost} are lost, {added} added, {holes} holes",
            stats.counts.triangles_drawn,
            whole.counts.triangles_drawn,
            100.0 * mean
        );
        let seen = exact.covered.iter().filter(|c| **c).count();
        assert!(seen > 1000, "{name}, view {view}: nothing is seen");
        assert!(
            stats.counts.triangles_drawn * 2 < whole.counts.triangles_drawn,
            "{name}: no detail is saved"
        );
        assert_eq!(lost, 0, "{name}, view {view}: parts of the surface are lost");
        assert!(
            (added + holes) * 2_000 <= seen,
            "{name}, view {view}: {added} places are added, {holes} are holes"
        );
    }
}

#[test]
fn silhouettes_stay_within_a_pixel_and_a_half() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/sculpture.ply");
    check("sculpture", &file, 8, [400, 225]);
}

#[test]
#[ignore = "needs the scans that FCT_DATA names; cargo xtask campaign runs it"]
fn scans() {
    let folder = std::env::var_os("FCT_DATA").expect("set FCT_DATA to a folder that holds dragon.ply");
    check("dragon", &PathBuf::from(folder).join("dragon.ply"), 20, [1280, 720]);
}
