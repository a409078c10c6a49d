//! How a cluster is seen along a direction.

use glam::{DMat3, DVec2, DVec3};

/// Where a vertex is seen: across the direction of a slab, and how high.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    pub(super) at: DVec2,
    pub(super) height: f64,
}

/// A direction to look along: rows across it, and its own.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gaze(DMat3);

impl Gaze {
    /// Along a unit vector.
    pub(crate) fn along(direction: DVec3) -> Gaze {
        let (x, y) = fcgeom::tangent_frame(direction);
        Gaze(DMat3::from_cols(x, y, direction).transpose())
    }

    /// What gives the places and heights as products.
    pub(super) fn rows(&self) -> [DVec3; 3] {
        let columns = self.0.transpose();
        [columns.x_axis, columns.y_axis, columns.z_axis]
    }

    /// The vector by which heights over a plane that leans so are products.
    pub(crate) fn leant(&self, slope: DVec2) -> DVec3 {
        self.0.transpose() * DVec3::new(-slope.x, -slope.y, 1.0)
    }

    #[inline]
    pub(super) fn see(&self, p: DVec3) -> Seen {
        let p = self.0 * p;
        Seen { at: p.truncate(), height: p.z }
    }
}
