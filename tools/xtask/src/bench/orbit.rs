//! A fixed path of views around a mesh, and what a walk of each takes.

use fcextract::{Error, Extraction, Order, Perspective, Selection, extract};
use fcgeom::Frustum;
use fct::Tree;
use glam::DVec3;

/// Work over all views.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Visits {
    /// Nodes looked at.
    pub(crate) nodes: u64,
    /// Triangles drawn.
    pub(crate) triangles: u64,
}

/// Views of the path.
const VIEWS: usize = 60;

/// Error allowed, in pixels, in an image of this height and vertical field of view.
const PIXELS: f64 = 1.0;
const HEIGHT: f64 = 720.0;
const HALF_FIELD: f64 = 0.35;
const ASPECT: f64 = 16.0 / 9.0;

/// Walks the tree for each view of three rounds, ever nearer, with all that is outside or turned away left out.
///
/// # Errors
/// When the tree is damaged.
pub(crate) fn visits(tree: &Tree) -> Result<Visits, Error> {
    let [low, high] =
        [tree.meta().bounds_min, tree.meta().bounds_max].map(|p| DVec3::from_array(p.map(f64::from)));
    let mut visits = Visits::default();
    let mut out = Extraction::default();
    for view in 0..VIEWS {
        extract(tree, &selection(view, (low + high) * 0.5, (high - low).length()), &mut out)?;
        visits.nodes += out.stats.nodes_visited;
        visits.triangles += out.stats.triangles;
    }
    Ok(visits)
}

/// The view of this number around a mesh of this centre and diagonal.
fn selection(view: usize, center: DVec3, size: f64) -> Selection {
    let along = view as f64 / VIEWS as f64;
    let (sin, cos) = (along * 3.0 * std::f64::consts::TAU).sin_cos();
    let distance = size * (1.6 - 1.1 * along);
    let lift = 0.5 * (along * std::f64::consts::TAU).sin();
    let eye = center + DVec3::new(cos, lift, sin).normalize_or_zero() * distance;
    let axis = (center - eye).normalize_or_zero();
    let to_eye = glam::dcamera::rh::view::look_at_mat4(eye, center, DVec3::Y);
    let projection =
        glam::dcamera::rh::proj::directx::perspective(2.0 * HALF_FIELD, ASPECT, size * 1e-3, size * 20.0);
    let perspective = Perspective::new(eye, axis, 2.0 * HALF_FIELD, [ASPECT * HEIGHT, HEIGHT], PIXELS);
    Selection {
        frustum: Some(Frustum::from_view_projection(&(projection * to_eye))),
        backface_eye: Some(eye),
        ..Selection::perspective(perspective, Order::Bound)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fcgeom::{Containment, Sphere};

    #[test]
    fn the_centre_is_always_in_view_and_what_lies_behind_the_eye_never() {
        for view in 0..VIEWS {
            let center = DVec3::new(3.0, -2.0, 1.0);
            let selection = selection(view, center, 2.0);
            let (frustum, eye) = (selection.frustum.unwrap(), selection.backface_eye.unwrap());
            let ball = |p: DVec3| Sphere { center: p.as_vec3(), radius: 0.01 };
            assert_eq!(frustum.classify_sphere(&ball(center)), Containment::Inside);
            assert_eq!(frustum.classify_sphere(&ball(2.0 * eye - center)), Containment::Outside);
            assert!((1.0..3.3).contains(&(eye - center).length()));
        }
    }
}
