//! Numbers that make sense on their own.

use crate::error::Violation;
use crate::node::Node;
use crate::records::{BoundingPolygonRecord, VertexRecord};
use crate::rule::Rule;
use crate::short_float::ShortFloat;
use crate::subtree::Subtree;

use super::vector::{Vector, length, widen};

/// How far an axis may be from length 1: f32 in careless hands.
const UNIT_SLACK: f64 = 1e-4;

type Broken = (Rule, String);

pub(crate) fn check_vertices(vertices: &[VertexRecord]) -> Result<(), Box<Violation>> {
    for (index, vertex) in vertices.iter().enumerate() {
        check_vertex(vertex)
            .map_err(|(rule, found)| Violation::new(rule, format!("section VERT, vertex {index}"), found))?;
    }
    Ok(())
}

fn check_vertex(vertex: &VertexRecord) -> Result<(), Broken> {
    finite("position", &vertex.position())?;
    key("bound", vertex.bound.get())?;
    key("budget key", vertex.budget.get())?;
    length_like("radius", vertex.radius.get())
}

pub(crate) fn check_node(subtree: &Subtree, node: &Node) -> Result<(), Box<Violation>> {
    let check = || {
        finite("centre", &node.center)?;
        length_like("radius", node.radius)?;
        key("bound", node.bound)?;
        key("budget key", node.budget)?;
        unit("cone axis", node.axis())?;
        let cos = node.cos();
        if !(-1.0..=1.0).contains(&cos) {
            return Err((Rule::Cosine, format!("its cosine is {cos}")));
        }
        length_like("epsilon", node.epsilon())
    };
    check().map_err(|(rule, found)| Violation::new(rule, subtree.to_string(), found))
}

pub(crate) fn check_bounding_polygon(
    index: usize,
    polygon: &BoundingPolygonRecord,
) -> Result<(), Box<Violation>> {
    let check = || {
        let (low, high) = (polygon.low.get(), polygon.high.get());
        finite("heights", &[low, high])?;
        finite("support", &polygon.support.map(ShortFloat::get))?;
        if low > high {
            return Err((Rule::Finite, format!("its low {low:e} is above its high {high:e}")));
        }
        Ok(())
    };
    check().map_err(|(rule, found)| Violation::new(rule, format!("section BPOL, record {index}"), found))
}

fn finite(what: &str, values: &[f32]) -> Result<(), Broken> {
    match values.iter().find(|v| !v.is_finite()) {
        None => Ok(()),
        Some(v) => Err((Rule::Finite, format!("its {what} holds {v}"))),
    }
}

/// Finite and not negative.
fn length_like(what: &str, value: f32) -> Result<(), Broken> {
    finite(what, &[value])?;
    not_negative(what, value)
}

/// Not negative, may be infinite.
fn key(what: &str, value: f32) -> Result<(), Broken> {
    if value.is_nan() {
        return Err((Rule::Finite, format!("its {what} is {value}")));
    }
    not_negative(what, value)
}

fn not_negative(what: &str, value: f32) -> Result<(), Broken> {
    if value >= 0.0 { Ok(()) } else { Err((Rule::NotNegative, format!("its {what} is {value:e}"))) }
}

fn unit(what: &str, axis: [f32; 3]) -> Result<(), Broken> {
    let axis: Vector = widen(axis);
    let length = length(axis);
    // Written so that NaN fails.
    if (length - 1.0).abs() <= UNIT_SLACK {
        Ok(())
    } else {
        Err((Rule::UnitVector, format!("its {what} has length {length}")))
    }
}
