//! What stands beside the tree: welds, groups, the description.

use crate::child::{Child, ChildRef};
use crate::error::Violation;
use crate::records::{GroupRecord, VertexRecord, WeldRecord};
use crate::rule::Rule;
use crate::subtree::Subtree;
use crate::tree::Tree;
use crate::walk::to_index;

use super::descent::Found;

pub(crate) fn check_weld(tree: &Tree) -> Result<(), Box<Violation>> {
    let (weld, vertices) = (tree.weld(), tree.vertices());
    let mut previous = None;
    for (index, record) in weld.iter().enumerate() {
        let (copy, original) = (record.vertex.get(), record.representative.get());
        let broken = |rule, found| Err(Violation::new(rule, format!("section WELD, record {index}"), found));
        let record_of = |v| to_index(v).and_then(|i| vertices.get(i));
        let (Some(a), Some(b)) = (record_of(copy), record_of(original)) else {
            return broken(Rule::VertexIndex, format!("it welds {copy} to {original} of {}", vertices.len()));
        };
        if previous.is_some_and(|p| p >= copy) {
            return broken(Rule::WeldOrder, format!("vertex {copy} comes after {}", previous.unwrap_or(0)));
        }
        previous = Some(copy);
        if copy == original || is_copy(weld, original) {
            return broken(Rule::WeldOrder, format!("the representative {original} of {copy} is a copy"));
        }
        if !equal(a, b) {
            return broken(Rule::WeldEqual, format!("vertices {copy} and {original} differ"));
        }
    }
    Ok(())
}

/// In an unsorted list the search may miss, but then the order is found broken.
fn is_copy(weld: &[WeldRecord], vertex: u32) -> bool {
    weld.binary_search_by_key(&vertex, |w| w.vertex.get()).is_ok()
}

/// Positions as numbers, so that -0 equals 0; NaN was refused before.
fn equal(a: &VertexRecord, b: &VertexRecord) -> bool {
    let rest = |v: &VertexRecord| (v.bound, v.budget, v.radius, v.offset, v.displacement);
    a.position() == b.position() && rest(a) == rest(b)
}

/// The groups that a walk in tree order has not met yet.
pub(crate) struct Groups<'a> {
    all: &'a [GroupRecord],
    names: usize,
    met: usize,
    face_end: u32,
}

impl<'a> Groups<'a> {
    pub(crate) fn new(all: &'a [GroupRecord], names: usize) -> Self {
        Self { all, names, met: 0, face_end: 0 }
    }

    /// Checks the group whose root is this subtree, if the next one is.
    pub(crate) fn check(&mut self, subtree: &Subtree) -> Result<(), Box<Violation>> {
        let next = self.all.get(self.met);
        let Some(group) = next.filter(|g| g.root.get() == subtree.child.raw()) else {
            return Ok(());
        };
        let (first, count) = (group.first_face.get(), group.face_count.get());
        let named = to_index(group.name.get()).is_some_and(|name| name < self.names);
        let exact = first == subtree.first_face && count == subtree.face_count();
        if !(named && exact && first >= self.face_end) {
            return Err(Violation::new(
                Rule::GroupRange,
                format!("section GRUP, record {}", self.met),
                format!(
                    "it has {count} faces from {first} on and name {} of {}; its root has the faces {}..{}, earlier groups end at {}",
                    group.name.get(),
                    self.names,
                    subtree.first_face,
                    subtree.face_end,
                    self.face_end
                ),
            ));
        }
        self.met = self.met.saturating_add(1);
        self.face_end = subtree.face_end;
        Ok(())
    }

    /// After the last face: a group that was not met is out of order, or its root is not there.
    pub(crate) fn check_all(&self) -> Result<(), Box<Violation>> {
        let Some(group) = self.all.get(self.met) else {
            return Ok(());
        };
        let root = match ChildRef::from_raw(group.root.get()).kind() {
            Child::Node(index) => format!("node {index}"),
            Child::Face(index) => format!("face {index}"),
        };
        Err(Violation::new(
            Rule::GroupRange,
            format!("section GRUP, record {}", self.met),
            format!("its root {root} does not follow in tree order"),
        ))
    }
}

/// Compares the description with what the walk found.
pub(crate) fn check_meta(tree: &Tree, found: &Found) -> Result<(), Box<Violation>> {
    let meta = tree.meta();
    let broken = |rule, text: String| Err(Violation::new(rule, "section META".to_owned(), text));
    if meta.origin.iter().any(|c| !c.is_finite()) {
        return broken(Rule::Finite, format!("its origin is {:?}", meta.origin));
    }
    let faces = tree.header().face_count;
    let dropped = meta.dropped.iter().try_fold(0_u64, |sum, (_, n)| sum.checked_add(*n));
    let accounted = dropped.and_then(|d| d.checked_add(meta.faces_kept));
    if meta.faces_kept != faces || accounted != Some(meta.faces_in) {
        return broken(
            Rule::MetaAgrees,
            format!(
                "{} faces in, {} kept, {dropped:?} dropped, {faces} in the file",
                meta.faces_in, meta.faces_kept
            ),
        );
    }
    if meta.depth != found.depth {
        return broken(
            Rule::MetaAgrees,
            format!("it says depth {}, the tree has {}", meta.depth, found.depth),
        );
    }
    let (low, high) = bounds(tree.vertices());
    if (meta.bounds_min, meta.bounds_max) != (low, high) {
        return broken(
            Rule::MetaAgrees,
            format!(
                "its box is {:?} to {:?}, that of the positions {low:?} to {high:?}",
                meta.bounds_min, meta.bounds_max
            ),
        );
    }
    if meta.closed && meta.seam_edges == 0 && found.has_boundary {
        return broken(
            Rule::MetaAgrees,
            "it says the surface is closed, and the faces have a boundary".to_owned(),
        );
    }
    Ok(())
}

fn bounds(vertices: &[VertexRecord]) -> ([f32; 3], [f32; 3]) {
    let mut low = [f32::INFINITY; 3];
    let mut high = [f32::NEG_INFINITY; 3];
    for vertex in vertices {
        let position = vertex.position();
        for ((low, high), p) in low.iter_mut().zip(&mut high).zip(position) {
            *low = low.min(p);
            *high = high.max(p);
        }
    }
    (low, high)
}
