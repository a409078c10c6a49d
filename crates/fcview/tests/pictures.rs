//! Promise: a picture shows what the scene holds, whatever its size, and odd scenes and cameras are survived.

mod model;

use fcbuild::BuildOptions;
use fcbuild::import::{ImportOptions, import};
use fcview::options::FrameOptions;
use fcview::orbit::Orbit;
use fcview::pick::pick;
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

/// Colours of distances once spanned the whole sphere of a model, so that a flat one had a single colour.
#[test]
fn colours_of_distances_span_what_is_in_sight() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("steps.fct");
    // Two squares, the right one farther off, and one behind the camera.
    let square = |x: f32, z: f32| {
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[u, v]| Vec3::new(x + u, v, z))
    };
    let corners = [square(-1.0, 0.2), square(0.0, -0.2), square(0.0, 90.0)].concat();
    let faces = [0, 4, 8].iter().flat_map(|k| [[*k, k + 1, k + 2], [*k, k + 2, k + 3]]).collect();
    model::write(&path, &corners, faces);
    let scene = alone(Model::open(&path).unwrap());
    let mut renderer = Renderer::new(model::gpu(), &scene).unwrap();
    let camera = Camera::look_at(DVec3::new(0.0, 0.5, 6.0), DVec3::new(0.0, 0.5, 0.0), 0.4).unwrap();
    let options = FrameOptions { color: ColorMode::Depth, ..options() };
    let (image, _) = renderer.render(&scene, &camera, &options).unwrap();
    let pixel = |x: usize| <[u8; 4]>::try_from(&image.rgba[4 * (60 * 160 + x)..][..4]).unwrap();
    let [near, far] = [pixel(60), pixel(100)];
    // Red and green: from yellow to what lies between pink and blue.
    assert!(near[0] > far[0] + 60 && near[1] > far[1] + 80, "near {near:?}, far {far:?}");
}

/// A tree of octahedra around some places, from a file in double precision.
fn octahedra(places: &[DVec3]) -> Model {
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        6 * places.len(),
        8 * places.len()
    );
    for place in places {
        for tip in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z] {
            let [x, y, z] = (place + tip).to_array();
            text += &format!("{x} {y} {z}\n");
        }
    }
    for first in (0..6 * places.len()).step_by(6) {
        for side in 0..8 {
            let [a, b, c] = [side & 1, 2 + (side >> 1 & 1), 4 + (side >> 2)].map(|tip| first + tip);
            let [b, c] = if (side & 1) ^ (side >> 1 & 1) ^ (side >> 2) == 0 { [b, c] } else { [c, b] };
            text += &format!("3 {a} {b} {c}\n");
        }
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("octahedra.ply");
    std::fs::write(&path, text).unwrap();
    let soup = import(&path, &ImportOptions { max_faces: u64::MAX, progress: &|_, _| {} }).unwrap();
    let options = BuildOptions::default();
    let built = fcbuild::build(soup, &options).unwrap();
    let path = folder.path().join("octahedra.fct");
    fct::write(&path, &built.data(), &fct::WriteOptions { overwrite: true, source_id: 0 }).unwrap();
    Model::open(&path).unwrap()
}

/// Tiles of a survey, each a tree with an origin of its own, once were all drawn in one place.
#[test]
fn trees_stand_where_the_coordinates_of_their_inputs_put_them() {
    let corner = DVec3::new(4_500_000.0, 560_000.0, 300.0);
    let places = [0.0, 4.0, 8.0].map(|x| corner + DVec3::new(x, 0.0, 0.25 * x));
    let tiles = Scene::standing(places.map(|place| octahedra(&[place])).to_vec());
    assert_eq!(tiles.origin, corner);
    let joined = Scene::standing(vec![octahedra(&places)]);
    assert_ne!(joined.origin, corner, "a test of two origins has two");
    let joined = joined.about(corner);

    let camera = Orbit::around(&tiles.extremes(), 0.7, 4.0 / 3.0).camera();
    let picture = |scene: &Scene| {
        let mut renderer = Renderer::new(model::gpu(), scene).unwrap();
        renderer.render(scene, &camera, &options()).unwrap().0.depth.unwrap()
    };
    let [apart, as_one] = [&tiles, &joined].map(picture);
    assert!(as_one.iter().filter(|depth| **depth > 0.0).count() > 500);
    let near = [&tiles, &joined].map(|scene| scene.near(camera.eye) as f32);
    // Distances along the axis; none where the background shows.
    let distances = |depth: &[f32], near: f32| depth.iter().map(|d| near / d).collect::<Vec<_>>();
    let differing = distances(&apart, near[0])
        .iter()
        .zip(distances(&as_one, near[1]))
        .filter(|(a, b)| *a != b && (*a - b).abs() > 1e-3)
        .count();
    assert!(differing <= 2, "{differing} pixels differ");
    for place in places {
        let target = place - corner;
        let ray = (target - camera.eye).normalize_or_zero();
        let [met, expected] = [&tiles, &joined].map(|scene| pick(scene, camera.eye, ray, false).unwrap());
        assert!(met.distance(expected) < 1e-6 && met.distance(target) < 1.0, "{met} is not {expected}");
    }
}
