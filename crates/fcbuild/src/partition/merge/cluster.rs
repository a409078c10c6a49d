//! A cluster while it grows by merging: the sums that its plane and its errors follow from.

use crate::colors::Coloring;
use fcgeom::{FaceMoments, SymMat3, smallest_eigenpair_near, smallest_eigenvalue};
use glam::DVec3;

/// Sums over the faces of a cluster, in normal units.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cluster<C> {
    pub(super) area: f64,
    pub(super) centroid: DVec3,
    /// The integral of the outer products of positions, counted from the centroid: area times `Z_rr`.
    pub(super) spread: SymMat3,
    /// The integral of unit normals.
    pub(super) normal: DVec3,
    /// Area times epsilon: the integral of the squared distance from the plane.
    pub(super) error: f64,
    /// The error when it is drawn as one polygon, see [`lost`], and what is lost of the colours.
    pub(super) lost: f64,
    pub(super) colors: C,
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

impl<C: Coloring> Cluster<C> {
    pub(super) fn of_face(face: u32, m: &FaceMoments, colors: C, perimeter: f32, component: u32) -> Self {
        let area = f64::from(m.area);
        let [xx, xy, xz, yy, yz, zz] = m.spread.map(f64::from);
        Cluster {
            area,
            centroid: m.centroid.as_dvec3(),
            spread: SymMat3 { xx, xy, xz, yy, yz, zz } * area,
            normal: m.normal.as_dvec3() * area,
            error: 0.0,
            lost: 0.0,
            colors,
            perimeter,
            component,
            root: face,
            faces: 1,
            depth: 0,
        }
    }

    /// The two as one; its tree is not known yet.
    // Most callers ask for a part of it.
    #[inline(always)]
    pub(super) fn union(&self, other: &Self, shared_length: f32) -> Self {
        let area = self.area + other.area;
        // Two clusters without area count the same.
        let share = if area > 0.0 { other.area / area } else { 0.5 };
        let apart = other.centroid - self.centroid;
        let weight = self.area * share;
        let spread = self.spread + other.spread + SymMat3::outer(apart) * weight;
        let colors = self.colors.union(&other.colors, share, apart, weight);
        // A union is never flatter than its parts are together; rounding may say so.
        let error = smallest_eigenvalue(&spread).max(self.error + other.error);
        let normal = self.normal + other.normal;
        Cluster {
            area,
            centroid: self.centroid + apart * share,
            spread,
            normal,
            error,
            lost: lost(area, normal, error) + colors.squared_loss(&spread),
            colors,
            perimeter: (self.perimeter + other.perimeter - 2.0 * shared_length).max(0.0),
            component: self.component,
            root: u32::MAX,
            faces: self.faces + other.faces,
            depth: 1 + self.depth.max(other.depth),
        }
    }

    /// Epsilon, and the unit normal of the plane through the centroid that fits best, on the side of the mean normal.
    pub(super) fn plane(&self) -> (f64, DVec3) {
        let (error, normal) = smallest_eigenpair_near(&self.spread, self.error);
        let epsilon = error / self.area;
        let epsilon = if epsilon.is_finite() { epsilon } else { 0.0 };
        (epsilon, if normal.dot(self.normal) < 0.0 { -normal } else { normal })
    }
}

/// The error of a cluster drawn as one polygon: area times epsilon, and more where the cluster bends around.
///
/// A polygon covers the vector area of its cluster. Where that is the smaller part of the area, as on a finger from
/// its base to its tip, the plane may fit well and the polygon is a lid on the stump all the same.
fn lost(area: f64, normal: DVec3, error: f64) -> f64 {
    let squared = area * area;
    let bent = squared / normal.length_squared().max(MOST_BENT * squared);
    if bent.is_finite() { error * bent } else { error }
}

/// A closed cluster counts as having a vector area whose square is this share of the square of its area.
const MOST_BENT: f64 = 1e-6;
