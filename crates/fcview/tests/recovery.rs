//! Promise: a device that fails is made anew or emptied, the picture is the same after it, and there is an end to it.

mod model;

use fcview::orbit::Orbit;
use fcview::{Camera, Error, FrameOptions, Gpu, Occlusion, Scene, Survivor};

const SIZE: [u32; 2] = [96, 64];

fn scene() -> Scene {
    Scene::standing(vec![model::torus(32, 16)])
}

fn camera(scene: &Scene) -> Camera {
    Orbit::facing(&scene.extremes(), 0.7, 1.5).camera()
}

fn options(occlusion: Occlusion) -> FrameOptions {
    FrameOptions { size: SIZE, occlusion, ..FrameOptions::default() }
}

#[test]
fn a_lost_device_is_rebuilt_three_times_with_the_same_picture() {
    for occlusion in [Occlusion::Off, Occlusion::Exact] {
        let scene = scene();
        let mut opened = 0;
        let mut survivor = Survivor::new(&scene, || {
            opened += 1;
            Gpu::headless()
        })
        .unwrap();
        let camera = camera(&scene);
        let picture = |survivor: &mut Survivor<'_>| {
            survivor
                .draw(&camera, &options(occlusion), |renderer| renderer.image(false))
                .map(|(_, image)| image.rgba)
        };
        let before = picture(&mut survivor).unwrap();
        assert!(before.iter().any(|byte| *byte > 128), "the torus shows");
        for _ in 0..3 {
            survivor.gpu().unwrap().lose();
            assert!(picture(&mut survivor).unwrap() == before, "the picture has changed");
        }
        survivor.gpu().unwrap().lose();
        let error = picture(&mut survivor).unwrap_err();
        assert!(matches!(error, Error::DeviceLost { .. }), "{error}");
        assert_eq!(error.exit_code(), 6);
        drop(survivor);
        assert_eq!(opened, 4, "the first device and three more");
    }
}

#[test]
fn a_device_lost_between_drawing_and_reading_back_is_noticed() {
    let scene = scene();
    let mut survivor = Survivor::new(&scene, Gpu::headless).unwrap();
    let mut losses = 1;
    let (_, image) = survivor
        .draw(&camera(&scene), &options(Occlusion::Off), |renderer| {
            if losses > 0 {
                losses -= 1;
                renderer.gpu().lose();
            }
            renderer.image(false)
        })
        .unwrap();
    assert!(image.rgba.iter().any(|byte| *byte > 128), "the torus shows");
}

#[test]
fn without_memory_a_frame_is_drawn_again_from_nothing_and_then_given_up() {
    let scene = scene();
    let mut survivor = Survivor::new(&scene, Gpu::headless).unwrap();
    let camera = camera(&scene);
    for (shortages, drawn) in [(0, true), (1, true), (2, false), (1, true)] {
        let mut left = shortages;
        let result = survivor.draw(&camera, &options(Occlusion::Exact), |renderer| {
            if left > 0 {
                left -= 1;
                renderer.gpu().run_out_of_memory();
            }
            renderer.image(false)
        });
        match result {
            Ok((_, image)) => assert!(drawn && image.rgba.iter().any(|byte| *byte > 128)),
            Err(error) => {
                assert!(!drawn && matches!(error, Error::DeviceMemory { .. }), "{error}");
                assert_eq!((error.code(), error.exit_code()), ("FC525", 5));
            }
        }
    }
}

#[test]
fn a_thousand_sizes_with_none_among_them_leave_the_renderer_whole() {
    let scene = scene();
    let mut survivor = Survivor::new(&scene, Gpu::headless).unwrap();
    let camera = camera(&scene);
    let mut random = fcview::random::Random::new(7);
    let mut refused = 0;
    for step in 0..1000 {
        let mut side = || random.below(65) as u32;
        let size = if step % 10 == 0 { [0, 0] } else { [side(), side()] };
        let options = FrameOptions { size, samples: 1 + 3 * (step / 500), ..options(Occlusion::Off) };
        match survivor.draw(&camera, &options, |_| Ok(())) {
            Ok(_) => assert!(size[0] > 0 && size[1] > 0, "{size:?}"),
            Err(Error::PictureSize { .. }) => {
                assert!(size[0] == 0 || size[1] == 0, "{size:?}");
                refused += 1;
            }
            Err(error) => panic!("{size:?}: {error}"),
        }
    }
    assert!(refused >= 100);
    let (_, image) =
        survivor.draw(&camera, &options(Occlusion::Off), |renderer| renderer.image(false)).unwrap();
    assert_eq!([image.width, image.height], SIZE);
    assert!(image.rgba.iter().any(|byte| *byte > 128), "the torus shows");
}
