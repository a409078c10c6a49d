//! A cluster while it grows by merging: the sums that its plane and its errors follow from.

use fcgeom::{Eigen, FaceMoments, SymMat3, eigen, smallest_eigenvalue};
use glam::DVec3;

/// Sums over the faces of a cluster, in normal units.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cluster {
    pub(super) area: f64,
    /// The integral of positions.
    pub(super) first: DVec3,
    /// The integral of their outer products.
    pub(super) second: SymMat3,
    /// The integral of unit normals.
    pub(super) normal: DVec3,
    /// Area times epsilon: the integral of the squared distance from the plane.
    pub(super) error: f64,
    /// Length of the boundary.
    pub(super) perimeter: f32,
    /// The component that the faces belong to.
    pub(super) component: u32,
    /// The tree over the faces: a face of the mesh or a merge.
    pub(super) root: u32,
    pub(super) faces: u32,
    /// Edges on the longest path from the root of that tree to a face.
    pub(super) depth: u32,
}

impl Cluster {
    pub(super) fn of_face(face: u32, m: &FaceMoments, perimeter: f32, component: u32) -> Cluster {
        let (area, c) = (f64::from(m.area), m.centroid.as_dvec3());
        let [xx, xy, xz, yy, yz, zz] = m.spread.map(f64::from);
        let spread = SymMat3 { xx, xy, xz, yy, yz, zz };
        Cluster {
            area,
            first: c * area,
            second: (spread + SymMat3::outer(c)) * area,
            normal: m.normal.as_dvec3() * area,
            error: 0.0,
            perimeter,
            component,
            root: face,
            faces: 1,
            depth: 0,
        }
    }

    /// The two as one; its tree is not known yet.
    pub(super) fn union(&self, other: &Cluster, shared_length: f32) -> Cluster {
        let mut union = Cluster {
            area: self.area + other.area,
            first: self.first + other.first,
            second: self.second + other.second,
            normal: self.normal + other.normal,
            error: 0.0,
            perimeter: (self.perimeter + other.perimeter - 2.0 * shared_length).max(0.0),
            component: self.component,
            root: u32::MAX,
            faces: self.faces + other.faces,
            depth: 1 + self.depth.max(other.depth),
        };
        // A union is never flatter than its parts are together; rounding may say so.
        let error = union.area * smallest_eigenvalue(&union.covariance());
        union.error = error.max(self.error + other.error);
        union
    }

    /// `Z_rr`.
    fn covariance(&self) -> SymMat3 {
        let per_area = 1.0 / self.area;
        if !per_area.is_finite() {
            return SymMat3::ZERO;
        }
        let mean = self.first * per_area;
        self.second * per_area - SymMat3::outer(mean)
    }

    pub(super) fn centroid(&self, if_flat: DVec3) -> DVec3 {
        let centroid = self.first * (1.0 / self.area);
        if centroid.is_finite() { centroid } else { if_flat }
    }

    /// Principal axes of the positions.
    pub(super) fn axes(&self) -> Eigen {
        eigen(&self.covariance())
    }
}
