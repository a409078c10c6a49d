//! The camera: where it is, what it sees, and its matrices.

use crate::Error;
use fcextract::Perspective;
use glam::{DMat4, DVec3};

/// A perspective camera in the scene's coordinates (right-handed).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where it stands.
    pub eye: DVec3,
    /// Where it looks, unit length.
    pub forward: DVec3,
    /// What is up in the picture; need not be at right angles to `forward`.
    pub up: DVec3,
    /// Vertical field of view, radians, between 0 and pi.
    pub fov: f64,
}

/// A camera made ready for one picture.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// Where the camera stands.
    pub eye: DVec3,
    /// Unit vector to the right of the picture.
    pub right: DVec3,
    /// Unit vector to the top of the picture.
    pub up: DVec3,
    /// Unit vector into the picture.
    pub forward: DVec3,
    /// Takes positions relative to the eye, along the world's axes, to clip space. Depth is reversed: the near
    /// plane at 1, infinity at 0.
    pub clip_from_eye: DMat4,
    /// Distance of the near plane.
    pub near: f64,
    /// Width of a pixel at distance 1 along the axis.
    pub pixel: f64,
    /// Cosine of the angle between the axis and the corner of the picture.
    pub corner_cos: f64,
}

impl Camera {
    /// A camera at `eye` that looks at `target`, with +y up (or +z, when looking along y).
    ///
    /// # Errors
    /// [`Error::Camera`] if the two are one point, or not finite.
    pub fn look_at(eye: DVec3, target: DVec3, fov: f64) -> Result<Camera, Error> {
        let Some(forward) = (target - eye).try_normalize() else {
            return Err(Error::Camera { reason: "the eye is where it looks, or not finite" });
        };
        let up = if forward.y.abs() > 0.999 { DVec3::Z } else { DVec3::Y };
        Ok(Camera { eye, forward, up, fov })
    }

    /// The matrices for a picture of `size` pixels, with the near plane at `near`.
    ///
    /// # Errors
    /// [`Error::Camera`] if any number is not finite or the field of view, the near distance or the up vector
    /// make no picture.
    pub fn view(&self, size: [u32; 2], near: f64) -> Result<View, Error> {
        let bad = |reason| Err(Error::Camera { reason });
        if !self.eye.is_finite() {
            return bad("the eye is not finite");
        }
        let Some(forward) = self.forward.try_normalize() else {
            return bad("the view direction is zero or not finite");
        };
        let Some(right) = forward.cross(self.up).try_normalize() else {
            return bad("the up vector is zero, not finite, or along the view direction");
        };
        if !(self.fov > 0.0 && self.fov < std::f64::consts::PI) {
            return bad("the field of view is not between 0 and 180 degrees");
        }
        if !(near > 0.0 && near.is_finite()) {
            return bad("the near distance is not positive");
        }
        let [width, height] = size.map(|pixels| f64::from(pixels.max(1)));
        let aspect = width / height;
        let picture = Perspective::new(self.eye, forward, self.fov, [width, height], 1.0);
        let up = right.cross(forward);
        let rotation = DMat4::from_cols(
            glam::DVec4::new(right.x, up.x, -forward.x, 0.0),
            glam::DVec4::new(right.y, up.y, -forward.y, 0.0),
            glam::DVec4::new(right.z, up.z, -forward.z, 0.0),
            glam::DVec4::W,
        );
        let projection =
            glam::dcamera::rh::proj::directx::perspective_infinite_reverse(self.fov, aspect, near);
        Ok(View {
            eye: self.eye,
            right,
            up,
            forward,
            clip_from_eye: projection * rotation,
            near,
            pixel: picture.slope,
            corner_cos: picture.corner_cos,
        })
    }
}

impl View {
    /// Takes world positions to clip space.
    pub fn clip_from_world(&self) -> DMat4 {
        self.clip_from_eye * DMat4::from_translation(-self.eye)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Camera {
        Camera::look_at(DVec3::new(3.0, 2.0, 10.0), DVec3::new(0.5, 0.0, 0.0), 0.8).unwrap()
    }

    #[test]
    fn what_is_looked_at_is_in_the_middle_and_depth_is_reversed() {
        let view = camera().view([640, 480], 0.5).unwrap();
        let clip = view.clip_from_world() * DVec3::new(0.5, 0.0, 0.0).extend(1.0);
        assert!((clip.x / clip.w).abs() < 1e-12 && (clip.y / clip.w).abs() < 1e-12);
        let near = view.clip_from_eye * (view.forward * view.near).extend(1.0);
        assert!((near.z / near.w - 1.0).abs() < 1e-12);
        let far = view.clip_from_eye * (view.forward * 1e9).extend(1.0);
        assert!(far.z / far.w > 0.0 && far.z / far.w < 1e-8);
    }

    #[test]
    fn right_is_right_and_up_is_up() {
        let view = camera().view([640, 480], 0.5).unwrap();
        let ahead = view.eye + 5.0 * view.forward;
        let right = view.clip_from_world() * (ahead + view.right).extend(1.0);
        let up = view.clip_from_world() * (ahead + view.up).extend(1.0);
        assert!(right.x > 0.0 && up.y > 0.0);
        assert!(view.up.y > 0.0);
    }

    #[test]
    fn a_pixel_is_what_the_projection_says() {
        let view = camera().view([640, 480], 0.5).unwrap();
        let at = |offset: f64| {
            let p =
                view.clip_from_world() * (view.eye + 7.0 * view.forward + offset * view.right).extend(1.0);
            0.5 * (p.x / p.w) * 640.0
        };
        assert!((at(7.0 * view.pixel) - at(0.0) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn numbers_that_make_no_view_are_refused() {
        let good = camera();
        let bad = [
            Camera { eye: DVec3::NAN, ..good },
            Camera { forward: DVec3::ZERO, ..good },
            Camera { up: DVec3::ZERO, ..good },
            Camera { up: good.forward, ..good },
            Camera { fov: 0.0, ..good },
            Camera { fov: f64::NAN, ..good },
            Camera { fov: 4.0, ..good },
        ];
        for camera in bad {
            assert!(camera.view([64, 64], 0.1).is_err(), "{camera:?}");
        }
        assert!(good.view([64, 64], 0.0).is_err());
        assert!(good.view([64, 64], f64::INFINITY).is_err());
        assert!(Camera::look_at(DVec3::ONE, DVec3::ONE, 1.0).is_err());
    }
}
