//! That bounding polygons hold their clusters.

use std::ops::Range;

use crate::error::Violation;
use crate::node::{BoundingPolygon, Node};
use crate::records::{BoundingPolygonRecord, VertexRecord};
use crate::rule::Rule;
use crate::walk::to_index;

use super::values::check_bounding_polygon;

/// Slack relative to the extent of the prism: a writer may have measured in another order of sums.
const SLACK: f64 = 1e-9;

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
    /// `first_used` is the range of them. The others lie on its boundary.
    pub(crate) fn check(
        &self,
        place: usize,
        node: &Node,
        boundary: &[u32],
        first_used: Range<u32>,
        vertices: &[VertexRecord],
    ) -> Result<(), Box<Violation>> {
        let Some(polygon) = self.all.get(place) else {
            return Ok(());
        };
        let prism = BoundingPolygon::new(polygon, node);
        let slack = SLACK * extent(&prism);
        let earlier = boundary.iter().copied().filter(|v| *v < first_used.start);
        for corner in first_used.clone().chain(earlier) {
            let Some(vertex) = to_index(corner).and_then(|i| vertices.get(i)) else {
                continue;
            };
            let outside = outside(&prism, vertex.position());
            if outside > slack {
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

fn extent(prism: &BoundingPolygon) -> f64 {
    let [s0, s1, s2, s3, s4, s5, s6, s7] = prism.support;
    [prism.high - prism.low, s0 + s4, s1 + s5, s2 + s6, s3 + s7].into_iter().fold(0.0, f64::max)
}

/// How far a point sticks out of the prism: the largest excess over any of its ten planes, not above 0 inside.
fn outside(prism: &BoundingPolygon, point: [f32; 3]) -> f64 {
    let [x, p, y, q, z] = prism.heights(point);
    let along = [x, p, y, q, -x, -p, -y, -q];
    let slab = [z - prism.high, prism.low - z];
    let rim = along.into_iter().zip(prism.support).map(|(a, s)| a - s);
    // Not `f64::max`, whose care for NaN costs more than all the rest; nothing here is NaN.
    slab.into_iter().chain(rim).fold(f64::NEG_INFINITY, |a, b| if b > a { b } else { a })
}
