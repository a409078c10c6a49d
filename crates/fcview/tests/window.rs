//! Promise: the window does what its keys, its mouse and its flags say, on a real display, and survives what happens
//! to windows.
#![cfg(all(feature = "window", target_os = "linux"))]

mod display;
mod model;

use display::{CONTROL, Display, ENTER, ESCAPE, HOME, PANEL, Viewer, end, wait_for};
use fcview::Camera;
use fcview::camera_path::CameraPath;
use fcview::random::Random;
use std::path::Path;

/// A folder with a torus and a finer one, and the viewer of the first.
fn open(display: &Display, words: &str) -> (tempfile::TempDir, Viewer) {
    let folder = folder();
    let viewer = display.view(folder.path(), &format!("torus.fct --size 900x600 {words}"));
    viewer.see_model();
    (folder, viewer)
}

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    model::write_torus(&folder.path().join("torus.fct"), 48, 24);
    model::write_torus(&folder.path().join("other.fct"), 9, 5);
    folder
}

/// Ends with a key and expects that all was well.
fn quit(viewer: Viewer) {
    viewer.press(ESCAPE);
    let (status, said) = viewer.end();
    assert_eq!(status.code(), Some(0), "{said}");
}

/// Records what the camera does meanwhile, from the first place to the last.
fn recorded(viewer: &Viewer, folder: &Path, meanwhile: impl FnOnce()) -> [Camera; 2] {
    let free = (0..).map(|n| folder.join(format!("fcview-path-{n}.json"))).find(|path| !path.exists());
    let path = free.unwrap();
    viewer.press(u32::from('r'));
    std::thread::sleep(std::time::Duration::from_millis(300));
    meanwhile();
    std::thread::sleep(std::time::Duration::from_millis(300));
    viewer.press(u32::from('r'));
    let way = wait_for("the recorded path", || CameraPath::read(&path).ok());
    [way.camera(0.0), way.camera(1.0)]
}

/// The picture that P saves.
fn saved(viewer: &Viewer, folder: &Path) -> (u32, u32, Vec<u8>) {
    let free = (0..).map(|n| folder.join(format!("fcview-{n}.png"))).find(|path| !path.exists());
    let path = free.unwrap();
    viewer.press(u32::from('p'));
    wait_for("the saved picture", || {
        let file = std::fs::File::open(&path).ok()?;
        let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().ok()?;
        let mut pixels = vec![0; reader.output_buffer_size()?];
        let info = reader.next_frame(&mut pixels).ok()?;
        Some((info.width, info.height, pixels))
    })
}

#[test]
fn mouse_and_keys_move_the_camera_as_the_documentation_says() {
    let display = Display::start();
    let (folder, viewer) = open(&display, "");
    let moves = |meanwhile: &dyn Fn()| recorded(&viewer, folder.path(), meanwhile);
    let middle = [600, 300];

    // Turning keeps the distance from what is turned around, the torus's middle.
    let [first, turned] = moves(&|| viewer.drag(1, middle, [700, 340]));
    assert!((first.eye.length() - turned.eye.length()).abs() < 0.02 * first.eye.length());
    assert!(first.forward.distance(turned.forward) > 0.1);
    // Panning keeps the direction.
    let [before, panned] = moves(&|| viewer.drag(3, middle, [700, 340]));
    assert!(before.forward.distance(panned.forward) < 1e-9 && before.eye.distance(panned.eye) > 0.05);
    // The wheel comes nearer.
    let [before, near] = moves(&|| viewer.wheel(middle, 4));
    assert!((near.eye - before.eye).dot(before.forward) > 0.1);
    // W flies ahead, D to the right, E up, and a drag then looks around from where the eye is.
    for (key, along) in [('w', near.forward), ('d', near.forward.cross(near.up)), ('e', near.up)] {
        let [before, flown] = moves(&|| {
            viewer.key(u32::from(key), true);
            std::thread::sleep(std::time::Duration::from_millis(300));
            // However busy the machine is, a frame has then been drawn while the key was down.
            saved(&viewer, folder.path());
            viewer.key(u32::from(key), false);
        });
        let way = flown.eye - before.eye;
        assert!(way.dot(along) > 0.8 * way.length() && way.length() > 0.05, "{key}: {way}");
        assert!(before.forward.distance(flown.forward) < 1e-9);
    }
    let [before, looked] = moves(&|| viewer.drag(1, middle, [700, 340]));
    assert!(before.eye.distance(looked.eye) < 1e-9 && before.forward.distance(looked.forward) > 0.1);
    // C turns around again from there, F sees everything from there, Home is the first view.
    let [before, after] = moves(&|| viewer.press(u32::from('c')));
    assert!(before.eye.distance(after.eye) < 1e-9 && before.forward.distance(after.forward) < 1e-9);
    let [before, fitted] = moves(&|| viewer.press(u32::from('f')));
    assert!(before.forward.distance(fitted.forward) < 1e-9 && before.eye.distance(fitted.eye) > 0.05);
    let [_, home] = moves(&|| viewer.press(HOME));
    assert!(home.eye.distance(first.eye) < 1e-9 && home.forward.distance(first.forward) < 1e-9);
    // A double click on the torus turns around what is there: it moves sideways only as far as the click was.
    let [before, centred] = moves(&|| viewer.double_click(on_the_torus(&viewer)));
    assert!(before.forward.distance(centred.forward) < 1e-9 && before.eye.distance(centred.eye) > 0.05);
    // T turns all the time.
    let [before, turned] = moves(&|| {
        viewer.press(u32::from('t'));
        std::thread::sleep(std::time::Duration::from_millis(500));
        saved(&viewer, folder.path());
        viewer.press(u32::from('t'));
    });
    assert!(before.forward.distance(turned.forward) > 0.02);
    quit(viewer);
}

/// A place of the window where the torus shows, off the middle.
fn on_the_torus(viewer: &Viewer) -> [i16; 2] {
    let picture = viewer.picture();
    let bright = |place: &usize| picture.rgb[*place][0] > 150 && place % picture.width > 500;
    let place = (0..picture.rgb.len()).rev().find(bright).unwrap() - 3 * picture.width;
    [place % picture.width, place / picture.width].map(|k| i16::try_from(k).unwrap())
}

#[test]
fn a_frozen_cut_is_outlined_and_the_panel_can_be_put_away() {
    let display = Display::start();
    let (folder, viewer) = open(&display, "");
    let yellow = |rgb: &[u8; 3]| rgb[0] > 220 && (170..230).contains(&rgb[1]) && rgb[2] < 130;
    viewer.press(u32::from(' '));
    viewer.wheel([600, 300], -12);
    viewer.drag(1, [600, 300], [800, 350]);
    viewer.see("the outline of a frozen view", |picture| picture.count(yellow) > 200);
    viewer.press(u32::from(' '));
    viewer.see("the outline gone", |picture| picture.count(yellow) == 0);
    viewer.see("the panel", |picture| picture.panel()[1] > 300);
    viewer.press(u32::from('h'));
    viewer.see("no panel", |picture| picture.panel() == [0, 0]);
    // V goes through all the colours and back, X draws edges and takes them away.
    viewer.press(HOME);
    let shaded = saved(&viewer, folder.path());
    for key in ['v', 'v', 'v', 'x'] {
        viewer.press(u32::from(key));
        assert!(saved(&viewer, folder.path()) != shaded, "{key} changes nothing");
    }
    viewer.press(u32::from('x'));
    viewer.press(u32::from('v'));
    assert!(saved(&viewer, folder.path()) == shaded);
    // Then the window shows just what is saved.
    let (width, height, pixels) = saved(&viewer, folder.path());
    assert_eq!((width, height), (900, 600));
    viewer.see("what was saved", |picture| {
        let near = |(a, b): (&[u8], &[u8; 3])| (0..3).all(|k| a[k].abs_diff(b[k]) < 3);
        pixels.chunks_exact(4).zip(&picture.rgb).all(near)
    });
    quit(viewer);
}

#[test]
fn another_file_is_opened_from_the_list_by_drop_or_not_at_all() {
    let display = Display::start();
    let (folder, mut viewer) = open(&display, "");
    assert_eq!(viewer.title(), "torus.fct - facetree");
    assert!(viewer.property("_NET_WM_ICON") > 64 * 64, "the window has an icon");
    let before = viewer.picture().count(|rgb| *rgb == PANEL);
    viewer.press(u32::from('o'));
    viewer.see("the list", |picture| picture.count(|rgb| *rgb == PANEL) > before + 10_000);
    viewer.write("other.fct");
    viewer.press(ENTER);
    wait_for("the other file", || (viewer.title() == "other.fct - facetree").then_some(()));
    let other = saved(&viewer, folder.path());

    // What is no tree changes nothing.
    std::fs::write(folder.path().join("mesh.ply"), "ply\n").unwrap();
    viewer.drop_file(&folder.path().join("mesh.ply"));
    viewer.drop_file(&folder.path().join("gone.fct"));
    assert!(saved(&viewer, folder.path()) == other);
    assert_eq!(viewer.title(), "other.fct - facetree");

    viewer.drop_file(&folder.path().join("torus.fct"));
    wait_for("the dropped file", || (viewer.title() == "torus.fct - facetree").then_some(()));
    assert!(saved(&viewer, folder.path()) != other);

    // Escape closes the list first.
    let before = viewer.picture().count(|rgb| *rgb == PANEL);
    viewer.press(u32::from('o'));
    viewer.see("the list", |picture| picture.count(|rgb| *rgb == PANEL) > before + 10_000);
    viewer.press(ESCAPE);
    viewer.see("no list", |picture| picture.count(|rgb| *rgb == PANEL) < before + 5_000);
    saved(&viewer, folder.path());
    viewer.runs("Escape with a list");
    viewer.key(CONTROL, true);
    viewer.press(u32::from('q'));
    viewer.key(CONTROL, false);
    let (status, said) = viewer.end();
    assert_eq!(status.code(), Some(0), "{said}");
}

#[test]
fn a_file_that_is_replaced_stays_on_display_or_is_shown_anew() {
    for watch in [false, true] {
        let display = Display::start();
        let (folder, mut viewer) = open(&display, if watch { "--watch" } else { "" });
        let before = saved(&viewer, folder.path());
        std::fs::rename(folder.path().join("other.fct"), folder.path().join("torus.fct")).unwrap();
        if watch {
            wait_for("the new file", || (saved(&viewer, folder.path()) != before).then_some(()));
            let now = saved(&viewer, folder.path());
            // A file that is gone, or no tree, leaves what is shown.
            std::fs::remove_file(folder.path().join("torus.fct")).unwrap();
            std::thread::sleep(std::time::Duration::from_millis(1500));
            std::fs::write(folder.path().join("torus.fct"), "no tree").unwrap();
            std::thread::sleep(std::time::Duration::from_millis(1500));
            assert!(saved(&viewer, folder.path()) == now);
        } else {
            std::thread::sleep(std::time::Duration::from_millis(1500));
            viewer.drag(1, [600, 300], [700, 340]);
            viewer.press(HOME);
            assert!(saved(&viewer, folder.path()) == before);
        }
        viewer.runs("replaced files");
        quit(viewer);
    }
}

#[test]
fn a_thousand_resizes_and_a_window_off_the_screen_are_survived() {
    let display = Display::start();
    let (folder, mut viewer) = open(&display, "");
    let mut random = Random::new(3);
    for step in 0..1000 {
        // X knows no size of zero; the window's own code for it, as of minimised windows elsewhere, has a unit test.
        let side = |random: &mut Random, most| 1 + random.below(most) as u32;
        let most = if step % 10 == 0 { 2 } else { 700 };
        viewer.resize(side(&mut random, most), side(&mut random, most));
        if step % 100 == 50 {
            viewer.show(false);
        }
        if step % 100 == 70 {
            viewer.show(true);
        }
        std::thread::sleep(std::time::Duration::from_millis(random.below(8)));
        viewer.runs(&format!("after {step} resizes"));
    }
    viewer.show(true);
    viewer.resize(640, 480);
    viewer.see("the model at the last size", |picture| picture.width == 640 && picture.bright() > 50);
    let (width, height, _) = saved(&viewer, folder.path());
    assert_eq!((width, height), (640, 480));
    quit(viewer);
}

#[test]
fn no_row_of_keys_clicks_and_sizes_ends_the_viewer() {
    let display = Display::start();
    let (_folder, mut viewer) = open(&display, "--instances 3");
    let mut random = Random::new(5);
    let keys =
        [['w', 'a', 's', 'd', 'q', 'e'], ['c', 'f', 't', ' ', '-', '='], ['v', 'x', 'o', 'h', 'r', 'p']];
    for step in 0..300 {
        let place = |random: &mut Random| [random.below(900) as i16, random.below(600) as i16];
        let (from, to) = (place(&mut random), place(&mut random));
        match random.below(8) {
            0 => viewer.drag(1 + random.below(3) as u8, from, to),
            1 => viewer.wheel(from, random.below(21) as i32 - 10),
            2 => viewer.double_click(from),
            3 => viewer.resize(100 + random.below(800) as u32, 100 + random.below(500) as u32),
            // Left down now and then, as when a window loses the keyboard in between.
            4 => viewer.key(u32::from(keys[0][random.below(6) as usize]), random.below(2) == 0),
            row => viewer.press(u32::from(keys[row as usize % 3][random.below(6) as usize])),
        }
        viewer.runs(&format!("after {step} steps"));
    }
    viewer.resize(900, 600);
    // The list of files takes the first Escape where it is open.
    viewer.press(ESCAPE);
    viewer.press(ESCAPE);
    let (status, said) = viewer.end();
    assert_eq!(status.code(), Some(0), "{said}");
}

#[test]
fn a_lost_device_is_rebuilt_in_the_window_three_times() {
    let display = Display::start();
    let (folder, viewer) = open(&display, "--lose-device 3");
    let mended = saved(&viewer, folder.path());
    quit(viewer);
    let whole = display.view(folder.path(), "torus.fct --size 900x600");
    whole.see_model();
    assert!(saved(&whole, folder.path()) == mended, "the picture has changed");
    quit(whole);
    let mut child = display.spawn(folder.path(), "torus.fct --size 900x600 --lose-device 4", &[]);
    let (status, said) = end(&mut child);
    assert_eq!(status.code(), Some(6), "{said}");
    assert!(said.contains("error[FC605]"), "{said}");
}

#[test]
fn without_memory_the_window_draws_more_coarsely_until_that_does_not_help() {
    let display = Display::start();
    let (folder, viewer) = open(&display, "--exhaust-memory 5");
    assert!(saved(&viewer, folder.path()).2.iter().any(|byte| *byte > 150), "the torus shows");
    quit(viewer);
    let mut child = display.spawn(folder.path(), "torus.fct --size 900x600 --exhaust-memory 1000", &[]);
    let (status, said) = end(&mut child);
    assert_eq!(status.code(), Some(5), "{said}");
    assert!(said.contains("error[FC525]"), "{said}");
}

#[test]
fn a_display_of_twice_the_density_has_a_panel_of_twice_the_size() {
    let display = Display::start();
    let folder = folder();
    let panel = |density: &str| {
        let words = "torus.fct --size 1200x780";
        let viewer = display.view_with(folder.path(), words, &[("WINIT_X11_SCALE_FACTOR", density)]);
        let picture = viewer.see("the panel", |picture| picture.panel()[0] > 0);
        assert_eq!([picture.width, picture.height], [1200, 780]);
        quit(viewer);
        picture.panel()[0] as f64
    };
    let ratio = panel("2") / panel("1");
    assert!((1.8..2.2).contains(&ratio), "{ratio}");
}

#[test]
fn a_display_that_goes_away_ends_the_viewer_at_once() {
    let mut display = Display::start();
    let (_folder, viewer) = open(&display, "");
    display.stop();
    let (status, said) = viewer.end();
    // The X library ends the program itself, with 1, before winit or we hear of it.
    assert!(matches!(status.code(), Some(1 | 6)), "{status}: {said}");
    assert!(!said.contains("panicked"), "{said}");
}
