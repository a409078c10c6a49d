//! Where a frozen cut was chosen from: the camera's view as lines in the picture.

use crate::camera::{Camera, View};
use egui::{Color32, Painter, Rect, Stroke, pos2};
use glam::{DVec3, DVec4};

/// The colour of the lines.
const COLOR: Color32 = Color32::from_rgb(0xFF, 0xC8, 0x57);

/// Draws the pyramid of what `frozen` sees, as deep as `depth`, into `area`, which shows `view`.
pub(super) fn draw(painter: &Painter, area: Rect, view: &View, frozen: &Camera, aspect: f64, depth: f64) {
    let stroke = Stroke::new(1.5, COLOR);
    for [from, to] in lines(frozen, aspect, depth) {
        if let Some(ends) = on_screen(view, from, to) {
            painter.line_segment(
                ends.map(|[x, y]| {
                    let across = area.width() * (0.5 + 0.5 * x as f32);
                    pos2(area.left() + across, area.top() + area.height() * (0.5 - 0.5 * y as f32))
                }),
                stroke,
            );
        }
    }
}

/// The edges of a camera's pyramid, in the scene.
fn lines(camera: &Camera, aspect: f64, depth: f64) -> Vec<[DVec3; 2]> {
    let Some(right) = camera.forward.cross(camera.up).try_normalize() else { return Vec::new() };
    let up = right.cross(camera.forward);
    let high = (0.5 * camera.fov).tan();
    let corner =
        |x: f64, y: f64| camera.eye + depth * (camera.forward + x * high * aspect * right + y * high * up);
    let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let mut lines: Vec<[DVec3; 2]> = corners.iter().map(|corner| [camera.eye, *corner]).collect();
    lines.extend((0..4).map(|k| [corners[k], corners[(k + 1) % 4]]));
    lines
}

/// A line's ends in the picture, -1 to 1, or `None` where all of it is behind the eye.
fn on_screen(view: &View, from: DVec3, to: DVec3) -> Option<[[f64; 2]; 2]> {
    let clip = |p: DVec3| view.clip_from_eye * (p - view.eye).extend(1.0);
    let (a, b) = (clip(from), clip(to));
    // What lies before this much of the near plane is cut off.
    let least = 0.01 * view.near;
    let cut = |inside: DVec4, outside: DVec4| {
        let t = (inside.w - least) / (inside.w - outside.w);
        inside + t * (outside - inside)
    };
    let (a, b) = match (a.w > least, b.w > least) {
        (true, true) => (a, b),
        (true, false) => (a, cut(a, b)),
        (false, true) => (cut(b, a), b),
        (false, false) => return None,
    };
    // Far outside, 32-bit numbers would no longer hold the slope.
    let flat = |p: DVec4| [p.x / p.w, p.y / p.w].map(|v| v.clamp(-1e4, 1e4));
    Some([flat(a), flat(b)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_camera_sees_its_own_pyramid_as_the_edge_of_its_picture() {
        let camera = Camera::look_at(DVec3::new(1.0, 2.0, 7.0), DVec3::ZERO, 0.7).unwrap();
        let view = camera.view([300, 200], 0.1).unwrap();
        let behind = Camera { eye: camera.eye - camera.forward, ..camera };
        for [from, to] in lines(&camera, 1.5, 5.0).into_iter().skip(4) {
            for end in on_screen(&view, from, to).unwrap().as_flattened() {
                assert!((end.abs() - 1.0).abs() < 1e-9, "{end}");
            }
        }
        for [from, to] in lines(&behind, 1.5, 0.5) {
            assert_eq!(on_screen(&view, from, to), None);
        }
        // Lines from behind the eye to before it are cut.
        for [from, to] in lines(&behind, 1.5, 5.0).into_iter().take(4) {
            let ends = on_screen(&view, from, to).unwrap();
            assert!(ends.as_flattened().iter().all(|v| v.is_finite()));
        }
    }
}
