//! The nodes above the pages, with all their digits.

use super::ball::Ball;
use super::loops::encode_top;
use super::page::offset;
use super::{Clusters, PackError, Packed, Plan};
use crate::node::Node;
use crate::plane::PlaneRecord;
use crate::records::{PAGE_BIT, TopRecord, pack as stored};
use crate::short_float::single_up;

/// Room for the rounding of a distance, and of a reader that computes it in another order.
const ROUNDING: f64 = 1.0 + 1e-12;

/// Appends the records and loops of all nodes above the pages, from the pages up.
pub(super) fn pack(clusters: &impl Clusters, plan: &Plan, out: &mut Packed) -> Result<(), PackError> {
    out.tops = vec![TopRecord::default(); plan.tops.len()];
    for (index, planned) in plan.tops.iter().enumerate().rev() {
        let data = clusters.cluster(planned.node);
        let (mut bound, mut budget) = (data.bound, data.budget);
        let children = planned.children.map(|child| Child::of(child, clusters, plan, out));
        for child in &children {
            if let Child::Node(node) = child {
                bound = bound.max(node.bound);
                budget = budget.max(node.budget);
            }
        }
        let (center, radius) = ball_around(center_of(&children).map(|x| x as f32), &children);
        if !(radius.is_finite() && center.iter().all(|c| c.is_finite())) {
            return Err(PackError::Range(planned.node));
        }
        let [left, right] = planned.children;
        let around = (data.axis.map(f64::from), f64::from(data.cos));
        let first = clusters.position(clusters.faces()[planned.first_face as usize][0]);
        out.tops[index] = TopRecord {
            center: stored(center),
            radius: radius.into(),
            bound: bound.into(),
            budget: budget.into(),
            axis: stored(data.axis),
            cos: data.cos.into(),
            epsilon: data.epsilon.into(),
            left: left.into(),
            right: right.into(),
            first_face: planned.first_face.into(),
            plane: PlaneRecord::encode(data.plane, data.offset, first, around, bound),
            ..TopRecord::default()
        };
    }
    let mut entries = Vec::new();
    for (planned, record) in plan.tops.iter().zip(&mut out.tops) {
        record.loop_start = offset(out.top_loops.len(), "section TOPL")?;
        if record.bound.get() != f32::INFINITY {
            entries.clear();
            clusters.boundary(planned.node, &mut entries);
            encode_top(&entries, &mut out.top_loops);
        }
        record.loop_end = offset(out.top_loops.len(), "section TOPL")?;
    }
    Ok(())
}

/// What a sphere has to hold.
enum Child {
    Node(Node),
    Face([[f32; 3]; 3]),
}

impl Child {
    fn of(child: u32, clusters: &impl Clusters, plan: &Plan, packed: &Packed) -> Child {
        if child & PAGE_BIT == 0 {
            return Child::Node(Node::of_top(&packed.tops[child as usize]));
        }
        let page = (child & !PAGE_BIT) as usize;
        let planned = &plan.pages[page];
        if planned.faces == 1 {
            let corners = clusters.faces()[planned.first_face as usize];
            return Child::Face(corners.map(|v| clusters.position(v)));
        }
        // Pages before it have one node less than faces.
        let root = planned.first_face as usize - page;
        Child::Node(Node::of_page(&packed.pages[page], &packed.nodes[root]))
    }

    /// How far it reaches from a place.
    fn reach(&self, from: [f64; 3]) -> f64 {
        match self {
            Child::Node(node) => distance(from, node.center.map(f64::from)) + f64::from(node.radius),
            Child::Face(corners) => {
                corners.iter().map(|c| distance(from, c.map(f64::from))).fold(0.0, f64::max)
            }
        }
    }
}

fn ball_around(center: [f32; 3], children: &[Child; 2]) -> ([f32; 3], f32) {
    let from = center.map(f64::from);
    let reach = children.iter().map(|c| c.reach(from)).fold(0.0, f64::max);
    (center, single_up(reach * ROUNDING))
}

/// The centre of a small ball around two children.
fn center_of(children: &[Child; 2]) -> [f64; 3] {
    let ball = |node: &Node| Ball { center: node.center.map(f64::from), radius: f64::from(node.radius) };
    let around = match children {
        [Child::Node(a), Child::Node(b)] => Ball::around(&ball(a), &ball(b)),
        [Child::Node(node), Child::Face(face)] | [Child::Face(face), Child::Node(node)] => {
            ball(node).stretched_to(face)
        }
        [Child::Face(a), Child::Face(b)] => Ball::of_faces(a, b),
    };
    around.center
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let d = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt()
}
