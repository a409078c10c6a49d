//! Selections for copies of a model that stand in a world.

use crate::{Error, Perspective, Region, Selection, Tolerance};
use glam::{DMat4, DVec3, DVec4};

/// How far a matrix may be off one that turns and scales alike in all directions, next to its scale: what single precision
/// and some products leave. Lengths are then that far off too.
const ROUNDING: f64 = 1e-4;

/// From the world to a model.
struct ToLocal {
    /// The model's axes, unit vectors of the world.
    axes: [DVec3; 3],
    scale: f64,
    origin: DVec3,
}

impl Selection {
    /// The same for a copy of a model, in the model's coordinates, where this one is in those of the world.
    ///
    /// `local_to_world` places the copy: it turns, mirrors and moves, and scales alike in all directions, since a length and
    /// an angle must mean the same everywhere in the model. Lengths of the world become those of the model: with a scale of
    /// 2, half as long; slopes stay. What a budget added is left as it is.
    ///
    /// ```
    /// # use fcextract::{Order, Selection, Tolerance};
    /// # use glam::{DMat4, DVec3};
    /// let world = Selection::uniform(0.5, Order::Bound);
    /// let local = world.in_local_space(&DMat4::from_scale(DVec3::splat(2.0)))?;
    /// assert_eq!(local.tolerance, Tolerance::Uniform { distance: 0.25 });
    /// # Ok::<(), fcextract::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Selection`] when the matrix is not finite, or does anything else.
    pub fn in_local_space(&self, local_to_world: &DMat4) -> Result<Selection, Error> {
        let to = ToLocal::new(local_to_world)?;
        let tolerance = match self.tolerance {
            Tolerance::Full => Tolerance::Full,
            Tolerance::Uniform { distance } => Tolerance::Uniform { distance: distance / to.scale },
            Tolerance::Perspective(view) => Tolerance::Perspective(Perspective {
                eye: to.point(view.eye),
                axis: to.direction(view.axis),
                ..view
            }),
        };
        let region = |region: &Region| Region {
            center: to.point(region.center),
            radius: region.radius / to.scale,
            distance: region.distance / to.scale,
        };
        Ok(Selection {
            tolerance,
            order: self.order,
            regions: self.regions.iter().map(region).collect(),
            displaced: self.displaced,
            frustum: self.frustum.map(|frustum| frustum.in_local_space(local_to_world)),
            backface_eye: self.backface_eye.map(|eye| to.point(eye)),
            extra: self.extra.clone(),
        })
    }
}

impl ToLocal {
    fn new(local_to_world: &DMat4) -> Result<ToLocal, Error> {
        let columns = [local_to_world.x_axis, local_to_world.y_axis, local_to_world.z_axis];
        let [x, y, z] = columns.map(DVec4::truncate);
        let lengths = [x, y, z].map(DVec3::length);
        let scale = lengths.into_iter().fold(0.0, f64::max);
        let near = |number: f64, to: f64, unit: f64| (number - to).abs() <= ROUNDING * unit;
        let alike = lengths.iter().all(|length| near(*length, scale, scale))
            && [x.dot(y), y.dot(z), z.dot(x)].iter().all(|dot| near(*dot, 0.0, scale * scale));
        let places = local_to_world.row(3) == DVec4::W && scale > 0.0 && local_to_world.is_finite();
        if !(alike && places) {
            return Err(Error::Selection(
                "the matrix of a copy must turn, mirror, move and scale alike in all directions, and do nothing else"
                    .to_owned(),
            ));
        }
        let axes = [x, y, z].map(|axis| axis / scale);
        Ok(ToLocal { axes, scale, origin: local_to_world.w_axis.truncate() })
    }

    fn turned(&self, v: DVec3) -> DVec3 {
        DVec3::from(self.axes.map(|axis| axis.dot(v)))
    }

    fn point(&self, p: DVec3) -> DVec3 {
        self.turned(p - self.origin) / self.scale
    }

    /// Of the same length, but for rounding.
    fn direction(&self, v: DVec3) -> DVec3 {
        self.turned(v)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Frustum, Order, Sphere};
    use glam::DQuat;

    fn world() -> Selection {
        let (eye, axis) = (DVec3::new(3.0, 1.0, -9.0), DVec3::new(-0.3, 0.1, 1.0));
        let to_eye = glam::dcamera::rh::view::look_to_mat4(eye, axis.normalize_or_zero(), DVec3::Y);
        let projection = glam::dcamera::rh::proj::directx::perspective(1.0, 1.5, 0.1, 100.0);
        Selection {
            frustum: Some(Frustum::from_view_projection(&(projection * to_eye))),
            backface_eye: Some(eye),
            regions: vec![Region { center: DVec3::new(1.0, 2.0, 3.0), radius: 4.0, distance: 0.004 }],
            ..Selection::perspective(Perspective::new(eye, axis, 1.0, [1200.0, 800.0], 2.0), Order::Bound)
        }
    }

    /// A sphere of the model is allowed as much, and shows as much, as its image in the world.
    #[test]
    fn a_copy_is_looked_at_as_its_image_in_the_world() {
        let world = world();
        let turned = DQuat::from_euler(glam::EulerRot::XYZ, 0.4, -1.1, 2.0);
        let [mut regions, mut outside] = [0, 0];
        for (scale, mirror) in [(1.0, 1.0), (0.03, 1.0), (40.0, -1.0)] {
            let scales = DVec3::new(scale, scale, scale * mirror);
            let place = DMat4::from_scale_rotation_translation(scales, turned, DVec3::new(5.0, -7.0, 2.0));
            let local = world.in_local_space(&place).expect("it turns, scales and moves");
            let eye = place.transform_point3(local.backface_eye.expect("it has one"));
            assert!(eye.distance(world.backface_eye.expect("it has one")) < 1e-9);
            assert!(local.check().is_ok(), "its axis stays of length 1");
            let back = place.inverse();
            for i in 0..1000 {
                let at = |step: f64| 30.0 * ((f64::from(i) * step).fract() - 0.5);
                let (center, radius) =
                    (DVec3::new(at(0.618), at(0.414), at(0.732)), 0.02 * f64::from(5 + i % 50));
                let (here, size) = (back.transform_point3(center), radius / scale);
                let [there, found] = [world.allowed(|| (center, radius)), local.allowed(|| (here, size))];
                let (Some(there), Some(found)) = (there, found) else { panic!("a finite tolerance") };
                assert!((found * scale - there).abs() <= 1e-9 * there, "{found} of {there}");
                regions += usize::from(there == 0.004);
                let of = |selection: &Selection, center: DVec3, radius: f64| {
                    let sphere = Sphere { center: center.as_vec3(), radius: radius as f32 };
                    selection.frustum.expect("it has one").classify_sphere(&sphere)
                };
                let there = of(&world, center, radius);
                outside += usize::from(there == crate::Containment::Outside);
                // Single precision rounds the two spheres in two ways.
                let near = [0.99, 1.0, 1.01].map(|grown| of(&local, here, size * grown));
                assert!(near.contains(&there), "{there:?}, not {near:?}");
            }
        }
        assert!(regions > 30 && outside > 100, "{regions} in a region, {outside} outside");
    }

    #[test]
    fn a_matrix_that_changes_angles_is_refused() {
        let rows = DMat4::from_cols_array(&[
            1.0, 0.0, 0.0, 0.0, 0.5, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0,
        ]);
        let projection = glam::dcamera::rh::proj::directx::perspective(1.0, 1.0, 0.1, 10.0);
        let flat = DMat4::from_scale(DVec3::new(1.0, 1.0, 0.0));
        let uneven = DMat4::from_scale(DVec3::new(1.0, 1.1, 1.0));
        for bad in [rows, projection, flat, uneven, DMat4::ZERO, DMat4::from_translation(DVec3::NAN)] {
            assert!(matches!(world().in_local_space(&bad), Err(Error::Selection(_))), "{bad}");
        }
    }
}
