//! Where the extraction benches look from.

use fcextract::Perspective;
use fcgeom::Frustum;
use glam::DVec3;

/// Height of the picture in pixels, its width over its height, and half its vertical field of view as a tangent.
const HEIGHT: f64 = 720.0;
const ASPECT: f64 = 16.0 / 9.0;
const HALF_FIELD: f64 = 0.577_350_269_189_625_8;

/// An eye and a direction, in a picture of 1280 x 720 pixels and 60 degrees.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View {
    pub(crate) eye: DVec3,
    /// Unit vector.
    pub(crate) axis: DVec3,
}

impl View {
    /// So many views around a box, from where its diagonal fills the picture's height.
    pub(crate) fn around(low: DVec3, high: DVec3, count: usize) -> Vec<View> {
        let (center, size) = (low.midpoint(high), (high - low).length());
        let view = |i: usize| {
            let (sin, cos) = (std::f64::consts::TAU * (i as f64 + 0.3) / count as f64).sin_cos();
            let lift = if i.is_multiple_of(2) { 0.4 } else { -0.3 };
            let back = DVec3::new(sin, lift, cos).normalize_or(DVec3::Z);
            View { eye: center + back * (0.5 * size / HALF_FIELD), axis: -back }
        };
        (0..count).map(view).collect()
    }

    /// What allows so many pixels.
    pub(crate) fn tolerance(&self, pixels: f64) -> Perspective {
        Perspective::new(self.eye, self.axis, 2.0 * HALF_FIELD.atan(), [ASPECT * HEIGHT, HEIGHT], pixels)
    }

    /// How many pixels a length takes at a place at most, the growth of perspective off the axis counted.
    pub(crate) fn pixels(&self, place: DVec3, length: f64) -> f64 {
        length / self.tolerance(1.0).at(place, 0.0)
    }

    /// What is seen, for something of a size.
    pub(crate) fn frustum(&self, size: f64) -> Frustum {
        let to_eye = glam::dcamera::rh::view::look_to_mat4(self.eye, self.axis, DVec3::Y);
        let field = 2.0 * HALF_FIELD.atan();
        let projection =
            glam::dcamera::rh::proj::directx::perspective(field, ASPECT, size * 1e-3, size * 1e3);
        Frustum::from_view_projection(&(projection * to_eye))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixel_is_a_pixel_in_the_middle_and_the_box_fits() {
        for view in View::around(DVec3::splat(-1.0), DVec3::ONE, 4) {
            let distance = view.eye.length();
            let pixel = 2.0 * HALF_FIELD * distance / HEIGHT;
            assert!((view.pixels(DVec3::ZERO, pixel) - 1.0).abs() < 1e-6);
            assert!((view.eye + view.axis * distance).length() < 1e-9);
            assert!(distance > 3.0_f64.sqrt() / 2.0);
        }
    }
}
