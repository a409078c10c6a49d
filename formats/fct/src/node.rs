//! A node as a reader sees it, whichever record it comes from.

use crate::octahedral::{NormalRecord, tangent_of};
use crate::plane::PlaneRecord;
use crate::records::{BoundingPolygonRecord, NodeRecord, PageRecord, TopRecord, unpack};

/// A cluster of two faces or more, decoded.
///
/// What every step of a walk needs is there; the rest is decoded when it is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// Centre of the bounding sphere of the cluster. A child's sphere lies inside its parent's.
    pub center: [f32; 3],
    /// Radius of the bounding sphere, never too small.
    pub radius: f32,
    /// Distance bound (length): how far the drawn cluster may lie from its faces. Never below a child's.
    /// Infinite: the node must always be refined (a virtual node over several components, the root of a closed surface).
    pub bound: f32,
    /// Budget key (length): nodes of larger keys are refined first where triangles are counted. Never below a child's; may be infinite like `bound`.
    pub budget: f32,
    rest: Rest,
}

/// What a cut does not read of a node.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Rest {
    Exact { axis: [f32; 3], cos: f32, epsilon: f32, plane: PlaneRecord },
    Coded { axis: NormalRecord, width: u8, epsilon: u8, quantum: f32, plane: PlaneRecord },
}

impl Node {
    pub(crate) fn of_top(record: &TopRecord) -> Self {
        Self {
            center: unpack(record.center),
            radius: record.radius.get(),
            bound: record.bound.get(),
            budget: record.budget.get(),
            rest: Rest::Exact {
                axis: unpack(record.axis),
                cos: record.cos.get(),
                epsilon: record.epsilon.get(),
                plane: record.plane,
            },
        }
    }

    #[inline]
    pub(crate) fn of_page(page: &PageRecord, record: &NodeRecord) -> Self {
        let quantum = page.quantum.get();
        let [x, y, z] = unpack(page.origin);
        // Exact in single precision: see the rule `grid`.
        let [i, j, k] = record.center.map(|c| quantum * f32::from(c));
        Self {
            center: [x + i, y + j, z + k],
            radius: quantum * f32::from(record.radius),
            bound: record.bound.get(),
            budget: record.budget.get(),
            rest: Rest::Coded {
                axis: record.axis,
                width: record.width,
                epsilon: record.epsilon,
                quantum,
                plane: record.plane,
            },
        }
    }

    /// Axis of the normal cone, a unit vector.
    #[inline]
    pub fn axis(&self) -> [f32; 3] {
        match self.rest {
            Rest::Exact { axis, .. } => axis,
            Rest::Coded { axis, .. } => axis.decode(),
        }
    }

    /// Cosine of the half angle of the normal cone, never too large. -1: the cone holds every direction and culls nothing.
    #[inline]
    pub fn cos(&self) -> f32 {
        match self.rest {
            Rest::Exact { cos, .. } => cos,
            Rest::Coded { width, .. } => cosine_of(width),
        }
    }

    /// The plane that fits the cluster best: its unit normal, and how high it lies along that above the first corner of
    /// the cluster's first face. Rounded, and good for choosing between triangulations.
    pub fn plane(&self) -> ([f64; 3], f64) {
        match self.rest {
            Rest::Exact { axis, cos, plane, .. } => {
                plane.decode((axis.map(f64::from), f64::from(cos)), self.bound)
            }
            Rest::Coded { axis, width, plane, .. } => {
                // In single precision, as an exact record of the same node has it.
                plane.decode((axis.decode().map(f64::from), f64::from(cosine_of(width))), self.bound)
            }
        }
    }

    /// The plane as it is stored.
    pub(crate) fn plane_record(&self) -> PlaneRecord {
        match self.rest {
            Rest::Exact { plane, .. } | Rest::Coded { plane, .. } => plane,
        }
    }

    /// Modelling error: the mean square distance of the cluster from its plane (length squared). Raw, so not monotone.
    /// In a page its root is rounded to one of eight steps an octave.
    ///
    /// # Paper
    /// [Tsuji07, eq. 8]: the smallest eigenvalue of the area-integrated covariance.
    pub fn epsilon(&self) -> f32 {
        match self.rest {
            Rest::Exact { epsilon, .. } => epsilon,
            Rest::Coded { epsilon, quantum, .. } => {
                let root = f64::from(quantum) * root_of(epsilon);
                single(root * root)
            }
        }
    }
}

/// The cosine of a cone's half angle by its stored width. Equal steps of the width are nearly equal steps of the angle.
#[inline]
pub(crate) fn cosine_of(width: u8) -> f32 {
    if width == u8::MAX {
        return -1.0;
    }
    let w = f32::from(width) / 256.0;
    1.0 - w * w
}

/// The sphere and the normal cone of a node in a page, in single precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConeFrame {
    /// Centre and radius of the bounding sphere, as [`Node`] has them.
    pub center: [f32; 3],
    /// See `center`.
    pub radius: f32,
    /// [`Node::axis`] but for rounding.
    pub axis: [f32; 3],
    /// The sine of the cone's half angle but for rounding, and its cosine, which is above 0.
    pub sin_cos: [f32; 2],
}

impl ConeFrame {
    /// Of a node in a page; none if its cone holds every direction.
    #[inline]
    pub(crate) fn of(page: &PageRecord, record: &NodeRecord) -> Option<Self> {
        if record.width == u8::MAX {
            return None;
        }
        let quantum = page.quantum.get();
        let [x, y, z] = unpack(page.origin);
        let [i, j, k] = record.center.map(|c| quantum * f32::from(c));
        let w = f32::from(record.width) / 256.0;
        Some(Self {
            center: [x + i, y + j, z + k],
            radius: quantum * f32::from(record.radius),
            axis: record.axis.near(),
            // With cos = 1 - w^2, sin^2 = (1 - cos) (1 + cos).
            sin_cos: [w * (2.0 - w * w).sqrt(), 1.0 - w * w],
        })
    }
}

/// The root of a modelling error in quanta: (8 + m) 2^(e - 26), with e the upper 5 bits and m the lower 3; 0 for 0.
pub(crate) fn root_of(code: u8) -> f64 {
    if code == 0 {
        return 0.0;
    }
    let power = f64::from(1_u32 << (code >> 3)) / f64::from(1_u32 << 26);
    f64::from(8 | (code & 7)) * power
}

#[allow(clippy::cast_possible_truncation, reason = "rounding to f32 is meant")]
fn single(x: f64) -> f32 {
    x as f32
}

/// A flat octagonal prism around a cluster, decoded.
///
/// With `b = normal x tangent`, the cluster lies in the points `origin + x tangent + y b + z normal` where
/// `low <= z <= high` and, for k in 0..8, `x cos(k 45 deg) + y sin(k 45 deg) <= support[k]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundingPolygon {
    /// Origin of the prism's frame: the centre of the node's sphere.
    pub origin: [f64; 3],
    /// Unit normal of the cluster's plane.
    pub normal: [f64; 3],
    /// Unit vector at right angles to `normal`.
    pub tangent: [f64; 3],
    /// Lowest height along the normal (length).
    pub low: f64,
    /// Greatest height along the normal (length).
    pub high: f64,
    /// The octagon's support (length) in the directions k times 45 degrees from `tangent` towards `b`.
    pub support: [f64; 8],
}

impl BoundingPolygon {
    /// The prism of a record and its node.
    pub fn new(record: &BoundingPolygonRecord, node: &Node) -> Self {
        let normal = record.normal.direction();
        Self {
            origin: node.center.map(f64::from),
            normal,
            tangent: tangent_of(normal),
            low: f64::from(record.low.get()),
            high: f64::from(record.high.get()),
            support: record.support.map(|s| f64::from(s.get())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{ConeFrame, Node, cosine_of, root_of};
    use crate::octahedral::NormalRecord;
    use crate::records::{NodeRecord, PageRecord, pack};
    use proptest::prelude::*;
    use zerocopy::little_endian::F32;

    proptest! {
        /// The short way to a cone ends where the long one does.
        #[test]
        fn cones_agree(center: [u8; 3], radius: u8, uv: [i8; 2], width: u8) {
            let page = PageRecord { origin: pack([3.0, -0.5, 40.0]), quantum: F32::new(0.25), ..PageRecord::default() };
            let record = NodeRecord { center, radius, axis: NormalRecord { uv }, width, ..NodeRecord::default() };
            let node = Node::of_page(&page, &record);
            let Some(cone) = ConeFrame::of(&page, &record) else {
                prop_assert!(node.cos() == -1.0);
                return Ok(());
            };
            prop_assert_eq!((cone.center, cone.radius), (node.center, node.radius));
            for (short, long) in cone.axis.iter().zip(node.axis()) {
                prop_assert!((short - long).abs() < 3e-7);
            }
            let [sin, cos] = cone.sin_cos.map(f64::from);
            prop_assert!(cos == f64::from(node.cos()) && cos > 0.0);
            prop_assert!((sin - (1.0 - cos * cos).sqrt()).abs() < 3e-7);
        }
    }

    #[test]
    fn codes_are_in_order() {
        assert!((0..u8::MAX).all(|c| cosine_of(c) > cosine_of(c + 1)));
        assert_eq!((cosine_of(0), cosine_of(u8::MAX)), (1.0, -1.0));
        assert!(cosine_of(254) > 0.0, "a cone that is not full culls something");
        assert!((0..u8::MAX).all(|c| root_of(c) < root_of(c + 1)));
        assert_eq!(root_of(0), 0.0);
        assert!(root_of(u8::MAX) > 255.0, "no error is larger than the sphere");
    }
}
