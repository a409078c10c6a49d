//! Promise: a picture shows what the scene holds, whatever its size, and odd scenes and cameras are survived.

mod model;

use fcview::options::FrameOptions;
use fcview::orbit::Orbit;
use fcview::{Camera, ColorMode, Detail, Error, Instance, Model, Occlusion, Renderer, Scene};
use glam::{DVec3, Vec3};
use std::sync::Arc;

fn options() -> FrameOptions {
    FrameOptions { size: [160, 120], detail: Detail::Full, depth: true, ..FrameOptions::default() }
}

fn alone(model: Model) -> Scene {
    Scene::placed(vec![model], 1, 0)
}

#[test]
fn depth_is_the_near_distance_over_the_distance_along_the_axis() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("square.fct");
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| Vec3::new(x, y, 0.0));
    model::write(&path, &corners, vec![[0, 1, 2], [0, 2, 3]]);
    let scene = alone(Model::open(&path).unwrap());
    let mut renderer = Renderer::new(model::gpu(), &scene).unwrap();
    let camera = Camera::look_at(DVec3::new(0.0, 0.0, 4.0), DVec3::ZERO, 0.8).unwrap();
    let (image, stats) = renderer.render(&scene, &camera, &options()).unwrap();
    assert_eq!(stats.counts.triangles_drawn, 2);
    let depth = image.depth.unwrap();
    let near = scene.near(camera.eye);
    let middle = f64::from(depth[60 * 160 + 80]);
    assert!((near / middle - 4.0).abs() < 1e-5, "distance {}", near / middle);
    // The square is 2 wide, the picture 2 * 4 * tan 0.4 high: so many pixels of 120 are its height.
    let column = (0..120).filter(|y| depth[y * 160 + 80] > 0.0).count();
    let expected = 120.0 * 2.0 / (8.0 * 0.4_f64.tan());
    assert!((column as f64 - expected).abs() <= 1.0, "{column} pixels, expected {expected}");
    assert_eq!(depth[0], 0.0, "the corner shows background");
    // From behind there is nothing but back faces.
    let behind = Camera::look_at(DVec3::new(0.0, 0.0, -4.0), DVec3::ZERO, 0.8).unwrap();
    let (hidden, _) = renderer.render(&scene, &behind, &options()).unwrap();
    assert!(hidden.depth.unwrap().iter().all(|d| *d == 0.0));
    let both = FrameOptions { two_sided: true, ..options() };
    let (shown, _) = renderer.render(&scene, &behind, &both).unwrap();
    assert!(shown.depth.unwrap()[60 * 160 + 80] > 0.0);
}

#[test]
fn the_same_view_gives_the_same_picture_and_another_size_its_own() {
    let scene = Scene::placed(vec![model::torus(48, 24)], 5, 1);
    let mut renderer = Renderer::new(model::gpu(), &scene).unwrap();
    let camera = Orbit::around(&scene.extremes(), 0.7, 1.3).camera();
    let (first, stats) = renderer.render(&scene, &camera, &options()).unwrap();
    assert!(stats.counts.triangles_drawn > 0);
    assert!(first.depth.as_ref().unwrap().iter().filter(|d| **d > 0.0).count() > 500);
    for size in [[1, 1], [33, 7], [640, 360]] {
        let sized = FrameOptions { size, samples: 4, ..options() };
        let (image, _) = renderer.render(&scene, &camera, &sized).unwrap();
        assert_eq!(image.rgba.len(), 4 * size[0] as usize * size[1] as usize);
        assert_eq!(image.depth, None, "several samples a pixel have no one depth");
    }
    let (again, _) = renderer.render(&scene, &camera, &options()).unwrap();
    assert_eq!(first, again);
}

#[test]
fn the_library_function_draws_the_same() {
    model::gpu();
    let scene = alone(model::torus(24, 12));
    let camera = Orbit::around(&scene.extremes(), 0.7, 1.3).camera();
    let (one, _) = fcview::render(&scene, &camera, &options()).unwrap();
    let (other, _) = fcview::render(&scene, &camera, &options()).unwrap();
    assert_eq!(one, other);
}

#[test]
fn a_copy_is_seen_where_it_stands_whatever_its_scale() {
    // A model twice as large and twice as far fills the same pixels.
    let model = model::torus(48, 24);
    let mut scene = alone(model);
    let mut renderer = Renderer::new(model::gpu(), &scene).unwrap();
    let camera = Camera::look_at(DVec3::new(1.0, 2.0, 4.0), DVec3::ZERO, 0.8).unwrap();
    let (image, _) = renderer.render(&scene, &camera, &options()).unwrap();
    scene.instances = vec![Instance { scale: 2.0, ..Instance::unmoved(0) }];
    let far = Camera { eye: 2.0 * camera.eye, ..camera };
    let (scaled, _) = renderer.render(&scene, &far, &options()).unwrap();
    assert_eq!(image.differing_pixels(&scaled), Some(0));
}

/// Squares of tiny lengths are zero in single precision.
#[test]
fn a_tiny_model_is_shaded_as_a_large_one() {
    let model = model::torus(48, 24);
    let [large, tiny] = [1.0, f64::from(2.0_f32.powi(-50))].map(|scale| {
        let mut scene = alone(model.clone());
        scene.instances[0].scale *= scale;
        scene.instances[0].translation *= scale;
        let camera = Orbit::around(&scene.extremes(), 0.7, 1.3).camera();
        let options = FrameOptions { depth: false, ..options() };
        fcview::render(&scene, &camera, &options).unwrap().0
    });
    let differing = large.differing_pixels(&tiny).unwrap();
    assert!(differing < 160 * 120 / 20, "{differing} pixels differ");
}

#[test]
fn a_scene_of_another_size_or_place_needs_another_view() {
    let model = model::torus(24, 12);
    let scene = |scale: f64, x: f64| {
        let mut scene = alone(model.clone());
        scene.instances =
            vec![Instance { scale, translation: DVec3::new(x, 0.0, 0.0), ..Instance::unmoved(0) }];
        scene
    };
    let usual = scene(1.0, 0.0);
    for (size, x, fits) in
        [(1.0, 0.0, true), (1.5, 0.1, true), (1000.0, 0.0, false), (0.001, 0.0, false), (1.0, 9.0, false)]
    {
        assert_eq!(scene(size, x).fills_the_view_of(&usual), fits, "{size} {x}");
    }
}

#[test]
fn an_empty_scene_is_background() {
    let scene = Scene::placed(vec![model::torus(8, 8)], 0, 1);
    let mut renderer = Renderer::new(model::gpu(), &scene).unwrap();
    let camera = Orbit::around(&scene.extremes(), 0.7, 1.3).camera();
    for occlusion in [Occlusion::Exact, Occlusion::Off] {
        let (image, stats) =
            renderer.render(&scene, &camera, &FrameOptions { occlusion, ..options() }).unwrap();
        assert_eq!(stats.counts.triangles_drawn, 0);
        assert!(image.depth.unwrap().iter().all(|d| *d == 0.0));
        assert!(image.rgba.as_chunks::<4>().0.iter().all(|p| p[0] < 120 && p[3] == 255));
    }
}

#[test]
fn a_tree_of_one_face_is_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("face.fct");
    model::write(&path, &[Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]]);
    let scene = alone(Model::new("face", Arc::new(fct::Tree::open(&path).unwrap())));
    let mut renderer = Renderer::new(model::gpu(), &scene).unwrap();
    let camera = Camera::look_at(DVec3::new(0.3, 0.3, 2.0), DVec3::new(0.3, 0.3, 0.0), 0.8).unwrap();
    for color in [ColorMode::Shaded, ColorMode::Clusters] {
        let (image, stats) = renderer.render(&scene, &camera, &FrameOptions { color, ..options() }).unwrap();
        assert_eq!(stats.counts.triangles_drawn, 1);
        assert!(image.depth.unwrap()[60 * 160 + 80] > 0.0);
    }
}

#[test]
fn cameras_without_a_view_are_errors_and_far_or_inside_ones_are_not() {
    let scene = alone(model::torus(24, 12));
    let mut renderer = Renderer::new(model::gpu(), &scene).unwrap();
    let good = Orbit::around(&scene.extremes(), 0.7, 1.3).camera();
    for bad in
        [Camera { eye: DVec3::NAN, ..good }, Camera { up: DVec3::ZERO, ..good }, Camera { fov: -1.0, ..good }]
    {
        let error = renderer.render(&scene, &bad, &options()).unwrap_err();
        assert!(matches!(error, Error::Camera { .. }), "{error}");
    }
    for eye in [DVec3::ZERO, DVec3::new(1.0, 0.0, 0.1), DVec3::new(0.0, 0.0, 1e9)] {
        for detail in [Detail::Full, Detail::Pixels(1.0)] {
            let camera = Camera { eye, ..good };
            renderer.render(&scene, &camera, &FrameOptions { detail, ..options() }).unwrap();
        }
    }
    let huge = FrameOptions { size: [1 << 20, 4], ..options() };
    let error = renderer.render(&scene, &good, &huge).unwrap_err();
    assert_eq!((error.code(), error.exit_code()), ("FC521", 5));
    renderer.render(&scene, &good, &options()).unwrap();
}
