//! Numbers that make sense on their own.

use zerocopy::little_endian::F32;

use crate::error::Violation;
use crate::records::{BoundingPolygonRecord, NodeRecord, VertexRecord};
use crate::rule::Rule;
use crate::walk::node_place;

use super::vector::{Vector, dot, length, widen};

/// How far an axis may be from length 1, and a tangent from a right angle: f32 in careless hands.
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
    finite("position", &vertex.position)?;
    key("bound", vertex.bound)?;
    key("budget key", vertex.budget)?;
    finite("centre", &vertex.center)?;
    length_like("radius", vertex.radius)
}

pub(crate) fn check_node(index: u32, node: &NodeRecord) -> Result<(), Box<Violation>> {
    let check = || {
        finite("centre", &node.center)?;
        length_like("radius", node.radius)?;
        key("bound", node.bound)?;
        key("budget key", node.budget)?;
        unit("cone axis", node.axis)?;
        let cos = node.cos.get();
        if !(-1.0..=1.0).contains(&cos) {
            return Err((Rule::Cosine, format!("its cosine is {cos}")));
        }
        length_like("epsilon", node.epsilon)
    };
    check().map_err(|(rule, found)| Violation::new(rule, node_place(index), found))
}

pub(crate) fn check_bounding_polygon(
    index: usize,
    polygon: &BoundingPolygonRecord,
) -> Result<(), Box<Violation>> {
    let check = || {
        if polygon.flags.get() != 0 {
            return Err((Rule::ReservedZero, format!("its flags are {:#x}", polygon.flags.get())));
        }
        finite("origin", &polygon.origin)?;
        unit("normal", polygon.normal)?;
        unit("tangent", polygon.tangent)?;
        let cosine = dot(widen(polygon.normal), widen(polygon.tangent));
        if cosine.abs() > UNIT_SLACK {
            return Err((Rule::UnitVector, format!("normal and tangent have the product {cosine:e}")));
        }
        finite("heights", &[polygon.low, polygon.high])?;
        finite("support", &polygon.support)?;
        let (low, high) = (polygon.low.get(), polygon.high.get());
        if low > high {
            return Err((Rule::Finite, format!("its low {low:e} is above its high {high:e}")));
        }
        Ok(())
    };
    check().map_err(|(rule, found)| Violation::new(rule, format!("section BPOL, record {index}"), found))
}

fn finite(what: &str, values: &[F32]) -> Result<(), Broken> {
    match values.iter().map(|v| v.get()).find(|v| !v.is_finite()) {
        None => Ok(()),
        Some(v) => Err((Rule::Finite, format!("its {what} holds {v}"))),
    }
}

/// Finite and not negative.
fn length_like(what: &str, value: F32) -> Result<(), Broken> {
    finite(what, &[value])?;
    not_negative(what, value.get())
}

/// Not negative, may be infinite.
fn key(what: &str, value: F32) -> Result<(), Broken> {
    let value = value.get();
    if value.is_nan() {
        return Err((Rule::Finite, format!("its {what} is {value}")));
    }
    not_negative(what, value)
}

fn not_negative(what: &str, value: f32) -> Result<(), Broken> {
    if value >= 0.0 { Ok(()) } else { Err((Rule::NotNegative, format!("its {what} is {value:e}"))) }
}

fn unit(what: &str, axis: [F32; 3]) -> Result<(), Broken> {
    let axis: Vector = widen(axis);
    let length = length(axis);
    // Written so that NaN fails.
    if (length - 1.0).abs() <= UNIT_SLACK {
        Ok(())
    } else {
        Err((Rule::UnitVector, format!("its {what} has length {length}")))
    }
}
