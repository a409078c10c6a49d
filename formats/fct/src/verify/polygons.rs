//! That bounding polygons hold their clusters.

use std::f64::consts::FRAC_1_SQRT_2;
use std::ops::Range;

use crate::error::Violation;
use crate::records::{BoundingPolygonRecord, FaceRecord, VertexRecord};
use crate::rule::Rule;
use crate::walk::to_index;

use super::values::check_bounding_polygon;
use super::vector::{Vector, cross, dot, sub, widen};

/// Slack relative to the extent of the prism.
const SLACK: f64 = 1e-5;

/// The bounding polygons that a walk in node order has not met yet.
pub(crate) struct Polygons<'a> {
    all: &'a [BoundingPolygonRecord],
    met: usize,
}

impl<'a> Polygons<'a> {
    pub(crate) fn new(all: &'a [BoundingPolygonRecord]) -> Self {
        Self { all, met: 0 }
    }

    /// The place of the bounding polygon of node `index`, if the next one is of that node.
    pub(crate) fn meet(&mut self, index: u32) -> Result<Option<usize>, Box<Violation>> {
        let place = self.met;
        let Some(polygon) = self.all.get(place).filter(|p| p.node.get() == index) else {
            return Ok(None);
        };
        check_bounding_polygon(place, polygon)?;
        self.met = place.saturating_add(1);
        Ok(Some(place))
    }

    /// Checks that the bounding polygon at a place holds a cluster.
    ///
    /// The vertices that the cluster is the first to use stand together, so each of them is looked at once;
    /// `first_used` is the range of them, and all are in range.
    pub(crate) fn check(
        &self,
        place: usize,
        cluster: &[FaceRecord],
        first_used: Range<u32>,
        vertices: &[VertexRecord],
    ) -> Result<(), Box<Violation>> {
        let Some(polygon) = self.all.get(place) else {
            return Ok(());
        };
        let prism = Prism::new(polygon);
        let corners = cluster.iter().flat_map(FaceRecord::indices);
        let earlier = corners.filter(|v| *v < first_used.start);
        for corner in first_used.clone().chain(earlier) {
            let Some(vertex) = to_index(corner).and_then(|i| vertices.get(i)) else {
                continue;
            };
            let outside = prism.outside(widen(vertex.position));
            if outside > prism.slack {
                return Err(Violation::new(
                    Rule::PolygonHolds,
                    format!("section BPOL, record {place} of node {}", polygon.node.get()),
                    format!("vertex {corner} lies {outside:e} outside"),
                ));
            }
        }
        Ok(())
    }

    /// After the last node: a polygon that was not met is out of order, or of a node that is not there.
    pub(crate) fn check_all(&self) -> Result<(), Box<Violation>> {
        match self.all.get(self.met) {
            None => Ok(()),
            Some(polygon) => Err(Violation::new(
                Rule::PolygonOrder,
                format!("section BPOL, record {}", self.met),
                format!("it is for node {}", polygon.node.get()),
            )),
        }
    }
}

struct Prism {
    origin: Vector,
    normal: Vector,
    tangent: Vector,
    bitangent: Vector,
    low: f64,
    high: f64,
    support: [f64; 8],
    slack: f64,
}

impl Prism {
    fn new(polygon: &BoundingPolygonRecord) -> Self {
        let (normal, tangent) = (widen(polygon.normal), widen(polygon.tangent));
        let (low, high) = (f64::from(polygon.low.get()), f64::from(polygon.high.get()));
        let support = polygon.support.map(|s| f64::from(s.get()));
        let [s0, s1, s2, s3, s4, s5, s6, s7] = support;
        let extent = [high - low, s0 + s4, s1 + s5, s2 + s6, s3 + s7].into_iter().fold(0.0, f64::max);
        Self {
            origin: widen(polygon.origin),
            normal,
            tangent,
            bitangent: cross(normal, tangent),
            low,
            high,
            support,
            slack: SLACK * extent,
        }
    }

    /// How far a point sticks out of the prism: the largest excess over any of its ten planes, not above 0 inside.
    fn outside(&self, point: Vector) -> f64 {
        let from_origin = sub(point, self.origin);
        let x = dot(from_origin, self.tangent);
        let y = dot(from_origin, self.bitangent);
        let z = dot(from_origin, self.normal);
        let (p, q) = ((x + y) * FRAC_1_SQRT_2, (y - x) * FRAC_1_SQRT_2);
        let along = [x, p, y, q, -x, -p, -y, -q];
        let slab = [z - self.high, self.low - z];
        let rim = along.into_iter().zip(self.support).map(|(a, s)| a - s);
        // Not `f64::max`, whose care for NaN costs more than all the rest; nothing here is NaN.
        slab.into_iter().chain(rim).fold(f64::NEG_INFINITY, |a, b| if b > a { b } else { a })
    }
}
