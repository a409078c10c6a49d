//! Bounding polygons, measured in the frame that a reader decodes.

use crate::node::{BoundingPolygon, Node};
use crate::octahedral::FineNormalRecord;
use crate::records::BoundingPolygonRecord;
use crate::short_float::ShortFloat;
use std::f64::consts::FRAC_1_SQRT_2;

/// Room for the rounding of coordinates, relative to the extent.
const ROUNDING: f64 = 1e-12;

impl BoundingPolygonRecord {
    /// The prism over the plane with this normal around the points of a cluster; `node` is its node as decoded, and
    /// `index` the node's place in preorder.
    pub fn around(
        index: u32,
        node: &Node,
        normal: [f32; 3],
        points: impl IntoIterator<Item = [f32; 3]>,
    ) -> Self {
        let mut record =
            Self { node: index.into(), normal: FineNormalRecord::encode(normal), ..Self::default() };
        let frame = BoundingPolygon::new(&record, node);
        let mut low = [f64::INFINITY; 5];
        let mut high = [f64::NEG_INFINITY; 5];
        for p in points {
            for (i, h) in frame.heights(p).into_iter().enumerate() {
                low[i] = low[i].min(h);
                high[i] = high[i].max(h);
            }
        }
        let extent = (0..5).map(|i| high[i].abs().max(low[i].abs())).fold(0.0, f64::max);
        let up = |h: f64| ShortFloat::up(h + ROUNDING * extent);
        record.low = ShortFloat::down(low[4] - ROUNDING * extent);
        record.high = up(high[4]);
        for i in 0..4 {
            record.support[i] = up(high[i]);
            record.support[i + 4] = up(-low[i]);
        }
        record
    }
}

impl BoundingPolygon {
    /// A point's places along the tangent, the diagonal, the bitangent, the other diagonal, and the normal.
    pub(crate) fn heights(&self, point: [f32; 3]) -> [f64; 5] {
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let (n, t) = (self.normal, self.tangent);
        let b = [n[1] * t[2] - n[2] * t[1], n[2] * t[0] - n[0] * t[2], n[0] * t[1] - n[1] * t[0]];
        let d = [0, 1, 2].map(|k| f64::from(point[k]) - self.origin[k]);
        let (x, y, z) = (dot(t, d), dot(b, d), dot(n, d));
        [x, (x + y) * FRAC_1_SQRT_2, y, (y - x) * FRAC_1_SQRT_2, z]
    }
}
