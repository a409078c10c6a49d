//! Promise: memory for vertices has a limit that is kept. What is enough for a frame changes no pixel of it, what is not
//! makes it coarser, and how a view is drawn depends on the view and the limit alone.

mod model;

use fcbuild::BuildOptions;
use fcbuild::import::{ImportOptions, import};
use fcview::options::FrameOptions;
use fcview::orbit::{Orbit, fly};
use fcview::{
    Camera, ColorMode, Detail, Error, FrameStats, Image, Model, Occlusion, Renderer, Scene, Survivor,
};
use std::path::Path;

/// Bytes of a page.
const PAGE: u64 = 256 * 20;

fn sculpture() -> Model {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/sculpture.ply");
    let soup = import(&file, &ImportOptions { max_faces: u64::MAX, progress: &|_, _| {} }).unwrap();
    let options = BuildOptions::default();
    let built = fcbuild::build(soup, &options).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sculpture.fct");
    fct::write(&path, &built.data(), &fct::WriteOptions { overwrite: true, source_id: 0 }).unwrap();
    // The map outlives the file's name.
    Model::open(&path).unwrap()
}

fn scene() -> Scene {
    Scene::placed(vec![sculpture(), model::torus(32, 16)], 6, 3)
}

fn options() -> FrameOptions {
    FrameOptions { size: [192, 120], queries: Some(256), ..FrameOptions::default() }
}

/// Views from around the scene and from within.
fn cameras(scene: &Scene) -> Vec<Camera> {
    let points = scene.extremes();
    let mut orbit = Orbit::around(&points, 0.8, 1.6);
    let mut cameras = Vec::new();
    for step in 0..4 {
        orbit.turn(1.3, 0.11);
        cameras.push(orbit.camera());
        cameras.push(fly(&points, 1.1, 0.07 + 0.23 * f64::from(step)));
    }
    cameras
}

fn limited(scene: &Scene, pages: u64) -> Renderer {
    Renderer::with_memory(model::gpu(), scene, Some(pages * PAGE)).unwrap()
}

fn total(scene: &Scene) -> u64 {
    scene.models.iter().map(|model| model.tree.vertices().len() as u64).sum::<u64>().div_ceil(256)
}

/// Draws all views.
fn draw(
    renderer: &mut Renderer,
    scene: &Scene,
    views: &[Camera],
    how: &FrameOptions,
) -> Vec<(Image, FrameStats)> {
    views.iter().map(|camera| renderer.render(scene, camera, how).unwrap()).collect()
}

/// The mean difference of channels, of 255.
fn difference(a: &Image, b: &Image) -> f64 {
    let sum: u64 = a.rgba.iter().zip(&b.rgba).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
    sum as f64 / a.rgba.len() as f64
}

#[test]
fn enough_memory_for_a_frame_changes_no_pixel_and_pages_come_and_go() {
    let scene = scene();
    let views = cameras(&scene);
    let pages = total(&scene) / 4;
    for color in [ColorMode::Shaded, ColorMode::Clusters] {
        let how = FrameOptions { color, detail: Detail::Pixels(1.75), ..options() };
        let whole = draw(&mut Renderer::new(model::gpu(), &scene).unwrap(), &scene, &views, &how);
        let mut renderer = limited(&scene, pages);
        let some = draw(&mut renderer, &scene, &views, &how);
        let mut evicted = 0;
        for (number, ((expected, all), (got, stats))) in whole.iter().zip(&some).enumerate() {
            let memory = &stats.memory;
            assert_eq!(memory.coarser, 1.0, "view {number}");
            assert_eq!(expected.differing_pixels(got), Some(0), "view {number}");
            assert_eq!(all.counts.triangles_drawn, stats.counts.triangles_drawn);
            assert_eq!((all.memory.pages_resident, memory.bytes), (all.memory.pages, pages * PAGE));
            assert!(memory.pages_resident <= pages && memory.pages_uploaded <= pages, "{memory:?}");
            evicted += memory.pages_evicted;
        }
        match color {
            ColorMode::Shaded => assert!(evicted > 0, "{evicted} pages evicted"),
            // Painted triangles bring their vertices with them.
            _ => assert!(some.iter().all(|(_, stats)| stats.memory.pages_uploaded == 0)),
        }
        // The last view again: nothing is missing.
        let (_, stats) = renderer.render(&scene, &views[views.len() - 1], &how).unwrap();
        assert_eq!((stats.memory.pages_uploaded, stats.memory.pages_evicted), (0, 0));
    }
}

#[test]
fn enough_for_everything_is_everything_at_once() {
    let scene = scene();
    let bytes = scene.models.iter().map(|model| model.tree.vertices().len() as u64 * 20).sum();
    for (bytes, all) in [(bytes, true), (bytes - 1, false)] {
        let mut renderer = Renderer::with_memory(model::gpu(), &scene, Some(bytes)).unwrap();
        let (_, stats) = renderer.render(&scene, &cameras(&scene)[0], &options()).unwrap();
        assert_eq!(stats.memory.pages_uploaded == 0, all, "{:?}", stats.memory);
        assert_eq!(stats.memory.pages_resident == stats.memory.pages, all);
    }
}

#[test]
fn too_little_memory_draws_coarser_and_near_the_truth() {
    let scene = scene();
    // From outside: within a model the nearest surfaces become coarse first.
    let views: Vec<Camera> = cameras(&scene).into_iter().step_by(2).collect();
    let mut whole = Renderer::new(model::gpu(), &scene).unwrap();
    for (detail, part) in [(Detail::Pixels(0.3), 12), (Detail::Gain(0.2), 12), (Detail::Triangles(60_000), 6)]
    {
        let how = FrameOptions { detail, ..options() };
        let mut renderer = limited(&scene, total(&scene) / part);
        let fine = draw(&mut whole, &scene, &views, &how);
        let coarse = draw(&mut renderer, &scene, &views, &how);
        for ((expected, all), (got, stats)) in fine.iter().zip(&coarse) {
            let apart = difference(expected, got);
            assert!(apart > 0.01 && apart < 2.0, "{apart} of 255 with {detail:?}");
            // Errors go about with the inverse of the number of vertices: a twelfth of them, twelve times the error. Budget
            // keys fall faster where hardly more than flat parts are left to refine, as at so many triangles.
            let most = if matches!(detail, Detail::Triangles(_)) { 16.0 } else { 12.0 };
            assert!(stats.memory.coarser > 1.0 && stats.memory.coarser < most, "{:?}", stats.memory);
            assert!(stats.counts.triangles_drawn < all.counts.triangles_drawn);
            if let Some(budget) = stats.budget {
                assert_eq!(budget.wanted, 60_000);
                assert!(budget.within && budget.selected < 30_000, "{budget:?}");
            }
        }
    }
}

#[test]
fn a_view_is_drawn_alike_whatever_was_drawn_before() {
    let scene = scene();
    let mut views = cameras(&scene);
    let how = FrameOptions { detail: Detail::Pixels(0.7), ..options() };
    let pages = total(&scene) / 5;
    let mut renderer = limited(&scene, pages);
    let forth = draw(&mut renderer, &scene, &views, &how);
    views.reverse();
    let mut back = draw(&mut renderer, &scene, &views, &how);
    back.reverse();
    views.reverse();
    for (number, (one, other)) in forth.iter().zip(&back).enumerate() {
        assert!(one.0.rgba == other.0.rgba, "view {number}");
        assert_eq!(one.1.memory.coarser, other.1.memory.coarser);
        let alone = limited(&scene, pages).render(&scene, &views[number], &how).unwrap();
        assert!(one.0.rgba == alone.0.rgba, "view {number}, alone");
        assert_eq!(one.1.memory.coarser, alone.1.memory.coarser);
    }
}

#[test]
fn culling_changes_no_pixel_where_memory_is_short() {
    let scene = scene();
    let views = cameras(&scene);
    // Without culling a frame needs more than fits at once: it is drawn in parts.
    let culled = FrameOptions { detail: Detail::Pixels(0.7), ..options() };
    let all = FrameOptions { frustum: false, occlusion: Occlusion::Off, ..culled };
    let both = FrameOptions { backface: false, ..all };
    let mut renderer = limited(&scene, total(&scene) / 12);
    let few = draw(&mut renderer, &scene, &views, &culled);
    let many = draw(&mut renderer, &scene, &views, &all);
    let most = draw(&mut renderer, &scene, &views, &both);
    let mut coarser = 0;
    let mut parts = 0;
    for (number, ((few, many), most)) in few.iter().zip(&many).zip(&most).enumerate() {
        assert_eq!(few.0.differing_pixels(&many.0), Some(0), "view {number}");
        let factors = [few, many, most].map(|(_, stats)| stats.memory.coarser);
        assert!(factors[0] == factors[1] && factors[1] == factors[2], "view {number}: {factors:?}");
        assert!(few.1.counts.triangles_drawn < many.1.counts.triangles_drawn);
        coarser += u32::from(factors[0] > 1.0);
        parts += u32::from(most.1.memory.pages_uploaded > total(&scene) / 12);
    }
    assert!(coarser >= 4 && parts >= 1, "{coarser} views coarser, {parts} drawn in parts");
}

#[test]
fn next_to_no_memory_draws_the_coarsest_mesh_or_says_what_is_missing() {
    let scene = scene();
    let camera = cameras(&scene)[1];
    let error = Renderer::with_memory(model::gpu(), &scene, Some(3 * PAGE - 1)).map(drop).unwrap_err();
    assert_eq!((error.code(), error.exit_code()), ("FC524", 5));
    assert!(matches!(error, Error::GpuMemory { .. }) && error.to_string().contains("15360"), "{error}");
    let mut whole = Renderer::new(model::gpu(), &scene).unwrap();
    let mut renderer = limited(&scene, 3);
    for detail in [Detail::Pixels(1.0), Detail::Triangles(10_000), Detail::Distance(0.01), Detail::Gain(1.0)]
    {
        let how = FrameOptions { detail, ..options() };
        let (image, stats) = renderer.render(&scene, &camera, &how).unwrap();
        assert!(stats.counts.triangles_drawn > 0 && stats.memory.coarser > 4.0, "{stats:?}");
        assert!(image.rgba.iter().any(|byte| *byte > 128), "{detail:?}");
    }
    // Every face is every face: pages come and go within the frame.
    for occlusion in [Occlusion::Off, Occlusion::Exact] {
        let how = FrameOptions { detail: Detail::Full, occlusion, ..options() };
        let (expected, _) = whole.render(&scene, &camera, &how).unwrap();
        let (got, stats) = limited(&scene, 40).render(&scene, &camera, &how).unwrap();
        assert_eq!(expected.differing_pixels(&got), Some(0));
        assert!(stats.memory.pages_uploaded > 40 && stats.memory.coarser == 1.0, "{:?}", stats.memory);
    }
}

#[test]
fn a_device_without_memory_goes_on_with_half_of_it_for_vertices() {
    let scene = scene();
    let camera = cameras(&scene)[0];
    let how = FrameOptions { detail: Detail::Pixels(0.3), ..options() };
    let mut survivor = Survivor::with_memory(&scene, None, fcview::Gpu::headless).unwrap();
    let mut bytes = total(&scene) * PAGE;
    for (shortages, halvings) in [(0, 0), (1, 0), (2, 1), (2, 1)] {
        let mut left = shortages;
        let (stats, image) = survivor
            .draw(&camera, &how, |renderer| {
                if left > 0 {
                    left -= 1;
                    renderer.gpu().run_out_of_memory();
                }
                renderer.image(false)
            })
            .unwrap();
        assert!(image.rgba.iter().any(|byte| *byte > 128), "{shortages} shortages");
        bytes >>= halvings;
        let memory = stats.memory;
        assert!(memory.bytes.abs_diff(bytes) <= 2 * PAGE, "{} bytes, expected {bytes}", memory.bytes);
    }
    let error = survivor
        .draw(&camera, &how, |renderer| {
            renderer.gpu().run_out_of_memory();
            renderer.image(false)
        })
        .unwrap_err();
    assert!(matches!(error, Error::DeviceMemory { .. }), "{error}");
}
